/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/SymmetryWalls.H"
#include "foam/foamVersion.H"
#include "symmetryPlanePolyPatch.H"
#include "symmetryPolyPatch.H"
#include "wallPolyPatch.H"

namespace Foam
{

bool isSymmetry(const polyPatch& patch)
{
    return isA<symmetryPolyPatch>(patch) || isA<symmetryPlanePolyPatch>(patch);
}


bool isContactPatch(const polyPatch& patch)
{
    return isA<wallPolyPatch>(patch) || isSymmetry(patch);
}


void addSymmetryMaterial
(
    elutria::dem::ContactMaterials& materials,
    const label nParticle,
    const polyMesh& mesh
)
{
    bool any = false;
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        any = any || isSymmetry(patch);
    }
    if (!any)
    {
        return;
    }
    elutria::dem::ContactMaterial symmetry(materials[0]);
    symmetry.name = "symmetry";
    const uint32_t index = materials.add(symmetry);
    for (label a = 0; a < nParticle; ++a)
    {
        elutria::dem::PairProperties pair(materials.pair(a, a));
        pair.friction = 0;
        pair.rollingFriction = 0;
        materials.setPair(a, index, pair);
    }
}


} // End namespace Foam
