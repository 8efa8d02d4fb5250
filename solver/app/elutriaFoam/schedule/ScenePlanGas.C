/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    What ScenePlan tells of the gas: how often it is solved, and why.

\*---------------------------------------------------------------------------*/

#include "schedule/ScenePlan.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

PlanTable::Decision ScenePlan::gasSolves() const
{
    const std::string courant(", Courant " + threeDigits(courant_));
    if (gasChoice_ == choice::off)
    {
        return {"never", "gas is off"};
    }
    if (gasChoice_ == choice::on)
    {
        return {"always", "gas is on" + courant};
    }
    if (basis_ != gasBasis::inlet && !flow_.steady())
    {
        return
        {
            "on every step",
            std::string("it is ") + flow_.name() + " by itself" + courant
        };
    }
    return
    {
        "as the scene allows",
        "when its velocity could change by " + percent(tolerance_) + courant
    };
}


PlanTable::Decision ScenePlan::gasBeforehand(const ElutriaCloud& cloud) const
{
    if (settles(cloud))
    {
        return
        {
            "settles without feed",
            "to " + percent(settledTolerance()) + " a passage"
        };
    }
    return
    {
        "skipped",
        !convergeGas_ ? "convergeGas is off"
      : !cloud.feed() ? "no constant/feed: the case's fields are the start"
      : "particles are inside"
    };
}


PlanTable::Decision ScenePlan::gasByItself() const
{
    if (basis_ == gasBasis::inlet)
    {
        return {"not known yet", "it settles first"};
    }
    return {flow_.name(), flow_.why()};
}


void ScenePlan::announceGas(PlanTable& table, const ElutriaCloud& cloud) const
{
    table.row("gas", gasSolves());
    table.row("gas beforehand", gasBeforehand(cloud));
    table.row("gas by itself", gasByItself());
    const bool dispersed = cloud.sampling().disperses();
    table.row
    (
        "dispersion", dispersed ? "needed" : "skipped",
        dispersed ? "the gas is turbulent" : "no model, or a laminar gas"
    );
}


} // End namespace Foam
