/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/controls.H"
#include "run/NothingExecuted.H"
#include "foam/foamVersion.H"
#include "foam/requireAllowed.H"
#include "IFstream.H"
#include "Time.H"

#include <regex>
#include <vector>

namespace Foam
{

namespace
{

//- A regular expression for OUTER/INNER/NAME, made once
struct Entries : std::regex
{
    Entries(const char* const text) : std::regex(text) {}
};

struct Place
{
    const char* file;
    Entries entries;
};

struct Number : Place { Range allowed; };
struct Word : Place { wordList allowed; };


//- What a single number may be
const std::vector<Number> numbers =
{
    {"controlDict", "deltaT", above(0, 1e6)},
    {"controlDict", "maxCo|maxDeltaT|writeInterval|writeFrequency", above(0)},
    {"controlDict", "endTime|purgeWrite", atLeast(0)},
    {"controlDict", "writePrecision|timePrecision", atLeast(1, 100)},
    {"fvSolution", "PIMPLE/(nOuterCorrectors|nCorrectors)", atLeast(1, 1000)},
    {"fvSolution", "PIMPLE/(nNonOrthogonalCorrectors)", atLeast(0, 1000)},
    {"fvSolution", "PIMPLE/pRefCell", atLeast(0)},
    {"fvSolution", "PIMPLE/residualControl/.*", atLeast(0)},
    {"fvSolution", "solvers/.*/(tolerance|relTol)", below(1)},
    {"fvSolution", "solvers/.*/(nSweeps|maxIter)", atLeast(1)},
    {"fvSolution", "solvers/.*/(minIter|n[A-Z].*)", atLeast(0)},
    {"fvSolution", "relaxationFactors/.*", above(0, 1)},
    {"blockMeshDict", "scale|convertToMeters", above(0)},
    {"cloudProperties", "constantProperties/rho0", above(0, 1e6)},
    {"cloudProperties", "constantProperties/youngsModulus", above(0, 1e24)},
    {"cloudProperties", "constantProperties/poissonsRatio", above(-1, 0.5)},
    {"cloudProperties", "constantProperties/(rhoMin|minParcelMass)", atLeast(0)},
    {"0", "boundaryField/.*/mixingLength", above(0)}
};

//- What the first word may be
const std::vector<Word> words =
{
    {"controlDict", "writeFormat", {"ascii", "binary"}},
    {"controlDict", "stopAt", {"endTime"}},
    {
        // One-step: the gas takes steps of its own, and others take old steps
        // from the run's time
        "fvSchemes", "ddtSchemes/.*", {"Euler", "none"}
    },
    {"controlDict", "timeFormat", {"general", "fixed", "scientific"}},
    {
        "controlDict", "writeCompression",
        {"on", "off", "yes", "no", "true", "false", "compressed", "uncompressed"}
    }
};


//- The first rule that speaks of an entry; null: none
template<class Rule>
const Rule* ruleOf
(
    const std::vector<Rule>& rules,
    const word& file,
    const std::string& path
)
{
    for (const Rule& rule : rules)
    {
        if (file == rule.file && std::regex_match(path, rule.entries))
        {
            return &rule;
        }
    }
    return nullptr;
}


void require
(
    const word& file,
    const std::string& path,
    const dictionary& dict,
    const word& name,
    const ITstream& values
)
{
    const token& value = values.first();
    const Number* const number =
        values.size() == 1 && value.isNumber()
      ? ruleOf(numbers, file, path) : nullptr;
    if (number)
    {
        requireAllowed(name, value.number(), number->allowed, dict);
    }
    const Word* const said =
        value.isWord() ? ruleOf(words, file, path) : nullptr;
    if (said)
    {
        requireAllowed(name, value.wordToken(), said->allowed, dict);
    }
}


void requireAll
(
    const word& file,
    const dictionary& dict,
    const std::string& around
)
{
    for (const entry& e : dict)
    {
        if (e.isDict())
        {
            requireAll(file, e.dict(), around + e.keyword() + '/');
        }
        else if (!e.stream().empty())
        {
            require
            (
                file, around + e.keyword(), dict, e.keyword(), e.stream()
            );
        }
    }
}


} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

void requireSoundControl(const word& file, const dictionary& dict)
{
    requireAll(file, dict, "");
}


void requireSoundControlDict(const Time& runTime)
{
    const dictionary& dict = runTime.controlDict();
    requireSoundControl("controlDict", dict);

    scalar start = 0, end = 0;
    if
    (
        dict.getOrDefault<word>("startFrom", "latestTime") == "startTime"
     && dict.readIfPresent("startTime", start)
     && dict.readIfPresent("endTime", end)
    )
    {
        requireAllowed("endTime", end, atLeast(start), dict);
    }
    // What a run has come to is no result of an earlier end
    end = runTime.endTime().value();
    if (end < runTime.value() - 0.5*runTime.deltaTValue())
    {
        FatalIOErrorInFunction(dict)
            << "endTime is " << end << ", but the run came to time "
            << runTime.timeName() << "; allowed: at least that"
            << exit(FatalIOError);
    }
}


void requireSoundBlocks(const fileName& root)
{
    for (const char* const folder : {"system", "constant/polyMesh"})
    {
        const fileName file(root/folder/"blockMeshDict");
        IFstream is(file);
        if (is.good())
        {
            // What it would execute is blockMesh's alone
            const NothingExecuted whileReading;
            requireSoundControl("blockMeshDict", dictionary(is));
        }
    }
}


} // End namespace Foam
