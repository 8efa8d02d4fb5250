/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "WholeTime.H"
#include "HashSet.H"
#include "IOstreams.H"
#include "OSspecific.H"
#include "Pstream.H"
#include "foamVersion.H"

#include <filesystem>
#include <fstream>
#include <string>

namespace Foam
{

namespace
{

const word markName("elutriaUnfinished");


//- OpenFOAM's files begin with a banner and end with one
bool isWhole(const std::filesystem::path& file)
{
    std::ifstream is(file, std::ios::binary);
    std::string begin(4, ' '), end(3, ' ');
    is.read(&begin[0], 4);
    is.seekg(-3, std::ios::end);
    is.read(&end[0], 3);

    // Of another's making: not ours to judge, unless nothing of it arrived
    const bool foams = begin == "/*--" || begin == "Foam";
    return foams ? is && end == "//\n" : std::filesystem::file_size(file) > 0;
}


std::string firstHalfFile(const fileName& folder)
{
    for
    (
        const auto& entry :
        std::filesystem::recursive_directory_iterator(folder.c_str())
    )
    {
        if (entry.is_regular_file() && entry.path().filename().string() != markName)
        {
            if (!isWhole(entry.path()))
            {
                return entry.path().string();
            }
        }
    }
    return "";
}

} // End anonymous namespace


WholeTime::WholeTime(const Time& runTime)
:
    runTime_(runTime),
    mark_(runTime.timePath()/markName)
{
    mkDir(mark_.path());
    const bool made = bool(std::ofstream(mark_) << "being written\n" << std::flush);
    if (!returnReduce(made, andOp<bool>()))
    {
        FatalErrorInFunction
            << "cannot write " << runTime.timePath() << ": is the disk full or"
            << " the folder read-only?" << exit(FatalError);
    }
}


void WholeTime::finish() const
{
    string half(firstHalfFile(mark_.path()));
    if (!returnReduce(half.empty(), andOp<bool>()))
    {
        FatalErrorInFunction
            << "cannot write " << (half.empty() ? mark_.path() : half)
            << ": is the disk full? The run can go on from the time before"
            << exit(FatalError);
    }
    rm(mark_);
}


void WholeTime::discardHalf(const fileName& folder)
{
    wordHashSet names;
    for (const fileName& name : readDir(folder, fileName::DIRECTORY))
    {
        if (isFile(folder/name/markName, false))
        {
            names.insert(name);
        }
    }
    Pstream::combineGather(names, plusEqOp<wordHashSet>());
    elutriaBroadcast(names);

    for (const word& name : names.sortedToc())
    {
        Info<< "elutria: time " << name << " was not written to its end and is"
            << " left out" << endl;
        rmDir(folder/name);
    }
    returnReduce(true, andOp<bool>());      // none reads before all are gone
}


} // End namespace Foam
