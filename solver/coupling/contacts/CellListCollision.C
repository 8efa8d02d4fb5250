/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "contacts/CellListCollision.H"
#include "core/ParticleName.hpp"
#include "sigFpe.H"

namespace Foam
{

//- Name of a parcel that is its own in the whole run
template<class ParcelType>
inline uint64_t parcelName(const ParcelType& p)
{
    return elutria::dem::ParticleName(p.origProc(), p.origId()).id();
}


template<class CloudType>
elutria::dem::Particles CellListCollision<CloudType>::particles() const
{
    elutria::dem::Particles all;
    for (const parcelType& p : this->owner())
    {
        all.id.push_back(parcelName(p));
        all.material.push_back(material(p));
        all.radius.push_back(0.5*p.d());
        all.mass.push_back(p.mass());
        all.position.push_back(toEngine(p.position()));
        all.velocity.push_back(toEngine(p.U()));
        all.spin.push_back(toEngine(p.omega()));
    }
    const size_t n = all.size();
    all.statisticalWeight.assign(n, 1);
    all.solidFraction.assign(n, 0);
    all.dragRate.assign(n, 0);
    all.gasVelocity.assign(n, {});
    all.acceleration.assign(n, {});
    all.dragImpulse.assign(n, {});
    return all;
}


template<class CloudType>
label CellListCollision<CloudType>::nSubCycles() const
{
    scalar smallest = GREAT, densest = 0, fastest = 0;
    for (const parcelType& p : this->owner())
    {
        smallest = min(smallest, 0.5*p.d());
        densest = max(densest, p.rho());
        fastest = max(fastest, mag(p.U()) + mag(p.omega())*0.5*p.d());
    }
    reduce(smallest, minOp<scalar>());
    reduce(densest, maxOp<scalar>());
    reduce(fastest, maxOp<scalar>());
    const scalar dt = this->owner().time().deltaTValue();
    if (densest == 0)
    {
        return 1;
    }

    if (contacts_.stockResolution > 0)
    {
        // The same number of sub-cycles as stock: duration of a Hertz
        // collision of two smallest spheres at twice the largest speed,
        // 2.94 (5 sqrt(2) pi rho (1 - nu^2)/(4 E))^(2/5) R v^(-1/5)
        const scalar duration =
            std::pow(constant::mathematical::pi, 1.4)*std::pow(1.25, 0.4)
           *0.5*smallest
           *std::pow
            (
                densest
               /(contacts_.stockModulus*std::sqrt(2*fastest) + VSMALL),
                0.4
            );
        return ceil(dt*contacts_.stockResolution/duration);
    }

    elutria::dem::Particles pair = particles();
    scalar limit = engine_->engine().stepLimit(pair, 2*fastest);
    reduce(limit, minOp<scalar>());
    return max(label(1), label(ceil(dt/limit)));
}


template<class CloudType>
void CellListCollision<CloudType>::collide()
{
    elutria::dem::Particles all = particles();
    const scalar dt = this->owner().time().deltaTValue();

    moveWalls();

    // The engine's vector kernels compute lanes that nobody uses
    const sigFpe::ignore untrapped;
    elutria::dem::VectorArray force, torque;
    engine_->engine().contactForces(all, dt, force, torque);

    size_t i = 0;
    for (parcelType& p : this->owner())
    {
        p.f() = toFoam(force[i]);
        p.torque() = toFoam(torque[i]);
        ++i;
    }
}


} // End namespace Foam
