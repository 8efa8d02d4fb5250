/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "averaging/SolidFraction.H"
#include "foam/foamVersion.H"
#include "foam/passingField.H"
#include "zeroGradientFvPatchFields.H"

namespace Foam
{

// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

SolidFraction::SolidFraction(const fvMesh& mesh, DiffusionKernel& kernel)
:
    kernel_(kernel),
    overlap_(mesh),
    theta_
    (
        IOobject
        (
            IOobject::groupName("alpha", "particles"),
            mesh.time().timeName(),
            mesh,
            IOobject::NO_READ,
            IOobject::AUTO_WRITE
        ),
        mesh,
        dimensionedScalar(dimless, Zero),
        zeroGradientFvPatchScalarField::typeName
    ),
    timeIndex_(-1),
    added_(overlap_.size(), Zero),
    largest_(0),
    excessVolume_(0),
    arrived_(overlap_.size(), Zero)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void SolidFraction::clear()
{
    added_ = Zero;
    timeIndex_ = mesh().time().timeIndex();
    largest_ = 0;
}


void SolidFraction::add
(
    const label celli,
    const point& centre,
    const scalar volume,
    const scalar diameter
)
{
    overlap_.add(added_, celli, centre, volume);
    largest_ = max(largest_, diameter);
}


const volScalarField& SolidFraction::finish(const scalar maximum)
{
    overlap_.close(added_);
    scalarField& theta = theta_.primitiveFieldRef();
    forAll(theta, celli)
    {
        theta[celli] = added_[celli]/mesh().V()[celli];
    }

    kernel_.adapt(returnReduce(largest_, maxOp<scalar>()));
    kernel_.smooth(theta_);

    excessVolume_ = 0;
    forAll(theta, celli)
    {
        if (theta[celli] > maximum)
        {
            excessVolume_ += (theta[celli] - maximum)*mesh().V()[celli];
            theta[celli] = maximum;
        }
    }
    reduce(excessVolume_, sumOp<scalar>());
    theta_.correctBoundaryConditions();
    return theta_;
}


void SolidFraction::arrive
(
    const label celli,
    const point& centre,
    const scalar volume
)
{
    overlap_.add(arrived_, celli, centre, volume);
}


tmp<volScalarField> SolidFraction::arrivedFraction()
{
    overlap_.close(arrived_);
    auto tfraction = tmp<volScalarField>::New
    (
        passingField("arrivedFraction", mesh()),
        mesh(),
        dimensionedScalar(dimless, Zero),
        zeroGradientFvPatchScalarField::typeName
    );
    scalarField& fraction = tfraction.ref().primitiveFieldRef();
    forAll(fraction, celli)
    {
        fraction[celli] = arrived_[celli]/mesh().V()[celli];
    }
    kernel_.smooth(tfraction.ref());
    tfraction.ref().correctBoundaryConditions();
    return tfraction;
}


} // End namespace Foam
