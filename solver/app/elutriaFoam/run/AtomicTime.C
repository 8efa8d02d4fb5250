/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/AtomicTime.H"
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

//- Beside the time folders: made before the folder and removed after it
const std::string markPrefix("elutriaUnfinished.");


//- OpenFOAM's files begin with a banner and end with one
bool isComplete(const std::filesystem::path& file)
{
    std::ifstream is(file, std::ios::binary);
    std::string begin(4, ' '), end(3, ' ');
    is.read(&begin[0], 4);
    is.seekg(-3, std::ios::end);
    is.read(&end[0], 3);

    // Another program's file is judged by its size only
    const bool foams = begin == "/*--" || begin == "Foam";
    return foams ? is && end == "//\n" : std::filesystem::file_size(file) > 0;
}


std::string firstIncomplete(const fileName& folder)
{
    for
    (
        const auto& entry :
        std::filesystem::recursive_directory_iterator(folder.c_str())
    )
    {
        if (entry.is_regular_file() && !isComplete(entry.path()))
        {
            return entry.path().string();
        }
    }
    return "";
}

} // End anonymous namespace


AtomicTime::AtomicTime(const Time& runTime)
:
    folder_(runTime.timePath()),
    mark_(folder_.path()/(markPrefix + folder_.name()))
{
    const bool made = bool(std::ofstream(mark_) << "being written\n" << std::flush);
    if (!returnReduce(made, andOp<bool>()))
    {
        fail(folder_);
    }
}


void AtomicTime::fail(const fileName& file) const
{
    FatalErrorInFunction
        << "cannot write " << file << ": is the disk full or the folder"
        << " read-only? The run can be continued from the time before"
        << exit(FatalError);
}


void AtomicTime::write(const std::function<void()>& work) const
{
    string incomplete;
    try
    {
        work();
        incomplete = firstIncomplete(folder_);
    }
    catch (const IOerror& error)
    {
        incomplete = error.ioFileName();
        if (Pstream::parRun())
        {
            fail(fileName(incomplete));   // the others may wait within the work
        }
    }
    if (!returnReduce(incomplete.empty(), andOp<bool>()))
    {
        fail(incomplete.empty() ? folder_ : fileName(incomplete));
    }
    rm(mark_);
}


void AtomicTime::discardIncomplete(const fileName& folder)
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
        Info<< "elutria: time " << name << " was not written completely and is"
            << " discarded" << endl;
        rmDir(folder/name);
    }
    returnReduce(true, andOp<bool>());      // all folders are removed before any mark
    for (const word& name : names)
    {
        rm(folder/(markPrefix + name));
    }
}


} // End namespace Foam
