/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/StepParcels.H"
#include "impacts/Flight.hpp"

#include <algorithm>

namespace Foam
{

namespace
{

using elutria::dem::Flight;
using elutria::dem::Particles;
using elutria::dem::Vector3;

} // End anonymous namespace


void StepParcels::list(StockCloud& cloud)
{
    parcels.clear();
    known_.clear();
    startSearch();
    for (StockParcel& p : cloud)
    {
        parcels.push_back(&p);
        known_.push_back(next(p));
    }
    resize(parcels.size());
}


void StepParcels::resize(const size_t n)
{
    starts.resize(n);
    tracked.resize(n);
    cells.resize(n);
    solids.resize(n);
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


StepParcels::End* StepParcels::next(const StockParcel& p)
{
    const uint64_t name = parcelName(p);

    // Parcels that are no more leave gaps
    size_t k = nextEnd_;
    while (k < ends.size() && ends[k].name != name)
    {
        ++k;
    }
    if (k == ends.size())
    {
        return nullptr;
    }
    nextEnd_ = k + 1;
    return &ends[k];
}


point StepParcels::placeOf(const StockParcel& p, const End* end)
{
    if (end && !end->tracked)
    {
        return end->position;
    }
    const point tracked(p.position());

    // Further away: a patch has turned it, or taken it to its other side
    constexpr scalar rounding = 1e-3;       // of its size
    const bool there =
        end && magSqr(end->position - tracked) < sqr(rounding*p.d());
    return there ? end->position : tracked;
}


point StepParcels::place(const StockParcel& p)
{
    return placeOf(p, next(p));
}


void StepParcels::start(const size_t i)
{
    const End* end = known_[i];
    starts[i] = placeOf(*parcels[i], end);
    tracked[i] = !end || end->tracked;
}


void StepParcels::setLateAside()
{
    all_ = Particles();
    if (std::all_of(share.begin(), share.end(), [](scalar f) { return f == 1; }))
    {
        return;
    }
    all_ = particles;
    elutria::dem::keepOnly
    (
        particles, [&](const size_t i) { return share[i] == 1; }
    );
}


void StepParcels::flyLate(const scalar dt)
{
    if (all_.size() == 0)
    {
        return;
    }
    std::swap(particles, all_);
    size_t moved = 0;
    for (size_t i = 0; i < particles.size(); ++i)
    {
        const scalar f = share[i];
        if (f == 1)
        {
            particles.position.set(i, all_.position[moved]);
            particles.velocity.set(i, all_.velocity[moved]);
            particles.spin.set(i, all_.spin[moved]);
            particles.dragImpulse.set(i, all_.dragImpulse[moved]);
            ++moved;
            continue;
        }
        const Vector3 force(particles.acceleration[i]);
        const Flight now
        (
            particles.position[i], particles.velocity[i], force,
            particles.gasVelocity[i], particles.dragRate[i]
        );
        const Flight end = now.at(f*dt);
        particles.position.set(i, end.position);
        particles.velocity.set(i, end.velocity);
        particles.dragImpulse.set
        (
            i, particles.mass[i]*now.dragGain(f*dt, force)
        );

        // Means over the whole step
        particles.acceleration.set(i, f*force);
        particles.dragRate[i] *= f;
    }
}


} // End namespace Foam
