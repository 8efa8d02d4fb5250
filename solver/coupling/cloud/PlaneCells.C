/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/PlaneCells.H"

namespace Foam
{

namespace
{

//- Of a cell's points from the planes of its faces, over the face's size
constexpr scalar flatness = 1e-6;

//- Distance from the boundary that is on it, over the face's size
constexpr scalar onBoundary = 1e-9;

//- Cells that a way leads through, at most: a corner is passed by rounding
constexpr label mostCells = 10000;

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

bool PlaneCells::isPlain(const label celli) const
{
    for (const label facei : mesh_.cells()[celli])
    {
        const FacePlane& plane = planes_[facei];
        const scalar size = sqrt(mag(mesh_.faceAreas()[facei]));
        const scalar outwards = mesh_.faceOwner()[facei] == celli ? 1 : -1;
        for (const label pointi : mesh_.cellPoints()[celli])
        {
            if
            (
                outwards*plane.beyond(mesh_.points()[pointi]) > flatness*size
            )
            {
                return false;
            }
        }
        for (const label pointi : mesh_.faces()[facei])
        {
            if (mag(plane.beyond(mesh_.points()[pointi])) > flatness*size)
            {
                return false;
            }
        }
    }
    return true;
}


label PlaneCells::exit
(
    const label celli,
    const point& from,
    const point& to
) const
{
    const labelUList& owner = mesh_.faceOwner();
    label first = -1;
    scalar firstPart = GREAT;
    for (const label facei : mesh_.cells()[celli])
    {
        const FacePlane& plane = planes_[facei];
        const scalar outwards = owner[facei] == celli ? 1 : -1;
        const scalar beyond = outwards*plane.beyond(to);
        if (beyond > 0)
        {
            const scalar before = -outwards*plane.beyond(from);
            const scalar part = max(before, scalar(0))/(before + beyond);
            if (part < firstPart)
            {
                first = facei;
                firstPart = part;
            }
        }
    }
    return first;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

PlaneCells::PlaneCells(const polyMesh& mesh)
:
    mesh_(mesh),
    planes_(facePlanes(mesh)),
    plain_(mesh.nCells())
{
    forAll(plain_, celli)
    {
        plain_[celli] = isPlain(celli);
    }
    for (label facei = mesh.nInternalFaces(); facei < mesh.nFaces(); ++facei)
    {
        planes_[facei].offset -= onBoundary*sqrt(mag(mesh.faceAreas()[facei]));
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

label PlaneCells::follow(label celli, const point& from, const point& to) const
{
    for (label passed = 0; passed < mostCells && plain_[celli]; ++passed)
    {
        const label facei = exit(celli, from, to);
        if (facei < 0)
        {
            return celli;
        }
        if (!mesh_.isInternalFace(facei))
        {
            return -1;
        }
        const label owner = mesh_.faceOwner()[facei];
        celli = owner == celli ? mesh_.faceNeighbour()[facei] : owner;
    }
    return -1;
}


} // End namespace Foam
