/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/ContactSettings.H"
#include "contacts/meshDimensions.H"
#include "contacts/SymmetryWalls.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "laws/LawList.hpp"
#include "parallel/coresOfProcess.H"
#include "Enum.H"
#include "volFields.H"

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

//- The entry of two materials, under either name; empty: they have none. One
//  that another pair has taken, since names may hold a hyphen and a wall may be
//  called as a material, and two of one pair are refused
word entryOfPair
(
    const dictionary& pairs,
    const word& name,
    const word& reverse,
    wordHashSet& taken
)
{
    const bool here = pairs.found(name, keyType::LITERAL);
    const bool there =
        name != reverse && pairs.found(reverse, keyType::LITERAL);
    if (here && there)
    {
        FatalIOErrorInFunction(pairs)
            << "there are " << name << " and " << reverse << ", allowed: one"
            << " of both" << exit(FatalIOError);
    }
    const word taking(here ? name : there ? reverse : word());
    if (!taking.empty() && !taken.insert(taking))
    {
        FatalIOErrorInFunction(pairs)
            << taking << " is the name of two pairs of materials and walls,"
            << " allowed: materials without hyphens, and not called as a wall"
            << exit(FatalIOError);
    }
    return taking;
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
    wordHashSet taken;

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
            const word own(entryOfPair(pairs, name, reverse, taken));
            const dictionary& source =
                own.empty() ? dict.subDict(usual) : pairs.subDict(own);

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
    wordList wallNames(wallPatchNames(mesh));
    settings.box = periodicBox(mesh);

    const dictionary* own = subModels.findDict("cellListCoeffs");
    const dictionary* stock = subModels.findDict("pairCollisionCoeffs");
    if (own)
    {
        surfaces = readWallSurfaces(*own, mesh);
        wallNames.append(namesOf(surfaces));
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
            U, surfaces, particleNames.size(), settings.box, false, wallFaces
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
    walls = collectWalls(U, surfaces, nParticle, settings.box, true, wallFaces);
}


} // End namespace Foam
