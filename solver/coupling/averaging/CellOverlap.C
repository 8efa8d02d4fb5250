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
    scalar part = 1;
    for (const label facei : mesh_.cells()[celli])
    {
        const FacePlane& plane = planes_[facei];
        const scalar outwards = mesh_.faceOwner()[facei] == celli ? 1 : -1;
        part *= inside(-outwards*plane.beyond(centre), b);
        if (part <= 0)
        {
            break;
        }
    }
    return part;
}


scalar CellOverlap::partBeyond
(
    const label i,
    const point& centre,
    const scalar b
) const
{
    scalar part = 1;
    for (const FacePlane& plane : beyond_.planes(i))
    {
        part *= inside(-plane.beyond(centre), b);
    }
    return part;
}


void CellOverlap::findAround(const label celli)
{
    cells_.clear();
    const auto add = [&](const label other)
    {
        if (!cells_.found(other))
        {
            cells_.append(other);
        }
    };
    for (const label pointi : mesh_.cellPoints()[celli])
    {
        for (const label around : mesh_.pointCells()[pointi])
        {
            add(around);
        }
        for (const label i : beyond_.at(pointi))
        {
            add(mesh_.nCells() + i);
        }
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

CellOverlap::CellOverlap(const fvMesh& mesh)
:
    mesh_(mesh),
    planes_(facePlanes(mesh)),
    beyond_(mesh),
    reach_(mesh.nCells(), GREAT)
{
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
        const label beyond = other - mesh_.nCells();
        parts_.append
        (
            beyond < 0 ? part(other, centre, b) : partBeyond(beyond, centre, b)
        );
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
