/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    What ScenePlan tells: the plan before the run, and what it came to.

\*---------------------------------------------------------------------------*/

#include "schedule/ScenePlan.H"
#include "contacts/ContactEstimate.H"
#include "mathematicalConstants.H"

#include <iomanip>
#include <sstream>

namespace Foam
{

namespace
{

constexpr scalar pi = constant::mathematical::pi;

//- Three significant digits
std::string number(const scalar value)
{
    std::ostringstream text;
    text << std::setprecision(3) << value;
    return text.str();
}


std::string percent(const scalar share)
{
    return number(100*share) + " %";
}


void row
(
    const std::string& what,
    const std::string& decision,
    const std::string& why
)
{
    std::ostringstream line;
    line << "    " << std::left << std::setw(16) << what << std::setw(30)
        << decision << why;
    Info<< line.str().c_str() << nl;
}


//- Relaxation time of a sphere slipping at a speed, Schiller & Naumann [s]
scalar relaxationTime
(
    const scalar density,
    const scalar diameter,
    const scalar speed,
    const scalar rho,
    const scalar mu
)
{
    const scalar Re = rho*speed*diameter/mu;
    return density*sqr(diameter)/(18*mu)/(1 + 0.15*std::pow(Re, 0.687));
}

//- Overlap over radius above which soft spheres are no longer spheres
constexpr scalar largestOverlap = 0.05;

//- Particles that a parcel may be where particles collide more than once:
//  heavier ones have few others near enough to meet, and meet those again and
//  again (docs/bench/accuracy.md, dense column: 6, 12 and 35)
constexpr scalar largestParcel = 12;

//- Share of a parcel's slip that its self-induced velocity may be. It is
//  corrected for; in the same place it is 3, 7 and 19 % for parcels of 6, 12 and
//  35 particles.
constexpr scalar largestWake = 0.1;

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

ScenePlan::Expected ScenePlan::expect(const Feed& feed) const
{
    Expected e;
    const scalar rho = gas_.meanDensity(), U = gas_.meanSpeed();
    const scalar mu = gAverage(gas_.mu().primitiveField());
    const scalar volume = gSum(gas_.U().mesh().V());

    // A particle is taken to stay as long as the gas
    const scalar stay = gas_.throughTime();
    e.loading = feed.massFlow()*stay/(rho*volume);
    const scalar inside = feed.massFlow()*stay;
    e.gasChange =
        inside*mag(gas_.gravity())*stay/(rho*U*volume);

    scalar crossSection = 0;
    for (const Feed::Material& m : feed.materials())
    {
        for (const scalar d : {m.sizes.min(), m.sizes.max()})
        {
            const scalar tau = relaxationTime(m.density, d, U, rho, mu);
            e.shortestRelaxation = min(e.shortestRelaxation, tau);
            e.longestRelaxation = max(e.longestRelaxation, tau);
        }
        e.smallest = min(e.smallest, m.sizes.min());
        const scalar d = m.sizes.quantileByNumber(0.5);
        crossSection += m.numberFraction*pi*sqr(d);
        e.solidFraction += m.massFraction*inside/m.density/volume;
    }
    e.collisions = inside/feed.meanMass()/volume*crossSection*0.5*U*stay;
    return e;
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void ScenePlan::announceStiffness(const ElutriaCloud& cloud) const
{
    const ContactEstimate contacts(cloud.engine(), *cloud.feed());
    const scalar overlap = contacts.deepestOverlap(gas_.meanSpeed());
    const bool tooSoft = contacts.softOnly() && overlap > largestOverlap;
    row
    (
        "stiffness", tooSoft ? "too low" : "enough",
        "overlap " + percent(overlap) + " of the radius at the gas' speed"
      + (contacts.softOnly() ? "" : ", if that were soft")
    );
    if (tooSoft)
    {
        Info<< "    Warning: contacts at the gas' speed overlap by "
            << percent(overlap).c_str() << " of the radius, allowed: "
            << percent(largestOverlap).c_str()
            << "; raise youngsModulus or normalStiffness" << nl;
    }
}


void ScenePlan::announceParcels
(
    const ElutriaCloud& cloud,
    const scalar collisions
) const
{
    const Feed& feed = *cloud.feed();
    const scalar each = feed.massFlow()/(feed.rate()*feed.meanMass());
    const scalar wake = cloud.sampling().selfInducedShare
    (
        feed.heaviestParcel()*mag(gas_.gravity()), gas_.meanSpeed()
    );
    row
    (
        "parcels", "each " + number(each) + " particles",
        "the heaviest feel gas slowed by themselves by " + percent(wake)
    );
    if (feed.added() > 0)
    {
        row
        (
            "", number(feed.added()) + " more than asked for",
            "so that they collide as particles do (particlesPerParcel)"
        );
    }
    for (const Feed::Material& m : feed.materials())
    {
        if (m.focus > 0)
        {
            row
            (
                "focus", "half of the parcels around",
                number(1e6*m.focus) + " um of " + m.name
            );
        }
    }
    if (wake > largestWake)
    {
        Info<< "    Warning: parcels so heavy can shift the cut; "
            << number(wake/largestWake).c_str()
            << " times as many (particles of constant/feed) stay below "
            << percent(largestWake).c_str() << nl;
    }
    if (cloud.contacts() && collisions > 1 && each > largestParcel)
    {
        Info<< "    Warning: parcels of " << number(each).c_str()
            << " particles that collide can shift the cut; "
            << number(each/largestParcel).c_str()
            << " times as many (particles of constant/feed) are few enough in"
            << " each" << nl;
    }
}


void ScenePlan::announce(const ElutriaCloud& cloud, const Time& runTime) const
{
    static const char* const forced[] = {"as the scene allows", "always", "never"};
    const auto said = [](const choice c) { return std::string(forced[label(c)]); };

    Info<< nl << "Scene plan (system/scenePlan)" << nl;
    const scalar dt = runTime.deltaTValue();
    const bool coupled = cloud.solution().coupled();
    if (const Feed* feed = cloud.feed())
    {
        const Expected e = expect(*feed);
        row
        (
            "coupling",
            !coupled ? "one-way: coupled is false"
          : e.gasChange < tolerance_ ? "one-way until it matters" : "two-way",
            "loading " + number(e.loading) + ", the load changes the gas by "
          + percent(e.gasChange)
        );
        if (feed->weighted() && coupled)
        {
            announceParcels(cloud, e.collisions);
        }
        row
        (
            "contacts",
            !cloud.contacts() ? "skipped: no contact model"
          : "impacts; soft where lasting",
            number(e.collisions) + " collisions a particle, "
          + number(e.solidFraction) + " solids by volume"
        );
        if (cloud.contacts())
        {
            const ContactEstimate contacts(cloud.engine(), *feed);
            const scalar contact = contacts.duration
            (
                e.smallest, gas_.meanSpeed()
            );
            row
            (
                "contact steps", "where something touches",
                "shortest contact " + number(contact) + " s, its steps "
              + number(contact*contacts.stepFraction()) + " s; gas step "
              + number(dt) + " s"
            );
            if
            (
                largestStep(cloud) < dt
             && runTime.controlDict().getOrDefault("adjustTimeStep", false)
            )
            {
                row
                (
                    "step", number(largestStep(cloud)) + " s at most",
                    "not deltaT: a particle collides less than "
                  + number(collisionsPerStep_) + " times in it"
                );
            }
            announceStiffness(cloud);
        }
        row
        (
            "drag", "closed form over a step",
            "relaxation " + number(e.shortestRelaxation) + " .. "
          + number(e.longestRelaxation) + " s"
        );
    }
    row
    (
        "gas", said(gasChoice_),
        "when its velocity could change by " + percent(tolerance_)
      + ", Courant " + number(courant_)
    );
    row
    (
        "gas beforehand", convergeGas_ ? "settles without feed" : "skipped",
        "to " + percent(0.1*tolerance_) + " a passage"
    );
    const bool dispersed = cloud.sampling().disperses();
    row
    (
        "dispersion", dispersed ? "needed" : "skipped",
        dispersed ? "the gas is turbulent" : "no model, or a laminar gas"
    );
    if (cloud.contacts())
    {
        const bool friction = hasFriction(cloud.engine());
        row
        (
            "spin, history", friction ? "needed" : "skipped",
            friction ? "friction" : "no friction anywhere"
        );
    }
    Info<< endl;
}


void ScenePlan::report(const ElutriaCloud& cloud) const
{
    static const char* const names[nParts] =
        {"particles", "exchange", "gas", "output"};

    scalar total = SMALL;
    for (const scalar s : seconds_)
    {
        total += s;
    }
    const ElutriaCloud::Work& work = cloud.work();
    const scalar flights = max(work.particleSteps, scalar(1));

    Info<< nl << "Scene plan: what was needed in " << steps_ << " steps" << nl;
    row
    (
        "gas solved", std::to_string(solves_) + " times",
        "left at rest " + std::to_string(sleeps_)
      + " times when due; largest change spared " + percent(largestSpared_)
    );
    if (cloud.contacts())
    {
        row
        (
            "flights", percent(work.freeFlights/flights),
            "of " + number(work.particleSteps) + " particle steps met nothing"
        );
        row
        (
            "impacts", number(work.impacts),
            "without contact steps"
        );
        row
        (
            "soft contacts", percent(work.softFlights/flights),
            "of the particle steps took contact steps"
        );
    }
    for (label p = 0; p < nParts; ++p)
    {
        row(names[p], percent(seconds_[p]/total), number(seconds_[p]) + " s");
    }
    Info<< endl;
}


} // End namespace Foam
