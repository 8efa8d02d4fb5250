#include "islands/IslandStepper.hpp"

#include "core/Stopwatch.hpp"
#include "impacts/FirstContact.hpp"
#include "impacts/StochasticCollisions.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

namespace
{

constexpr double chunkSteps = 32;            // sub-steps between looks at what touches
constexpr std::size_t smallIsland = 256;
constexpr double chunksOfLarge = 16;         // a large island is looked at this often per step

Settings forIslands(Settings settings)
{
    settings.threads = 1;
    return settings;
}

double endOf(const std::vector<PathSegment>& segments, std::size_t k, double duration)
{
    return k + 1 < segments.size() ? segments[k + 1].begin : duration;
}

bool onFreeFlight(const ParticleState& start, const PathSegment& segment)
{
    const Vector3 &v = segment.flight.velocity, &free = start.flight.velocity;
    return segment.begin == 0 && segment.slack == 0 && v.x == free.x && v.y == free.y && v.z == free.z;
}

bool flightsMeet(const Flight& a, const Flight& b, double distance, const PeriodicBox& box,
                 double duration)
{
    const Vector3 d = a.position - b.position, shortest = box.shortest(d);
    return norm(shortest) < distance*(1 - EventDriven::shallow)
        || firstContact(a, b, d - shortest, distance, 0, duration).time < never;
}

} // namespace


IslandStepper::IslandStepper(const Settings& settings, const ContactMaterials& materials,
                             const Walls& walls, const ImpactTable& laws, StepLimit stepLimit)
  : settings_(forIslands(settings)), materials_(materials), walls_(walls),
    stepLimit_(std::move(stepLimit)),
    events_(laws, walls, settings_.box, settings.treatment == ContactTreatment::impact)
{}


void IslandStepper::run(Island& island, const std::vector<ParticleState>& start, double duration,
                        std::uint64_t seed, const std::vector<ContactRecord>& history)
{
    const std::size_t n = island.particles.size();
    island.end.clear();
    for (const std::uint32_t i : island.particles) island.end.push_back(start[i]);
    island.segments.assign(n, {});
    island.impacts = island.subSteps = 0;
    island.shortestStep = 1e300;
    island.largestOverlap = island.impactSeconds = island.softSeconds = 0;
    island.contacts.clear();

    double time = 0;
    bool touching = island.touching;
    if (touching) startSoft(history);
    while (time < duration)
    {
        if (!touching)
        {
            const Stopwatch watch(island.impactSeconds);
            time = events_.run(island.end, time, duration, seed, island.segments);
            island.impacts += events_.impacts();
            island.largestOverlap = std::max(island.largestOverlap, events_.largestOverlap());
        }
        if (time >= duration) break;
        const Stopwatch watch(island.softSeconds);
        if (!touching) startSoft({});
        time = softChunk(island, time, duration, touching);
    }
    if (touching) island.contacts = soft_->exportContacts();
}


/// A new integrator each time: what it did before for other islands must not show in this one.
void IslandStepper::startSoft(const std::vector<ContactRecord>& history)
{
    soft_.emplace(settings_, materials_, walls_);
    soft_->importContacts(history);
}


void IslandStepper::gather(const std::vector<ParticleState>& members)
{
    Particles& p = gathered_;
    const std::size_t n = members.size();
    p.id.resize(n), p.material.resize(n), p.radius.resize(n), p.mass.resize(n);
    p.dragRate.resize(n), p.number.resize(n);
    for (VectorArray* array :
         {&p.position, &p.velocity, &p.spin, &p.gasVelocity, &p.acceleration, &p.dragImpulse})
        array->resize(n);
    for (std::size_t i = 0; i < n; ++i)
    {
        const ParticleState& t = members[i];
        p.id[i] = t.id, p.material[i] = t.material, p.radius[i] = t.radius, p.mass[i] = t.mass;
        p.dragRate[i] = t.flight.rate;
        p.number[i] = t.number;
        p.position.set(i, t.flight.position);
        p.velocity.set(i, t.flight.velocity);
        p.spin.set(i, t.spin);
        p.gasVelocity.set(i, t.gasVelocity);
        p.acceleration.set(i, t.force);
    }
}


double IslandStepper::softChunk(Island& island, double begin, double end, bool& touching)
{
    gather(island.end);
    const double remaining = end - begin, limit = stepLimit_(gathered_);
    const double needed = std::max(1.0, std::ceil(remaining/limit*(1 - 1e-12)));
    const double wanted = island.end.size() <= smallIsland
        ? chunkSteps : std::max(chunkSteps, std::ceil(needed/chunksOfLarge));
    const double steps = std::min(needed, wanted);
    const double time = steps == needed ? remaining : steps*(remaining/needed);

    StepReport report;
    soft_->run(gathered_, time, std::size_t(steps), report);
    touching = report.touching + report.wallTouching > 0;
    island.subSteps += std::size_t(steps);
    island.shortestStep = std::min(island.shortestStep, time/steps);
    island.largestOverlap = std::max(island.largestOverlap, report.largestOverlap);
    for (std::size_t i = 0; i < island.end.size(); ++i)
    {
        ParticleState& t = island.end[i];
        const Vector3 moved =
            settings_.box.shortest(gathered_.position[i] - t.flight.position);
        const Vector3 velocity = gathered_.velocity[i];
        PathSegment segment{begin, {}, 0.5*time*norm(velocity - t.flight.velocity)};
        segment.flight.position = t.flight.position;
        segment.flight.velocity = (1/time)*moved;
        island.segments[i].push_back(segment);
        t.flight = Flight(t.flight.position + moved, velocity, t.force, t.gasVelocity,
                          t.flight.rate);
        t.spin = gathered_.spin[i];
        t.dragGain += (1/t.mass)*gathered_.dragImpulse[i];
    }
    return steps == needed ? end : begin + time;
}


bool pathsMeet(const ParticleState& a, const std::vector<PathSegment>& pathA, const ParticleState& b,
               const std::vector<PathSegment>& pathB, std::uint64_t seed, const PeriodicBox& box,
               double duration)
{
    std::size_t i = 0, j = 0;
    while (i < pathA.size() && j < pathB.size())
    {
        const PathSegment &segmentA = pathA[i], &segmentB = pathB[j];
        const double endA = endOf(pathA, i, duration), endB = endOf(pathB, j, duration);
        const double begin = std::max(segmentA.begin, segmentB.begin), end = std::min(endA, endB);
        const bool stillFree = onFreeFlight(a, segmentA) && onFreeFlight(b, segmentB);   // looked at before
        if (end > begin && !stillFree)
        {
            const Flight fa = segmentA.flight.at(begin - segmentA.begin);
            const Flight fb = segmentB.flight.at(begin - segmentB.begin);
            const double slack = segmentA.slack + segmentB.slack, rest = duration - begin;
            if (!isWeighted(a, b))
            {
                if (flightsMeet(fa, fb, a.radius + b.radius + slack, box, end - begin)) return true;
            }
            else if (slack == 0)           // in contact steps they pass each other
            {
                const Passage passage(begin, duration, fa.position, fa.at(rest).position,
                                      fb.position, fb.at(rest).position, box);
                if (stochasticCollision(a, b, passage, {seed, a, i, b, j}) < end) return true;
            }
        }
        if (endA <= endB) ++i;
        else ++j;
    }
    return false;
}


Bound boundOf(const std::vector<PathSegment>& segments, double radius, double duration, const Vector3& frame)
{
    Vector3 low = segments[0].flight.position, high = low;
    double slack = 0;
    for (std::size_t k = 0; k < segments.size(); ++k)
    {
        const double time = endOf(segments, k, duration) - segments[k].begin;
        slack = std::max(slack, segments[k].slack + segments[k].flight.chordDeviation(time));
        for (const double t : {0.0, time})
        {
            const Vector3 p = segments[k].flight.at(t).position - (segments[k].begin + t)*frame;
            for (int axis = 0; axis < 3; ++axis)
            {
                low[axis] = std::min(low[axis], p[axis]);
                high[axis] = std::max(high[axis], p[axis]);
            }
        }
    }
    return {0.5*(low + high), radius + 0.5*norm(high - low) + slack};
}

} // namespace elutria::dem
