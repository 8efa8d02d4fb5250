/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "FeedEntrance.H"
#include "foamVersion.H"
#include "polyMeshTetDecomposition.H"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace Foam
{

namespace
{

//- Coordinates in steps far above rounding and far below a cell: what two
//  decompositions of a mesh agree on
class Lattice
{
    const boundBox bounds_;
    const scalar step_;

public:

    explicit Lattice(const fvMesh& mesh)
    :
        bounds_(mesh.points()),
        step_(1e-9*bounds_.mag())
    {}

    std::array<int64_t, 3> operator()(const point& p) const
    {
        // Not a simple fraction: mesh points do not lie between two steps
        const vector steps((p - bounds_.min())/step_ + 0.371*vector::one);
        return
        {
            int64_t(std::floor(steps.x())),
            int64_t(std::floor(steps.y())),
            int64_t(std::floor(steps.z()))
        };
    }
};


template<class Piece>
point centre(const Piece& piece)
{
    return std::accumulate(piece.begin(), piece.end(), point(Zero))
       /scalar(piece.size());
}


//- All processors' pieces, in the order of their centres
template<class Piece>
List<Piece> gathered(const List<Piece>& own, const Lattice& lattice)
{
    List<List<Piece>> ofProcessor(Pstream::nProcs());
    ofProcessor[Pstream::myProcNo()] = own;
    Pstream::gatherList(ofProcessor);
    Pstream::scatterList(ofProcessor);

    List<Piece> all;
    for (const List<Piece>& list : ofProcessor)
    {
        all.append(list);
    }
    std::sort
    (
        all.begin(), all.end(),
        [&](const Piece& a, const Piece& b)
        {
            return lattice(centre(a)) < lattice(centre(b));
        }
    );
    return all;
}


vector areaNormal(const triPoints& t)
{
    return 0.5*((t[1] - t[0]) ^ (t[2] - t[0]));
}


scalar size(const triPoints& t)
{
    return mag(areaNormal(t));
}


scalar size(const FixedList<point, 4>& t)
{
    return mag(((t[1] - t[0]) ^ (t[2] - t[0])) & (t[3] - t[0]))/6;
}


template<class Piece>
scalarList cumulativeShares(const List<Piece>& pieces)
{
    scalarList shares(pieces.size());
    scalar sum = 0;
    forAll(pieces, i)
    {
        sum += size(pieces[i]);
        shares[i] = sum;
    }
    for (scalar& share : shares)
    {
        share /= sum;
    }
    return shares;
}


//- Uniform over a triangle
point within(const triPoints& t, const scalar r, const scalar s)
{
    const scalar root = std::sqrt(r);
    return (1 - root)*t[0] + root*(1 - s)*t[1] + root*s*t[2];
}


//- Uniform over a tetrahedron: the sorted numbers cut the unit interval into
//  four parts that are uniform on the simplex
point within
(
    const FixedList<point, 4>& t,
    const scalar r,
    const scalar s,
    const scalar q
)
{
    std::array<scalar, 3> cut{r, s, q};
    std::sort(cut.begin(), cut.end());
    return
        cut[0]*t[0] + (cut[1] - cut[0])*t[1] + (cut[2] - cut[1])*t[2]
      + (1 - cut[2])*t[3];
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void FeedEntrance::collectPatch(const polyPatch& patch)
{
    const polyMesh& mesh = patch.boundaryMesh().mesh();
    const pointField& p = mesh.points();
    DynamicList<triPoints> own;

    for (const face& f : patch)
    {
        // A fan around the first point is enough for a feed patch
        for (label i = 1; i < f.size() - 1; ++i)
        {
            own.append(triPoints(p[f[0]], p[f[i]], p[f[i+1]]));
        }
    }
    triangles_ = gathered(List<triPoints>(own), Lattice(refCast<const fvMesh>(mesh)));
    cumulativeShare_ = cumulativeShares(triangles_);
}


void FeedEntrance::collectZone(const fvMesh& mesh, const labelUList& cells)
{
    const Lattice lattice(mesh);
    DynamicList<FixedList<point, 4>> own;

    for (const label celli : cells)
    {
        for
        (
            const tetIndices& indices :
            polyMeshTetDecomposition::cellTetIndices(mesh, celli)
        )
        {
            const tetPointRef tet(indices.tet(mesh));
            FixedList<point, 4> corners{tet.a(), tet.b(), tet.c(), tet.d()};
            // A face turns round where it lies between processors
            std::sort
            (
                corners.begin(), corners.end(),
                [&](const point& a, const point& b)
                {
                    return lattice(a) < lattice(b);
                }
            );
            own.append(corners);
        }
    }
    tetrahedra_ = gathered(List<FixedList<point, 4>>(own), lattice);
    cumulativeShare_ = cumulativeShares(tetrahedra_);
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

FeedEntrance::FeedEntrance(const fvMesh& mesh, const dictionary& dict)
{
    if (dict.found("patch") == dict.found("zone"))
    {
        FatalIOErrorInFunction(dict)
            << "give either patch or zone: where the feed enters"
            << exit(FatalIOError);
    }

    if (dict.found("patch"))
    {
        const word name(dict.get<word>("patch"));
        const label patchi = mesh.boundaryMesh().findPatchID(name);
        if (patchi < 0)
        {
            FatalIOErrorInFunction(dict)
                << "patch is " << name << ", allowed: "
                << mesh.boundaryMesh().names() << exit(FatalIOError);
        }
        collectPatch(mesh.boundaryMesh()[patchi]);
    }
    else
    {
        const word name(dict.get<word>("zone"));
        const label zonei = mesh.cellZones().findZoneID(name);
        if (returnReduce(zonei, maxOp<label>()) < 0)
        {
            FatalIOErrorInFunction(dict)
                << "zone is " << name << ", allowed: "
                << mesh.cellZones().names() << exit(FatalIOError);
        }
        collectZone
        (
            mesh,
            zonei < 0 ? labelUList() : labelUList(mesh.cellZones()[zonei])
        );
    }

    if (cumulativeShare_.empty() || !(cumulativeShare_.last() > 0))
    {
        FatalIOErrorInFunction(dict)
            << "the feed's patch or zone has no faces or cells"
            << exit(FatalIOError);
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

point FeedEntrance::place
(
    const FixedList<scalar, 4>& random,
    const scalar radius
) const
{
    const label k = min
    (
        label
        (
            std::upper_bound
            (
                cumulativeShare_.cbegin(), cumulativeShare_.cend(), random[0]
            )
          - cumulativeShare_.cbegin()
        ),
        cumulativeShare_.size() - 1
    );

    if (triangles_.size())
    {
        const triPoints& t = triangles_[k];
        return
            within(t, random[1], random[2])
          - (1 + 1e-6)*radius*normalised(areaNormal(t));
    }
    return within(tetrahedra_[k], random[1], random[2], random[3]);
}


} // End namespace Foam
