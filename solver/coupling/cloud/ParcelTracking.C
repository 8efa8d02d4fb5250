/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/ParcelTracking.H"
#include "cloud/GasSampling.H"
#include "cloud/parcelBlocks.H"
#include "contacts/SymmetryWalls.H"
#include "foam/engineVectors.H"
#include "foam/foamVersion.H"
#include "laws/DragLaws.hpp"
#include "meshTools.H"
#include "processorCyclicPolyPatch.H"
#include "profiling.H"

#include <algorithm>
#include <set>

namespace Foam
{

namespace
{

//- Parcels between the one at hand and the one whose memory is asked for: a
//  parcel takes a tenth of a microsecond, memory as much or more
constexpr label ahead = 4;

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

bool ParcelTracking::onlyCellsMatter() const
{
    static const std::set<word> withoutPlace
    {
        "gravity", "sphereDrag", "nonSphereDrag"
    };
    for (const auto& force : cloud_.forces())
    {
        if
        (
            !withoutPlace.count(force.type())
         && !elutria::laws::findDragLaw(force.type())
        )
        {
            return false;
        }
    }
    return
        GasSampling::readsCells(cloud_)
     && cloud_.functions().size() == (recorder_ ? 1 : 0)
     && mesh().nSolutionD() == 3;
}


ParcelTracking::Outcome ParcelTracking::outcome
(
    const StepParcels& step,
    const size_t i
)
{
    const elutria::dem::Particles& all = step.particles;
    return
    {
        step.effectiveMass[i]/all.mass[i]*toFoam(all.dragImpulse[i]),
        all.dragRate[i],
        toFoam(all.position[i]),
        scalar(step.takenAt.size() ? step.takenAt[i] : -1)
    };
}


ParcelTracking::Flight ParcelTracking::flight
(
    const StepParcels& step,
    const size_t i,
    const scalar dt
) const
{
    const StockParcel& p = *step.parcels[i];
    const elutria::dem::Particles& all = step.particles;
    Flight f;
    f.from = step.starts[i];
    f.displacement = toFoam(box_.shortest(all.position[i] - toEngine(f.from)));
    f.start = p.U();
    f.end = toFoam(all.velocity[i]);
    f.spin = toFoam(all.spin[i]);
    f.age = p.age() - p.stepFraction()*dt;
    const bool told = cloud_.functions().size();
    f.known = told && p.stepFraction() > 0 ? p.position() : f.from;
    f.elsewhere = 0;
    f.outcome = outcome(step, i);

    if (planar_)
    {
        meshTools::constrainDirection
        (
            mesh(), mesh().solutionD(), f.displacement
        );
        meshTools::constrainDirection(mesh(), mesh().solutionD(), f.end);
    }

    // As if it had come all the step's way
    const scalar share = step.share[i];
    if (share > 0 && share < 1)
    {
        f.displacement /= share;
        f.start = f.end - (f.end - f.start)/share;
    }
    return f;
}


bool ParcelTracking::passCells
(
    StepParcels& step,
    const size_t i,
    const scalar dt
)
{
    StockParcel& p = *step.parcels[i];

    // The case's functions are read when the time loop begins
    if
    (
        !onlyCells_ || cloud_.time().functionObjects().size()
     || p.stepFraction() > 0 || !p.active()
    )
    {
        return false;
    }
    const Flight flight(this->flight(step, i, dt));
    const label celli = cells_.follow
    (
        p.cell(), flight.from, flight.from + flight.displacement
    );
    if (celli < 0)
    {
        return false;
    }
    p.cell() = celli;
    p.stepFraction() = 1;
    p.age() = flight.age + dt;
    finish(p, flight);
    return true;
}


void ParcelTracking::passAllCells
(
    StepParcels& step,
    const scalar dt,
    std::vector<char>& passed
)
{
    const size_t n = step.parcels.size();
    passed.resize(n);
    const unsigned threads = parcelThreads(contacts_, n);
    forParcelBlocks(threads, n, [&](const size_t from, const size_t to)
    {
        for (size_t i = from; i < to; ++i)
        {
            const size_t soon = min(i + ahead, to - 1);
            soonRead(*step.parcels[soon]);
            cells_.expect(step.cells[soon]);
            turnFluctuation(*step.parcels[i], thrown(step, i, dt));
            passed[i] = passCells(step, i, dt);
        }
    });
}


void ParcelTracking::finish(StockParcel& p, const Flight& flight)
{
    p.U() = flight.end;
    p.angularMomentum() = p.momentOfInertia()*flight.spin;
}


vector ParcelTracking::thrown
(
    const StepParcels& step,
    const size_t i,
    const scalar dt
)
{
    // What neither drag nor other forces did, contacts did
    const elutria::dem::Particles& all = step.particles;
    return
        toFoam(all.velocity[i]) - step.parcels[i]->U()
      - dt*toFoam(all.acceleration[i]) - toFoam(all.dragImpulse[i])/all.mass[i];
}


void ParcelTracking::turnFluctuation(StockParcel& p, const vector& thrown) const
{
    const scalar size = mag(thrown);
    if (!inertialDispersion_ || size < 1e-6*mag(p.U()) + VSMALL)
    {
        return;
    }
    const vector n(thrown/size);
    p.UTurb() -= 2*min(p.UTurb() & n, scalar(0))*n;
}


void ParcelTracking::deposit(const StockParcel& p, const Outcome& outcome)
{
    coupling_.deposit(p.cell(), p.nParticle()*outcome.impulse);
}


void ParcelTracking::leave
(
    StockParcel& p,
    const Outcome& outcome,
    const label patchi
)
{
    if (p.origProc() == Feed::feedOrigin && patchi >= 0)
    {
        ++goneThrough_[patchi];
    }
    deposit(p, outcome);
    solids_.arrive(p.cell(), p.position(), -p.nParticle()*p.volume());
    cloud_.deleteParticle(p);
}


void ParcelTracking::arrive
(
    StockParcel& p,
    const Outcome& outcome,
    const bool tracked,
    std::vector<Arrived>& arrived
)
{
    if (outcome.takenAt >= 0 && !sticks_[label(outcome.takenAt)])
    {
        leave(p, outcome, label(outcome.takenAt));
        return;
    }
    if (outcome.takenAt >= 0)
    {
        p.active(false);
    }
    deposit(p, outcome);
    arrived.push_back({&p, outcome.target, outcome.dragRate, tracked});
}


void ParcelTracking::slide
(
    StockParcel& p,
    Flight& flight,
    StockTracking& td,
    const scalar dt
)
{
    // The chord of a curved path cuts a corner. Go where the path ends, or
    // along the wall towards it.
    const scalar left = 1 - p.stepFraction();
    const point target(p.position() + left*flight.displacement);
    const label celli = mesh().findCell(target);
    if (celli >= 0)
    {
        // Off the cell's faces by rounding, so that it is found again
        const point inside(target + 1e-6*(mesh().C()[celli] - target));
        p.relocate(inside, celli);
        p.stepFraction() = 1;
        p.age() = flight.age + dt;
    }
    else
    {
        const vector n(p.normal());
        flight.displacement -= (flight.displacement & n)*n;
        p.hitFace(flight.displacement, cloud_, td);
    }
}


bool ParcelTracking::atEnginesWall(const StockParcel& p) const
{
    return
        contacts_ && p.onBoundaryFace()
     && isContactPatch(mesh().boundaryMesh()[p.patch()]);
}


void ParcelTracking::meetPatch
(
    StockParcel& p,
    Flight& flight,
    StockTracking& td,
    const scalar dt
)
{
    const scalar done = p.stepFraction();
    const vector arrival(flight.start + done*(flight.end - flight.start));

    if (atEnginesWall(p))
    {
        slide(p, flight, td, dt);
        return;
    }

    p.U() = arrival;
    p.hitFace(flight.displacement, cloud_, td);

    if (td.keepParticle && p.U() != arrival)
    {
        turnFluctuation(p, p.U() - arrival);

        // Turned by a rebound or a mirror: what the forces had still to add
        // in this step stays
        flight.end = p.U() + (flight.end - arrival);
        flight.displacement = 0.5*(p.U() + flight.end)*dt;
        flight.start = flight.end;
    }
}


void ParcelTracking::trackParcel
(
    StockParcel& p,
    Flight& flight,
    StockTracking& td,
    const scalar dt
)
{
    td.switchProcessor = false;
    td.keepParticle = true;
    if (!p.active())
    {
        // As in stock, a parcel that a wall holds grows older there
        p.age() += dt;
        callPostMove(cloud_.functions(), p, dt, p.position(), td);
        return;
    }

    // A parcel that slides along walls without end is left where it is
    label attempts = 0;

    const bool told = cloud_.functions().size();

    // Where the cloud's functions know it to be: slides are told with the next
    // move, and so is what rounding adds where a processor takes over, else a
    // plane there would not see it pass
    point& known = flight.known;
    if (flight.elsewhere > 0)
    {
        known = p.position();
        flight.elsewhere = 0;
    }

    while
    (
        td.keepParticle && !td.switchProcessor && p.stepFraction() < 1
     && p.active()
    )
    {
        const scalar before = p.stepFraction();
        const scalar f = 1 - before;

        p.trackToFace
        (
            f*flight.displacement - p.deviationFromMeshCentre(), f
        );
        const scalar spent = (p.stepFraction() - before)*dt;
        p.age() = flight.age + p.stepFraction()*dt;

        if (told)
        {
            callPostMove(cloud_.functions(), p, spent, known, td);
            known = p.position();
        }
        if (!p.onFace())
        {
            continue;
        }
        if (!atEnginesWall(p))
        {
            callPostFace(cloud_.functions(), p, td);
        }

        if (p.onBoundaryFace())
        {
            if (spent < SMALL*dt && ++attempts > 20)
            {
                p.stepFraction() = 1;
                p.age() = flight.age + dt;
            }
            else
            {
                meetPatch(p, flight, td, dt);
            }
        }
        else
        {
            p.hitFace(flight.displacement, cloud_, td);
        }
    }

    if (td.keepParticle && !td.switchProcessor && p.active())
    {
        if (told && p.position() != known)
        {
            callPostMove(cloud_.functions(), p, 0, known, td);
        }
        finish(p, flight);
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

ParcelTracking::ParcelTracking
(
    StockCloud& cloud,
    GasCoupling& coupling,
    SolidFraction& solids,
    const PlaneCells& cells,
    const CloudContacts* contacts,
    FeedEntry::Recorder* recorder,
    const bool inertialDispersion,
    const boolList& sticks
)
:
    cloud_(cloud),
    coupling_(coupling),
    solids_(solids),
    contacts_(contacts),
    planar_(cloud.mesh().nSolutionD() < 3),
    box_
    (
        contacts ? contacts->engine().settings().box
      : elutria::dem::PeriodicBox()
    ),
    recorder_(recorder),
    cells_(cells),
    onlyCells_(onlyCellsMatter()),
    inertialDispersion_(inertialDispersion),
    sticks_(sticks),
    goneThrough_(cloud.mesh().boundaryMesh().size(), Zero)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void ParcelTracking::catchUp(StepParcels& step)
{
    if (!onlyCells_)
    {
        return;
    }
    step.startSearch();
    for (StockParcel& p : cloud_)
    {
        StepParcels::End* end = step.next(p);
        if (end && !end->tracked)
        {
            p.relocate(end->position, p.cell());
            end->tracked = true;
        }
    }
}


labelList ParcelTracking::goneThrough() const
{
    // Patches between processors come last and differ
    labelList gone
    (
        SubList<label>(goneThrough_, mesh().boundaryMesh().nNonProcessor())
    );
    Pstream::listCombineGather(gone, plusEqOp<label>());
    return gone;
}


void ParcelTracking::move
(
    StockParcel& p,
    Flight flight,
    StockTracking& td,
    const scalar dt,
    Transfer& transfer,
    std::vector<Arrived>& arrived
)
{
    trackParcel(p, flight, td, dt);
    if (!td.keepParticle)
    {
        leave(p, flight.outcome, p.onBoundaryFace() ? p.patch() : -1);
    }
    else if (td.switchProcessor)
    {
        const polyPatch& patch = mesh().boundaryMesh()[p.patch()];
        flight.elsewhere = isA<processorCyclicPolyPatch>(patch) ? 1 : 0;
        transfer.add(cloud_.remove(&p), flight);
    }
    else
    {
        arrive(p, flight.outcome, true, arrived);
    }
}


void ParcelTracking::keep(std::vector<Arrived>& arrived, StepParcels& step)
{
    if (Pstream::parRun())
    {
        // Sums over the parcels of a cell are taken in the cloud's order: let
        // it be that of one processor, where none ever comes from elsewhere
        std::stable_sort
        (
            arrived.begin(), arrived.end(),
            [](const Arrived& a, const Arrived& b)
            {
                return parcelName(*a.parcel) < parcelName(*b.parcel);
            }
        );
        for (const Arrived& a : arrived)
        {
            cloud_.append(cloud_.remove(a.parcel));
        }
    }
    step.ends.clear();
    for (const Arrived& a : arrived)
    {
        step.ends.push_back({parcelName(*a.parcel), a.target, a.tracked});
        coupling_.keep(a.dragRate);
    }
}


void ParcelTracking::track
(
    StepParcels& step,
    StockTracking& td,
    const scalar dt
)
{
    addProfiling(tracking, "elutria::tracking");

    std::vector<char> passed;
    passAllCells(step, dt, passed);

    const size_t n = step.parcels.size();
    std::vector<Arrived> arrived;
    arrived.reserve(n);
    Transfer transfer(mesh());
    for (size_t i = 0; i < n; ++i)
    {
        const size_t soon = min(i + ahead, n - 1);
        soonRead(*step.parcels[soon]);
        coupling_.expect(step.cells[soon]);
        StockParcel& p = *step.parcels[i];
        if (!passed[i])
        {
            const Flight flight(this->flight(step, i, dt));
            if (!step.tracked[i])
            {
                p.relocate(flight.from, p.cell());
            }
            move(p, flight, td, dt, transfer, arrived);
            continue;
        }
        const Outcome end(outcome(step, i));
        if (recorder_)
        {
            recorder_->pass(p, step.starts[i], end.target, dt);
        }
        arrive(p, end, false, arrived);
    }

    // Those that arrive from other processors
    IDLList<StockParcel> moving;
    List<Flight> flights;
    while (transfer.exchange(moving, flights, td))
    {
        for (const Flight& flight : flights)
        {
            StockParcel* p = moving.removeHead();
            cloud_.append(p);
            move(*p, flight, td, dt, transfer, arrived);
        }
    }
    keep(arrived, step);
}


} // End namespace Foam
