/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    Diffusion smoothing: what every kernel must keep, and the moments that
    make this one a Gaussian. Explicit and implicit steps alike.

\*---------------------------------------------------------------------------*/

#include <doctest/doctest.h>

#include "tests/near.H"
#include "tests/BoxMesh.H"
#include "averaging/DiffusionKernel.H"
#include "foam/foamVersion.H"
#include "foam/passingField.H"
#include "Random.H"
#include "zeroGradientFvPatchFields.H"

using namespace Foam;

namespace
{

constexpr scalar side = 1e-3;   // m, of a cell

// m: the first is reached by explicit steps, the second by implicit ones
constexpr scalar widths[] = {2e-3, 6e-3};


dictionary widthEntry(const scalar width)
{
    dictionary dict;
    dict.add("width", width);
    return dict;
}


volScalarField makeField(const fvMesh& mesh, const scalar value)
{
    return volScalarField
    (
        passingField("density", mesh), mesh,
        dimensionedScalar("value", dimless, value),
        zeroGradientFvPatchScalarField::typeName
    );
}


volScalarField randomField(const fvMesh& mesh, Random& random)
{
    volScalarField field(makeField(mesh, 0));
    for (scalar& value : field.primitiveFieldRef())
    {
        value = random.sample01<scalar>();
    }
    return field;
}


scalar integral(const volScalarField& field)
{
    return sum(field.primitiveField()*field.mesh().V().field());
}

} // End anonymous namespace


TEST_SUITE_BEGIN("diffusion kernel");

TEST_CASE("a constant stays constant")
{
    const BoxMesh box({8, 9, 10}, side);
    for (const scalar width : widths)
    {
        const DiffusionKernel kernel(box.mesh(), widthEntry(width));
        volScalarField field(makeField(box.mesh(), 3.5));
        kernel.smooth(field);
        CHECK(max(mag(field.primitiveField() - 3.5)) < 1e-8);
    }
}


TEST_CASE("the deposit is conserved and stays positive")
{
    const BoxMesh box({8, 9, 10}, side);
    for (const scalar width : widths)
    {
        const DiffusionKernel kernel(box.mesh(), widthEntry(width));
        volScalarField field(makeField(box.mesh(), 0));
        field.primitiveFieldRef()[0] = 1;       // in a corner
        field.primitiveFieldRef()[333] = 2;
        const scalar before = integral(field);
        kernel.smooth(field);
        CHECK(integral(field) == near(before, 1e-8));
        CHECK(min(field.primitiveField()) > -1e-12);
        CHECK(max(field.primitiveField()) < 2);
    }
}


TEST_CASE("a point becomes a distribution of variance width^2")
{
    const BoxMesh box({101, 1, 1}, side);
    for (const scalar width : widths)
    {
        const DiffusionKernel kernel(box.mesh(), widthEntry(width));
        volScalarField field(makeField(box.mesh(), 0));
        field.primitiveFieldRef()[50] = 1;
        kernel.smooth(field);
        scalar mass = 0, first = 0, second = 0;
        forAll(field, celli)
        {
            const scalar x = (celli - 50)*side;
            mass += field[celli];
            first += field[celli]*x;
            second += field[celli]*sqr(x);
        }
        CHECK(mag(first/mass) < 1e-6*side);
        CHECK(second/mass == near(sqr(width), 1e-4));
    }
}


TEST_CASE("the operator is symmetric: gas and particles exchange the same")
{
    const BoxMesh box({6, 7, 8}, side);
    Random random(3);
    for (const scalar width : widths)
    {
        const DiffusionKernel kernel(box.mesh(), widthEntry(width));
        const volScalarField a(randomField(box.mesh(), random));
        const volScalarField b(randomField(box.mesh(), random));
        volScalarField smoothA("a", a), smoothB("b", b);
        kernel.smooth(smoothA);
        kernel.smooth(smoothB);
        CHECK
        (
            sum(smoothA.primitiveField()*b.primitiveField())
         == near(sum(a.primitiveField()*smoothB.primitiveField()), 1e-8)
        );
    }
}


TEST_CASE("the width follows the largest particle unless it is given")
{
    const BoxMesh box({2, 2, 2}, side);
    DiffusionKernel follows(box.mesh(), dictionary());
    CHECK_FALSE(follows.active());
    follows.adapt(2e-3);
    CHECK(follows.active());
    CHECK(follows.width() == near(3e-3));

    DiffusionKernel given(box.mesh(), widthEntry(4e-3));
    given.adapt(2e-3);
    CHECK(given.width() == near(4e-3));

    // A kernel much narrower than the cells changes nothing
    DiffusionKernel narrow(box.mesh(), widthEntry(1e-5));
    CHECK_FALSE(narrow.active());
}


TEST_CASE("what is not allowed is refused by name")
{
    const BoxMesh box({2, 2, 2}, side);
    dictionary noSteps(widthEntry(1e-3));
    noSteps.add("steps", 0);
    dictionary noWidth;
    noWidth.add("width", word("wide"));
    CHECK_THROWS_AS(DiffusionKernel(box.mesh(), widthEntry(-1)), IOerror);
    CHECK_THROWS_AS(DiffusionKernel(box.mesh(), noSteps), IOerror);
    CHECK_THROWS_AS(DiffusionKernel(box.mesh(), noWidth), IOerror);
}

TEST_SUITE_END();
