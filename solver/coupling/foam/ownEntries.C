/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "foam/ownEntries.H"
#include "foam/fileEntries.H"
#include "foam/foamVersion.H"
#include "foam/standsIn.H"
#include "OSspecific.H"
#include "Pstream.H"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <vector>

namespace Foam
{

namespace
{

//- The entries of each dictionary
wordList entriesOf(const ownDictionary kind)
{
    switch (kind)
    {
        case ownDictionary::feed:
            return
            {
                "outlets", "planes", "partitionTo", "patch", "zone", "loading", "massFlowRate", "start",
                "duration", "particles", "parcels", "focus",
                "particlesPerParcel", "drainTime", "velocity", "seed",
                "materials"
            };
        case ownDictionary::planes:
            return {"first", "spacing", "number"};
        case ownDictionary::material:
            return
            {
                "density", "densityDistribution", "sphericity", "flatness",
                "elongation", "measuredVelocity", "massFraction",
                "sizeDistribution"
            };
        case ownDictionary::measuredVelocity:
            return {"file", "gasDensity", "gasViscosity"};
        case ownDictionary::selfInducedVelocity:
            return {"correct"};
        case ownDictionary::ownWake:
            return {"undisturbed"};
        case ownDictionary::spreading:
            return {"width", "steps"};
        case ownDictionary::dragLaw:
            return {"alphac", "sphericity", "flatness", "elongation"};
        case ownDictionary::cellList:
            return
            {
                "contactLaw", "treatment", "stepFraction", "step", "search",
                "cellLayers", "skin", "threads", "particle", "wall",
                "particleParticle", "particleWall", "pairs", "surfaces"
            };
        case ownDictionary::wallSurface:
            return {"file", "scale"};
        case ownDictionary::contactMaterial:
            return {"youngsModulus", "poissonsRatio"};
        case ownDictionary::contactPair:
            return
            {
                "contactLaw", "restitution", "friction", "rollingFriction",
                "cohesion", "normalStiffness", "tangentialRatio"
            };
        case ownDictionary::dispersion:
            return {"C0", "beta"};
        case ownDictionary::scenePlan:
            return
            {
                "gas", "convergeGas", "gasTolerance", "gasCourant",
                "collisionsPerStep", "retakes"
            };
    }
    return wordList();
}


//- Letters to change, add or leave out (Levenshtein)
size_t distance(const std::string& a, const std::string& b)
{
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j)
    {
        row[j] = j;
    }
    for (size_t i = 1; i <= a.size(); ++i)
    {
        size_t corner = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j)
        {
            const size_t above = row[j];
            row[j] = std::min
            ({
                above + 1, row[j - 1] + 1, corner + (a[i - 1] != b[j - 1])
            });
            corner = above;
        }
    }
    return row[b.size()];
}


//- The file that a dictionary was read from, for all processors
fileName fileOf(const dictionary& wholeFile)
{
    const fileName path(wholeFile.name());
    if (isFile(path, false))
    {
        return path;
    }
    // case/processor0/constant/feed
    const fileName folder(path.path());
    return folder.path().path()/folder.name()/path.name();
}


bool has(const wordList& names, const word& name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}


bool isAllowed(const keyType& key, const wordList& allowed)
{
    return std::any_of
    (
        allowed.begin(), allowed.end(),
        [&](const word& name) { return key.match(name); }
    );
}


[[noreturn]] void refuse
(
    const dictionary& dict,
    const entry& e,
    const wordList& allowed
)
{
    FatalIOErrorInFunction(dict)
        << e.keyword() << " is not an entry of " << dict.dictName()
        << ", allowed: " << listed(allowed).c_str() << exit(FatalIOError);
    std::abort();   // never reached
}

} // End anonymous namespace


std::string listed(const wordList& names)
{
    std::string all;
    for (const word& name : names)
    {
        all += (all.empty() ? "" : ", ") + name;
    }
    return all;
}


wordList includedFiles(const fileName& path)
{
    std::ifstream file(path);
    DynamicList<word> names;
    std::string line;
    const std::regex include
    (
        "\\s*#\\s*s?include(IfPresent)?\\s+\"([^\"]*)\".*"
    );
    while (std::getline(file, line))
    {
        std::smatch found;
        if
        (
            line.find('#') != std::string::npos
         && std::regex_match(line, found, include)
        )
        {
            names.append(word(found[2], false));
        }
    }
    return wordList(std::move(names));
}


void requireEntries(const dictionary& dict, const wordList& allowed)
{
    for (const entry& e : dict)
    {
        if (!isAllowed(e.keyword(), allowed))
        {
            refuse(dict, e, allowed);
        }
    }
}


bool standsIn(const dictionary& wholeFile, const word& name)
{
    bool stands =
        Pstream::master() && has(topLevelKeys(fileOf(wholeFile)), name);
    elutriaBroadcast(stands);
    return stands;
}


void requireOwnEntries(const dictionary& dict, const ownDictionary kind)
{
    const wordList allowed(entriesOf(kind));
    if (kind != ownDictionary::feed && kind != ownDictionary::scenePlan)
    {
        requireEntries(dict, allowed);
        return;
    }
    if (!Pstream::master())
    {
        return;
    }
    const wordList keys(topLevelKeys(fileOf(dict)));
    for (const word& twice : repeatedEntries(fileOf(dict), true))
    {
        FatalIOErrorInFunction(dict)
            << twice << " stands there twice, allowed: once"
            << exit(FatalIOError);
    }
    for (const entry& e : dict)
    {
        if (!isAllowed(e.keyword(), allowed) && has(keys, e.keyword())
         && e.keyword() != "FoamFile")
        {
            refuse(dict, e, allowed);
        }
    }
}


void refuseNearMisses(const dictionary& dict, const wordList& ours)
{
    for (const entry& e : dict)
    {
        for (const word& name : ours)
        {
            if
            (
                !e.keyword().isPattern() && !isAllowed(e.keyword(), ours)
             && distance(e.keyword(), name) <= 2
            )
            {
                refuse(dict, e, wordList({name}));
            }
        }
    }
}


} // End namespace Foam
