/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Cells that a straight way leads to: against OpenFOAM's search of the mesh.

\*---------------------------------------------------------------------------*/

#include <doctest/doctest.h>

#include "tests/BoxMesh.H"
#include "cloud/PlaneCells.H"
#include "Random.H"

using namespace Foam;

TEST_SUITE_BEGIN("plane cells");

TEST_CASE("a way ends in the cell where OpenFOAM finds its end")
{
    const BoxMesh box({5, 4, 3}, 1e-3);
    const vector size(5e-3, 4e-3, 3e-3);
    const PlaneCells cells(box.mesh());
    Random random(1);

    for (label trial = 0; trial < 500; ++trial)
    {
        const point from(cmptMultiply(size, random.sample01<vector>()));
        const point to(cmptMultiply(size, random.sample01<vector>()));
        CHECK
        (
            cells.follow(box.mesh().findCell(from), from, to)
         == box.mesh().findCell(to)
        );
    }
}

TEST_CASE("along edges and through corners of cells")
{
    const BoxMesh box({4, 4, 4}, 1e-3);
    const PlaneCells cells(box.mesh());
    const point from(0.5e-3, 0.5e-3, 0.5e-3);
    const label first = box.mesh().findCell(from);

    for (const scalar end : {1.5e-3, 2.5e-3, 3.5e-3})
    {
        for (const point& to : {point(end, end, end), point(end, end, 0.5e-3)})
        {
            CHECK(cells.follow(first, from, to) == box.mesh().findCell(to));
        }
    }
}

TEST_CASE("what leaves the mesh, or is on its boundary, is not found")
{
    const BoxMesh box({4, 4, 4}, 1e-3);
    const PlaneCells cells(box.mesh());
    const point from(0.2e-3, 0.5e-3, 0.5e-3);
    const label first = box.mesh().findCell(from);

    CHECK(cells.follow(first, from, point(-1e-6, 0.5e-3, 0.5e-3)) == -1);
    CHECK(cells.follow(first, from, point(0, 0.5e-3, 0.5e-3)) == -1);
    CHECK(cells.follow(first, from, point(5e-3, 1.5e-3, 0.5e-3)) == -1);
    CHECK(cells.follow(first, from, point(1e-6, 0.5e-3, 0.5e-3)) == first);
}

TEST_SUITE_END();
