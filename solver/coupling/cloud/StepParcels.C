/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/StepParcels.H"

namespace Foam
{

void StepParcels::resize(const size_t n)
{
    starts.resize(n);
    effectiveMass.resize(n);
    share.resize(n);

    elutria::dem::Particles& all = particles;
    all.id.resize(n);
    all.material.resize(n);
    all.radius.resize(n);
    all.mass.resize(n);
    all.statisticalWeight.resize(n);
    all.dragRate.resize(n);
    for
    (
        auto* vectors :
        {
            &all.position, &all.velocity, &all.spin, &all.gasVelocity,
            &all.acceleration, &all.dragImpulse
        }
    )
    {
        vectors->resize(n);
    }
}


void StepParcels::slowLate()
{
    elutria::dem::Particles& all = particles;
    late_.clear();
    for (size_t i = 0; i < all.size(); ++i)
    {
        const scalar f = share[i];
        if (f == 1)
        {
            continue;
        }
        const elutria::dem::Vector3 force(all.acceleration[i]);
        late_.push_back
        ({
            i,
            elutria::dem::Flight
            (
                all.position[i], all.velocity[i], force, all.gasVelocity[i],
                all.dragRate[i]
            ),
            force
        });
        all.velocity.set(i, f*all.velocity[i]);
        all.gasVelocity.set(i, f*all.gasVelocity[i]);
        all.acceleration.set(i, f*f*force);
        all.dragRate[i] *= f;
    }
}


void StepParcels::restoreLate(const scalar dt)
{
    elutria::dem::Particles& all = particles;
    for (const Late& late : late_)
    {
        const size_t i = late.i;
        const scalar f = share[i];
        const elutria::dem::Vector3 end = late.flight.at(f*dt).velocity;

        all.velocity.set(i, end + (all.velocity[i] - f*end));
        all.dragImpulse.set
        (
            i, all.mass[i]*late.flight.dragGain(f*dt, late.force)
        );
        all.acceleration.set(i, f*late.force);
    }
}


} // End namespace Foam
