/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/ParcelForces.H"
#include "laws/DragLaws.hpp"
#include "laws/StockDrag.hpp"

namespace Foam
{

ParcelForces::ParcelForces(const StockCloud& cloud)
:
    simple_(true)
{
    for (const auto& force : cloud.forces())
    {
        const word type(force.type());
        const bool drag =
            elutria::laws::findDragLaw(type)
         || elutria::laws::findStockDrag(type);
        const bool gravity = type == "gravity";
        if (!gravity)
        {
            coupled_.push_back(&force);
        }
        if (!drag)
        {
            nonCoupled_.push_back(&force);
        }
        if (!drag && !gravity)
        {
            addingMass_.push_back(&force);
            simple_ = false;
        }
    }
}


forceSuSp ParcelForces::coupled
(
    const StockParcel& p,
    const StockTracking& td,
    const scalar dt,
    const scalar mass,
    const scalar Re
) const
{
    forceSuSp sum(Zero);
    for (const Force* force : coupled_)
    {
        sum += force->calcCoupled(p, td, dt, mass, Re, td.muc());
    }
    return sum;
}


forceSuSp ParcelForces::nonCoupled
(
    const StockParcel& p,
    const StockTracking& td,
    const scalar dt,
    const scalar mass,
    const scalar Re
) const
{
    forceSuSp sum(Zero);
    for (const Force* force : nonCoupled_)
    {
        sum += force->calcNonCoupled(p, td, dt, mass, Re, td.muc());
    }
    return sum;
}


scalar ParcelForces::effectiveMass
(
    const StockParcel& p,
    const StockTracking& td,
    const scalar mass
) const
{
    scalar sum = mass;
    for (const Force* force : addingMass_)
    {
        sum += force->massAdd(p, td, mass);
    }
    return sum;
}


} // End namespace Foam
