/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "averaging/CellOverlap.H"
#include "volMesh.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

scalar CellOverlap::part
(
    const label celli,
    const point& centre,
    const scalar b
) const
{
    const scalar perHalfSide = 0.5/b;
    scalar inside = 1;
    for (const label facei : mesh_.cells()[celli])
    {
        const Face& face = faces_[facei];
        const scalar outwards = mesh_.faceOwner()[facei] == celli ? 1 : -1;
        const scalar distance = outwards*(face.offset - (centre & face.normal));

        inside *=
            min(max(0.5 + perHalfSide*distance, scalar(0)), scalar(1));
        if (inside <= 0)
        {
            break;
        }
    }
    return inside;
}


void CellOverlap::findAround(const label celli)
{
    cells_.clear();
    for (const label pointi : mesh_.cellPoints()[celli])
    {
        for (const label other : mesh_.pointCells()[pointi])
        {
            if (!cells_.found(other))
            {
                cells_.append(other);
            }
        }
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

CellOverlap::CellOverlap(const fvMesh& mesh)
:
    mesh_(mesh),
    faces_(mesh.nFaces()),
    reach_(mesh.nCells(), GREAT)
{
    forAll(faces_, facei)
    {
        const vector& area = mesh.faceAreas()[facei];
        const vector normal(area/mag(area));
        faces_[facei] = {normal, normal & mesh.faceCentres()[facei]};
    }
    forAll(mesh.cells(), celli)
    {
        scalar area = 0;
        for (const label facei : mesh.cells()[celli])
        {
            area = max(area, mag(mesh.faceAreas()[facei]));
        }
        reach_[celli] = 0.5*mesh.V()[celli]/area;
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void CellOverlap::add
(
    scalarField& sums,
    const label celli,
    const point& centre,
    const scalar volume
)
{
    const scalar b = min(0.5*cbrt(mag(volume)), reach_[celli]);
    if (part(celli, centre, b) >= 1)
    {
        sums[celli] += volume;
        return;
    }

    findAround(celli);
    parts_.clear();
    scalar all = 0;
    for (const label other : cells_)
    {
        parts_.append(part(other, centre, b));
        all += parts_.last();
    }
    if (all <= 0)       // outside its cell by rounding, or cells that overlap
    {
        sums[celli] += volume;
        return;
    }
    forAll(cells_, i)
    {
        sums[cells_[i]] += volume*parts_[i]/all;
    }
}


} // End namespace Foam
