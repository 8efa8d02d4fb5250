/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/WallMotion.H"
#include "foam/engineVectors.H"
#include "wallPolyPatch.H"
#include "volFields.H"

namespace Foam
{

bool anyWallMoves(const volVectorField& U)
{
    bool moves = false;
    for (const fvPatchVectorField& values : U.boundaryField())
    {
        if (!isA<wallPolyPatch>(values.patch().patch()) || !values.fixesValue())
        {
            continue;
        }
        const word& type = values.type();
        const bool constant =
            type == "noSlip" || type == "fixedValue"
         || type == "movingWallVelocity";
        moves = moves || !constant || max(mag(values)()) > 0;
    }
    return returnReduce(moves, orOp<bool>());
}


std::vector<elutria::dem::WallMotion> wallMotions(const volVectorField& U)
{
    List<vectorField> velocities(Pstream::nProcs());
    DynamicList<vector> own;
    for (const fvPatchVectorField& values : U.boundaryField())
    {
        if (isA<wallPolyPatch>(values.patch().patch()))
        {
            forAll(values, facei)
            {
                own.append(values.fixesValue() ? values[facei] : Zero);
            }
        }
    }
    velocities[Pstream::myProcNo()] = vectorField(own);
    Pstream::gatherList(velocities);

    std::vector<elutria::dem::WallMotion> motions;
    if (Pstream::master())
    {
        for (const vectorField& ofProcessor : velocities)
        {
            for (const vector& v : ofProcessor)
            {
                motions.push_back({toEngine(v), {}, {}});
            }
        }
        motions.push_back({});
    }
    return motions;
}


} // End namespace Foam
