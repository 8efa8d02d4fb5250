#include "islands/AdaptiveIntegrator.hpp"

#include "core/Stopwatch.hpp"
#include "impacts/StochasticCollisions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

// The course of a step: who steps what for how long.

namespace elutria::dem
{

namespace
{

constexpr std::size_t crowd = 256;           // island of impacts above which a step is cut
constexpr std::size_t softCrowd = 32;        // island with lasting contacts, of weighted spheres
constexpr int mostCuts = 12;                 // halvings of a step
constexpr double fewSubSteps = 24;           // these cost no more than looking around first
constexpr int separationRounds = 5;

/// Contacts counted once for each particle they hold.
std::size_t contactEnds(const std::vector<ContactRecord>& records)
{
    std::size_t ends = 0;
    for (const ContactRecord& record : records) ends += record.wall ? 1 : 2;
    return ends;
}

} // namespace


AdaptiveIntegrator::AdaptiveIntegrator(const Settings& settings, const ContactMaterials& materials, const Walls& walls,
               SoftIntegrator& soft, IslandStepper::StepLimit stepLimit)
  : settings_(settings), walls_(walls), soft_(soft), stepLimit_(stepLimit),
    laws_(settings.law, materials)
{
    for (unsigned t = 0; t < settings.threads; ++t)
        steppers_.push_back(
            std::make_unique<IslandStepper>(settings, materials, walls, laws_, stepLimit));
}


std::vector<ContactRecord> AdaptiveIntegrator::exportContacts() const
{
    std::vector<ContactRecord> records = softRules_ ? soft_.exportContacts() : records_;
    std::sort(records.begin(), records.end(), recordBefore);
    return records;
}


void AdaptiveIntegrator::importContacts(const std::vector<ContactRecord>& records)
{
    records_ = records;
    std::sort(records_.begin(), records_.end(), recordBefore);
    softRules_ = false;
    contactEnds_ = contactEnds(records_);
}


void AdaptiveIntegrator::useSoft()
{
    if (softRules_) return;
    soft_.importContacts(records_);
    softRules_ = true;
}


void AdaptiveIntegrator::advance(Particles& particles, double duration, StepReport& report)
{
    if (particles.size() == 0) return;
    const bool forced = settings_.treatment == ContactTreatment::impact;
    const double softStep = stepLimit_(particles);
    // from the state alone, so that a restart decides alike
    if (!forced && (duration <= fewSubSteps*softStep || 2*contactEnds_ > particles.size()))
        return runSoft(particles, duration, report);
    if (softRules_) importContacts(soft_.exportContacts());

    load(particles);
    widen(particles);
    const double whole = std::ldexp(1.0, mostCuts);      // a piece is a power of two of these
    double done = 0, length = whole;
    while (done < whole)
    {
        length = std::min(length, whole - done);
        seed_ = scrambled(scrambled(particles.moment) + std::uint64_t(done));
        const bool mayCut = length > 1 && duration*length/whole > fewSubSteps*softStep;
        switch (piece(duration*length/whole, mayCut, report))
        {
            case Outcome::tooLong:
                length /= 2;
                break;
            case Outcome::contactsRule:
                store(particles);
                return runSoft(particles, duration*(1 - done/whole), report);
            case Outcome::done:
                done += length;
                ++report.pieces;
                break;
        }
    }
    store(particles);
}


void AdaptiveIntegrator::load(const Particles& p)
{
    const std::size_t n = p.size();
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), 0u);
    if (!std::is_sorted(p.id.begin(), p.id.end()))
        std::sort(order_.begin(), order_.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return p.id[a] < p.id[b]; });
    start_.resize(n);
    forParticles([&](std::size_t i)
    {
        const std::uint32_t k = order_[i];
        ParticleState& t = start_[i];
        t.id = p.id[k], t.material = p.material[k], t.mass = p.mass[k];
        t.radius = t.reach = p.radius[k];
        t.number = p.number.empty() ? 1 : p.number[k];
        t.spin = p.spin[k];
        t.force = p.acceleration.empty() ? Vector3{} : p.acceleration[k];
        t.gasVelocity = p.gasVelocity.empty() ? Vector3{} : p.gasVelocity[k];
        t.flight = Flight(p.position[k], p.velocity[k], t.force, t.gasVelocity,
                          p.dragRate.empty() ? 0 : p.dragRate[k]);
        t.dragGain = {};
    });
    for (std::size_t i = 1; i < n; ++i)
        if (start_[i - 1].id == start_[i].id)
            throw std::invalid_argument("particle id " + std::to_string(start_[i].id)
                                        + " is given twice; allowed: once");
}


/// Where some stand for several particles, or for a share: how far and how often all meet.
void AdaptiveIntegrator::widen(const Particles& p)
{
    weighted_ = std::any_of(start_.begin(), start_.end(),
                            [](const ParticleState& t) { return t.number != 1; });
    if (!weighted_) return;
    double room = never;                  // in the periodic box, so that images stay apart
    for (int axis = 0; axis < 3; ++axis)
        if (settings_.box.periodic[axis])
            room = std::min(room, (settings_.box.high[axis] - settings_.box.low[axis])/16);
    for (std::size_t i = 0; i < start_.size(); ++i)
    {
        ParticleState& t = start_[i];
        t.reach = std::max(t.radius, std::min(collisionReach(t.radius, t.number), room));
        if (!p.solidFraction.empty()) t.enskogFactor = contactCorrelation(p.solidFraction[order_[i]]);
    }
}


void AdaptiveIntegrator::store(Particles& p) const
{
    const bool drag = !p.dragRate.empty();
    if (drag) p.dragImpulse.resize(p.size());
    forParticles([&](std::size_t i)
    {
        const std::uint32_t k = order_[i];
        const ParticleState& t = start_[i];
        p.position.set(k, settings_.box.wrapped(t.flight.position));
        p.velocity.set(k, t.flight.velocity);
        p.spin.set(k, t.spin);
        if (drag) p.dragImpulse.set(k, t.mass*t.dragGain);
    });
}


/// The soft law for all.
void AdaptiveIntegrator::runSoft(Particles& particles, double duration, StepReport& report)
{
    const Stopwatch watch(report.softSeconds);
    const bool continued = !softRules_ && !particles.dragRate.empty();
    const VectorArray before = continued ? particles.dragImpulse : VectorArray{};
    useSoft();
    const double steps =
        std::max(1.0, std::ceil(duration/stepLimit_(particles)*(1 - 1e-12)));
    soft_.run(particles, duration, std::size_t(steps), report);
    for (std::size_t i = 0; i < before.size(); ++i)
        particles.dragImpulse.set(i, particles.dragImpulse[i] + before[i]);

    contactEnds_ = 2*report.touching + report.wallTouching;
}


/// Moves all by `duration`, or says why not and leaves them where they were.
AdaptiveIntegrator::Outcome AdaptiveIntegrator::piece(double duration, bool mayCut, StepReport& report)
{
    const bool forced = settings_.treatment == ContactTreatment::impact;
    {
        const Stopwatch watch(report.searchSeconds);
        for (int round = 0;; ++round)
        {
            if (!bounds(duration))
                return mayCut ? Outcome::tooLong : Outcome::contactsRule;
            findCandidates(duration, report);
            if (overlaps_.empty() || round == separationRounds) break;
            separateOverlaps(report);
        }
        for (const Candidate& overlap : overlaps_)       // crowded: no room to move apart
        {
            touching_.push_back(overlap.first);
            if (overlap.second != none) touching_.push_back(overlap.second);
        }
        std::sort(touching_.begin(), touching_.end());
        touching_.erase(std::unique(touching_.begin(), touching_.end()), touching_.end());
        makeIslands();
        std::size_t largest = 0;
        for (const Island& island : islands_)
            if (!island.touching) largest = std::max(largest, island.particles.size());
        if (largest > crowd && mayCut) return Outcome::tooLong;
        if (largest > 16*crowd && !forced) return Outcome::contactsRule;
    }
    do
    {
        runIslands(duration);
        if (mayCut && crowds()) return Outcome::tooLong;
    }
    while (mergeIslands(duration, report));
    finishPiece(duration, report);
    return Outcome::done;
}


/// Whether meetings of spheres of many particles make islands that shorter pieces would not.
bool AdaptiveIntegrator::crowds() const
{
    return weighted_ && std::any_of(islands_.begin(), islands_.end(), [](const Island& island)
    {
        return island.particles.size() > (island.soft() ? softCrowd : crowd);
    });
}


void AdaptiveIntegrator::finishPiece(double duration, StepReport& report)
{
    forParticles([&](std::size_t i)
    {
        ParticleState& t = start_[i];
        if (islandOf_[i] != none)
        {
            t = islands_[islandOf_[i]].end[placeIn_[i]];
            return;
        }
        if (t.flight.rate > 0) t.dragGain += t.flight.dragGain(duration, t.force);
        t.flight = ends_[i];
    });
    std::size_t free = start_.size();
    records_.clear();
    report.touching = report.wallTouching = report.softParticles = 0;
    for (const Island& island : islands_)
    {
        free -= island.particles.size();
        records_.insert(records_.end(), island.contacts.begin(), island.contacts.end());
        report.islands += !island.particles.empty();
        report.impacts += island.impacts;
        report.impactSeconds += island.impactSeconds;
        report.softSeconds += island.softSeconds;
        report.largestOverlap = std::max(report.largestOverlap, island.largestOverlap);
        if (!island.soft()) continue;
        ++report.softIslands;
        report.softParticles += island.particles.size();
        report.subSteps += island.subSteps;
        report.step = report.step > 0 ? std::min(report.step, island.shortestStep)
                                      : island.shortestStep;
    }
    for (const ContactRecord& record : records_)
        ++(record.wall ? report.wallTouching : report.touching);
    report.freeParticles = free;
    contactEnds_ = 2*report.touching + report.wallTouching;
    std::sort(records_.begin(), records_.end(), recordBefore);
}

} // namespace elutria::dem
