/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Division of a particle's volume among cells: against the overlap of
    intervals, which is exact for aligned cubes.

\*---------------------------------------------------------------------------*/

#include <doctest/doctest.h>

#include "tests/near.H"
#include "tests/BoxMesh.H"
#include "averaging/CellOverlap.H"
#include "foam/foamVersion.H"
#include "Random.H"

using namespace Foam;

namespace
{

//- Length that [x - b, x + b] and [low, high] have in common, over 2 b
scalar common
(
    const scalar x,
    const scalar b,
    const scalar low,
    const scalar high
)
{
    return max(min(x + b, high) - max(x - b, low), scalar(0))/(2*b);
}

} // End anonymous namespace


TEST_SUITE_BEGIN("cell overlap");

TEST_CASE("a cube anywhere on a grid of cubes: exact shares")
{
    const BoxMesh box({4, 4, 4}, 1e-3);
    CellOverlap overlap(box.mesh());
    Random random(1);
    const scalar b = 0.4e-3, volume = 8*pow3(b);

    for (label trial = 0; trial < 200; ++trial)
    {
        // The cube stays within the box
        const point centre
        (
            b*vector::one + (4e-3 - 2*b)*random.sample01<vector>()
        );
        scalarField sums(box.mesh().nCells(), Zero);
        overlap.add(sums, box.mesh().findCell(centre), centre, volume);

        CHECK(sum(sums) == near(volume, 1e-12));
        forAll(sums, celli)
        {
            scalar part = 1;
            for (direction axis = 0; axis < 3; ++axis)
            {
                const scalar middle = box.mesh().C()[celli][axis];
                part *= common
                (
                    centre[axis], b, middle - 0.5e-3, middle + 0.5e-3
                );
            }
            CHECK(mag(sums[celli]/volume - part) < 1e-9);
        }
    }
}


TEST_CASE("beyond a wall there is nothing: the volume stays inside")
{
    const BoxMesh box({2, 2, 2}, 1e-3);
    CellOverlap overlap(box.mesh());
    for (const scalar gap : {1e-9, 1e-5, 1e-4, 5e-4})
    {
        const point centre(gap, 0.9e-3, 1.7e-3);
        scalarField sums(box.mesh().nCells(), Zero);
        overlap.add(sums, box.mesh().findCell(centre), centre, 1e-10);
        CHECK(sum(sums) == near(1e-10, 1e-12));
        CHECK(min(sums) >= 0);
    }
}


TEST_CASE("a step of the centre moves no more volume than its path sweeps")
{
    const BoxMesh box({2, 1, 1}, 1e-3);
    CellOverlap overlap(box.mesh());
    const scalar b = 0.2e-3, volume = 8*pow3(b), step = 1e-6;
    scalar before = volume;
    for (scalar x = 0.7e-3; x < 1.3e-3; x += step)
    {
        const point centre(x, 0.5e-3, 0.5e-3);
        scalarField sums(2, Zero);
        overlap.add(sums, x < 1e-3 ? 0 : 1, centre, volume);
        CHECK(sums[0] <= before*(1 + 1e-12));
        CHECK(before - sums[0] < volume*step/(2*b)*(1 + 1e-6));
        before = sums[0];
    }
    CHECK(before == 0);
}


TEST_CASE("what leaves takes as much as came")
{
    const BoxMesh box({3, 3, 3}, 1e-3);
    CellOverlap overlap(box.mesh());
    scalarField sums(box.mesh().nCells(), Zero);
    const point centre(1.1e-3, 1.9e-3, 1.5e-3);
    overlap.add(sums, 13, centre, 3e-10);
    overlap.add(sums, 13, centre, -3e-10);
    CHECK(max(mag(sums)) == 0);
}

TEST_SUITE_END();
