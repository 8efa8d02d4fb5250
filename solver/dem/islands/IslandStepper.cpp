#include "islands/IslandStepper.hpp"

#include "core/Stopwatch.hpp"
#include "core/TooMuchWork.hpp"
#include "core/forEach.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

namespace
{

constexpr double chunkSteps = 32;            // sub-steps between looks at what touches
constexpr std::size_t smallIsland = 256;
constexpr std::size_t manyIslands = 32;      // worth a second thread
constexpr double chunksOfLarge = 16;         // a large island is looked at this often per step
constexpr std::size_t longContact = 4096;    // sub-steps after which contacts are looked at closer
constexpr double slowest = 1e-9;             // m/s

Settings forIslands(Settings settings)
{
    settings.threads = 1;
    return settings;
}

} // namespace


IslandStepper::IslandStepper(const Settings& settings, const LawTables& laws, const Walls& walls,
                             const ImpactLaws& impacts, StepLimit stepLimit)
  : settings_(forIslands(settings)), laws_(laws), walls_(walls),
    stepLimit_(std::move(stepLimit)),
    events_(impacts, walls, settings_.box, settings.treatment == ContactTreatment::impact)
{}


void IslandStepper::run(const Piece& piece, const Island& island, IslandResult& result)
{
    const double duration = piece.duration;
    result.end.clear();
    for (const std::uint32_t i : island.particles) result.end.push_back(piece.start[i]);
    result.paths.assign(island.particles.size(), {});
    result.impacts = result.subSteps = 0;
    result.shortestStep = 1e300;
    result.largestOverlap = result.impactSeconds = result.softSeconds = 0;
    result.contacts.clear();
    result.hits.clear();
    result.finished = true;
    const double impactsAllowed = piece.work/(double(result.end.size()) + 20);

    double time = 0;
    bool touching = island.touching;
    if (touching)
    {
        std::vector<ContactRecord> history;
        for (const std::uint32_t i : island.particles)
            piece.history.copy(piece.start[i].id, history);
        startSoft(history);
    }
    while (time < duration)
    {
        result.finished = result.work() <= piece.work;
        if (!result.finished) return;
        if (!touching)
        {
            const Stopwatch watch(result.impactSeconds);
            time = events_.run(result.end, time, duration, piece.seed, result.paths,
                               impactsAllowed);
            result.impacts += events_.impacts();
            result.hits.insert(result.hits.end(), events_.hits().begin(), events_.hits().end());
            result.largestOverlap = std::max(result.largestOverlap, events_.largestOverlap());
        }
        if (time >= duration) break;
        const Stopwatch watch(result.softSeconds);
        if (!touching) startSoft({});
        time = softChunk(result, time, duration, touching);
    }
    if (touching) result.contacts = soft_->exportContacts();
}


/// A new integrator each time: what it did before for other islands must not show in this one.
void IslandStepper::startSoft(const std::vector<ContactRecord>& history)
{
    soft_.emplace(settings_, laws_, walls_);
    soft_->importContacts(history);
}


void IslandStepper::gather(const std::vector<ParticleState>& members)
{
    Particles& p = gathered_;
    memberOf_.clear();
    for (std::uint32_t i = 0; i < members.size(); ++i)
        if (!members[i].taken) memberOf_.push_back(i);
    const std::size_t n = memberOf_.size();
    p.id.resize(n), p.material.resize(n), p.radius.resize(n), p.mass.resize(n);
    p.dragRate.resize(n), p.statisticalWeight.resize(n);
    for (VectorArray* array :
         {&p.position, &p.velocity, &p.spin, &p.gasVelocity, &p.acceleration, &p.dragImpulse})
        array->resize(n);
    for (std::size_t i = 0; i < n; ++i)
    {
        const ParticleState& t = members[memberOf_[i]];
        p.id[i] = t.id, p.material[i] = t.material, p.radius[i] = t.radius, p.mass[i] = t.mass;
        p.dragRate[i] = t.flight.rate;
        p.statisticalWeight[i] = t.weight;
        p.position.set(i, t.flight.position);
        p.velocity.set(i, t.flight.velocity);
        p.spin.set(i, t.spin);
        p.gasVelocity.set(i, t.gasVelocity);
        p.acceleration.set(i, t.force);
    }
}


/// m/s, across the wall, of any member that comes near one within `time`, at most; infinite near a
/// wall that is not flat there. Along a flat wall friction alone acts, which no speed stiffens.
double IslandStepper::wallSpeed(double time)
{
    constexpr double infinite = 1e100;         // its square is a number: laws take it
    double fastest = 0;
    for (std::size_t i = 0; i < gathered_.size(); ++i)
    {
        const Vector3 now = gathered_.position[i], velocity = gathered_.velocity[i];
        const double radius = gathered_.radius[i], reach = 2*radius;
        const Vector3 then = now + time*velocity;
        if (!walls_.near(now, then, reach)) continue;
        walls_.collect(now, then, reach, images_);
        if (images_.empty()) continue;
        std::uint32_t below = 0;
        const double around = reach + time*norm(velocity);
        if (!walls_.isFlat(now, around, images_)) return infinite;
        walls_.contactsOnFlat(now, radius, around, images_, below, wall_);
        for (const WallContact& contact : wall_)
        {
            const double across = std::abs(dot(velocity, contact.normal))
                                + time*std::abs(dot(forcing(i), contact.normal));
            fastest = std::max(fastest, across);
        }
    }
    return fastest;
}


/// m/s^2, of a member, by drag and forces.
Vector3 IslandStepper::forcing(std::size_t i) const
{
    const Particles& p = gathered_;
    return p.acceleration[i] + p.dragRate[i]*(p.gasVelocity[i] - p.velocity[i]);
}


/// m/s, of any two members, or of one and a wall, within `time`, at most: from their velocities now,
/// from what drag and forces make of them, and from what the deepest contact holds.
double IslandStepper::meetingSpeed(double time)
{
    const Particles& p = gathered_;
    const double share = 1/double(p.size());
    Vector3 velocity, acceleration;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        velocity += share*p.velocity[i];
        acceleration += share*forcing(i);
    }
    double speed = 0, smallest = 1e300, lightest = 1e300;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        if (p.size() > 1)
        {
            speed = std::max(speed, norm(p.velocity[i] - velocity)
                                    + time*norm(forcing(i) - acceleration)
                                    + p.radius[i]*norm(p.spin[i]));
        }
        smallest = std::min(smallest, p.radius[i]);
        lightest = std::min(lightest, p.mass[i]);
    }
    double held = 0;
    laws_.forEach([&](const LawTable& table, std::uint32_t a, std::uint32_t b)
    {
        held = std::max(held, table.law().storedEnergy(table(a, b), smallest, overlap_*smallest));
    });
    return std::max(slowest, std::max(2*speed, wallSpeed(time)) + std::sqrt(4*held/lightest));
}


/// Of the next chunk. A step for contacts at the members' own speed is far too short where they move
/// side by side, or along a wall, and press each other or the wall lightly.
double IslandStepper::longestStep(const IslandResult& result)
{
    const double usual = stepLimit_(gathered_, 0);
    if (result.subSteps < longContact || gathered_.size() > smallIsland) return usual;
    const double guess = stepLimit_(gathered_, meetingSpeed(0));
    return std::max(usual, stepLimit_(gathered_, meetingSpeed(chunkSteps*guess)));
}


double IslandStepper::softChunk(IslandResult& result, double begin, double end, bool& touching)
{
    gather(result.end);
    const double remaining = end - begin, limit = longestStep(result);
    const double needed = stepsOf(remaining, limit);
    const double wanted = result.end.size() <= smallIsland || walls_.take()
        ? chunkSteps : std::max(chunkSteps, std::ceil(needed/chunksOfLarge));
    const double steps = std::min(needed, wanted);
    const double time = steps == needed ? remaining : steps*(remaining/needed);

    StepReport report;
    soft_->run(gathered_, time, std::size_t(steps), report);
    touching = report.touching + report.wallTouching > 0;
    result.subSteps += std::size_t(steps);
    result.shortestStep = std::min(result.shortestStep, time/steps);
    overlap_ = report.largestOverlap;
    result.largestOverlap = std::max(result.largestOverlap, overlap_);
    for (std::size_t i = 0; i < gathered_.size(); ++i)
    {
        ParticleState& t = result.end[memberOf_[i]];
        const Vector3 moved =
            settings_.box.shortest(gathered_.position[i] - t.flight.position);
        const Vector3 velocity = gathered_.velocity[i];
        PathSegment segment{begin, {}, 0.5*time*norm(velocity - t.flight.velocity)};
        segment.flight.position = t.flight.position;
        segment.flight.velocity = (1/time)*moved;
        result.paths[memberOf_[i]].push_back(segment);
        t.flight = Flight(t.flight.position + moved, velocity, t.force, t.gasVelocity,
                          t.flight.rate);
        t.spin = gathered_.spin[i];
        t.dragGain += (1/t.mass)*gathered_.dragImpulse[i];
    }
    for (WallHit hit : report.hits)
    {
        hit.time += begin;
        result.hits.push_back(hit);
        if (hit.answer != WallAnswer::takes) continue;
        const auto place = std::find(gathered_.id.begin(), gathered_.id.end(), hit.id);
        const std::uint32_t member = memberOf_[std::size_t(place - gathered_.id.begin())];
        result.end[member].rest();
        result.paths[member].push_back({begin + time, result.end[member].flight, 0});
    }
    return steps == needed ? end : begin + time;
}


IslandSteppers::IslandSteppers(const Settings& settings, const LawTables& laws,
                               const Walls& walls, const ImpactLaws& impacts,
                               const IslandStepper::StepLimit& stepLimit)
  : threads_(settings.threads)
{
    for (unsigned t = 0; t < threads_; ++t)
        steppers_.push_back(
            std::make_unique<IslandStepper>(settings, laws, walls, impacts, stepLimit));
}


void IslandSteppers::run(const Piece& piece, const std::vector<Island>& islands,
                         const std::vector<std::uint32_t>& which,
                         std::vector<IslandResult>& results)
{
    const std::size_t threads = which.size() < manyIslands ? 1 : steppers_.size();
    forEach(threads_, threads, [&](std::size_t t)
    {
        for (std::size_t k = t; k < which.size(); k += threads)
            steppers_[t]->run(piece, islands[which[k]], results[which[k]]);
    });
}

} // namespace elutria::dem
