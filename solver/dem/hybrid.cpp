#include "hybrid.hpp"

#include "meeting.hpp"
#include "search.hpp"
#include "threads.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace elutria::dem
{

namespace
{

constexpr std::uint32_t none = 0xffffffffu;
constexpr std::size_t crowd = 256;           // island of impacts above which a step is cut
constexpr int mostCuts = 12;                 // halvings of a step
constexpr double fewSubSteps = 24;           // these cost no more than looking around first
constexpr std::size_t block = 2048;           // particles handled by one thread at a time
constexpr std::size_t manyParticles = 4*block, manyIslands = 32;   // worth a second thread
constexpr int separationRounds = 5, separationSweeps = 20;

class Stopwatch
{
public:
    explicit Stopwatch(double& total) : total_(total) {}
    ~Stopwatch()
    {
        total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    double& total_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

bool recordBefore(const ContactRecord& a, const ContactRecord& b)
{
    if (a.first != b.first) return a.first < b.first;
    return a.second != b.second ? a.second < b.second : a.wall < b.wall;
}

/// Contacts counted once for each particle they hold.
std::size_t contactEnds(const std::vector<ContactRecord>& records)
{
    std::size_t ends = 0;
    for (const ContactRecord& record : records) ends += record.wall ? 1 : 2;
    return ends;
}

/// Squared distance of the origin from the segment d + s*along, 0 <= s <= 1.
double squaredDistanceOfSegment(const Vector3& d, const Vector3& along)
{
    const double length2 = squaredNorm(along);
    const double s = length2 > 0 ? std::clamp(-dot(d, along)/length2, 0.0, 1.0) : 0;
    return squaredNorm(d + s*along);
}

} // namespace


Hybrid::Hybrid(const Settings& settings, const ContactMaterials& materials, const Walls& walls,
               SoftIntegrator& plain, IslandStepper::StepLimit stepLimit)
  : settings_(settings), walls_(walls), plain_(plain), stepLimit_(stepLimit),
    laws_(settings.law, materials)
{
    for (unsigned t = 0; t < settings.threads; ++t)
        steppers_.push_back(
            std::make_unique<IslandStepper>(settings, materials, walls, laws_, stepLimit));
}


std::vector<ContactRecord> Hybrid::exportContacts() const
{
    std::vector<ContactRecord> records = plainRules_ ? plain_.exportContacts() : records_;
    std::sort(records.begin(), records.end(), recordBefore);
    return records;
}


void Hybrid::importContacts(const std::vector<ContactRecord>& records)
{
    records_ = records;
    std::sort(records_.begin(), records_.end(), recordBefore);
    plainRules_ = false;
    contactEnds_ = contactEnds(records_);
}


void Hybrid::usePlain()
{
    if (plainRules_) return;
    plain_.importContacts(records_);
    plainRules_ = true;
}


void Hybrid::advance(Particles& particles, double duration, StepReport& report)
{
    if (particles.size() == 0) return;
    const bool forced = settings_.treatment == ContactTreatment::impact;
    const double softStep = stepLimit_(particles);
    // from the state alone, so that a restart decides alike
    if (!forced && (duration <= fewSubSteps*softStep || 2*contactEnds_ > particles.size()))
        return runPlain(particles, duration, report);
    if (plainRules_) importContacts(plain_.exportContacts());

    load(particles);
    const double whole = std::ldexp(1.0, mostCuts);      // a piece is a power of two of these
    double done = 0, length = whole;
    while (done < whole)
    {
        length = std::min(length, whole - done);
        const bool mayCut = length > 1 && duration*length/whole > fewSubSteps*softStep;
        switch (piece(duration*length/whole, mayCut, report))
        {
            case Outcome::tooLong:
                length /= 2;
                break;
            case Outcome::contactsRule:
                store(particles);
                return runPlain(particles, duration*(1 - done/whole), report);
            case Outcome::done:
                done += length;
                ++report.pieces;
                break;
        }
    }
    store(particles);
}


unsigned Hybrid::threadsFor(std::size_t particles) const
{
    return particles < manyParticles ? 1 : settings_.threads;
}


/// Calls work(i) for every particle, in any order.
template<class Work>
void Hybrid::forParticles(const Work& work) const
{
    const std::size_t n = start_.size();
    forEach(threadsFor(n), (n + block - 1)/block, [&](std::size_t k)
    {
        for (std::size_t i = k*block; i < std::min(n, (k + 1)*block); ++i) work(i);
    });
}


void Hybrid::load(const Particles& p)
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
        Traveller& t = start_[i];
        t.id = p.id[k], t.material = p.material[k], t.radius = p.radius[k], t.mass = p.mass[k];
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


void Hybrid::store(Particles& p) const
{
    const bool drag = !p.dragRate.empty();
    if (drag) p.dragImpulse.resize(p.size());
    forParticles([&](std::size_t i)
    {
        const std::uint32_t k = order_[i];
        const Traveller& t = start_[i];
        p.position.set(k, settings_.box.wrapped(t.flight.position));
        p.velocity.set(k, t.flight.velocity);
        p.spin.set(k, t.spin);
        if (drag) p.dragImpulse.set(k, t.mass*t.dragGain);
    });
}


/// The soft law for all.
void Hybrid::runPlain(Particles& particles, double duration, StepReport& report)
{
    const Stopwatch watch(report.softSeconds);
    const bool continued = !plainRules_ && !particles.dragRate.empty();
    const VectorArray before = continued ? particles.dragImpulse : VectorArray{};
    usePlain();
    const double steps =
        std::max(1.0, std::ceil(duration/stepLimit_(particles)*(1 - 1e-12)));
    plain_.run(particles, duration, std::size_t(steps), report);
    for (std::size_t i = 0; i < before.size(); ++i)
        particles.dragImpulse.set(i, particles.dragImpulse[i] + before[i]);

    contactEnds_ = 2*report.touching + report.wallTouching;
}


/// Moves all by `duration`, or says why not and leaves them where they were.
Hybrid::Outcome Hybrid::piece(double duration, bool mayCut, StepReport& report)
{
    const bool forced = settings_.treatment == ContactTreatment::impact;
    {
        const Stopwatch watch(report.searchSeconds);
        for (int round = 0;; ++round)
        {
            if (!bounds(duration)) return mayCut ? Outcome::tooLong : Outcome::contactsRule;
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
    do runIslands(duration);
    while (mergeIslands(duration, report));
    finishPiece(duration, report);
    return Outcome::done;
}


/// False where a path is too long for the periodic box to tell images apart.
bool Hybrid::bounds(double duration)
{
    const std::size_t n = start_.size();
    ends_.resize(n), bounds_.resize(n), slack_.resize(n);
    forParticles([&](std::size_t i) { ends_[i] = start_[i].flight.at(duration); });
    frame_ = {};
    for (std::size_t i = 0; i < n; ++i) frame_ += ends_[i].position - start_[i].flight.position;
    frame_ *= 1/(duration*double(n));
    forParticles([&](std::size_t i)
    {
        const Flight& flight = start_[i].flight;
        const Vector3 moved = ends_[i].position - flight.position - duration*frame_;
        slack_[i] = flight.chordDeviation(duration);
        bounds_[i] = {flight.position + 0.5*moved,
                      start_[i].radius + 0.5*norm(moved) + slack_[i]};
    });
    double largest = 0;
    for (const Bound& bound : bounds_) largest = std::max(largest, bound.reach);
    for (int axis = 0; axis < 3; ++axis)
        if (settings_.box.periodic[axis]
            && 4*largest > settings_.box.high[axis] - settings_.box.low[axis]) return false;
    return true;
}


void Hybrid::findCandidates(double duration, StepReport& report)
{
    candidates_.clear(), atWall_.clear(), touching_.clear(), overlaps_.clear();
    findBoundPairs();
    report.candidates += pairs_.size();
    forBoundPairs([&](std::uint32_t i, std::uint32_t j) { checkPair(i, j); });
    if (walls_.empty()) return;
    wallLooks_.resize(start_.size());
    forParticles([&](std::size_t i) { wallLooks_[i] = lookForWalls(i, duration); });
    for (std::uint32_t i = 0; i < start_.size(); ++i)
    {
        if (wallLooks_[i] == WallLook::away) continue;
        if (wallLooks_[i] == WallLook::overlaps) overlaps_.push_back({i, none});
        if (wallLooks_[i] == WallLook::touches) touching_.push_back(i);
        atWall_.push_back(i);
    }
}


template<class Visit>
void Hybrid::forBoundPairs(const Visit& visit) const
{
    for (std::uint32_t i = 0; i < bounds_.size(); ++i)
        for (std::uint32_t k = pairs_.begin[i]; k < pairs_.begin[i + 1]; ++k)
            visit(i, pairs_.second[k]);
}


void Hybrid::findBoundPairs()
{
    const std::size_t n = bounds_.size();
    centres_.resize(n), reach_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
    {
        centres_.set(i, settings_.box.wrapped(bounds_[i].centre));
        reach_[i] = bounds_[i].reach;
    }
    findPairs({n, centres_.x.data(), centres_.y.data(), centres_.z.data(), reach_.data()},
              settings_.box, NeighbourSearch::automatic, 1, threadsFor(n), pairs_);
}


void Hybrid::checkPair(std::uint32_t i, std::uint32_t j)
{
    const Flight &a = start_[i].flight, &b = start_[j].flight;
    const Vector3 centres = bounds_[i].centre - bounds_[j].centre;
    const Vector3 offset = centres - settings_.box.shortest(centres);
    const Vector3 apart = a.position - b.position - offset;
    const Vector3 moved = (ends_[i].position - a.position) - (ends_[j].position - b.position);
    const double sum = start_[i].radius + start_[j].radius;
    const double close = sum + slack_[i] + slack_[j];
    if (squaredDistanceOfSegment(apart, moved) >= close*close) return;
    candidates_.push_back({i, j});
    const double distance2 = squaredNorm(apart);
    if (distance2 >= sum*sum) return;
    const std::uint64_t a0 = start_[i].id, b0 = start_[j].id;
    const ContactRecord key{std::min(a0, b0), std::max(a0, b0), false, {}};
    const auto at = std::lower_bound(records_.begin(), records_.end(), key, recordBefore);
    const bool known = at != records_.end() && !recordBefore(key, *at);
    if (known) touching_.push_back(i), touching_.push_back(j);
    else if (distance2 < sum*sum*(1 - 2*EventDriven::shallow)) overlaps_.push_back({i, j});
}


Hybrid::WallLook Hybrid::lookForWalls(std::size_t i, double duration) const
{
    const Flight& flight = start_[i].flight;
    const double radius = start_[i].radius, shallow = radius*(1 - EventDriven::shallow);
    thread_local std::vector<Walls::Image> images;
    walls_.collect(flight.position, ends_[i].position, radius + slack_[i], images);
    bool meets = false;
    double nearestAtStart = never;
    for (const Walls::Image& image : images)
    {
        const auto nearest = [&](const Vector3& p) { return walls_.nearestPoint(image, p); };
        const double distance = norm(flight.position - nearest(flight.position));
        nearestAtStart = std::min(nearestAtStart, distance);
        meets = meets || distance < shallow
            || wallMeeting(flight, radius, 0, duration, nearest).time < never;
    }
    if (nearestAtStart < radius)
    {
        const std::uint64_t id = start_[i].id;
        auto at = std::lower_bound(records_.begin(), records_.end(),
                                   ContactRecord{id, 0, false, {}}, recordBefore);
        while (at != records_.end() && at->first == id && !at->wall) ++at;
        if (at != records_.end() && at->first == id) return WallLook::touches;
        if (nearestAtStart < shallow) return WallLook::overlaps;
    }
    return meets ? WallLook::meets : WallLook::away;
}


/// Moves the listed overlaps apart, centre of mass kept; velocities stay.
void Hybrid::separateOverlaps(StepReport& report)
{
    std::vector<WallContact> contacts;
    report.separated += overlaps_.size();
    for (int sweep = 0; sweep < separationSweeps; ++sweep)
        for (const Candidate& overlap : overlaps_)
        {
            Traveller& a = start_[overlap.first];
            if (overlap.second == none)
            {
                walls_.contacts(a.flight.position, a.radius, 0, contacts);
                for (const WallContact& c : contacts)
                    a.flight.position -= c.gap*(1 + 1e-9)*c.normal;
                continue;
            }
            Traveller& b = start_[overlap.second];
            Vector3 apart = settings_.box.shortest(a.flight.position - b.flight.position);
            const double distance = norm(apart), sum = a.radius + b.radius;
            if (distance >= sum) continue;
            apart = distance > 0 ? (1/distance)*apart : Vector3{0, 0, 1};
            const Vector3 move = ((sum - distance)*(1 + 1e-9)/(a.mass + b.mass))*apart;
            a.flight.position += b.mass*move;
            b.flight.position -= a.mass*move;
        }
}


void Hybrid::makeIslands()
{
    const std::size_t n = start_.size();
    sets_.reset(n);
    islandOf_.assign(n, none);
    placeIn_.resize(n);
    std::vector<std::uint32_t> involved(atWall_);
    for (const Candidate& c : candidates_)
    {
        sets_.join(c.first, c.second);
        involved.push_back(c.first);
        involved.push_back(c.second);
    }
    involved.insert(involved.end(), touching_.begin(), touching_.end());
    std::sort(involved.begin(), involved.end());
    involved.erase(std::unique(involved.begin(), involved.end()), involved.end());

    islands_.clear();
    for (const std::uint32_t i : involved)      // a set's smallest number, its root, comes first
    {
        const std::uint32_t root = sets_.root(i);
        if (root == i)
        {
            islandOf_[i] = std::uint32_t(islands_.size());
            islands_.emplace_back();
        }
        add(i, islandOf_[root]);
    }
    for (const std::uint32_t i : touching_) islands_[islandOf_[i]].touching = true;
    rerun_.resize(islands_.size());
    std::iota(rerun_.begin(), rerun_.end(), 0u);
}


void Hybrid::add(std::uint32_t particle, std::uint32_t island)
{
    islandOf_[particle] = island;
    placeIn_[particle] = std::uint32_t(islands_[island].particles.size());
    islands_[island].particles.push_back(particle);
}


void Hybrid::runIslands(double duration)
{
    const std::size_t threads = rerun_.size() < manyIslands ? 1 : steppers_.size();
    forEach(settings_.threads, threads, [&](std::size_t t)
    {
        for (std::size_t k = t; k < rerun_.size(); k += threads)
            runIsland(islands_[rerun_[k]], *steppers_[t], duration);
    });
}


void Hybrid::runIsland(Island& island, IslandStepper& stepper, double duration) const
{
    std::vector<ContactRecord> history;
    if (island.touching)
        for (const std::uint32_t i : island.particles)
        {
            const std::uint64_t id = start_[i].id;
            auto at = std::lower_bound(records_.begin(), records_.end(),
                                       ContactRecord{id, 0, false, {}}, recordBefore);
            for (; at != records_.end() && at->first == id; ++at) history.push_back(*at);
        }
    stepper.run(island, start_, duration, history);
}


const std::vector<Leg>& Hybrid::path(std::uint32_t i, std::vector<Leg>& free) const
{
    if (islandOf_[i] != none) return islands_[islandOf_[i]].legs[placeIn_[i]];
    free.assign(1, {0, start_[i].flight, 0});
    return free;
}


/// Looks for hits between paths changed in the last round and paths outside their islands, merges
/// the islands concerned; true if there are any to step again.
bool Hybrid::mergeIslands(double duration, StepReport& report)
{
    std::vector<std::uint32_t> changed;
    for (const std::uint32_t k : rerun_)
    {
        const Island& island = islands_[k];
        for (std::size_t p = 0; p < island.particles.size(); ++p)
        {
            const std::uint32_t i = island.particles[p];
            const std::vector<Leg>& legs = island.legs[p];
            bounds_[i] = boundOf(legs, start_[i].radius, duration, frame_);
            if (legs.size() > 1 || legs[0].slack > 0) changed.push_back(i);
        }
    }
    rerun_.clear();
    if (changed.empty()) return false;
    const Stopwatch watch(report.searchSeconds);
    isChanged_.assign(start_.size(), false);
    for (const std::uint32_t i : changed) isChanged_[i] = true;

    std::vector<Candidate> hits;
    std::vector<Leg> freeA, freeB;
    const auto check = [&](std::uint32_t i, std::uint32_t j)
    {
        if (islandOf_[i] == islandOf_[j] && islandOf_[i] != none) return;
        const double sum = start_[i].radius + start_[j].radius;
        if (pathsMeet(path(i, freeA), path(j, freeB), sum, settings_.box, duration) < never)
            hits.push_back({i, j});
    };
    if (changed.size() < 32)
    {
        for (const std::uint32_t i : changed)
            for (std::uint32_t j = 0; j < start_.size(); ++j)
            {
                if (j == i || (isChanged_[j] && j < i)) continue;
                const double reach = bounds_[i].reach + bounds_[j].reach;
                const Vector3 d = settings_.box.shortest(bounds_[i].centre - bounds_[j].centre);
                if (squaredNorm(d) < reach*reach) check(i, j);
            }
    }
    else
    {
        findBoundPairs();
        forBoundPairs([&](std::uint32_t i, std::uint32_t j)
        {
            if (isChanged_[i] || isChanged_[j]) check(i, j);
        });
    }
    if (hits.empty()) return false;
    merge(hits, report);
    return true;
}


void Hybrid::merge(const std::vector<Candidate>& hits, StepReport& report)
{
    for (const Candidate& hit : hits)
        for (const std::uint32_t i : {hit.first, hit.second})
            if (islandOf_[i] == none)
            {
                islands_.emplace_back();
                add(i, std::uint32_t(islands_.size() - 1));
            }
    DisjointSets sets(islands_.size());
    std::vector<bool> involved(islands_.size(), false);
    for (const Candidate& hit : hits)
    {
        sets.join(islandOf_[hit.first], islandOf_[hit.second]);
        involved[islandOf_[hit.first]] = involved[islandOf_[hit.second]] = true;
    }
    for (std::uint32_t k = 0; k < islands_.size(); ++k)
    {
        if (!involved[k]) continue;
        const std::uint32_t root = sets.root(k);
        if (root == k)
        {
            rerun_.push_back(k);
            continue;
        }
        Island& into = islands_[root];
        into.touching = into.touching || islands_[k].touching;
        into.particles.insert(into.particles.end(), islands_[k].particles.begin(),
                              islands_[k].particles.end());
        islands_[k] = {};
        ++report.mergedIslands;
    }
    for (const std::uint32_t k : rerun_)
    {
        std::vector<std::uint32_t> particles;
        particles.swap(islands_[k].particles);
        std::sort(particles.begin(), particles.end());
        for (const std::uint32_t i : particles) add(i, k);
    }
}


void Hybrid::finishPiece(double duration, StepReport& report)
{
    forParticles([&](std::size_t i)
    {
        Traveller& t = start_[i];
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
