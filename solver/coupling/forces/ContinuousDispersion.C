/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "forces/ContinuousDispersion.H"
#include "foam/foamVersion.H"
#include "calculatedFvPatchFields.H"
#include "fvcGrad.H"
#include "wallPolyPatch.H"

namespace Foam
{

namespace
{

//- A cell's value, linear to the place at the offset from its centre
scalar linearInCell
(
    const scalar value,
    const vector& slope,
    const vector& offset
)
{
    return max(value + (slope & offset), 0.1*value);
}


vector normalVector(Random& random)
{
    const scalar x = random.GaussNormal<scalar>();
    const scalar y = random.GaussNormal<scalar>();
    return vector(x, y, random.GaussNormal<scalar>());
}


//- Of the process w with the time scale T over a step of theta T
struct LangevinStep
{
    const scalar decay;         // of the start in the end
    const scalar gained;        // 1 - decay
    const scalar varEnd, varMean, covariance;   // of end and mean

    explicit LangevinStep(const scalar theta)
    :
        decay(exp(-theta)),
        gained(-std::expm1(-theta)),
        varEnd(-std::expm1(-2*theta)),
        varMean
        (
            theta > 1e-3
          ? (2*theta - 3 + 4*decay - sqr(decay))/sqr(theta)
          : 2.0/3.0*theta
        ),
        covariance(sqr(gained)/theta)
    {}
};


//- Extrapolate the values on walls from inside
void extrapolateToWalls(volScalarField& field, const volVectorField& gradient)
{
    forAll(field.boundaryField(), patchi)
    {
        const fvPatch& patch = field.mesh().boundary()[patchi];
        if (!isA<wallPolyPatch>(patch.patch()))
        {
            continue;
        }
        const vectorField delta(patch.delta());
        fvPatchScalarField& there = field.boundaryFieldRef()[patchi];
        forAll(there, facei)
        {
            const label celli = patch.faceCells()[facei];
            const scalar inside =
                field[celli] + (gradient[celli] & delta[facei]);
            there[facei] = max(2*inside - there[facei], scalar(0));
        }
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

tmp<volVectorField> InertialDispersion::interiorGradient
(
    const volScalarField& given
)
{
    volScalarField field
    (
        IOobject
        (
            "inside", given.time().timeName(), given.mesh(),
            IOobject::NO_READ, IOobject::NO_WRITE, false
        ),
        given,
        calculatedFvPatchScalarField::typeName
    );
    volVectorField gradient(fvc::grad(field));

    // On an orthogonal mesh, changing the wall value by d changes the value
    // extrapolated from inside by d/2: over-relaxing by 2 converges in one
    // pass. Three passes cover non-orthogonal cells.
    for (label pass = 0; pass < 3; ++pass)
    {
        extrapolateToWalls(field, gradient);
        gradient = fvc::grad(field);
    }
    return tmp<volVectorField>::New(gradient);
}


vector InertialDispersion::fluctuation
(
    Random& random,
    const scalar dt,
    const Turbulence& gas,
    const Inertia& parcel,
    vector& UTurb,
    scalar& tTurb
) const
{
    const scalar cellSigma = sqrt(2.0/3.0*gas.k);
    const vector& slope = gas.gradSigma;
    const scalar sigma = linearInCell(cellSigma, slope, parcel.offset);
    if (cellSigma < SMALL || gas.epsilon < SMALL)
    {
        UTurb = Zero;
        tTurb = 0;
        return Zero;
    }

    const vector w0(tTurb > SMALL ? UTurb/tTurb : normalVector(random));
    const scalar shorter = 1/sqrt(1 + sqr(beta*parcel.meanSlip/sigma));
    const vector timeSlope(shorter*gas.gradTime);
    const scalar T = linearInCell
    (
        shorter*gas.k/gas.epsilon/(0.5 + 0.75*C0), timeSlope, parcel.offset
    );

    const scalar theta = dt/T;
    const LangevinStep step(theta);
    const scalar gained = step.gained;
    const vector a(normalVector(random)), b(normalVector(random));

    const scalar inertia = 1/(1 + parcel.relaxationTime/T);
    const vector drift(inertia*T*slope);
    const vector lag(inertia*sigma*timeSlope);
    const vector end
    (
        step.decay*w0 + sqrt(step.varEnd)*a
      + gained*drift + (gained - theta*step.decay)*lag
    );
    const vector mean
    (
        gained/theta*w0
      + step.covariance/sqrt(step.varEnd)*a
      + sqrt(max(step.varMean - sqr(step.covariance)/step.varEnd, scalar(0)))*b
      + (1 - gained/theta)*drift
      + (2*(1 - gained/theta) - gained)*lag
    );

    UTurb = sigma*end;
    tTurb = sigma;

    // The path leads through sigma of its middle
    const scalar steps = dt/max(parcel.relaxationTime, VSMALL);
    const scalar followed = 1 + std::expm1(-steps)/steps;
    const vector middle(parcel.offset + 0.5*followed*dt*sigma*mean);
    return linearInCell(cellSigma, slope, middle)*mean;
}


} // End namespace Foam
