/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    The dispersion's process over a step, in gas of even turbulence: Taylor's
    (1921) spread, whatever the steps that lead to it.

\*---------------------------------------------------------------------------*/

#include <doctest/doctest.h>

#include "tests/near.H"
#include "forces/ContinuousDispersion.H"
#include "tests/BoxMesh.H"
#include "foam/foamVersion.H"

#include <cmath>

using namespace Foam;

namespace
{

//- With sigma 1 m/s and a time scale of 1 s
struct Process
:
    public InertialDispersion
{
    static constexpr label particles = 20000;
    static constexpr scalar k = 1.5;

    Random random{1};
    Turbulence gas{k, k/(0.5 + 0.75*2.1), Zero, Zero};
    Inertia parcel;

    //- Mean square of the end's fluctuation and of the way, and its mean, after
    //  a time in equal steps, of one component
    struct Spread { scalar end = 0, way = 0, mean = 0; };

    Spread after(const scalar time, const label steps)
    {
        Spread spread;
        for (label i = 0; i < particles; ++i)
        {
            vector u(Zero), way(Zero);
            scalar sigma = 0;
            for (label step = 0; step < steps; ++step)
            {
                way +=
                    time/steps
                   *fluctuation(random, time/steps, gas, parcel, u, sigma);
            }
            spread.end += sqr(u.x())/particles;
            spread.way += sqr(way.x())/particles;
            spread.mean += way.x()/particles;
        }
        return spread;
    }

    using InertialDispersion::interiorGradient;
};

} // End anonymous namespace


TEST_SUITE_BEGIN("dispersion");

TEST_CASE("tracers spread as Taylor's theory says, in one step or in many")
{
    for (const scalar time : {0.1, 1.0, 5.0})
    {
        const scalar taylor = 2*(time - 1 + std::exp(-time));
        for (const label steps : {1, 4})
        {
            CAPTURE(time);
            CAPTURE(steps);
            const Process::Spread spread = Process().after(time, steps);
            CHECK(spread.end == near(1, 0.04));
            CHECK(spread.way == near(taylor, 0.04));
            CHECK(mag(spread.mean) < 4*std::sqrt(taylor/Process::particles));
        }
    }
}


TEST_CASE("particles that slip through eddies spread less")
{
    Process slow, fast;
    fast.parcel.meanSlip = 3;
    CHECK(fast.after(5, 2).way < 0.6*slow.after(5, 2).way);
}


TEST_CASE("without turbulence nothing fluctuates")
{
    Process process;
    process.gas.k = 0;
    vector u(1, 2, 3);
    scalar sigma = 1;
    const vector moved
    (
        process.fluctuation
        (
            process.random, 1, process.gas, process.parcel, u, sigma
        )
    );
    CHECK(moved == vector(Zero));
    CHECK(u == vector(Zero));
}


TEST_CASE("a linear field keeps its gradient up to the walls")
{
    const BoxMesh box({4, 4, 4}, 1e-3);
    const fvMesh& mesh = box.mesh();
    volScalarField field
    (
        IOobject("field", mesh.time().timeName(), mesh),
        mesh,
        dimensionedScalar(dimless, Zero)
    );
    field.primitiveFieldRef() =
        mesh.C().primitiveField() & vector(100, 200, 300);
    const volVectorField gradient(Process::interiorGradient(field));
    for (const vector& g : gradient.primitiveField())
    {
        CHECK(mag(g - vector(100, 200, 300)) < 1e-6);
    }
}

TEST_SUITE_END();
