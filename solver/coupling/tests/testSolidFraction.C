/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Solid fraction of a mesh: nothing is lost, nothing is above the maximum.

\*---------------------------------------------------------------------------*/

#include <doctest/doctest.h>

#include "tests/near.H"
#include "tests/BoxMesh.H"
#include "averaging/SolidFraction.H"
#include "foam/foamVersion.H"
#include "Random.H"

using namespace Foam;

namespace
{

scalar integral(const volScalarField& field)
{
    return sum(field.primitiveField()*field.mesh().V().field());
}


//- Particles of a volume [m3] at random places; returns their volume [m3]
scalar addSome(SolidFraction& solids, const fvMesh& mesh, const scalar volume)
{
    Random random(7);
    scalar all = 0;
    for (label k = 0; k < 40; ++k)
    {
        const point place
        (
            cmptMultiply(random.sample01<vector>(), mesh.bounds().max())
        );
        solids.add(mesh.findCell(place), place, volume, 1e-3);
        all += volume;
    }
    return all;
}

} // End anonymous namespace


TEST_SUITE_BEGIN("solid fraction");

TEST_CASE("the field holds the volume that was added, anew each time")
{
    const BoxMesh box({6, 6, 6}, 1e-3);
    DiffusionKernel kernel(box.mesh(), dictionary());
    SolidFraction solids(box.mesh(), kernel);
    for (label time = 0; time < 2; ++time)
    {
        solids.clear();
        const scalar added = addSome(solids, box.mesh(), 1e-10);
        const scalar held = integral(solids.finish(1));
        CHECK(held == near(added, 1e-8));
        CHECK(solids.excessVolume() == 0);
        CHECK(min(solids.field().primitiveField()) >= -1e-12);
    }
}


TEST_CASE("what is above the maximum is counted, not lost")
{
    const BoxMesh box({4, 4, 4}, 1e-3);
    dictionary sharp;
    sharp.add("width", 0);
    DiffusionKernel kernel(box.mesh(), sharp);
    SolidFraction solids(box.mesh(), kernel);
    solids.clear();
    const point middle(box.mesh().C()[21]);
    solids.add(21, middle, 0.9e-9, 1e-3);
    const scalar inField = integral(solids.finish(0.6));
    CHECK(max(solids.field().primitiveField()) == near(0.6));
    CHECK(solids.excessVolume() == near(0.3e-9));
    CHECK(inField + solids.excessVolume() == near(0.9e-9));
}


TEST_CASE("arrivals and departures add up until they are forgotten")
{
    const BoxMesh box({5, 5, 5}, 1e-3);
    DiffusionKernel kernel(box.mesh(), dictionary());
    kernel.adapt(1e-3);
    SolidFraction solids(box.mesh(), kernel);
    solids.arrive(0, box.mesh().C()[0], 5e-10);
    solids.arrive(124, box.mesh().C()[124], -2e-10);
    const scalar arrived = integral(solids.arrivedFraction()());
    CHECK(arrived == near(3e-10, 1e-8));
    solids.forgetArrivals();
    CHECK(integral(solids.arrivedFraction()()) == 0);
}

TEST_SUITE_END();
