/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/FeedEntrance.H"
#include "foam/foamVersion.H"
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


point centre(const FeedEntrance::Piece& piece)
{
    return 0.25*(piece[0] + piece[1] + piece[2] + piece[3]);
}


//- All processors' pieces, in the order of their centres
List<FeedEntrance::Piece> gathered
(
    const List<FeedEntrance::Piece>& own,
    const Lattice& lattice
)
{
    typedef FeedEntrance::Piece Piece;
    List<List<Piece>> ofProcessor(Pstream::nProcs());
    ofProcessor[Pstream::myProcNo()] = own;
    Pstream::gatherList(ofProcessor);
    elutriaBroadcast(ofProcessor);

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


//- Of the triangle of the first three corners
vector areaNormal(const FeedEntrance::Piece& t)
{
    return 0.5*((t[1] - t[0]) ^ (t[2] - t[0]));
}


//- Uniform over the triangle of the first three corners
point within(const FeedEntrance::Piece& t, const scalar r, const scalar s)
{
    const scalar root = std::sqrt(r);
    return (1 - root)*t[0] + root*(1 - s)*t[1] + root*s*t[2];
}


//- Uniform over a tetrahedron: the sorted numbers cut the unit interval into
//  four parts that are uniform on the simplex
point within
(
    const FeedEntrance::Piece& t,
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

scalar FeedEntrance::size(const Piece& t) const
{
    return onPatch_ ? mag(areaNormal(t)) : mag(areaNormal(t) & (t[3] - t[0]))/3;
}


List<FeedEntrance::Piece> FeedEntrance::ofPatch
(
    const fvMesh& mesh,
    const dictionary& dict
) const
{
    const word name(dict.get<word>("patch"));
    const label patchi = mesh.boundaryMesh().findPatchID(name);
    if (patchi < 0)
    {
        FatalIOErrorInFunction(dict)
            << "patch is " << name << ", allowed: "
            << mesh.boundaryMesh().names() << exit(FatalIOError);
    }

    const polyPatch& patch = mesh.boundaryMesh()[patchi];
    DynamicList<Piece> own;
    forAll(patch, i)
    {
        const label celli = patch.faceCells()[i];
        for
        (
            const tetIndices& tet :
            polyMeshTetDecomposition::faceTetIndices
            (
                mesh, patch.start() + i, celli
            )
        )
        {
            const triPointRef face(tet.faceTri(mesh));
            own.append(Piece{face.a(), face.b(), face.c(), mesh.cellCentres()[celli]});
        }
    }
    return gathered(own, Lattice(mesh));
}


List<FeedEntrance::Piece> FeedEntrance::ofZone
(
    const fvMesh& mesh,
    const dictionary& dict
) const
{
    const word name(dict.get<word>("zone"));
    const label zonei = mesh.cellZones().findZoneID(name);
    if (returnReduce(zonei, maxOp<label>()) < 0)
    {
        FatalIOErrorInFunction(dict)
            << "zone is " << name << ", allowed: "
            << mesh.cellZones().names() << exit(FatalIOError);
    }

    const labelUList cells
    (
        zonei < 0 ? labelUList() : labelUList(mesh.cellZones()[zonei])
    );
    const Lattice lattice(mesh);
    DynamicList<Piece> own;
    for (const label celli : cells)
    {
        for
        (
            const tetIndices& indices :
            polyMeshTetDecomposition::cellTetIndices(mesh, celli)
        )
        {
            const tetPointRef tet(indices.tet(mesh));
            Piece corners{tet.a(), tet.b(), tet.c(), tet.d()};
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
    return gathered(own, lattice);
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

FeedEntrance::FeedEntrance(const fvMesh& mesh, const dictionary& dict)
:
    onPatch_(dict.found("patch"))
{
    if (onPatch_ == dict.found("zone"))
    {
        FatalIOErrorInFunction(dict)
            << "give either patch or zone: where the feed enters"
            << exit(FatalIOError);
    }

    pieces_ =
        onPatch_
      ? ofPatch(mesh, dict)
      : ofZone(mesh, dict);

    cumulativeShare_.resize(pieces_.size());
    scalar sum = 0;
    forAll(pieces_, i)
    {
        sum += size(pieces_[i]);
        cumulativeShare_[i] = sum;
    }
    if (!(sum > 0))
    {
        FatalIOErrorInFunction(dict)
            << "the feed's patch or zone has no faces or cells"
            << exit(FatalIOError);
    }
    for (scalar& share : cumulativeShare_)
    {
        share /= sum;
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

point FeedEntrance::place
(
    const FixedList<scalar, 4>& random,
    const scalar radius,
    const bool retreat
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
    const Piece& piece = pieces_[k];

    if (!onPatch_)
    {
        const point p(within(piece, random[1], random[2], random[3]));
        return retreat ? p + 1e-6*(centre(piece) - p) : p;
    }
    const point p(within(piece, random[1], random[2]));
    const vector outward(normalised(areaNormal(piece)));
    const scalar depth = (1 + 1e-6)*radius;
    if (!retreat)
    {
        return p - depth*outward;
    }
    const scalar deepest = max((p - piece[3]) & outward, VSMALL);
    return p + min(depth/deepest, scalar(0.5))*(piece[3] - p);
}


} // End namespace Foam
