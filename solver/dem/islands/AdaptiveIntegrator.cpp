#include "islands/AdaptiveIntegrator.hpp"

#include "core/Stopwatch.hpp"
#include "core/TooMuchWork.hpp"
#include "core/text.hpp"
#include "core/forEach.hpp"
#include "impacts/StochasticCollisions.hpp"
#include "islands/OverlapSeparation.hpp"

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
                                       SoftIntegrator& soft, IslandStepper::StepLimit stepLimit)
  : settings_(settings), walls_(walls), soft_(soft), stepLimit_(stepLimit),
    impacts_(laws, materials), states_(settings), boundPairs_(settings),
    search_(settings, walls, boundPairs_),
    steppers_(settings, laws, walls, impacts_, stepLimit), pathCheck_(settings, boundPairs_)
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
    if (softRules_) return;
    soft_.importContacts(contacts_.records());
    softRules_ = true;
}


void AdaptiveIntegrator::advance(Particles& particles, double duration, StepReport& report)
{
    if (particles.size() == 0) return;
    const bool forced = settings_.treatment == ContactTreatment::impact;
    const double softStep = stepLimit_(particles, 0);
    // from the state alone, so that a restart decides alike
    if (!forced && (duration <= fewSubSteps*softStep || 2*contactEnds_ > particles.size()))
        return runSoft(particles, duration, report);
    if (softRules_) importContacts(soft_.exportContacts());

    states_.load(particles);
    workLeft_ = std::min(mostOverSoft*duration/softStep*(double(particles.size()) + 20),
                         TooMuchWork::most);
    const double whole = std::ldexp(1.0, mostCuts);      // a piece is a power of two of these
    double done = 0, length = whole;
    while (done < whole)
    {
        length = std::min(length, whole - done);
        const std::uint64_t seed = scrambled(scrambled(particles.stepIndex) + std::uint64_t(done));
        const bool mayCut = length > 1 && duration*length/whole > fewSubSteps*softStep;
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
                return runSoft(particles, duration*(1 - done/whole), report);
            case Outcome::done:
                done += length;
                ++report.pieces;
                break;
        }
    }
    states_.store(particles);
}


/// The soft law for all.
void AdaptiveIntegrator::runSoft(Particles& particles, double duration, StepReport& report)
{
    const Stopwatch watch(report.softSeconds);
    const bool continued = !softRules_ && !particles.dragRate.empty();
    const VectorArray before = continued ? particles.dragImpulse : VectorArray{};
    useSoft();
    const double steps =
        std::max(1.0, std::ceil(duration/stepLimit_(particles, 0)*(1 - 1e-12)));
    refuseTooMuchWork(duration, steps, particles.size());
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
        partition(states_.size(), candidates_, partition_);
        const std::size_t largest = partition_.largestWithoutContacts();
        if (largest > crowd && mayCut) return Outcome::tooLong;
        if (largest > 16*crowd && !forced) return Outcome::contactsRule;
    }
    results_.clear();
    results_.resize(partition_.islands.size());
    toStep_.resize(partition_.islands.size());
    std::iota(toStep_.begin(), toStep_.end(), 0u);
    do
    {
        steppers_.run(piece, partition_.islands, toStep_, results_);
        workLeft_ -= workOf(toStep_);
        if (workLeft_ < 0) return Outcome::contactsRule;
        if (mayCut && crowds()) return Outcome::tooLong;
    }
    while (mergeWhatMeets(piece, report));
    finishPiece(piece, report);
    return Outcome::done;
}


/// Of the islands just stepped, and of the search for what they meet.
double AdaptiveIntegrator::workOf(const std::vector<std::uint32_t>& islands) const
{
    double sum = workOfSearch*double(states_.size());
    for (const std::uint32_t k : islands) sum += results_[k].work();
    return sum;
}


/// Free flights and candidates, after overlaps without a history are separated; what is too crowded
/// for that counts as touching. False where the periodic box is too small for the paths.
bool AdaptiveIntegrator::findCandidates(const Piece& piece, StepReport& report)
{
    for (int round = 0;; ++round)
    {
        if (!flyFreely(piece, settings_, flights_)) return false;
        search_.find(piece, flights_, candidates_);
        report.candidates += boundPairs_.size();
        if (candidates_.overlaps.empty() || round == separationRounds) break;
        report.separated += candidates_.overlaps.size();
        separate(states_.all(), candidates_.overlaps, walls_, settings_.box);
    }
    for (const Overlap& overlap : candidates_.overlaps)
    {
        candidates_.touching.push_back(overlap.first);
        if (overlap.second != Overlap::wall) candidates_.touching.push_back(overlap.second);
    }
    return true;
}


/// Whether stochastic collisions make islands that shorter pieces would not.
bool AdaptiveIntegrator::crowds() const
{
    if (!states_.weighted()) return false;
    for (std::size_t k = 0; k < results_.size(); ++k)
        if (partition_.islands[k].particles.size() > (results_[k].soft() ? softCrowd : crowd))
            return true;
    return false;
}


/// Merges the islands whose particles meet on their new paths; false if there are none.
bool AdaptiveIntegrator::mergeWhatMeets(const Piece& piece, StepReport& report)
{
    const Stopwatch watch(report.searchSeconds);
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
    for (std::size_t k = 0; k < results_.size(); ++k)
    {
        const std::size_t particles = partition_.islands[k].particles.size();
        if (particles == 0) continue;          // merged into another
        const IslandResult& result = results_[k];
        report.freeParticles -= particles;
        lasting.insert(lasting.end(), result.contacts.begin(), result.contacts.end());
        ++report.islands;
        report.impacts += result.impacts;
        report.impactSeconds += result.impactSeconds;
        report.softSeconds += result.softSeconds;
        report.largestOverlap = std::max(report.largestOverlap, result.largestOverlap);
        if (!result.soft()) continue;
        ++report.softIslands;
        report.softParticles += particles;
        report.subSteps += result.subSteps;
        report.step = report.step > 0 ? std::min(report.step, result.shortestStep)
                                      : result.shortestStep;
    }
    report.touching = report.wallTouching = 0;
    for (const ContactRecord& record : lasting)
        ++(record.wall ? report.wallTouching : report.touching);
    contactEnds_ = 2*report.touching + report.wallTouching;
    contacts_ = SortedContacts(std::move(lasting));
}

} // namespace elutria::dem
