/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/caseFunctions.H"
#include "run/exitHandling.H"
#include "functionObject.H"
#include "functionObjectList.H"
#include "OSspecific.H"
#include "Time.H"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <sstream>

namespace Foam
{

namespace
{

//- Letters of OpenFOAM's reason that a line has room for
constexpr size_t longestReason = 500;


//- While it lives, what is written to the program's outputs is kept; then it is
//  written
class Kept
{
    std::ostringstream text_;
    std::streambuf* const out_;
    std::streambuf* const err_;

public:

    Kept()
    :
        out_(std::cout.rdbuf(text_.rdbuf())),
        err_(std::cerr.rdbuf(text_.rdbuf()))
    {}

    ~Kept()
    {
        std::cout.rdbuf(out_);
        std::cerr.rdbuf(err_);
        std::cout<< text_.str() << std::flush;
    }

    std::string reason() const
    {
        return "system/controlDict: functions: "
          + text_.str().substr(0, longestReason);
    }
};

std::unique_ptr<Kept> making;


//- OpenFOAM ends the program at an entry that a function lacks
void endMaking()
{
    if (making)
    {
        const std::string reason(making->reason());
        making.reset();
        exitHandling::refuseAtExit(reason);
    }
}


void requireLibraries(Time& runTime, const dictionary& dict)
{
    for (const char* const entry : {"libs", "functionObjectLibs"})
    {
        fileNameList names;
        dict.readIfPresent(entry, names);
        for (const fileName& name : names)
        {
            if (!runTime.libs().open(fileNameList(1, name), false))
            {
                FatalIOErrorInFunction(dict)
                    << entry << " has " << name << ", which cannot be loaded;"
                    << " allowed: libraries in a folder of LD_LIBRARY_PATH"
                    << exit(FatalIOError);
            }
        }
    }
}


bool isAsked(const entry& function)
{
    return
        function.isDict()
     && function.dict().getOrDefault("enabled", true);
}


//- Empty without any
const dictionary& functionsOf(const Time& runTime)
{
    const dictionary& control = runTime.controlDict();
    return
        control.found("functions")
      ? control.subDict("functions") : dictionary::null;
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void caseFunctions::load(Time& runTime)
{
    requireLibraries(runTime, runTime.controlDict());
    const dictionary& functions = functionsOf(runTime);
    requireLibraries(runTime, functions);
    for (const entry& e : functions)
    {
        if (!isAsked(e))
        {
            continue;
        }
        requireLibraries(runTime, e.dict());
        const word type(e.dict().get<word>("type"));
        const auto* const known = functionObject::dictionaryConstructorTablePtr_;
        if (!known || !known->cfind(type).good())
        {
            FatalIOErrorInFunction(e.dict())
                << "type is " << type << ", allowed: a function of OpenFOAM's,"
                << " or of the libraries that libs names"
                << exit(FatalIOError);
        }
    }
}


void caseFunctions::make(Time& runTime)
{
    if (!runTime.functionObjects().status())
    {
        return;     // -noFunctionObjects
    }
    static const bool watched = std::atexit(endMaking) == 0;
    making.reset(watched ? new Kept() : nullptr);
    runTime.functionObjects().start();
    const std::string reason(making ? making->reason() : "");
    making.reset();
    for (const entry& e : functionsOf(runTime))
    {
        if (isAsked(e) && runTime.functionObjects().findObjectID(e.keyword()) < 0)
        {
            exitHandling::refuse(reason);
        }
    }
}


void caseFunctions::tryToMake(Time& runTime)
{
    const word place(functionObject::outputPrefix);
    functionObject::outputPrefix = place + "Tried";
    make(runTime);
    rmDir(runTime.globalPath()/functionObject::outputPrefix);
    functionObject::outputPrefix = place;
}


} // End namespace Foam
