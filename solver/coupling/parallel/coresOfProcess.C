/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "parallel/coresOfProcess.H"
#include "core/threads.hpp"
#include "foam/foamVersion.H"
#include "OSspecific.H"
#include "Pstream.H"
#include "stringList.H"

#include <sched.h>

namespace Foam
{

namespace
{

//- The host and its cores that this process may use, as a word of its own
string placeOfProcess()
{
    string place(hostName());
    cpu_set_t cores;
    CPU_ZERO(&cores);
    if (sched_getaffinity(0, sizeof(cores), &cores) == 0)
    {
        for (int core = 0; core < CPU_SETSIZE; ++core)
        {
            place += CPU_ISSET(core, &cores) ? '1' : '0';
        }
    }
    return place;
}

} // End anonymous namespace


label coresOfProcess()
{
    stringList places(Pstream::nProcs());
    const string own(placeOfProcess());
    places[Pstream::myProcNo()] = own;
    Pstream::gatherList(places);
    elutriaBroadcast(places);
    label together = 0;
    for (const string& place : places)
    {
        together += place == own;
    }
    return coresEach(elutria::dem::threadsOfProcess(), together);
}


} // End namespace Foam
