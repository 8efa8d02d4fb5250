/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/caseWalls.H"
#include "contacts/SymmetryWalls.H"
#include "contacts/WallMotion.H"
#include "foam/engineVectors.H"
#include "foam/foamVersion.H"
#include "cyclicPolyPatch.H"
#include "wallPolyPatch.H"
#include "volFields.H"

#include <algorithm>
#include <array>

namespace Foam
{

namespace
{

//- Of a wall's face, as the tracking divides it
struct Triangle
{
    FixedList<point, 3> corners;
    label wall;         // index of the patch, then of the surface; planes of
                        // symmetry last
    label motion;       // face among its processor's, -1: does not move
    label place;        // of the face in the whole mesh
    label proci, facei; // of the face in its processor's mesh

    bool operator==(const Triangle& t) const
    {
        return
            corners == t.corners && wall == t.wall && motion == t.motion
         && place == t.place && proci == t.proci && facei == t.facei;
    }
    bool operator!=(const Triangle& t) const { return !(*this == t); }

    friend Ostream& operator<<(Ostream& os, const Triangle& t)
    {
        return os
            << t.corners << token::SPACE << t.wall << token::SPACE << t.motion
            << token::SPACE << t.place << token::SPACE << t.proci
            << token::SPACE << t.facei;
    }

    friend Istream& operator>>(Istream& is, Triangle& t)
    {
        return is
            >> t.corners >> t.wall >> t.motion >> t.place >> t.proci >> t.facei;
    }
};


//- Of each processor, by its number
template<class T>
List<T> everyones(const T& own)
{
    List<T> ofProcessors(Pstream::nProcs());
    ofProcessors[Pstream::myProcNo()] = own;
    Pstream::gatherList(ofProcessors);
    elutriaBroadcast(ofProcessors);
    return ofProcessors;
}


//- Index of each face in the mesh before it was decomposed; the own index where
//  that is not known
labelList facesOfWholeMesh(const polyMesh& mesh)
{
    labelList faces(identity(mesh.nFaces()));
    if (Pstream::parRun())
    {
        const labelIOList addressing
        (
            IOobject
            (
                "faceProcAddressing",
                mesh.facesInstance(),
                polyMesh::meshSubDir,
                mesh,
                IOobject::READ_IF_PRESENT,
                IOobject::NO_WRITE,
                false
            )
        );
        const bool known = addressing.size() == faces.size();
        if (returnReduce(known, andOp<bool>()))
        {
            forAll(faces, facei)
            {
                // Counted from 1, negative where turned
                faces[facei] = mag(addressing[facei]) - 1;
            }
        }
    }
    return faces;
}


//- Of this processor's walls, and of its planes of symmetry if these have a
//  number (not -1). Each face of a wall has a motion: counts those
List<Triangle> ownTriangles
(
    const polyMesh& mesh,
    const label symmetry,
    label& motions
)
{
    const labelList place(facesOfWholeMesh(mesh));
    DynamicList<Triangle> triangles;
    label walls = 0;
    motions = 0;
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        const bool mirror = symmetry >= 0 && isSymmetry(patch);
        if (!isA<wallPolyPatch>(patch) && !mirror)
        {
            continue;
        }
        const label wall = mirror ? symmetry : walls++;
        forAll(patch, patchFacei)
        {
            const face& f = patch[patchFacei];
            const label facei = patch.start() + patchFacei;
            const label motion = mirror ? -1 : motions++;
            faceList parts(f.nTriangles());
            label n = 0;
            f.triangles(mesh.points(), n, parts);
            for (const face& part : parts)
            {
                Triangle t
                {
                    {}, wall, motion, place[facei], Pstream::myProcNo(), facei
                };
                for (label k = 0; k < 3; ++k)
                {
                    t.corners[k] = mesh.points()[part[k]];
                }
                triangles.append(t);
            }
        }
    }
    return List<Triangle>(std::move(triangles));
}


//- Of all processors' patches, in the order of the whole mesh: results do not
//  show the decomposition. The motions are counted over all processors
std::vector<Triangle> patchTriangles
(
    const polyMesh& mesh,
    const label symmetry
)
{
    label ownMotions = 0;
    const List<List<Triangle>> ofProcessors
    (
        everyones(ownTriangles(mesh, symmetry, ownMotions))
    );
    const labelList motions(everyones(ownMotions));

    std::vector<Triangle> all;
    label before = 0;
    forAll(ofProcessors, proci)
    {
        for (const Triangle& t : ofProcessors[proci])
        {
            all.push_back(t);
            all.back().motion += t.motion < 0 ? 0 : before;
        }
        before += motions[proci];
    }
    std::stable_sort
    (
        all.begin(), all.end(),
        [](const Triangle& a, const Triangle& b) { return a.place < b.place; }
    );
    return all;
}


//- Add those of surfaces, which all processors know
void addSurfaces
(
    std::vector<Triangle>& triangles,
    const UList<WallSurface>& surfaces,
    const label firstWall
)
{
    forAll(surfaces, i)
    {
        for (const FixedList<point, 3>& corners : surfaces[i].triangles)
        {
            triangles.push_back({corners, firstWall + i, -1, -1, -1, -1});
        }
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * * Functions * * * * * * * * * * * * * * * * //

wordList wallPatchNames(const polyMesh& mesh)
{
    wordList names;
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        if (isA<wallPolyPatch>(patch))
        {
            names.append(patch.name());
        }
    }
    return names;
}


elutria::dem::Walls collectWalls
(
    const volVectorField& U,
    const UList<WallSurface>& surfaces,
    const uint32_t firstMaterial,
    const elutria::dem::PeriodicBox& box,
    const bool symmetryPlanes,
    std::vector<WallFace>& ofTriangles
)
{
    elutria::dem::WallGeometry geometry;
    const bool moves = anyWallMoves(U);
    if (moves)
    {
        geometry.motions = wallMotions(U);
    }
    ofTriangles.clear();

    const label nPatches = wallPatchNames(U.mesh()).size();
    std::vector<Triangle> triangles
    (
        patchTriangles
        (
            U.mesh(), symmetryPlanes ? nPatches + surfaces.size() : -1
        )
    );
    addSurfaces(triangles, surfaces, nPatches);

    // Triangles share points, across processors too
    HashTable<uint32_t, point, Hash<point>> known;
    for (const Triangle& t : triangles)
    {
        std::array<uint32_t, 3> triangle;
        for (label k = 0; k < 3; ++k)
        {
            const point& p = t.corners[k];
            if (!known.found(p))
            {
                known.insert(p, geometry.points.size());
                geometry.points.push_back(toEngine(p));
            }
            triangle[k] = known[p];
        }
        geometry.triangles.push_back(triangle);
        geometry.material.push_back(firstMaterial + t.wall);
        if (moves)
        {
            geometry.motion.push_back
            (
                t.motion < 0 ? geometry.motions.size() - 1 : t.motion
            );
        }
        ofTriangles.push_back({t.proci, t.facei});
    }
    return elutria::dem::Walls(std::move(geometry), box);
}


elutria::dem::PeriodicBox periodicBox(const polyMesh& mesh)
{
    elutria::dem::PeriodicBox box;
    const boundBox bounds(mesh.bounds());
    box.low = toEngine(bounds.min());
    box.high = toEngine(bounds.max());

    boolList periodic(3, false);
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        const auto* cyclic = isA<cyclicPolyPatch>(patch);
        if (!cyclic || !cyclic->size() || !cyclic->owner())
        {
            continue;
        }

        const vector separation
        (
            cyclic->transform() == cyclicPolyPatch::ROTATIONAL
          ? vector::uniform(VGREAT)
          : cyclic->neighbPatch().faceCentres()[0] - cyclic->faceCentres()[0]
        );
        const label axis =
            findMax(scalarList({mag(separation.x()), mag(separation.y()),
            mag(separation.z())}));

        const scalar length = bounds.span()[axis];
        if (mag(mag(separation) - length) > 1e-6*length)
        {
            FatalErrorInFunction
                << "cyclic patch " << patch.name() << " has a separation of "
                << separation << ", allowed with contacts: along one axis, the"
                << " length of the whole mesh" << exit(FatalError);
        }
        periodic[axis] = true;
    }

    for (label axis = 0; axis < 3; ++axis)
    {
        box.periodic[axis] = returnReduce(bool(periodic[axis]), orOp<bool>());
    }
    return box;
}


} // End namespace Foam
