/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "averaging/CellsBeyond.H"
#include "foam/foamVersion.H"
#include "globalMeshData.H"
#include "mapDistribute.H"
#include "PstreamBuffers.H"
#include "UIPstream.H"
#include "UOPstream.H"
#include "volMesh.H"

#include <map>

namespace Foam
{

// * * * * * * * * * * * * * * Local Functions * * * * * * * * * * * * * * * //

namespace
{

//- All cells of both, each once
struct Unite
{
    void operator()
    (
        List<CellsBeyond::Cell>& all,
        const List<CellsBeyond::Cell>& more
    ) const
    {
        for (const CellsBeyond::Cell& other : more)
        {
            if (!all.found(other))
            {
                all.append(other);
            }
        }
    }
};


//- Cells as they lie from the other side of periodic patches
struct Transform
{
    template<class Lists>
    void operator()
    (
        const vectorTensorTransform& through,
        const bool forward,
        Lists& lists
    ) const
    {
        const tensor R(forward ? through.R() : through.R().T());
        for (List<CellsBeyond::Cell>& cells : lists)
        {
            for (CellsBeyond::Cell& cell : cells)
            {
                const auto move = [&](point& p)
                {
                    p =
                        forward
                      ? through.transformPosition(p)
                      : through.invTransformPosition(p);
                };
                move(cell.centre);
                for (point& centre : cell.faceCentres)
                {
                    move(centre);
                }
                if (through.hasR())
                {
                    for (vector& normal : cell.normals)
                    {
                        normal = R & normal;
                    }
                }
            }
        }
    }
};


CellsBeyond::Cell ownCell(const fvMesh& mesh, const label celli)
{
    const cell& faces = mesh.cells()[celli];
    CellsBeyond::Cell own
    {
        Pstream::myProcNo(), celli, cbrt(mesh.V()[celli]), mesh.cellCentres()[celli],
        pointField(faces.size()), vectorField(faces.size())
    };
    forAll(faces, i)
    {
        const label facei = faces[i];
        const vector& area = mesh.faceAreas()[facei];
        own.faceCentres[i] = mesh.faceCentres()[facei];
        own.normals[i] = area/mag(area);
        if (mesh.faceOwner()[facei] != celli)
        {
            own.normals[i] *= -1;
        }
    }
    return own;
}


List<FacePlane> planesOf(const CellsBeyond::Cell& cell)
{
    List<FacePlane> planes(cell.normals.size());
    forAll(planes, i)
    {
        planes[i] = FacePlane(cell.normals[i], cell.faceCentres[i]);
    }
    return planes;
}


//- Cells, each once, found by whose they are
struct Found
{
    DynamicList<CellsBeyond::Cell> cells;
    std::map<std::pair<label, label>, DynamicList<label>> images;

    //- Index of a cell, which is appended if it is new
    label index(const CellsBeyond::Cell& cell)
    {
        DynamicList<label>& known = images[{cell.proci, cell.celli}];
        for (const label i : known)
        {
            if (cells[i] == cell)
            {
                return i;
            }
        }
        known.append(cells.size());
        cells.append(cell);
        return known.last();
    }
};

} // End anonymous namespace


Ostream& operator<<(Ostream& os, const CellsBeyond::Cell& cell)
{
    return os
        << cell.proci << token::SPACE << cell.celli << token::SPACE
        << cell.size << token::SPACE << cell.centre << token::SPACE
        << cell.faceCentres << token::SPACE << cell.normals;
}


Istream& operator>>(Istream& is, CellsBeyond::Cell& cell)
{
    return is
        >> cell.proci >> cell.celli >> cell.size >> cell.centre
        >> cell.faceCentres >> cell.normals;
}


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

List<List<CellsBeyond::Cell>> CellsBeyond::own(const fvMesh& mesh)
{
    List<List<Cell>> cells(mesh.nPoints());
    for (const label pointi : mesh.globalData().coupledPatch().meshPoints())
    {
        for (const label celli : mesh.pointCells()[pointi])
        {
            cells[pointi].append(ownCell(mesh, celli));
        }
    }
    return cells;
}


void CellsBeyond::announce(const UList<Cell>& cells)
{
    List<DynamicList<label>> places(Pstream::nProcs());
    List<DynamicList<label>> homes(Pstream::nProcs());
    forAll(cells, i)
    {
        places[cells[i].proci].append(i);
        homes[cells[i].proci].append(cells[i].celli);
    }

    PstreamBuffers streams(Pstream::commsTypes::nonBlocking);
    labelList received(Pstream::nProcs(), Zero);
    forAll(homes, proci)
    {
        places_[proci].transfer(places[proci]);
        if (proci == Pstream::myProcNo())
        {
            homes_[proci].transfer(homes[proci]);
        }
        else if (homes[proci].size())
        {
            UOPstream os(proci, streams);
            os << homes[proci];
        }
    }
    streams.finishedSends(received);
    forAll(received, proci)
    {
        if (proci != Pstream::myProcNo() && received[proci])
        {
            UIPstream is(proci, streams);
            is >> homes_[proci];
        }
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

CellsBeyond::CellsBeyond(const fvMesh& mesh)
:
    nCells_(mesh.nCells()),
    places_(Pstream::nProcs()),
    homes_(Pstream::nProcs())
{
    const indirectPrimitivePatch& coupled = mesh.globalData().coupledPatch();
    if (!returnReduce(coupled.size() > 0, orOp<bool>()))
    {
        return;
    }

    List<List<Cell>> around(own(mesh));
    const List<List<Cell>> here(around);
    mesh.globalData().syncPointData(around, Unite(), Transform());

    Found found;
    for (const label pointi : coupled.meshPoints())
    {
        DynamicList<label> beyond;
        for (const Cell& other : around[pointi])
        {
            if (!here[pointi].found(other))
            {
                beyond.append(found.index(other));
            }
        }
        atPoint_.insert(pointi, beyond);
    }
    planes_.resize(found.cells.size());
    forAll(planes_, i)
    {
        planes_[i] = planesOf(found.cells[i]);
    }
    announce(found.cells);
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void CellsBeyond::bringHome(scalarField& sums) const
{
    PstreamBuffers streams(Pstream::commsTypes::nonBlocking);
    scalarField own;
    forAll(places_, proci)
    {
        if (places_[proci].empty())
        {
            continue;
        }
        scalarField values(places_[proci].size());
        forAll(values, i)
        {
            scalar& sum = sums[nCells_ + places_[proci][i]];
            values[i] = sum;
            sum = 0;
        }
        if (proci == Pstream::myProcNo())
        {
            own.transfer(values);
        }
        else
        {
            UOPstream os(proci, streams);
            os << values;
        }
    }

    labelList received(Pstream::nProcs(), Zero);
    streams.finishedSends(received);
    forAll(homes_, proci)
    {
        scalarField values;
        if (proci == Pstream::myProcNo())
        {
            values.transfer(own);
        }
        else if (received[proci])
        {
            UIPstream is(proci, streams);
            is >> values;
        }
        forAll(values, i)
        {
            sums[homes_[proci][i]] += values[i];
        }
    }
}


} // End namespace Foam
