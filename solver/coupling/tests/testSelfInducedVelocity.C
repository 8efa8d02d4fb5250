/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Self-induced velocity: against Stokes' flow integrated over a Gaussian, and
    what must hold whatever the fits.

\*---------------------------------------------------------------------------*/

#include <doctest/doctest.h>

#include "tests/near.H"
#include "laws/SelfInducedVelocity.hpp"

#include <cmath>
#include <vector>

using namespace elutria::laws;

namespace
{

const double pi = std::acos(-1.0);

//- Air around a hovering particle, kernel and cell [m]
DepositSurroundings air(double kernel, double cellSize)
{
    return {kernel, cellSize, 1e300, 1.8e-5, 1.5e-5};
}


//- Velocity in the middle of a unit force that is spread over a Gaussian of
//  standard deviation w in Stokes' flow [m/s/N]: the Stokeslet's mean over all
//  directions, 1/(6 pi mu r), shell by shell
double velocityOfUnitForce(double w, double mu)
{
    const int shells = 20000;
    const double dr = 10*w/shells;
    double sum = 0;
    for (int i = 0; i < shells; ++i)
    {
        const double r = (i + 0.5)*dr;
        const double density =
            std::exp(-r*r/(2*w*w))/std::pow(2*pi*w*w, 1.5);
        sum += 4*pi*r*r*dr*density/(6*pi*mu*r);
    }
    return sum;
}


//- Part of a unit deposit in one cell that is there after a random walk along
//  an axis to the given variance [cells^2]
double staysOnLattice(double variance)
{
    const int cells = 201, steps = 20000;
    const double move = 0.5*variance/steps;
    std::vector<double> now(cells, 0.0), next(cells);
    now[cells/2] = 1;
    for (int step = 0; step < steps; ++step)
    {
        next = now;
        for (int i = 1; i + 1 < cells; ++i)
        {
            next[i] += move*(now[i - 1] - 2*now[i] + now[i + 1]);
        }
        now.swap(next);
    }
    return now[cells/2];
}

} // namespace


TEST_SUITE_BEGIN("self-induced velocity");

TEST_CASE("slow and wide, it is Stokes' flow of a force spread over a Gaussian")
{
    // A kernel much wider than the cell: the width is the kernel's
    const double kernel = 1e-2, dragRate = 1e-8;
    const DepositSurroundings gas = air(kernel, 1e-5);
    const double share = selfInducedShare(dragRate, {1e-9, 0, 0}, gas);
    const double stokes = dragRate*velocityOfUnitForce(kernel, gas.mu);
    CHECK(share == near(stokes, 1e-4));
}


TEST_CASE("it grows with the drag, up to half of the slip")
{
    const DepositSurroundings gas = air(1e-3, 1e-3);
    const DepositMotion motion{1, 0, 0};
    const double once = selfInducedShare(1e-8, motion, gas);
    CHECK(once > 0);
    CHECK(selfInducedShare(2e-8, motion, gas) == near(2*once));
    CHECK(selfInducedShare(0, motion, gas) == 0);
    CHECK(selfInducedShare(1, motion, gas) == 0.5);
}


TEST_CASE("wider deposits, neighbours and inertia take from it")
{
    const DepositMotion motion{1, 0, 0};
    const double dragRate = 1e-7;
    const double alone = selfInducedShare(dragRate, motion, air(1e-3, 1e-3));
    CHECK(selfInducedShare(dragRate, motion, air(2e-3, 1e-3)) < alone);
    CHECK(selfInducedShare(dragRate, {10, 0, 0}, air(1e-3, 1e-3)) < alone);

    DepositSurroundings suspension = air(1e-3, 1e-3);
    suspension.spacing = 0.5;
    const double sparse = selfInducedShare(dragRate, motion, suspension);
    CHECK(sparse > 0);
    CHECK(sparse < alone);
    suspension.spacing = 1e-3;
    CHECK(selfInducedShare(dragRate, motion, suspension) == 0);
}


TEST_CASE("a particle that moves on leaves its disturbance behind")
{
    const DepositSurroundings gas = air(1e-3, 1e-3);
    double before = selfInducedShare(1e-8, {1, 0.1, 0}, gas);
    for (double distance = 5e-3; distance < 0.05; distance += 5e-3)
    {
        const double now = selfInducedShare(1e-8, {1, 0.1, distance}, gas);
        CHECK(now < before);
        before = now;
    }
    CHECK_FALSE(outOfDisturbance(0, 1e-3, 1e-3));
    CHECK(outOfDisturbance(0.05, 1e-3, 1e-3));

    // Out of it also means: nothing of a share that could be felt
    CHECK(selfInducedShare(1e-8, {1, 0.1, 0.05}, gas) < 1e-6*0.5);
}


TEST_CASE("the part that stays in a cell is that of a walk on the lattice")
{
    for (const double kernel : {0.3, 1.0, 2.5})
    {
        const double stays = staysOnLattice(kernel*kernel);
        CHECK
        (
            depositKept(kernel, 1)
         == near(stays*stays*stays, 1e-3)
        );
    }
    CHECK(depositKept(0, 1) == 1);
}


TEST_CASE("spacing is the cube root of the volume that each parcel has")
{
    // 1000 parcels of 1 mm3 in 0.1 m3, 1 % of which is their own
    CHECK(neighbourSpacing(1e-5, 1e-9, 0) == near(std::cbrt(1e-4)));
    CHECK
    (
        neighbourSpacing(1e-5, 1e-9, 5e-6) > neighbourSpacing(1e-5, 1e-9, 0)
    );
    CHECK(neighbourSpacing(0, 1e-9, 0) > 1e30);
}

TEST_SUITE_END();
