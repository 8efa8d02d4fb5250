/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    ElutriaCloud's side of the exchange with the gas.

\*---------------------------------------------------------------------------*/

#include "cloud/ElutriaCloud.H"
#include "foam/stateFile.H"
#include "foam/foamVersion.H"
#include "IOField.H"
#include "zeroGradientFvPatchFields.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

scalar ElutriaCloud::response(const label k) const
{
    return -std::expm1(-dragRates_[k]*window_);
}


void ElutriaCloud::countArrival(const parcelType& p, const scalar sign)
{
    volumeShares_.add
    (
        arrived_, p.cell(), p.position(), sign*p.nParticle()*p.volume()
    );
}


void ElutriaCloud::countInjected()
{
    if (this->size() == injectedFrom_)
    {
        return;
    }
    label k = 0;
    for (const parcelType& p : *this)
    {
        if (k++ >= injectedFrom_)
        {
            countArrival(p, 1);
        }
    }
}


scalar ElutriaCloud::readWakeAge() const
{
    const IOField<scalar> age(stateFile(*this, "ownWakeAge", IOobject::READ_IF_PRESENT));
    return age.empty() ? -1 : age[0];
}


void ElutriaCloud::seeUndisturbedGas
(
    const parcelType& p,
    trackingData& td,
    const scalar dt
)
{
    if (!ownWake_.corrects() || p.age() < wakeAge_ || wakeAge_ < 0)
    {
        return;
    }

    const scalar cellVolume = mesh().V()[p.cell()];
    const scalar cellSize = cbrt(cellVolume);
    const scalar kernel = kernel_.active() ? kernel_.width() : 0;
    const vector seen(td.Uc() - p.U());
    const scalar passing = (p.U() & seen)/max(mag(seen), VSMALL);
    if (OwnWake::leftBehind(passing*wakeAge_, kernel, cellSize))
    {
        return;
    }

    const scalar volume = p.nParticle()*p.volume();
    const scalar viscosity =
        td.muc() + (eddyViscosity_ ? td.rhoc()*(*eddyViscosity_)[p.cell()] : 0);
    const OwnWake::Surroundings gas
    {
        kernel,
        cellSize,
        OwnWake::spacing
        (
            theta_[p.cell()], volume,
            volume/cellVolume*OwnWake::kept(kernel, cellSize)
        ),
        viscosity,
        viscosity/td.rhoc()
    };

    scalar share = 0, change = 1;
    for (label pass = 0; pass < 20 && change > 1e-5; ++pass)
    {
        td.Uc() = p.U() + seen/(1 - share);
        const scalar dragRate = forces().calcCoupled
        (
            p, td, dt, p.mass(), p.Re(td), td.muc()
        ).Sp();
        const scalar better = OwnWake::share
        (
            p.nParticle()*dragRate,
            {mag(td.Uc() - p.U()), passing, passing*wakeAge_},
            gas
        );
        change = mag(better - share);
        share = better;
    }
    td.Uc() = p.U() + seen/(1 - share);
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

scalar ElutriaCloud::ownWake(const scalar weight, const scalar speed) const
{
    scalar largest = 0;
    for (const Feed::Material& m : feed_->materials())
    {
        largest = max(largest, m.sizes.max());
    }
    SpreadingKernel kernel(kernel_);
    kernel.adapt(largest);

    const scalar viscosity = gAverage(mu().primitiveField());
    return OwnWake::share
    (
        weight/speed,
        {speed, 0, 0},
        {
            kernel.active() ? kernel.width() : 0,
            cbrt(gAverage(mesh().V().field())),
            GREAT,
            viscosity,
            viscosity/gAverage(rho().primitiveField())
        }
    );
}


vectorField ElutriaCloud::forceOnGas() const
{
    if (!solution().coupled() || window_ <= 0)
    {
        return vectorField(mesh().nCells(), Zero);
    }
    return (stockMotion_ ? UTrans().field() : impulse_)/window_;
}


scalarField ElutriaCloud::solidVolume() const
{
    scalarField volume(mesh().nCells(), Zero);
    for (const parcelType& p : *this)
    {
        volume[p.cell()] += p.nParticle()*p.volume();
    }
    return volume;
}


ElutriaCloud::GasExchange ElutriaCloud::exchange() const
{
    GasExchange gas
    {
        volVectorField
        (
            passingField("particleForce"), mesh(),
            dimensionedVector(dimForce/dimVolume, Zero),
            zeroGradientFvPatchVectorField::typeName
        ),
        volScalarField
        (
            passingField("particleCoefficient"), mesh(),
            dimensionedScalar(dimDensity/dimTime, Zero),
            zeroGradientFvPatchScalarField::typeName
        )
    };
    if (!solution().coupled() || window_ <= 0)
    {
        return gas;
    }

    scalarField& coefficient = gas.coefficient.primitiveFieldRef();
    if (stockMotion_)
    {
        coefficient = UCoeff().field();
    }
    else
    {
        label k = 0;
        for (const parcelType& p : *this)
        {
            coefficient[p.cell()] += p.nParticle()*p.mass()*response(k++);
        }
    }
    coefficient /= mesh().V()*window_;
    gas.force.primitiveFieldRef() = forceOnGas()/mesh().V();
    kernel_.spread(gas.force);
    kernel_.spread(gas.coefficient);
    gas.force.correctBoundaryConditions();
    gas.coefficient.correctBoundaryConditions();
    return gas;
}


void ElutriaCloud::correct(const volVectorField& change)
{
    if (!stockMotion_ && solution().coupled())
    {
        volVectorField seen
        (
            passingField("gasChange"), mesh(),
            dimensionedVector(dimVelocity, Zero),
            zeroGradientFvPatchVectorField::typeName
        );
        seen.primitiveFieldRef() = change.primitiveField();
        kernel_.spread(seen);

        label k = 0;
        for (parcelType& p : *this)
        {
            p.U() += response(k++)*seen[p.cell()];
        }
    }
    drop();
    wakeAge_ = solution().coupled() ? 0 : -1;
}


void ElutriaCloud::drop()
{
    impulse_ = Zero;
    arrived_ = Zero;
    window_ = 0;
    windowStart_ = time().timeIndex();
}


const volScalarField& ElutriaCloud::solidFraction(const scalar maximum)
{
    scalarField& theta = theta_.primitiveFieldRef();
    scalar largest = 0;

    theta = 0;
    thetaTime_ = time().timeIndex();
    for (const parcelType& p : *this)
    {
        volumeShares_.add
        (
            theta, p.cell(), p.position(), p.nParticle()*p.volume()
        );
        largest = max(largest, p.d());
    }
    theta /= mesh().V();

    reduce(largest, maxOp<scalar>());
    kernel_.adapt(largest);
    kernel_.spread(theta_);

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


tmp<volScalarField> ElutriaCloud::arrivedFraction() const
{
    auto tfraction = tmp<volScalarField>::New
    (
        passingField("arrivedFraction"), mesh(), dimensionedScalar(dimless, Zero),
        zeroGradientFvPatchScalarField::typeName
    );
    tfraction.ref().primitiveFieldRef() = arrived_/mesh().V();
    kernel_.spread(tfraction.ref());
    tfraction.ref().correctBoundaryConditions();
    return tfraction;
}


} // End namespace Foam
