/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/WholeTime.H"
#include "HashSet.H"
#include "IOstreams.H"
#include "OSspecific.H"
#include "Pstream.H"
#include "foam/foamVersion.H"

#include <filesystem>
#include <fstream>
#include <string>

namespace Foam
{

namespace
{

//- Beside the time folders, so that it comes before the folder and goes after it
const std::string markPrefix("elutriaUnfinished.");


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
        if (entry.is_regular_file() && !isWhole(entry.path()))
        {
            return entry.path().string();
        }
    }
    return "";
}

} // End anonymous namespace


WholeTime::WholeTime(const Time& runTime)
:
    folder_(runTime.timePath()),
    mark_(folder_.path()/(markPrefix + folder_.name()))
{
    const bool made = bool(std::ofstream(mark_) << "being written\n" << std::flush);
    if (!returnReduce(made, andOp<bool>()))
    {
        breakOff(folder_);
    }
}


void WholeTime::breakOff(const fileName& file) const
{
    FatalErrorInFunction
        << "cannot write " << file << ": is the disk full or the folder"
        << " read-only? The run can go on from the time before"
        << exit(FatalError);
}


void WholeTime::write(const std::function<void()>& work) const
{
    string half;
    try
    {
        work();
        half = firstHalfFile(folder_);
    }
    catch (const IOerror& error)
    {
        half = error.ioFileName();
        if (Pstream::parRun())
        {
            breakOff(fileName(half));   // the others may wait within the work
        }
    }
    if (!returnReduce(half.empty(), andOp<bool>()))
    {
        breakOff(half.empty() ? folder_ : fileName(half));
    }
    rm(mark_);
}


void WholeTime::discardHalf(const fileName& folder)
{
    wordHashSet names;
    for (const fileName& file : readDir(folder, fileName::FILE, false))
    {
        if (file.startsWith(markPrefix))
        {
            names.insert(file.substr(markPrefix.size()));
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
    returnReduce(true, andOp<bool>());      // no mark goes before all folders
    for (const word& name : names)
    {
        rm(folder/(markPrefix + name));
    }
}


} // End namespace Foam
