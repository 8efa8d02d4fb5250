/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/Feed.H"
#include "feed/FeedRecord.H"
#include "feed/feedRate.H"
#include "feed/grainDensity.H"
#include "feed/grainForm.H"
#include "foam/digits.H"
#include "foam/foamVersion.H"
#include "foam/ownEntries.H"
#include "foam/requireAllowed.H"
#include "foam/standsIn.H"
#include "laws/FeedRules.hpp"
#include "volFields.H"
#include "wordRes.H"

#include <cmath>

namespace Foam
{

defineTypeNameAndDebug(Feed, 0);

namespace
{

//- Beyond these it is a mistake, in a unit or an exponent
constexpr scalar
    fastest = 1000,             // of what is fed [m/s]
    largestFlow = 1e6;          // [kg/s], or kg of solids per kg of gas

} // End anonymous namespace


// * * * * * * * * * * * * * * * * Material  * * * * * * * * * * * * * * * * //

Feed::Material::Material(const word& name, const dictionary& dict)
:
    name(name),
    density(readDensity(dict)),
    measured(readMeasuredDrag(dict, density)),
    form(readForm(dict)),
    massFraction
    (
        dict.found("massFraction") ? readAllowed(dict, "massFraction", atLeast(0, 1 + 1e-6)) : 1
    ),
    focus(0),
    sizes(dict.subDict("sizeDistribution")),
    scatter(readDensityScatter(dict))
{
    requireOwnEntries(dict, ownDictionary::material);
    form.measured = measured.get();
    if (measured)
    {
        warnOfSizes(name, *measured, sizes);
    }
}


elutria::laws::Ingredient Feed::Material::ingredient() const
{
    return
    {
        massFraction, scatter ? scatter->meanByNumber() : density, &sizes,
        scatter.get()
    };
}


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void Feed::readMaterials()
{
    const dictionary& dict = subDict("materials");
    scalar massSum = 0;

    materials_.resize(dict.size());
    label n = 0;
    for (const entry& e : dict)
    {
        if (!e.isDict())
        {
            FatalIOErrorInFunction(dict)
                << e.keyword() << " is not a dictionary of a material"
                << exit(FatalIOError);
        }
        // The tables have rows of these names
        if (e.keyword() == "all" || e.keyword().find(',') != string::npos)
        {
            FatalIOErrorInFunction(dict)
                << "a material is named " << e.keyword()
                << ", allowed: another word, without commas"
                << exit(FatalIOError);
        }
        materials_.set(n, new Material(e.keyword(), e.dict()));
        massSum += materials_[n].massFraction;
        ++n;
    }

    if (n == 0 || mag(massSum - 1) > 1e-6)
    {
        FatalIOErrorInFunction(dict)
            << "massFraction of all materials adds up to " << massSum
            << ", allowed: 1" << exit(FatalIOError);
    }
    for (Material& m : materials_)
    {
        m.massFraction /= massSum;
    }
}


scalar Feed::boundaryGasFlow(const word& phaseName) const
{
    const auto& U = mesh_.lookupObject<volVectorField>
    (
        IOobject::groupName("U", phaseName)
    );
    const auto& rho = mesh_.lookupObject<volScalarField>
    (
        IOobject::groupName("rho", phaseName)
    );

    scalar flow = 0;
    forAll(mesh_.boundary(), patchi)
    {
        const fvPatch& patch = mesh_.boundary()[patchi];
        if (patch.coupled())
        {
            continue;
        }
        const scalarField inward
        (
           -(U.boundaryField()[patchi] & patch.Sf())
           *rho.boundaryField()[patchi]
        );
        flow += sum(max(inward, scalar(0)));
    }
    return ofAnyOrder(returnReduce(flow, sumOp<scalar>()));
}


IOobject Feed::gasFlowHeader(const IOobject::readOption read) const
{
    return IOobject
    (
        "feedGas", mesh_.time().timeName(), "uniform", mesh_, read,
        IOobject::NO_WRITE, false
    );
}


void Feed::readGasFlow(const word& phaseName)
{
    const IOdictionary state(gasFlowHeader(IOobject::READ_IF_PRESENT));
    gasFlowTold_ = state.found("massFlow");
    gasFlow_ =
        gasFlowTold_
      ? state.get<scalar>("massFlow") : boundaryGasFlow(phaseName);
}


void Feed::readAmounts(const word& phaseName)
{
    materials_.clear();
    readMaterials();
    readSchedule();
    readFocus(phaseName);
    if (massFlow_ > 0)
    {
        drawParcels();
    }
}


bool Feed::isRated() const
{
    // Either may also be the name of a variable in a file that is included
    const bool both = found("loading") && found("massFlowRate");
    const bool rated = both ? standsIn(*this, "massFlowRate") : found("massFlowRate");
    if
    (
        !told_.found("massFlow")
     && rated == (both ? standsIn(*this, "loading") : found("loading"))
    )
    {
        FatalIOErrorInFunction(*this)
            << "give either loading (kg solids per kg gas) or"
            << " massFlowRate (kg/s)" << exit(FatalIOError);
    }
    return rated;
}


scalar Feed::meanFlowOfTable() const
{
    const scalar end = start_ + duration_;
    const scalar rounding = 1e-9*max(mag(end), scalar(1e-3));
    const scalar fed = duration_ > 0 ? table_->mass(start_, end) : 0;
    if
    (
        start_ < table_->begin() - rounding || end > table_->end() + rounding
     || !(fed > 0)
    )
    {
        FatalIOErrorInFunction(*this)
            << "massFlowRate is a table from " << table_->begin() << " to "
            << table_->end() << " s that feeds " << fed << " kg from " << start_
            << " to " << end << " s, allowed: one of all that time, with a mass"
            << exit(FatalIOError);
    }
    return fed/duration_;
}


void Feed::readSchedule()
{
    const bool rated = isRated();
    table_ = rated ? readRateTable(*this) : nullptr;
    start_ =
        found("start")
      ? readAllowed(*this, "start", atLeast(0, longestFeed)) : 0;
    if (!found("duration") && !found("particles") && !table_)
    {
        FatalIOErrorInFunction(*this)
            << "give duration (s), particles (a whole number) or both"
            << exit(FatalIOError);
    }
    duration_ = feedDuration(*this, table_.get());
    const bool lasts = duration_ < GREAT;

    massFlow_ =
        table_
      ? meanFlowOfTable()
      : told_.found("massFlow")
      ? told_.get<scalar>("massFlow")
      : rated
      ? readAllowed(*this, "massFlowRate", above(0, largestFlow))
      : readAllowed(*this, "loading", above(0, largestFlow))*gasFlow_;

    drainTime_ =
        found("drainTime") ? readAllowed(*this, "drainTime", atLeast(0)) : GREAT;
    maxParticles_ = getOrDefault<label>("particles", labelMax);
    requireAllowed("particles", maxParticles_, atLeast(1), *this);
    asked_ = maxParticles_;

    sampling_ = readSampling();
    rate_ = max(massFlow_/meanMass(), SMALL);
    if (weighted() && lasts && found("particles"))
    {
        addParcels();
        rate_ = maxParticles_/duration_;
    }
    slots_ = min(scalar(maxParticles_), duration_*rate_);
    parcels_ = label(max(scalar(1), std::round(min(slots_, scalar(labelMax)))));

    requireAllowed("seed", seedEntry(), atLeast(0), *this);
    seed_ = elutria::laws::scrambled(uint64_t(seedEntry()) + 0x9e3779b97f4a7c15ULL);
}


void Feed::addParcels()
{
    if (told_.found("parcels"))
    {
        maxParticles_ = told_.get<label>("parcels");
        return;
    }
    if (!found("particlesPerParcel"))
    {
        return;
    }
    const scalar most = readAllowed(*this, "particlesPerParcel", above(0));
    if (!isDilute())
    {
        const scalar fed =
            elutria::laws::parcelsFed(asked_, rate_*duration_, most);
        maxParticles_ = label(min(fed, scalar(labelMax)));
    }
}


bool Feed::isDilute() const
{
    return peakFlow() < elutria::laws::largestDiluteLoading*gasFlow_;
}


elutria::laws::Sampling Feed::readSampling() const
{
    const word parcels(getOrDefault<word>("parcels", "particles"));
    if (parcels == "evenMass")
    {
        return Sampling::evenMass;
    }
    if (parcels == "evenSizes")
    {
        return Sampling::evenSizes;
    }
    requireAllowed
    (
        "parcels", parcels, wordList({"particles", "evenMass", "evenSizes"}),
        *this
    );
    return Sampling::particles;
}


word Feed::place() const
{
    return found("patch") ? get<word>("patch") : get<word>("zone");
}


label Feed::seedEntry() const
{
    return getOrDefault<label>("seed", 1);
}


scalar Feed::massFactor(const scalar time) const
{
    if (steering_.empty())
    {
        return 1;
    }
    const Steering::Change now = steering_.at(time);
    return now.loading*(found("loading") ? now.gas : 1);
}


scalar Feed::entryTime(const label k) const
{
    return timeOf(slot(k));
}


scalar Feed::slotsUntil(const scalar time) const
{
    return
        table_
      ? table_->mass(start_, time)*rate_/massFlow_
      : (time - start_)*rate_;
}


scalar Feed::timeOf(const scalar slots) const
{
    return
        table_
      ? table_->timeOf(slots*massFlow_/rate_, start_)
      : start_ + slots/rate_;
}


scalar Feed::random(const label i, const label k) const
{
    return elutria::laws::uniform
    (
        seed_, (uint64_t(uint32_t(first_ + i)) << 8) + uint64_t(k) + 1
    );
}


point Feed::place
(
    const label i,
    const scalar diameter,
    const bool retreat
) const
{
    return entrance_.place
    (
        {random(i, 3), random(i, 4), random(i, 5), random(i, 6)},
        0.5*diameter,
        retreat
    );
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Feed::Feed(const fvMesh& mesh, const word& phaseName)
:
    IOdictionary
    (
        IOobject
        (
            "feed",
            mesh.time().constant(),
            mesh,
            IOobject::MUST_READ,
            IOobject::NO_WRITE
        )
    ),
    mesh_(mesh),
    products_(*this, mesh.boundaryMesh()),
    entrance_(mesh, *this),
    steering_(mesh.time())
{
    requireOwnEntries(*this, ownDictionary::feed);
    if (isRated())
    {
        stateRate(*this);
    }
    goOn(phaseName);
    readAll(phaseName);
    requireDrainAhead();
}


Feed::Feed(const fvMesh& mesh, const word& phaseName, const dictionary& told)
:
    IOdictionary
    (
        IOobject
        (
            "feed",
            mesh.time().constant(),
            mesh,
            IOobject::NO_READ,
            IOobject::NO_WRITE,
            false
        ),
        told.subDict("settings")
    ),
    mesh_(mesh),
    products_(*this, mesh.boundaryMesh()),
    entrance_(mesh, *this),
    steering_(mesh.time())
{
    takeOver(phaseName, told);
    readAll(phaseName);
}


void Feed::readAll(const word& phaseName)
{
    velocity_ = getOrDefault<vector>("velocity", Zero);
    requireAllowed("velocity", mag(velocity_), below(fastest), *this);
    readGasFlow(phaseName);
    readAmounts(phaseName);
}


const Feed* Feed::find(const fvMesh& mesh, const word& phaseName)
{
    if (const Feed* known = mesh.findObject<Feed>("feed"))
    {
        return known;
    }

    IOobject header("feed", mesh.time().constant(), mesh, IOobject::MUST_READ);
    if (!header.typeHeaderOk<IOdictionary>(false))
    {
        if (!feedRecord::read(mesh).empty())
        {
            FatalErrorInFunction
                << "constant/feed: file not found, but the run came to time "
                << mesh.time().timeName() << " with it; allowed: that file, or"
                << " a run from the start" << exit(FatalError);
        }
        return nullptr;
    }

    Feed* feed = new Feed(mesh, phaseName);
    feed->store();
    return feed;
}


const Feed& Feed::require
(
    const fvMesh& mesh,
    const word& phaseName,
    const char* const model
)
{
    const Feed* feed = find(mesh, phaseName);
    if (!feed)
    {
        FatalErrorInFunction
            << (mesh.time().constant()/"feed").c_str()
            << ": file not found; " << model
            << " of the cloud's properties needs it" << exit(FatalError);
    }
    return *feed;
}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void Feed::tellGasFlow(const scalar massFlow, const word& phaseName)
{
    // In few enough digits that the file gives it back
    gasFlow_ =
        inDigits(massFlow, min(10, int(IOstream::defaultPrecision())));
    gasFlowTold_ = true;
    readAmounts(phaseName);
}


void Feed::requireRate() const
{
    if (!(massFlow_ > 0))
    {
        FatalIOErrorInFunction(*this)
            << "loading gives a feed of " << massFlow_ << " kg/s: no gas flows"
            << " in; allowed: an inflow, or massFlowRate"
            << exit(FatalIOError);
    }
}


void Feed::writeState() const
{
    if (gasFlowTold_)
    {
        IOdictionary state(gasFlowHeader(IOobject::NO_READ));
        state.add("massFlow", gasFlow_);
        state.regIOobject::write();
    }
}


scalar Feed::end() const
{
    return timeOf(slots_);
}


label Feed::fedUntil(const scalar time) const
{
    if (before_ && time <= start_)
    {
        return before_->fedUntil(time);
    }

    const scalar slots = slotsUntil(min(time, start_ + duration_));
    if (slots <= 0)
    {
        return first_;
    }

    const label i = label(min(slots, scalar(labelMax - 1)));
    const bool entered = slot(i) < slots;

    return first_ + min(i + label(entered), parcels_);
}


Feed::Particle Feed::particle(const label i) const
{
    const Feed& own = stretchOf(i);
    return own.ownParticle(i - own.first_);
}


Feed::Particle Feed::ownParticle(const label k) const
{
    const elutria::laws::FedParcel parcel = drawn(k);
    Particle p;
    p.time = entryTime(k);
    p.material = parcel.material;
    p.diameter = parcel.diameter;
    p.density = parcel.density;
    p.number = ownNumber(k);

    p.position = place(k, p.diameter, false);
    return p;
}


point Feed::retreat(const label i) const
{
    const Feed& own = stretchOf(i);
    const label k = i - own.first_;
    return own.place(k, own.drawn(k).diameter, true);
}


} // End namespace Foam
