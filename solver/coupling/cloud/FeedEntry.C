/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "cloud/FeedEntry.H"
#include "cloud/injectorState.H"
#include "foam/foamVersion.H"
#include "profiling.H"

namespace Foam
{

// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void FeedEntry::findInjection()
{
    label found = 0;
    for (auto& injector : cloud_.injectors())
    {
        if (auto* injection = dynamic_cast<Injection*>(&injector))
        {
            ++found;
            injection_ = injection;
            injection_->handOver();
        }
    }
    if (feed_ && found != 1)
    {
        FatalIOErrorInFunction(cloud_.particleProperties())
            << "subModels.injectionModels: " << found << " models are of type"
            << " feed, allowed: one, feed { type feed; }, or no constant/feed"
            << exit(FatalIOError);
    }
}


void FeedEntry::findRecorder()
{
    for (auto& object : cloud_.functions())
    {
        if (auto* recorder = dynamic_cast<Recorder*>(&object))
        {
            recorder_ = recorder;
        }
    }
    if (!recorder_)
    {
        dictionary settings;
        settings.add("type", Recorder::typeName);
        recorder_ = new Recorder(settings, cloud_, "outlets");
        cloud_.functions().append(recorder_);
    }
    recorder_->solverWrites();
}


void FeedEntry::countArrival(const StockParcel& p)
{
    solids_.arrive(p.cell(), p.position(), p.nParticle()*p.volume());
}


void FeedEntry::takeInjected()
{
    if (cloud_.size() == injectedFrom_)
    {
        return;
    }
    label k = 0;
    for (StockParcel& p : cloud_)
    {
        if (k++ < injectedFrom_)
        {
            continue;
        }
        countArrival(p);

        // Times of injection are differences of the run's times
        constexpr scalar rounding = 1e-6;
        if (p.stepFraction() < rounding)
        {
            p.stepFraction() = 0;
        }
        p.stepFraction() = min(p.stepFraction(), 1 - rounding);
    }
}


label FeedEntry::findCell(const point& place) const
{
    // OpenFOAM's search makes a tree of all cells first
    const label celli =
        mesh().nCells() ? cells_.follow(0, mesh().C()[0], place) : -1;
    return celli < 0 ? mesh().findCell(place) : celli;
}


labelList FeedEntry::findOwners
(
    const UList<point>& positions,
    labelList& cells
) const
{
    const label nowhere = Pstream::nProcs();
    labelList owners(positions.size(), nowhere);
    cells.resize(positions.size());
    forAll(positions, k)
    {
        cells[k] = findCell(positions[k]);
        if (cells[k] >= 0)
        {
            owners[k] = Pstream::myProcNo();
        }
    }

    // One processor takes a particle: the first that has the place
    Pstream::listCombineGather(owners, minEqOp<label>());
    elutriaBroadcast(owners);
    for (label& owner : owners)
    {
        owner = owner == nowhere ? -1 : owner;
    }
    return owners;
}


labelList FeedEntry::findPlaces
(
    const labelRange& particles,
    List<point>& positions,
    labelList& cells
) const
{
    positions.resize(particles.size());
    forAll(positions, k)
    {
        positions[k] = injection_->position(particles[k]);
    }
    labelList owners(findOwners(positions, cells));
    if (min(owners) >= 0)
    {
        return owners;
    }

    forAll(positions, k)
    {
        if (owners[k] < 0)
        {
            positions[k] = feed_->retreat(particles[k]);
        }
    }
    owners = findOwners(positions, cells);
    const label lost = owners.find(-1);
    if (lost >= 0)
    {
        FatalErrorInFunction
            << "particle " << particles[lost] << " of the feed would enter at "
            << positions[lost] << ", outside the mesh: move the feed's patch or"
            << " zone away from the domain's edge" << exit(FatalError);
    }
    return owners;
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

FeedEntry::FeedEntry
(
    StockCloud& cloud,
    SolidFraction& solids,
    const PlaneCells& cells,
    const Feed* feed
)
:
    cloud_(cloud),
    solids_(solids),
    cells_(cells),
    feed_(feed),
    injection_(nullptr),
    recorder_(nullptr),
    injectedFrom_(0)
{
    findInjection();
    if (feed_)
    {
        findRecorder();
    }
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void FeedEntry::startStep()
{
    injectedFrom_ = cloud_.size();
    for (StockParcel& p : cloud_)
    {
        p.stepFraction() = 0;
    }
}


void FeedEntry::enter(StepParcels& step)
{
    addProfiling(feed, "elutria::feed");
    takeInjected();
    if (!injection_)
    {
        return;
    }

    const labelRange entering(injection_->take(cloud_.time().value()));
    injection_->count(entering);
    if (entering.empty())
    {
        return;
    }
    const scalar dt = cloud_.solution().trackTime();
    List<point> positions;
    labelList cells;
    const labelList owners(findPlaces(entering, positions, cells));
    forAll(owners, k)
    {
        if (owners[k] != Pstream::myProcNo())
        {
            continue;
        }

        auto* parcel = new StockParcel(mesh(), positions[k], cells[k]);
        cloud_.setParcelThermoProperties(*parcel, dt);
        injection_->setParcel(entering[k], *parcel);
        cloud_.checkParcelProperties(*parcel, dt, true);
        cloud_.addParticle(parcel);
        step.ends.push_back({parcelName(*parcel), positions[k], true});
        countArrival(*parcel);
    }
}


wordList FeedEntry::uncounted() const
{
    DynamicList<word> names;
    for (const auto& injector : cloud_.injectors())
    {
        if (feed_ && !isA<Injection>(injector))
        {
            names.append(injector.modelName());
        }
    }
    return wordList(std::move(names));
}


void FeedEntry::takeBack()
{
    for (StockParcel& p : cloud_)
    {
        if
        (
            p.origProc() == Feed::feedOrigin
         && p.origId() >= feed_->fedUntil(cloud_.time().value())
        )
        {
            cloud_.deleteParticle(p);
        }
    }
}


FeedEntry::Count FeedEntry::count() const
{
    Count count;
    for (const StockParcel& p : cloud_)
    {
        const bool counts = p.origProc() == Feed::feedOrigin || !feed_;
        count.inside += counts;
        count.stuck += counts && !p.active();
    }
    reduce(count.inside, sumOp<label>());
    reduce(count.stuck, sumOp<label>());

    if (feed_)
    {
        count.fed = feed_->fedUntil(cloud_.time().value());
        count.left = recorder_->leftParcels();
        count.lost = count.fed - count.inside - sum(count.left);
    }
    return count;
}


bool FeedEntry::drained(const Count& count) const
{
    const scalar time = cloud_.time().value();
    return
        feed_
     && time > feed_->end()
     && (count.inside == count.stuck || time > feed_->drained());
}


void FeedEntry::writeState()
{
    writeInjectorState(cloud_);
    if (recorder_)
    {
        recorder_->writeFiles();
        feed_->writeState();
    }
}


} // End namespace Foam
