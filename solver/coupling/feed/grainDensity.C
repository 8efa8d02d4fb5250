/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/grainDensity.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "foam/requireAllowed.H"
#include "laws/FeedRules.hpp"
#include "scalarList.H"

#include <stdexcept>

namespace Foam
{

namespace
{

namespace laws = elutria::laws;


laws::CumulativeCurve readTable(const dictionary& dict)
{
    requireEntries(dict, {"type", "densities", "cumulative"});
    const scalarList densities(dict.get<scalarList>("densities"));
    const scalarList lighter(dict.get<scalarList>("cumulative"));
    return laws::sieved
    (
        {densities.cbegin(), densities.cend()},
        {lighter.cbegin(), lighter.cend()}, "densities",
        laws::largestDensity
    );
}


laws::CumulativeCurve readCurve(const dictionary& dict)
{
    const word type(dict.get<word>("type"));
    if (type == "table")
    {
        return readTable(dict);
    }
    if (type != "normal" && type != "uniform")
    {
        throw std::invalid_argument
        (
            "type is " + type + ", allowed: normal, uniform, table"
        );
    }
    std::vector<double> parameters;
    wordList entries{"type", "min", "max"};
    if (type == "normal")
    {
        parameters = {dict.get<scalar>("mean"), dict.get<scalar>("standardDeviation")};
        entries.append(wordList({"mean", "standardDeviation"}));
    }
    requireEntries(dict, entries);
    return laws::truncated
    (
        *laws::findSizeLaw(type), parameters.data(), dict.get<scalar>("min"),
        dict.get<scalar>("max"), laws::largestDensity
    );
}

} // End anonymous namespace


scalar readDensity(const dictionary& material)
{
    const auto scatter = readDensityScatter(material);
    return
        scatter
      ? scatter->meanByMass()
      : readAllowed
        (
            material, "density",
            atLeast(laws::leastDensity, laws::largestDensity)
        );
}


std::shared_ptr<const laws::DensityScatter> readDensityScatter
(
    const dictionary& material
)
{
    if (!material.found("densityDistribution"))
    {
        return nullptr;
    }
    const dictionary& dict = material.subDict("densityDistribution");
    for (const word other : {"density", "measuredVelocity"})
    {
        if (material.found(other))
        {
            FatalIOErrorInFunction(material)
                << other << " is there beside densityDistribution, allowed: one"
                << " of both" << exit(FatalIOError);
        }
    }
    try
    {
        const auto scatter =
            std::make_shared<const laws::DensityScatter>(readCurve(dict));
        if (scatter->min() < laws::leastDensity)
        {
            throw std::invalid_argument
            (
                "the least density is below " + name(laws::leastDensity)
              + ", allowed: >= that (kg/m3)"
            );
        }
        return scatter;
    }
    catch (const std::invalid_argument& refused)
    {
        FatalIOErrorInFunction(dict) << refused.what() << exit(FatalIOError);
        throw;
    }
}


} // End namespace Foam
