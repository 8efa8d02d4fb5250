/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later

Description
    What ScenePlan tells: the plan before the run, and what it came to.

\*---------------------------------------------------------------------------*/

#include "schedule/ScenePlan.H"
#include "cloud/stockWords.H"
#include "contacts/ContactEstimate.H"
#include "contacts/wallsCrossed.H"
#include "foam/Json.H"
#include "foam/ownEntries.H"
#include "laws/OutputFiles.hpp"

#include <fstream>

namespace Foam
{

namespace
{

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

elutria::laws::Gas ScenePlan::gas() const
{
    return {gas_.meanDensity(), gAverage(gas_.mu().primitiveField())};
}


elutria::laws::GasStream ScenePlan::stream(const Feed& feed) const
{
    return
    {
        gas_.meanDensity(),
        basis_ == gasBasis::inlet
      ? feed.superficialSpeed(gas_.name()) : gas_.meanSpeed(),
        gSum(gas_.U().mesh().V()),
        gas_.throughTime()
    };
}


elutria::laws::SceneEstimate ScenePlan::expect
(
    const Feed& feed,
    const elutria::laws::GasStream& gas
) const
{
    elutria::laws::Solids solids{feed.massFlow(), feed.meanMass(), {}};
    for (const Feed::Material& m : feed.materials())
    {
        solids.materials.push_back
        ({
            m.density, m.massFraction, feed.numberFraction(m),
            m.sizes.quantileByNumber(0.5)
        });
    }
    return elutria::laws::estimate(solids, gas, mag(gas_.gravity()));
}


std::pair<scalar, scalar> ScenePlan::relaxationTimes
(
    const Feed& feed,
    const CaseDrag& drag,
    const scalar slip
) const
{
    std::pair<scalar, scalar> times(GREAT, 0);
    for (const Feed::Material& m : feed.materials())
    {
        for (const scalar d : {m.sizes.min(), m.sizes.max()})
        {
            const scalar tau = drag.relaxationTime(m, d, slip, gas());
            times = {min(times.first, tau), max(times.second, tau)};
        }
    }
    return times;
}


void ScenePlan::announceStiffness
(
    PlanTable& table,
    const ElutriaCloud& cloud,
    const scalar speed
) const
{
    const ContactEstimate contacts(cloud.engine(), *cloud.feed());
    const scalar overlap = contacts.deepestOverlap(speed);
    const bool tooSoft = contacts.softOnly() && overlap > largestOverlap;
    table.row
    (
        "stiffness", tooSoft ? "too low" : "enough",
        "overlap " + percent(overlap) + " of the radius at the gas' speed"
      + (contacts.softOnly() ? "" : ", if that were soft")
    );
    if (tooSoft)
    {
        table.warn
        ({
            "stiffness", "contacts at the gas' speed overlap",
            percent(overlap) + " of the radius, allowed: "
          + percent(largestOverlap),
            "raise youngsModulus or normalStiffness", overlap
        });
    }
}


void ScenePlan::announceEnd
(
    PlanTable& table,
    const Feed& feed,
    const Time& runTime
) const
{
    const scalar end = runTime.endTime().value();
    const label all = feed.fedUntil(GREAT);
    const label fed = feed.fedUntil(end);
    if (fed >= all)
    {
        return;
    }
    table.warn
    ({
        "feedCut", "the run ends before its feed is over",
        name(fed) + " of " + name(all) + " parcels enter by endTime, "
      + threeDigits(end) + " s",
        "raise endTime of system/controlDict above " + threeDigits(feed.end())
      + " s and drainTime", 1 - scalar(fed)/all
    });
}


void ScenePlan::announceParcels
(
    PlanTable& table,
    const ElutriaCloud& cloud,
    const elutria::laws::GasStream& gas,
    const scalar collisions
) const
{
    const Feed& feed = *cloud.feed();
    const scalar each = feed.particlesPerParcel();
    const scalar wake = cloud.sampling().selfInducedShare
    (
        feed.heaviestParcel()*mag(gas_.gravity()), gas.speed
    );
    table.row
    (
        "parcels", "each " + threeDigits(each) + " particles",
        "the heaviest feel gas slowed by themselves by " + percent(wake)
    );
    if (feed.added() > 0)
    {
        table.row
        (
            "", threeDigits(feed.added()) + " more than asked for",
            "so that they collide as particles do (particlesPerParcel)"
        );
    }
    for (const Feed::Material& m : feed.materials())
    {
        if (m.focus > 0)
        {
            table.row
            (
                "focus", "half of the parcels around",
                threeDigits(1e6*m.focus) + " um of " + m.name
            );
        }
    }
    if (wake > largestWake)
    {
        table.warn
        ({
            "heavyParcels", "parcels so heavy can shift the cut",
            "they feel gas slowed by themselves by " + percent(wake)
          + ", allowed: " + percent(largestWake),
            "feed " + threeDigits(wake/largestWake)
          + " times as many (particles of constant/feed)", wake
        });
    }
    if (cloud.contacts() && collisions > 1 && each > largestParcel)
    {
        table.warn
        ({
            "manyInAParcel", "parcels of many particles that collide can shift"
            " the cut",
            threeDigits(each) + " particles in each, allowed: "
          + threeDigits(largestParcel),
            "feed " + threeDigits(each/largestParcel)
          + " times as many (particles of constant/feed)", each
        });
    }
}


void ScenePlan::announceContacts
(
    PlanTable& table,
    const ElutriaCloud& cloud,
    const Time& runTime
) const
{
    const Feed& feed = *cloud.feed();
    const scalar speed = stream(feed).speed;
    scalar smallest = GREAT;
    for (const Feed::Material& m : feed.materials())
    {
        smallest = min(smallest, m.sizes.min());
    }
    const ContactEstimate contacts(cloud.engine(), feed);
    const scalar contact = contacts.duration(smallest, speed);
    table.row
    (
        "contact steps", "where something touches",
        "shortest contact " + threeDigits(contact) + " s, its steps "
      + threeDigits(contact*contacts.stepFraction()) + " s; gas step "
      + threeDigits(runTime.deltaTValue()) + " s"
    );
    if
    (
        largestStep(cloud) < runTime.deltaTValue()
     && runTime.controlDict().getOrDefault("adjustTimeStep", false)
    )
    {
        table.row
        (
            "step", threeDigits(largestStep(cloud)) + " s at most",
            "not deltaT: a particle collides less than "
          + threeDigits(collisionsPerStep_) + " times in it"
        );
    }
    announceStiffness(table, cloud, speed);
}


void ScenePlan::announceFeed
(
    PlanTable& table,
    const ElutriaCloud& cloud,
    const Time& runTime
) const
{
    const Feed& feed = *cloud.feed();
    const bool coupled = cloud.solution().coupled();
    const elutria::laws::GasStream gas(stream(feed));
    if (!(feed.massFlow() > 0))
    {
        table.row
        (
            "feed", "known when the gas flows",
            "loading is per gas that flows in, which pressure drives"
        );
        return;
    }
    announceEnd(table, feed, runTime);
    const elutria::laws::SceneEstimate e(expect(feed, gas));
    table.row
    (
        "coupling",
        !coupled ? "one-way: coupled is false"
      : e.gasChange < tolerance_ ? "one-way until it matters" : "two-way",
        "loading " + threeDigits(e.loading) + ", the load changes the gas by "
      + percent(e.gasChange)
    );
    if (feed.weighted() && coupled)
    {
        announceParcels(table, cloud, gas, e.collisions);
    }
    table.row
    (
        "contacts",
        !cloud.contacts() ? "skipped: no contact model"
      : "impacts; soft where lasting",
        threeDigits(e.collisions) + " collisions a particle, "
      + threeDigits(e.solidFraction) + " solids by volume"
    );
    if (cloud.contacts())
    {
        announceContacts(table, cloud, runTime);
    }
    const CaseDrag drag(cloud.particleProperties());
    const auto relaxation = relaxationTimes(feed, drag, gas.speed);
    table.row
    (
        "drag", "closed form over a step",
        "relaxation " + threeDigits(relaxation.first) + " .. "
      + threeDigits(relaxation.second) + " s"
    );
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void ScenePlan::announce
(
    const ElutriaCloud& cloud,
    const Time& runTime,
    const std::vector<caseFiles::Unused>& unused
) const
{
    PlanTable table("Scene plan (system/scenePlan)");
    if (cloud.feed())
    {
        announceFeed(table, cloud, runTime);
    }
    announceGas(table, cloud);
    if (cloud.contacts())
    {
        for (const RunWarning& warning : wallsCrossed(gas_.U()))
        {
            table.warn(warning);
        }
        for (const WallSurface& surface : cloud.wallSurfaces())
        {
            table.row
            (
                "walls", surface.name + ", of particles alone",
                std::to_string(surface.triangles.size()) + " triangles of "
              + surface.file + "; the gas flows through"
            );
        }
        const bool friction = hasFriction(cloud.engine());
        table.row
        (
            "spin, history", friction ? "needed" : "skipped",
            friction ? "friction" : "no friction anywhere"
        );
    }
    const wordList idle
    (
        cloud.stockMotion()
      ? wordList() : entriesWithoutEffect(cloud.particleProperties())
    );
    if (!idle.empty())
    {
        table.row
        (
            "without effect", "stock's motion",
            "solution: " + listed(idle) + ": ours replaces it"
        );
    }
    const wordList uncounted(cloud.uncounted());
    if (!uncounted.empty())
    {
        table.row
        (
            "not counted", "injection: " + listed(uncounted),
            "products and ledger are of constant/feed's particles alone"
        );
    }
    for (const caseFiles::Unused& one : unused)
    {
        table.row("not used", one.what, one.why);
    }
    table.end();
    writePlan(table, cloud, runTime);
}


void ScenePlan::reportRanks(PlanTable& table, const ElutriaCloud& cloud) const
{
    if (!Pstream::parRun() || !cloud.contacts())
    {
        return;
    }
    const List<ElutriaCloud::RankWork> ranks(cloud.workOfRanks());
    if (!Pstream::master())
    {
        return;
    }
    const fileName folder(cloud.time().globalPath()/"postProcessing");
    mkDir(folder);
    std::ofstream file(folder/"ranks.csv");
    file << elutria::laws::rankColumns << '\n';
    forAll(ranks, r)
    {
        const ElutriaCloud::RankWork& rank = ranks[r];
        file<< r;
        for
        (
            const scalar number :
            {
                rank.cells, rank.particles, rank.particleSteps,
                rank.ghostSteps, rank.sharedIslands, rank.calls, rank.seconds,
                rank.bytes
            }
        )
        {
            file<< ',' << json::number(number);
        }
        file<< '\n';
        table.row
        (
            "rank " + std::to_string(r),
            threeDigits(rank.particleSteps) + " steps",
            threeDigits(rank.ghostSteps) + " of ghosts, "
          + threeDigits(rank.sharedIslands) + " shared islands, "
          + threeDigits(rank.seconds) + " s in exchange, "
          + threeDigits(rank.bytes/1e6) + " MB sent"
        );
    }
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

    PlanTable table
    (
        "Scene plan: what was needed in " + std::to_string(steps_) + " steps"
    );
    table.row
    (
        "gas solved", std::to_string(solves_) + " times",
        "left at rest " + std::to_string(sleeps_)
      + " times when due; largest change spared " + percent(largestSpared_)
    );
    table.row("gas by itself", flow_.name(), flow_.why());
    if (cloud.contacts())
    {
        table.row
        (
            "flights", percent(work.freeFlights/flights),
            "of " + threeDigits(work.particleSteps) + " particle steps met nothing"
        );
        table.row
        (
            "impacts", threeDigits(work.impacts),
            "without contact steps"
        );
        table.row
        (
            "soft contacts", percent(work.softFlights/flights),
            "of the particle steps took contact steps"
        );
    }
    reportRanks(table, cloud);
    for (label p = 0; p < nParts; ++p)
    {
        table.row
        (
            names[p], percent(seconds_[p]/total),
            threeDigits(seconds_[p]) + " s"
        );
    }
    table.end();
}


} // End namespace Foam
