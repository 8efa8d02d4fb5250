#include "islands/AdaptiveIntegrator.hpp"

#include "core/Stopwatch.hpp"
#include "core/TooMuchWork.hpp"
#include "core/text.hpp"
#include "core/forEach.hpp"
#include "impacts/StochasticCollisions.hpp"
#include "parallel/Agreement.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elutria::dem
{

namespace
{

constexpr std::size_t crowd = 256;           // particles of an island above which a step is cut
constexpr std::size_t softCrowd = 32;        // the same with lasting contacts and weighted spheres
constexpr int mostCuts = 12;                 // halvings of a step
constexpr double fewSubSteps = 24;           // a shorter step takes the soft law for all
constexpr int separationRounds = 5;
constexpr double mostOverSoft = 4;           // work of a step over that of the soft law for all
constexpr double workOfSearch = 4;           // of a particle, in sub-steps

} // namespace


AdaptiveIntegrator::AdaptiveIntegrator(const Settings& settings, const ContactMaterials& materials,
                                       const LawTables& laws, const Walls& walls,
                                       SoftIntegrator& soft, IslandStepper::StepLimit stepLimit,
                                       Exchange& exchange)
  : settings_(settings), walls_(walls), soft_(soft), stepLimit_(stepLimit), exchange_(exchange),
    impacts_(laws, materials), states_(settings), boundPairs_(settings),
    search_(settings, walls, boundPairs_),
    steppers_(settings, laws, walls, impacts_, stepLimit), pathCheck_(settings, boundPairs_),
    ghosts_(settings, exchange), shared_(exchange, steppers_)
{}


std::vector<ContactRecord> AdaptiveIntegrator::exportContacts() const
{
    return softRules_ ? SortedContacts(soft_.exportContacts()).records() : contacts_.records();
}


void AdaptiveIntegrator::importContacts(const std::vector<ContactRecord>& records)
{
    contacts_ = SortedContacts(records);
    softRules_ = false;
    contactEnds_ = contacts_.ends();
}


void AdaptiveIntegrator::useSoft()
{
    if (!softRules_) soft_.importContacts(contacts_.records());
    softRules_ = true;
}


void AdaptiveIntegrator::advance(Particles& particles, double duration, StepReport& report)
{
    all_ = takeCensus(exchange_, particles, contactEnds_);
    if (all_.particles == 0) return;
    const bool forced = settings_.treatment == ContactTreatment::impact;
    const double softStep = stepLimit_(all_.decisive(particles), 0);
    // from the state alone, so that a restart decides alike
    if (!forced && (duration <= fewSubSteps*softStep || 2*all_.contactEnds > all_.particles))
        return runSoft(particles, duration, false, report);
    if (softRules_) importContacts(soft_.exportContacts());

    load(particles, all_.weighted);
    workLeft_ = std::min(mostOverSoft*duration/softStep*(double(all_.particles) + 20),
                         TooMuchWork::most);
    const double whole = std::ldexp(1.0, mostCuts);      // a piece is a power of two of these
    double done = 0, length = whole;
    while (done < whole)
    {
        length = std::min(length, whole - done);
        const std::uint64_t seed = scrambled(scrambled(particles.stepIndex) + std::uint64_t(done));
        const bool mayCut = length > 1 && duration*length/whole > fewSubSteps*softStep;
        pieceBegin_ = duration*done/whole;
        switch (advancePiece(duration*length/whole, seed, mayCut, report))
        {
            case Outcome::tooLong:
                length /= 2;
                break;
            case Outcome::contactsRule:
                states_.store(particles);
                if (workLeft_ < 0)
                    report.warnings.push_back({"stepWork",
                        "impacts and contacts of a step were too much work: contact steps took the "
                        "rest of it, in which parcels that stand for several particles do not "
                        "collide",
                        "more than " + text(mostOverSoft) + " times the work of contact steps for all",
                        "lower deltaT, or feed fewer particles", 1 - done/whole});
                return runRestSoft(particles, duration, done/whole, report);
            case Outcome::done:
                done += length;
                ++report.pieces;
                break;
        }
    }
    states_.store(particles);
}


/// The soft law for all for what is left of a step of which a share is done. What walls have taken
/// before takes part: it is put back, and its hits are forgotten.
void AdaptiveIntegrator::runRestSoft(Particles& particles, double duration, double done,
                                     StepReport& report)
{
    std::vector<WallHit> hits = std::move(report.hits);
    report.hits.clear();
    runSoft(particles, duration*(1 - done), true, report);
    states_.storeTaken(particles);
    const auto isTaken = [&](std::uint64_t id)
    {
        return std::any_of(hits.begin(), hits.end(), [&](const WallHit& hit)
        { return hit.id == id && hit.answer == WallAnswer::takes; });
    };
    std::vector<WallHit> later;
    for (WallHit hit : report.hits)
    {
        hit.time += duration*done;
        if (!isTaken(hit.id)) later.push_back(hit);
    }
    hits.insert(hits.end(), later.begin(), later.end());
    report.hits = std::move(hits);
}


/// The soft law for all; `continued`: for the rest of a step.
void AdaptiveIntegrator::runSoft(Particles& particles, double duration, bool continued,
                                 StepReport& report)
{
    const Stopwatch watch(report.softSeconds);
    useSoft();
    if (continued) all_ = takeCensus(exchange_, particles, contactEnds_);
    continued = continued && !particles.dragRate.empty();
    const VectorArray before = continued ? particles.dragImpulse : VectorArray{};
    const double steps = stepsOf(duration, stepLimit_(all_.decisive(particles), 0));
    refuseTooMuchWork(duration, steps, all_.particles);
    soft_.run(particles, duration, std::size_t(steps), report);
    for (std::size_t i = 0; i < before.size(); ++i)
        particles.dragImpulse.set(i, particles.dragImpulse[i] + before[i]);

    contactEnds_ = 2*report.touching + report.wallTouching;
}


/// Moves all by `duration`, or says why not and leaves them where they were.
AdaptiveIntegrator::Outcome AdaptiveIntegrator::advancePiece(double duration, std::uint64_t seed,
                                                             bool mayCut, StepReport& report)
{
    const Piece piece{states_.all(), contacts_, duration, seed, workLeft_};
    const bool forced = settings_.treatment == ContactTreatment::impact;
    {
        const Stopwatch watch(report.searchSeconds);
        if (!findCandidates(piece, report))
            return mayCut ? Outcome::tooLong : Outcome::contactsRule;
        const std::size_t largest = formIslands();
        if (largest > crowd && mayCut) return Outcome::tooLong;
        if (largest > 16*crowd && !forced) return Outcome::contactsRule;
    }
    results_.clear();
    results_.resize(partition_.islands.size());
    do
    {
        const Outcome outcome = stepIslands(piece, mayCut);
        if (outcome != Outcome::done) return outcome;
    }
    while (mergeWhatMeets(piece, report));
    finishPiece(piece, report);
    return Outcome::done;
}


AdaptiveIntegrator::Outcome AdaptiveIntegrator::stepIslands(const Piece& piece, bool mayCut)
{
    shared_.gather(piece, partition_);
    struct Round { double work; bool crowded; };
    const std::vector<Bytes> rounds = shareMade(exchange_, [&]
    {
        steppers_.run(piece, partition_.islands, toStep_, results_);
        shared_.run();
        Outgoing out;
        out << Round{workOfRound(), mayCut && crowds()};
        return out.take();
    });
    double work = workOfSearch*double(all_.particles);       // of the search for what they meet
    bool crowded = false;
    for (const Bytes& bytes : rounds)
    {
        const auto round = Incoming(bytes).get<Round>();
        work += round.work;
        crowded = crowded || round.crowded;
    }
    workLeft_ -= work;
    if (workLeft_ < 0) return Outcome::contactsRule;
    if (crowded) return Outcome::tooLong;
    shared_.sendHome(results_);
    return Outcome::done;
}


/// Of the islands just stepped.
double AdaptiveIntegrator::workOfRound() const
{
    double sum = 0;
    for (const std::uint32_t k : toStep_) sum += results_[k].work();
    shared_.forEachResult(true, [&](const IslandResult& result) { sum += result.work(); });
    return sum;
}


/// Free flights and candidates, after overlaps without a history are separated; what is too crowded
/// for that counts as touching. False where the periodic box is too small for the paths.
bool AdaptiveIntegrator::findCandidates(const Piece& piece, StepReport& report)
{
    for (int round = 0;; ++round)
    {
        if (!flyFreely(piece)) return false;
        if (exchange_.alone()) search_.find(piece, flights_, candidates_);
        else findAmongRanks(piece, report);
        report.candidates += boundPairs_.size();
        const std::size_t overlaps =
            exchange_.alone() ? candidates_.overlaps.size() : overlaps_.overlaps.size();
        if (overlaps == 0 || round == separationRounds) break;
        if (exchange_.rank() == 0) report.separated += overlaps;
        separateOverlaps();
    }
    for (const Overlap& overlap : candidates_.overlaps)
        for (const std::uint32_t i : {overlap.first, overlap.second})
            if (i < piece.own()) candidates_.touching.push_back(i);
    return true;
}


/// Whether stochastic collisions make islands that shorter pieces would not.
bool AdaptiveIntegrator::crowds() const
{
    if (!states_.weighted()) return false;
    bool crowded = false;
    const auto look = [&](std::size_t particles, const IslandResult& result)
    {
        crowded = crowded || particles > (result.soft() ? softCrowd : crowd);
    };
    for (std::size_t k = 0; k < results_.size(); ++k)
        if (shared_.nameOf(k) == SharedIslands::none)
            look(partition_.islands[k].particles.size(), results_[k]);
    shared_.forEachResult(false, [&](const IslandResult& r) { look(r.end.size(), r); });
    return crowded;
}


/// Merges the islands whose particles meet on their new paths; false if there are none.
bool AdaptiveIntegrator::mergeWhatMeets(const Piece& piece, StepReport& report)
{
    const Stopwatch watch(report.searchSeconds);
    if (!exchange_.alone()) return mergeWhatMeetsAmongRanks(piece, report);
    const std::vector<Pair> hits = pathCheck_.find(piece, partition_, results_, toStep_,
                                                   flights_.frame, flights_.bounds);
    if (hits.empty()) return false;
    toStep_ = partition_.merge(hits, report.mergedIslands);
    results_.resize(partition_.islands.size());
    return true;
}


void AdaptiveIntegrator::finishPiece(const Piece& piece, StepReport& report)
{
    std::vector<ParticleState>& all = states_.all();
    forElements(settings_.threads, all.size(), [&](std::size_t i)
    {
        ParticleState& s = all[i];
        if (!partition_.isFree(std::uint32_t(i)))
        {
            s = results_[partition_.islandOf[i]].end[partition_.placeIn[i]];
            return;
        }
        if (s.flight.rate > 0) s.dragGain += s.flight.dragGain(piece.duration, s.force);
        s.flight = flights_.end[i];
    });
    report.freeParticles = all.size();
    report.softParticles = 0;
    std::vector<ContactRecord> lasting;
    const auto count = [&](const IslandResult& result)
    {
        ++report.islands;
        report.impacts += result.impacts;
        report.impactSeconds += result.impactSeconds;
        report.softSeconds += result.softSeconds;
        report.largestOverlap = std::max(report.largestOverlap, result.largestOverlap);
        if (!result.soft()) return;
        ++report.softIslands;
        report.softParticles += result.end.size();
        report.subSteps += result.subSteps;
        report.step = report.step > 0 ? std::min(report.step, result.shortestStep)
                                      : result.shortestStep;
    };
    for (std::size_t k = 0; k < results_.size(); ++k)
    {
        const std::size_t particles = partition_.islands[k].particles.size();
        if (particles == 0) continue;          // merged into another
        report.freeParticles -= particles;
        lasting.insert(lasting.end(), results_[k].contacts.begin(), results_[k].contacts.end());
        for (WallHit hit : results_[k].hits)
        {
            hit.time += pieceBegin_;
            report.hits.push_back(hit);
        }
        if (shared_.nameOf(k) == SharedIslands::none) count(results_[k]);
    }
    shared_.forEachResult(false, count);
    report.sharedIslands += shared_.steppedHere();
    report.touching = report.wallTouching = 0;
    for (const ContactRecord& record : lasting)
        ++(record.wall ? report.wallTouching : report.touching);
    contactEnds_ = 2*report.touching + report.wallTouching;
    contacts_ = SortedContacts(std::move(lasting));
    if (walls_.take()) states_.setTakenAside();
}

} // namespace elutria::dem
