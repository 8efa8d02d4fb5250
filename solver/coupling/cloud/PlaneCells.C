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

//- Is the cell convex, with plane faces?
bool isConvexAndPlane
(
    const polyMesh& mesh,
    const UList<FacePlane>& planes,
    const label celli
)
{
    for (const label facei : mesh.cells()[celli])
    {
        const FacePlane& plane = planes[facei];
        const scalar size = sqrt(mag(mesh.faceAreas()[facei]));
        const scalar outwards = mesh.faceOwner()[facei] == celli ? 1 : -1;
        for (const label pointi : mesh.cellPoints()[celli])
        {
            if (outwards*plane.beyond(mesh.points()[pointi]) > flatness*size)
            {
                return false;
            }
        }
        for (const label pointi : mesh.faces()[facei])
        {
            if (mag(plane.beyond(mesh.points()[pointi])) > flatness*size)
            {
                return false;
            }
        }
    }
    return true;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

const PlaneCells::Side* PlaneCells::exit
(
    const label celli,
    const point& from,
    const point& to
) const
{
    const Side* first = nullptr;
    scalar firstPart = GREAT;
    for (label i = first_[celli]; i < first_[celli + 1]; ++i)
    {
        const Side& side = sides_[i];
        const scalar beyond = side.plane.beyond(to);
        if (beyond > 0)
        {
            const scalar before = -side.plane.beyond(from);
            const scalar part = max(before, scalar(0))/(before + beyond);
            if (part < firstPart)
            {
                first = &side;
                firstPart = part;
            }
        }
    }
    return first;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

PlaneCells::PlaneCells(const polyMesh& mesh)
:
    first_(mesh.nCells() + 1)
{
    List<FacePlane> planes(facePlanes(mesh));
    boolList plain(mesh.nCells());
    forAll(plain, celli)
    {
        plain[celli] = isConvexAndPlane(mesh, planes, celli);
    }
    for (label facei = mesh.nInternalFaces(); facei < mesh.nFaces(); ++facei)
    {
        planes[facei].offset -= onBoundary*sqrt(mag(mesh.faceAreas()[facei]));
    }

    sides_.reserve(2*mesh.nFaces());
    forAll(plain, celli)
    {
        first_[celli] = sides_.size();
        if (!plain[celli])
        {
            continue;
        }
        for (const label facei : mesh.cells()[celli])
        {
            const bool owns = mesh.faceOwner()[facei] == celli;
            sides_.append
            ({
                owns ? planes[facei] : planes[facei].fromBehind(),
                !mesh.isInternalFace(facei) ? -1
              : owns ? mesh.faceNeighbour()[facei]
              : mesh.faceOwner()[facei]
            });
        }
    }
    first_.last() = sides_.size();
    sides_.shrink();
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

label PlaneCells::follow(label celli, const point& from, const point& to) const
{
    for (label passed = 0; passed < mostCells && isPlain(celli); ++passed)
    {
        const Side* side = exit(celli, from, to);
        if (!side)
        {
            return celli;
        }
        celli = side->behind;
        if (celli < 0)
        {
            return -1;
        }
    }
    return -1;
}


} // End namespace Foam
