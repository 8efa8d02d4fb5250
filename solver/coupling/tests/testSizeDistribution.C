/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Size distributions of a feed: quantiles against the stated laws, numbers
    against mass by drawing.

\*---------------------------------------------------------------------------*/

#include <doctest/doctest.h>

#include "tests/near.H"
#include "feed/SizeDistribution.H"
#include "foam/foamVersion.H"
#include "StringStream.H"

#include <cmath>
#include <functional>

using namespace Foam;

namespace
{

SizeDistribution read(const std::string& entries)
{
    IStringStream is(entries);
    return SizeDistribution(dictionary(is));
}

constexpr label draws = 20000;

//- Mean over even draws of a cumulative curve
scalar meanOverDraws(const std::function<scalar(scalar)>& value)
{
    scalar sum = 0;
    for (label i = 0; i < draws; ++i)
    {
        sum += value((i + 0.5)/draws);
    }
    return sum/draws;
}

const std::string rosin =
    "type RosinRammler; d63 9e-4; n 3; min 3e-4; max 2e-3;";

} // End anonymous namespace


TEST_SUITE_BEGIN("size distribution");

TEST_CASE("quantiles by mass are those of the stated law, truncated")
{
    const SizeDistribution sizes(read(rosin));
    const auto finer = [](scalar d) { return 1 - std::exp(-pow3(d/9e-4)); };
    for (scalar u = 0.05; u < 1; u += 0.1)
    {
        const scalar d = sizes.quantileByMass(u);
        const scalar truncated =
            (finer(d) - finer(3e-4))/(finer(2e-3) - finer(3e-4));
        CHECK(truncated == near(u, 1e-4));
    }
    CHECK(sizes.min() == near(3e-4));
    CHECK(sizes.max() == near(2e-3));

    const SizeDistribution logNormal
    (
        read("type logNormal; d50 5e-4; sigma 1.5; min 1e-5; max 1e-2;")
    );
    CHECK(logNormal.quantileByMass(0.5) == near(5e-4, 1e-4));
    CHECK
    (
        logNormal.quantileByMass(0.841344746)
     == near(1.5*5e-4, 1e-3)
    );
}


TEST_CASE("numbers drawn and weighed give back the mass")
{
    for (const char* const weighting : {"mass", "number"})
    {
        const SizeDistribution sizes
        (
            read(rosin + "weighting " + weighting + ";")
        );
        const scalar meanCube = meanOverDraws([&](scalar u)
        {
            return pow3(sizes.quantileByNumber(u));
        });
        CHECK(sizes.meanCube() == near(meanCube, 1e-3));

        // Mass of the draws below the median by mass
        const scalar median = sizes.quantileByMass(0.5);
        const scalar below = meanOverDraws([&](scalar u)
        {
            const scalar d = sizes.quantileByNumber(u);
            return d < median ? pow3(d) : 0;
        });
        CHECK(below/meanCube == near(0.5, 2e-3));
    }
}


TEST_CASE("a sieve analysis is linear between its sieves; one size is one size")
{
    const SizeDistribution sieves
    (
        read("type table; diameters (1e-4 2e-4 4e-4); cumulative (0 0.25 1);")
    );
    CHECK(sieves.quantileByMass(0.25) == near(2e-4, 1e-3));
    CHECK(sieves.quantileByMass(0.625) == near(3e-4, 1e-3));

    const SizeDistribution one(read("type fixedValue; value 5e-4;"));
    CHECK(one.quantileByNumber(0.3) == near(5e-4));
    CHECK(one.meanCube() == near(1.25e-10));
}


TEST_CASE("what is not allowed is refused")
{
    for
    (
        const char* const entries :
        {
            "type Weibull; min 1e-4; max 1e-3;",
            "type RosinRammler; d63 -1; n 3; min 1e-4; max 1e-3;",
            "type RosinRammler; d63 1e-3; n 3; min 1e-3; max 1e-4;",
            "type logNormal; d50 1e-3; sigma 1; min 1e-4; max 1e-2;",
            "type table; diameters (1e-4 2e-4); cumulative (0 0.9);",
            "type uniform; min 1e-4; max 1e-3; weighting volume;"
        }
    )
    {
        CAPTURE(entries);
        CHECK_THROWS_AS(read(entries), IOerror);
    }
}

TEST_SUITE_END();
