/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/GasCoupling.H"
#include "foam/foamVersion.H"
#include "foam/passingField.H"
#include "profiling.H"
#include "zeroGradientFvPatchFields.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

scalar GasCoupling::response(const label k) const
{
    return -std::expm1(-dragRates_[k]*window_);
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

GasCoupling::GasCoupling
(
    StockCloud& cloud,
    const DiffusionKernel& kernel,
    const bool stockMotion
)
:
    cloud_(cloud),
    kernel_(kernel),
    stockMotion_(stockMotion),
    impulse_(cloud.mesh().nCells(), Zero),
    given_(cloud.mesh().nCells(), false),
    stockCoefficient_(stockMotion ? cloud.mesh().nCells() : 0, Zero),
    window_(0),
    windowStart_(cloud.time().timeIndex())
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void GasCoupling::startStep(const scalar dt)
{
    window_ += dt;
    dragRates_.clear();
}


void GasCoupling::depositStock()
{
    if (cloud_.solution().coupled())
    {
        forAll(impulse_, celli)
        {
            give(celli);
        }
        impulse_ += cloud_.UTrans().field();
        stockCoefficient_ += cloud_.UCoeff().field();
    }
}


vector GasCoupling::forceOnGas(const label celli) const
{
    const bool acts = cloud_.solution().coupled() && window_ > 0;
    return acts ? impulse_[celli]/window_ : vector::zero;
}


GasExchange GasCoupling::exchange() const
{
    addProfiling(exchange, "elutria::exchange");
    const fvMesh& mesh = cloud_.mesh();
    GasExchange gas
    {
        volVectorField
        (
            passingField("particleForce", mesh), mesh,
            dimensionedVector(dimForce/dimVolume, Zero),
            zeroGradientFvPatchVectorField::typeName
        ),
        volScalarField
        (
            passingField("particleCoefficient", mesh), mesh,
            dimensionedScalar(dimDensity/dimTime, Zero),
            zeroGradientFvPatchScalarField::typeName
        )
    };
    if (!cloud_.solution().coupled() || window_ <= 0)
    {
        return gas;
    }

    scalarField& coefficient = gas.coefficient.primitiveFieldRef();
    if (stockMotion_)
    {
        coefficient = stockCoefficient_;
    }
    else
    {
        label k = 0;
        for (const StockParcel& p : cloud_)
        {
            coefficient[p.cell()] += p.nParticle()*p.mass()*response(k++);
        }
    }
    coefficient /= mesh.V()*window_;
    vectorField& force = gas.force.primitiveFieldRef();
    for (const label celli : cells_)
    {
        force[celli] = forceOnGas(celli)/mesh.V()[celli];
    }
    kernel_.smooth(gas.force);
    kernel_.smooth(gas.coefficient);
    gas.force.correctBoundaryConditions();
    gas.coefficient.correctBoundaryConditions();
    return gas;
}


void GasCoupling::correct(const volVectorField& change)
{
    if (stockMotion_ || !cloud_.solution().coupled())
    {
        return;
    }
    const fvMesh& mesh = cloud_.mesh();
    volVectorField seen
    (
        passingField("gasChange", mesh), mesh,
        dimensionedVector(dimVelocity, Zero),
        zeroGradientFvPatchVectorField::typeName
    );
    seen.primitiveFieldRef() = change.primitiveField();
    kernel_.smooth(seen);

    label k = 0;
    for (StockParcel& p : cloud_)
    {
        p.U() += response(k++)*seen[p.cell()];
    }
}


void GasCoupling::restart()
{
    for (const label celli : cells_)
    {
        impulse_[celli] = Zero;
        given_[celli] = false;
    }
    cells_.clear();
    stockCoefficient_ = Zero;
    window_ = 0;
    windowStart_ = cloud_.time().timeIndex();
}


} // End namespace Foam
