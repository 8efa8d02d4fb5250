/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/controls.H"
#include "foam/foamVersion.H"
#include "foam/requirePositive.H"

namespace Foam
{

void requireSoundControl(const dictionary& controlDict)
{
    for (const word entry : {"maxCo", "maxDeltaT", "writeInterval", "writePrecision"})
    {
        if (controlDict.found(entry))
        {
            requirePositive(entry, controlDict.get<scalar>(entry), controlDict);
        }
    }

    scalar end = 0;
    controlDict.readIfPresent("endTime", end);
    if (end < 0)
    {
        FatalIOErrorInFunction(controlDict)
            << "endTime is " << end << ", allowed: 0 or more"
            << exit(FatalIOError);
    }

    const word format(controlDict.getOrDefault<word>("writeFormat", "ascii"));
    if (format != "ascii" && format != "binary")
    {
        FatalIOErrorInFunction(controlDict)
            << "writeFormat is " << format << ", allowed: ascii, binary"
            << exit(FatalIOError);
    }
}


} // End namespace Foam
