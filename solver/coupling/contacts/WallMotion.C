/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/WallMotion.H"
#include "contacts/wallsCrossed.H"
#include "foam/engineVectors.H"
#include "foam/foamVersion.H"
#include "wallPolyPatch.H"
#include "volFields.H"

namespace Foam
{

namespace
{

//- Velocity of a patch's faces along themselves; 0 where gas flows through
tmp<vectorField> faceVelocity(const fvPatchVectorField& values)
{
    auto tvelocity = tmp<vectorField>::New(values.size(), Zero);
    if (values.fixesValue())
    {
        const vectorField normals(values.patch().nf());
        forAll(values, facei)
        {
            if (!crosses(values[facei], normals[facei]))
            {
                tvelocity.ref()[facei] = values[facei];
            }
        }
    }
    return tvelocity;
}

} // End anonymous namespace


bool anyWallMoves(const volVectorField& U)
{
    bool moves = false;
    for (const fvPatchVectorField& values : U.boundaryField())
    {
        if
        (
            !isA<wallPolyPatch>(values.patch().patch())
         || !values.fixesValue()
         || values.empty()
        )
        {
            continue;
        }
        const word& type = values.type();
        const bool constant =
            type == "noSlip" || type == "fixedValue"
         || type == "movingWallVelocity";
        const vectorField along(faceVelocity(values));
        const bool inlet = max(mag(values - along)()) > 0;
        moves = moves || (constant ? max(mag(along)()) > 0 : !inlet);
    }
    return returnReduce(moves, orOp<bool>());
}


std::vector<elutria::dem::WallMotion> wallMotions(const volVectorField& U)
{
    for (const RunWarning& warning : wallsCrossed(U))
    {
        Warnings::add(warning);
    }
    List<vectorField> velocities(Pstream::nProcs());
    DynamicList<vector> own;
    for (const fvPatchVectorField& values : U.boundaryField())
    {
        if (isA<wallPolyPatch>(values.patch().patch()))
        {
            own.append(faceVelocity(values)());
        }
    }
    velocities[Pstream::myProcNo()] = vectorField(own);
    Pstream::gatherList(velocities);
    elutriaBroadcast(velocities);

    std::vector<elutria::dem::WallMotion> motions;
    for (const vectorField& ofProcessor : velocities)
    {
        for (const vector& v : ofProcessor)
        {
            motions.push_back({toEngine(v), {}, {}});
        }
    }
    motions.push_back({});
    return motions;
}


} // End namespace Foam
