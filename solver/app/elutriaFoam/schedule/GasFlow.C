/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "schedule/GasFlow.H"
#include "schedule/PlanTable.H"
#include "messageStream.H"

namespace Foam
{

namespace
{

const char* const names[] = {"developing", "unsteady", "steady"};

//- Passages after which a gas that still develops is called unsteady
constexpr label longDevelopment = 10;

//- Change of a steady gas' velocity in one solve over what the particles' load
//  and the tolerance explain, from which on it is steady no longer. In
//  default columns, of 300 to 1000 parcels, it is at most 1.06
constexpr scalar surprise = 2;

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void GasFlow::become(const state s, const std::string& why)
{
    const bool never = resolvesEddies_ && s == state::steady;
    state_ = never ? state::unsteady : s;
    why_ = never ? "its eddies are resolved (simulationType LES)" : why;
    watched_ = changed_ = caused_ = 0;
    passages_ = 0;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

GasFlow::GasFlow(const scalar tolerance, const bool resolvesEddies)
:
    resolvesEddies_(resolvesEddies),
    tolerance_(tolerance)
{
    become(state::developing, "it starts from the fields of the case");
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

const char* GasFlow::name() const
{
    return names[label(state_)];
}


void GasFlow::restore(const std::string& name)
{
    for (const state s : {state::developing, state::unsteady, state::steady})
    {
        if (name == names[label(s)])
        {
            become(s, "found so by the run that is continued");
        }
    }
}


void GasFlow::settled(const scalar change)
{
    if (change >= GREAT)
    {
        become(state::developing, "no gas flows in yet");
        return;
    }
    become
    (
        change > tolerance_ ? state::unsteady : state::steady,
        "changed by " + percent(change) + " a passage without particles"
    );
}


void GasFlow::disturbed()
{
    if (state_ == state::steady)
    {
        become(state::developing, "a condition at the boundary has changed");
        Info<< "Scene plan: the gas is solved on every step: " << why_ << endl;
    }
}


void GasFlow::solved
(
    const scalar passage,
    const scalar change,
    const scalar byLoad
)
{
    watched_ += passage;
    changed_ += change;
    caused_ += steady() ? byLoad : byLoad*passage;

    const bool sudden = steady() && change > surprise*(byLoad + tolerance_);
    if (watched_ < 1 && !sudden)
    {
        return;
    }

    const std::string observed
    (
        "changed by " + percent(changed_/max(watched_, scalar(1))) + " in a passage, by "
      + percent(caused_/max(watched_, scalar(1))) + " for the particles"
    );
    const bool explained = changed_ < tolerance_*watched_ + caused_;
    if (steady())
    {
        if (sudden || !explained)
        {
            become(state::developing, observed);
            Info<< "Scene plan: the gas is solved on every step again: it "
                << observed.c_str() << endl;
        }
    }
    else if (++passages_, explained)
    {
        become(state::steady, observed);
        if (steady())
        {
            Info<< "Scene plan: the gas is steady by itself: it " << observed
                << endl;
        }
    }
    else if (state_ == state::developing && passages_ == longDevelopment)
    {
        become(state::unsteady, observed);
    }
    watched_ = changed_ = caused_ = 0;
}


} // End namespace Foam
