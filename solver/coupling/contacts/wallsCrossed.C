/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/wallsCrossed.H"
#include "foam/digits.H"
#include "volFields.H"
#include "wallPolyPatch.H"

namespace Foam
{

std::vector<RunWarning> wallsCrossed(const volVectorField& U)
{
    std::vector<RunWarning> warnings;
    for (const fvPatchVectorField& values : U.boundaryField())
    {
        const fvPatch& patch = values.patch();
        if (!isA<wallPolyPatch>(patch.patch()) || !values.fixesValue())
        {
            continue;
        }
        const vectorField normals(patch.nf());
        scalar across = 0;
        forAll(values, facei)
        {
            if (crosses(values[facei], normals[facei]))
            {
                across = max(across, mag(values[facei] & normals[facei]));
            }
        }
        reduce(across, maxOp<scalar>());
        if (across > 0)
        {
            warnings.push_back({"wallVelocity",
                "gas flows through the wall " + patch.name()
              + ", and grains meet it at rest",
                threeDigits(across) + " m/s across it",
                "give U a velocity along the wall, or the patch the type patch",
                across});
        }
    }
    return warnings;
}


} // End namespace Foam
