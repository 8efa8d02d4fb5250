/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/ContactSettings.H"
#include "contacts/meshDimensions.H"
#include "contacts/SymmetryWalls.H"
#include "contacts/WallMotion.H"
#include "foam/foamVersion.H"
#include "foam/engineVectors.H"
#include "foam/ownEntries.H"
#include "laws/LawList.hpp"
#include "parallel/coresOfProcess.H"
#include "cyclicPolyPatch.H"
#include "processorCyclicPolyPatch.H"
#include "Enum.H"
#include "OSspecific.H"
#include "SubField.H"
#include "wallPolyPatch.H"
#include "volFields.H"

#include <algorithm>
#include <stdexcept>

namespace Foam
{

namespace
{

using elutria::dem::ContactLaw;
using elutria::dem::ContactLaws;
using elutria::dem::ContactMaterial;
using elutria::dem::ContactTreatment;
using elutria::dem::NeighbourSearch;
using elutria::dem::PairProperties;

//- The law that an entry names
const ContactLaw& readLaw(const dictionary& dict)
{
    const word name(dict.get<word>("contactLaw"));
    const size_t place = ContactLaws::find(name);
    if (place == ContactLaws::size)
    {
        wordList allowed;
        for (const ContactLaw* law : ContactLaws::laws)
        {
            if (string::valid<word>(law->name))
            {
                allowed.append(law->name);
            }
        }
        FatalIOErrorInFunction(dict)
            << "contactLaw is " << name << ", allowed: " << allowed
            << exit(FatalIOError);
    }
    return *ContactLaws::laws[place];
}


//- The law of a kind of contacts, where its own dictionary names one
const ContactLaw& readLaw(const dictionary& dict, const word& contacts)
{
    const dictionary& own = dict.subOrEmptyDict(contacts);
    return readLaw(own.found("contactLaw") ? own : dict);
}


const Enum<ContactTreatment> treatments
({
    {ContactTreatment::automatic, "auto"},
    {ContactTreatment::soft, "soft"},
    {ContactTreatment::impact, "impact"},
});

const Enum<NeighbourSearch> searches
({
    {NeighbourSearch::automatic, "auto"},
    {NeighbourSearch::bruteForce, "bruteForce"},
    {NeighbourSearch::cells, "cells"},
    {NeighbourSearch::verlet, "verlet"},
    {NeighbourSearch::hierarchical, "hierarchical"},
});


ContactMaterial readMaterial(const word& name, const dictionary& dict)
{
    ContactMaterial material;
    material.name = name;
    material.youngsModulus = dict.get<scalar>("youngsModulus");
    material.poissonRatio = dict.get<scalar>("poissonsRatio");
    return material;
}


PairProperties readPair(const dictionary& dict, const ContactLaw& law)
{
    requireOwnEntries(dict, ownDictionary::contactPair);
    PairProperties pair;
    dict.readEntry("restitution", pair.restitution);
    dict.readEntry("friction", pair.friction);
    dict.readIfPresent("rollingFriction", pair.rollingFriction);
    dict.readIfPresent("cohesion", pair.cohesion);
    if (law.givenStiffness)
    {
        dict.readEntry("normalStiffness", pair.normalStiffness);
        dict.readIfPresent("tangentialRatio", pair.tangentialRatio);
    }
    return pair;
}


PairProperties readStockPair(const dictionary& dict)
{
    PairProperties pair;
    dict.readEntry("alpha", pair.damping);
    dict.readEntry("b", pair.exponent);
    dict.readEntry("mu", pair.friction);
    dict.readEntry("cohesionEnergyDensity", pair.cohesion);
    return pair;
}


//- So many threads as asked for, or those that have a core: more would wait
//  for each other. A user may insist.
label threadsWithCores(const label asked)
{
    const label cores = coresOfProcess();
    if (asked <= cores || getEnv("ELUTRIA_EXACT") == "yes")
    {
        return asked;
    }
    Info<< "elutria: cellListCoeffs: threads " << asked << " -> " << cores
        << ": there " << (cores > 1 ? "are " : "is ") << cores << " core"
        << (cores > 1 ? "s" : "") << " for each process (ELUTRIA_EXACT=yes"
        << " takes " << asked << ')' << endl;
    return cores;
}


//- Stock's effective modulus of two materials [Pa]
scalar effectiveModulus(const ContactMaterial& a, const ContactMaterial& b)
{
    return
        1
       /(
            (1 - sqr(a.poissonRatio))/a.youngsModulus
          + (1 - sqr(b.poissonRatio))/b.youngsModulus
        );
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void ContactSettings::readOwn
(
    const dictionary& dict,
    const wordList& particleNames,
    const wordList& wallNames
)
{
    requireOwnEntries(dict, ownDictionary::cellList);
    for (const char* const name : {"particle", "wall"})
    {
        requireOwnEntries(dict.subDict(name), ownDictionary::contactMaterial);
    }
    settings.law = &readLaw(dict, "particleParticle");
    settings.wallLaw = &readLaw(dict, "particleWall");
    settings.treatment =
        treatments.getOrDefault("treatment", dict, settings.treatment);
    settings.search = searches.getOrDefault("search", dict, settings.search);
    settings.threads = threadsWithCores(dict.getOrDefault<label>("threads", 1));
    settings.cellLayers = dict.getOrDefault<label>("cellLayers", 1);
    dict.readIfPresent("stepFraction", settings.stepFraction);
    if (settings.stepFraction > largestStepFraction)
    {
        FatalIOErrorInFunction(dict)
            << "stepFraction is " << settings.stepFraction
            << ", allowed: above 0, up to " << largestStepFraction
            << " of the duration of a contact" << exit(FatalIOError);
    }
    dict.readIfPresent("step", settings.step);
    dict.readIfPresent("skin", settings.skin);

    for (const word& name : particleNames)
    {
        materials.add(readMaterial(name, dict.subDict("particle")));
    }
    for (const word& name : wallNames)
    {
        materials.add(readMaterial(name, dict.subDict("wall")));
    }

    const label nParticle = particleNames.size();
    const label n = nParticle + wallNames.size();
    const dictionary& pairs = dict.subOrEmptyDict("pairs");
    wordList pairNames;

    for (label a = 0; a < nParticle; ++a)
    {
        for (label b = a; b < n; ++b)
        {
            const word name(materials[a].name + '-' + materials[b].name);
            const word reverse(materials[b].name + '-' + materials[a].name);
            pairNames.append(name);
            pairNames.append(reverse);
            const word usual
            (
                b < nParticle ? "particleParticle" : "particleWall"
            );
            const dictionary& source =
                pairs.found(name) ? pairs.subDict(name)
              : pairs.found(reverse) ? pairs.subDict(reverse)
              : dict.subDict(usual);

            materials.setPair
            (
                a,
                b,
                readPair
                (
                    source,
                    b < nParticle ? *settings.law : settings.lawAtWalls()
                )
            );
        }
    }
    requireEntries(pairs, pairNames);
}


void ContactSettings::readStock
(
    const dictionary& coeffs,
    const dictionary& constants,
    const wordList& particleNames,
    const wordList& wallNames
)
{
    settings.law = &elutria::dem::contactLaw<elutria::dem::SpringSliderDashpot>;

    const word pairModel(coeffs.get<word>("pairModel"));
    const dictionary& pairDict = coeffs.subDict(pairModel + "Coeffs");

    const word wallModel(coeffs.get<word>("wallModel"));
    const dictionary& wallDict = coeffs.subDict(wallModel + "Coeffs");
    const bool local = wallModel == "wallLocalSpringSliderDashpot";

    const auto wallPart = [&](const word& name) -> const dictionary&
    {
        return local ? wallDict.subDict(name) : wallDict;
    };

    for (const word& name : particleNames)
    {
        materials.add(readMaterial(name, constants));
    }
    for (const word& name : wallNames)
    {
        materials.add(readMaterial(name, wallPart(name)));
    }

    const label nParticle = particleNames.size();
    for (label a = 0; a < nParticle; ++a)
    {
        for (label b = a; b < nParticle; ++b)
        {
            materials.setPair(a, b, readStockPair(pairDict));
        }
        forAll(wallNames, w)
        {
            materials.setPair
            (
                a, nParticle + w, readStockPair(wallPart(wallNames[w]))
            );
        }
    }

    stockResolution = pairDict.get<scalar>("collisionResolutionSteps");
    settings.stepFraction =
        min(largestStepFraction, 1/max(stockResolution, scalar(1)));
    for (uint32_t b = 0; b < materials.size(); ++b)
    {
        stockModulus =
            max(stockModulus, effectiveModulus(materials[0], materials[b]));
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

ContactSettings::ContactSettings
(
    const dictionary& subModels,
    const dictionary& constants,
    const wordList& particleNames,
    const volVectorField& U
)
{
    const polyMesh& mesh = U.mesh();
    requireDepth(mesh);
    const wordList wallNames(wallPatchNames(mesh));
    settings.box = periodicBox(mesh);

    const dictionary* own = subModels.findDict("cellListCoeffs");
    const dictionary* stock = subModels.findDict("pairCollisionCoeffs");
    if (own)
    {
        readOwn(*own, particleNames, wallNames);
    }
    else if (stock)
    {
        readStock(*stock, constants, particleNames, wallNames);
    }
    else
    {
        FatalIOErrorInFunction(subModels)
            << "collisionModel cellList needs cellListCoeffs or"
            << " pairCollisionCoeffs" << exit(FatalIOError);
    }
    try
    {
        materials.check();
        walls = collectWalls
        (
            U, particleNames.size(), settings.box, false, wallFaces
        );
    }
    catch (const std::invalid_argument& error)
    {
        FatalIOErrorInFunction(own ? *own : *stock)
            << error.what() << exit(FatalIOError);
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void ContactSettings::addSymmetryWalls
(
    const label nParticle,
    const volVectorField& U
)
{
    addSymmetryMaterial(materials, nParticle, U.mesh());
    walls = collectWalls(U, nParticle, settings.box, true, wallFaces);
}


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


namespace
{

//- Every processor's entry, on every processor
template<class T>
void everyones(List<T>& ofProcessors)
{
    Pstream::gatherList(ofProcessors);
    elutriaBroadcast(ofProcessors);
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

} // End anonymous namespace


elutria::dem::Walls collectWalls
(
    const volVectorField& U,
    const uint32_t firstMaterial,
    const elutria::dem::PeriodicBox& box,
    const bool symmetryPlanes,
    std::vector<WallFace>& ofTriangles
)
{
    const polyMesh& mesh = U.mesh();

    // Own wall faces, triangulated as the tracking does; nine numbers, the
    // wall's and the face's index a triangle (-1: a plane of symmetry)
    List<pointField> corners(Pstream::nProcs());
    List<labelList> wallOf(Pstream::nProcs());
    List<labelList> faceOf(Pstream::nProcs());
    List<labelList> placeOf(Pstream::nProcs());
    List<labelList> meshFaceOf(Pstream::nProcs());
    labelList faces(Pstream::nProcs(), 0);
    DynamicList<point> ownCorners;
    DynamicList<label> ownWall;
    DynamicList<label> ownFace;
    DynamicList<label> ownPlace;
    DynamicList<label> ownMeshFace;
    const labelList wholeFaces(facesOfWholeMesh(mesh));
    label& nFaces = faces[Pstream::myProcNo()];

    const label symmetry = wallPatchNames(mesh).size();
    label walls = 0;
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        if (!isA<wallPolyPatch>(patch) && !(symmetryPlanes && isSymmetry(patch)))
        {
            continue;
        }
        const label wall = isSymmetry(patch) ? symmetry : walls++;
        forAll(patch, patchFacei)
        {
            const face& f = patch[patchFacei];
            const label facei = wall == symmetry ? -1 : nFaces++;
            faceList triangles(f.nTriangles());
            label n = 0;
            f.triangles(mesh.points(), n, triangles);
            for (const face& t : triangles)
            {
                for (const label pointi : t)
                {
                    ownCorners.append(mesh.points()[pointi]);
                }
                ownWall.append(wall);
                ownFace.append(facei);
                ownMeshFace.append(patch.start() + patchFacei);
                ownPlace.append(wholeFaces[ownMeshFace.last()]);
            }
        }
    }
    const label me = Pstream::myProcNo();
    corners[me] = ownCorners;
    wallOf[me] = ownWall;
    faceOf[me] = ownFace;
    placeOf[me] = ownPlace;
    meshFaceOf[me] = ownMeshFace;
    everyones(corners);
    everyones(wallOf);
    everyones(faceOf);
    everyones(placeOf);
    everyones(meshFaceOf);
    everyones(faces);

    elutria::dem::WallGeometry geometry;
    const bool moves = anyWallMoves(U);
    if (moves)
    {
        geometry.motions = wallMotions(U);
    }
    // In the order of the whole mesh: results do not show the decomposition
    struct Triangle { label place, proci, i; };
    std::vector<Triangle> triangles;
    labelList firstFace(Pstream::nProcs(), 0);
    forAll(corners, proci)
    {
        firstFace[proci] = proci ? firstFace[proci - 1] + faces[proci - 1] : 0;
        forAll(wallOf[proci], i)
        {
            triangles.push_back({placeOf[proci][i], proci, i});
        }
    }
    std::stable_sort
    (
        triangles.begin(), triangles.end(),
        [](const Triangle& a, const Triangle& b) { return a.place < b.place; }
    );

    ofTriangles.clear();

    // Triangles share points, across processors too
    HashTable<uint32_t, point, Hash<point>> known;
    for (const Triangle& t : triangles)
    {
        std::array<uint32_t, 3> triangle;
        for (label k = 0; k < 3; ++k)
        {
            const point& p = corners[t.proci][3*t.i + k];
            if (!known.found(p))
            {
                known.insert(p, geometry.points.size());
                geometry.points.push_back(toEngine(p));
            }
            triangle[k] = known[p];
        }
        geometry.triangles.push_back(triangle);
        ofTriangles.push_back({t.proci, meshFaceOf[t.proci][t.i]});
        geometry.material.push_back(firstMaterial + wallOf[t.proci][t.i]);
        if (moves)
        {
            const label facei = faceOf[t.proci][t.i];
            geometry.motion.push_back
            (
                facei < 0 ? geometry.motions.size() - 1
              : firstFace[t.proci] + facei
            );
        }
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
