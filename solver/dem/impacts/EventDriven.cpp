#include "impacts/EventDriven.hpp"

#include "impacts/StochasticCollisions.hpp"
#include "neighbours/PairSearch.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

namespace
{

constexpr std::uint32_t mostImpacts = 10;        // of one sphere in one run
constexpr std::uint32_t mostForcedImpacts = 1000;    // also of stochastic collisions
constexpr std::size_t fewMembers = 24;           // up to here all pairs are tried

ImpactBody bodyOf(const ParticleState& t)
{
    return {t.radius, 1/t.mass, t.flight.velocity, t.spin};
}

} // namespace


double EventDriven::run(std::vector<ParticleState>& members, double begin, double end,
                        std::uint64_t seed, std::vector<Path>& segments, double mostImpacts)
{
    members_ = &members, paths_ = &segments, end_ = end, seed_ = seed;
    impacts_ = 0;
    hits_.clear();
    largestOverlap_ = 0;
    busyUntil_ = begin;
    queue_.clear();
    states_.assign(members.size(), {});
    for (std::size_t i = 0; i < members.size(); ++i)
    {
        states_[i].since = begin;
        states_[i].bound = boundOf(members[i].flight, members[i].reach, end - begin);
        states_[i].end = members[i].flight.at(end - begin).position;
        segments[i].push_back({begin, members[i].flight, 0});
    }
    predictAll();

    double reached = end;
    while (!queue_.empty())
    {
        std::pop_heap(queue_.begin(), queue_.end());
        const Event next = queue_.back();
        queue_.pop_back();
        if (next.versionA != states_[next.a].version) continue;
        if (next.b != wall && next.versionB != states_[next.b].version) continue;
        const bool stop = next.handOver || double(impacts_) > mostImpacts;
        const Verdict verdict = stop ? Verdict::handOver : carryOut(next);
        if (verdict == Verdict::done) continue;
        reached = verdict == Verdict::crowded ? goBack() : next.time;
        break;
    }
    for (std::uint32_t i = 0; i < members.size(); ++i) fly(i, reached);
    return reached;
}


void EventDriven::predictAll()
{
    const std::size_t n = states_.size();
    const double begin = n > 0 ? states_[0].since : 0;
    if (n <= fewMembers)
    {
        for (std::uint32_t a = 0; a < n; ++a)
            for (std::uint32_t b = a + 1; b < n; ++b) predictPair(a, b, begin);
    }
    else
    {
        std::vector<double> x(n), y(n), z(n), reach(n);
        for (std::size_t i = 0; i < n; ++i)
        {
            const Bound& bound = states_[i].bound;
            const Vector3 centre = box_.wrapped(bound.centre);
            x[i] = centre.x, y[i] = centre.y, z[i] = centre.z, reach[i] = bound.reach;
        }
        const Spheres bounds{n, x.data(), y.data(), z.data(), reach.data()};
        for (const Pair& pair : findPairs(bounds, box_, NeighbourSearch::automatic))
            predictPair(pair.first, pair.second, begin);
    }
    for (std::uint32_t a = 0; a < n; ++a) predictWall(a, begin);
}


void EventDriven::push(const Event& event)
{
    queue_.push_back(event);
    std::push_heap(queue_.begin(), queue_.end());
}


void EventDriven::predictPair(std::uint32_t a, std::uint32_t b, double from)
{
    const State &sa = states_[a], &sb = states_[b];
    const Vector3 apart = box_.shortest(sa.bound.centre - sb.bound.centre);
    const double reach = sa.bound.reach + sb.bound.reach;
    if (squaredNorm(apart) >= reach*reach) return;

    const ParticleState &ta = (*members_)[a], &tb = (*members_)[b];
    if (ta.taken || tb.taken) return;
    const Flight fa = sa.since == from ? ta.flight : ta.flight.at(from - sa.since);
    const Flight fb = sb.since == from ? tb.flight : tb.flight.at(from - sb.since);
    if (isWeighted(ta, tb))
    {
        const Passage passage(from, end_, fa.position, sa.end, fb.position, sb.end, box_);
        const double time = stochasticCollision(ta, tb, passage, randomStream(a, b));
        if (time < never) push({time, a, b, sa.version, sb.version, false});
        return;
    }
    const Vector3 d = fa.position - fb.position, shortest = box_.shortest(d);
    const double sum = ta.radius + tb.radius;
    Event event{from, a, b, sa.version, sb.version, true};
    if (norm(shortest) >= (1 - shallow)*sum)
    {
        const FirstContact m = firstContact(fa, fb, d - shortest, sum, 0, end_ - from);
        if (m.time >= never) return;
        event.time = from + m.time;
        event.handOver = m.lasting || !laws_.pairs()(ta.material, tb.material).applies();
    }
    push(event);
}


RandomStream EventDriven::randomStream(std::uint32_t a, std::uint32_t b) const
{
    return {seed_, (*members_)[a], (*paths_)[a].size() - 1, (*members_)[b], (*paths_)[b].size() - 1};
}


void EventDriven::predictWall(std::uint32_t a, double from)
{
    State& state = states_[a];
    const ParticleState& t = (*members_)[a];
    if (t.taken) return;
    const double time = end_ - from;
    walls_.collect(t.flight.position, t.flight.at(time).position,
                   t.radius + t.flight.chordDeviation(time), images_);
    FirstContact first;
    for (const Walls::Image& image : images_)
    {
        const auto nearest = [&](const Vector3& p) { return walls_.nearestPoint(image, p); };
        FirstContact m{0, true};
        if (norm(t.flight.position - nearest(t.flight.position)) >= (1 - shallow)*t.radius)
            m = firstWallContact(t.flight, t.radius, 0, time, nearest);
        if (m.time > first.time || (m.time == first.time && !m.lasting)) continue;
        first = m;
        state.nextWall = image;
    }
    if (first.time >= never) return;
    const std::uint32_t triangle = state.nextWall.triangle;
    const bool suits = laws_.walls()(t.material, walls_.material(triangle)).applies();
    const bool takes = walls_.answer(triangle) == WallAnswer::takes;
    push({from + first.time, a, wall, state.version, 0, !takes && (first.lasting || !suits)});
}


void EventDriven::fly(std::uint32_t a, double to)
{
    State& state = states_[a];
    if (to == state.since) return;
    ParticleState& t = (*members_)[a];
    t.dragGain += t.flight.dragGain(to - state.since, t.force);
    t.flight = t.flight.at(to - state.since);
    state.since = to;
}


void EventDriven::remember(double time)
{
    Checkpoint& c = checkpoint_;
    c.time = time;
    c.members = *members_;
    c.impacts = impacts_;
    c.hits = hits_.size();
    c.since.clear(), c.segments.clear();
    for (const State& state : states_) c.since.push_back(state.since);
    for (const Path& segments : *paths_) c.segments.push_back(segments.size());
}


double EventDriven::goBack()
{
    const Checkpoint& c = checkpoint_;
    *members_ = c.members;
    impacts_ = c.impacts;
    hits_.resize(c.hits);
    for (std::size_t i = 0; i < states_.size(); ++i)
    {
        states_[i].since = c.since[i];
        (*paths_)[i].resize(c.segments[i]);
    }
    return c.time;
}


/// Many impacts of a sphere mean that it is crowded; many stochastic collisions do not: their
/// partners do not touch it.
bool EventDriven::tooMany(const Event& event) const
{
    const State &a = states_[event.a], &b = states_[event.b == wall ? event.a : event.b];
    if (event.b != wall && isWeighted((*members_)[event.a], (*members_)[event.b]))
        return std::max(a.stochastic, b.stochastic) >= mostForcedImpacts;
    return std::max(a.impacts, b.impacts) >= (forced_ ? mostForcedImpacts : mostImpacts);
}


EventDriven::Verdict EventDriven::carryOut(const Event& event)
{
    const auto [time, a, b, versionA, versionB, handOver] = event;
    const bool onWall = b == wall;
    State& sa = states_[a];
    if (tooMany(event)) return Verdict::handOver;
    if (!onWall && isWeighted((*members_)[a], (*members_)[b]))
    {
        collideStochastically(event);
        return Verdict::done;
    }
    if (!forced_ && time >= busyUntil_) remember(time);

    fly(a, time);
    if (!onWall) fly(b, time);
    if (onWall && walls_.answer(sa.nextWall.triangle) == WallAnswer::takes)
    {
        reportHit(event);
        rest(a);
        return Verdict::done;
    }
    const ParticleState& ta = (*members_)[a];
    ImpactBody bodyA = bodyOf(ta), bodyB;
    Vector3 normal, acceleration = ta.flight.acceleration;
    std::uint32_t other;
    if (onWall)
    {
        const Vector3 point = walls_.nearestPoint(sa.nextWall, ta.flight.position);
        normal = ta.flight.position - point;
        if (walls_.move())
            bodyB.velocity = walls_.surfaceVelocity(sa.nextWall, point, (1/norm(normal))*normal);
        other = walls_.material(sa.nextWall.triangle);
    }
    else
    {
        const ParticleState& tb = (*members_)[b];
        bodyB = bodyOf(tb);
        normal = box_.shortest(ta.flight.position - tb.flight.position);
        other = tb.material;
        acceleration -= tb.flight.acceleration;
    }
    normal *= 1/norm(normal);
    const ImpactLaw& law = (onWall ? laws_.walls() : laws_.pairs())(ta.material, other);
    const double closing = -dot(bodyA.velocity - bodyB.velocity, normal);
    const double mass = 1/(bodyA.inverseMass + bodyB.inverseMass);
    const double radius = onWall ? ta.radius
        : ta.radius*bodyB.radius/(ta.radius + bodyB.radius);
    const bool busy = time < sa.busyUntil || (!onWall && time < states_[b].busyUntil);
    if (busy && !forced_) return Verdict::crowded;
    if (!(closing > 0)) return Verdict::handOver;
    const double lasts = law.duration(mass, radius, closing);
    const double pressing = -dot(acceleration, normal)*lasts/closing;
    if (std::abs(pressing) > ImpactLaw::mostPressing && !forced_) return Verdict::handOver;
    if (!collide(bodyA, bodyB, normal, law, pressing)) return Verdict::handOver;
    if (onWall) reportHit(event);

    ++impacts_;
    largestOverlap_ = std::max(largestOverlap_, law.depth(lasts, closing)
                                                /(onWall ? radius : 2*radius));
    const double over = time + lasts;
    busyUntil_ = std::max(busyUntil_, over);
    sa.busyUntil = over;
    changed(a, bodyA);
    ++sa.impacts;
    if (!onWall)
    {
        states_[b].busyUntil = over;
        changed(b, bodyB);
        ++states_[b].impacts;
    }
    predictAfter(event, true, !onWall);
    return Verdict::done;
}


/// An impact at a random place of the cross-section; each sphere takes part with a probability in
/// proportion to the other's weight.
void EventDriven::collideStochastically(const Event& event)
{
    fly(event.a, event.time);
    fly(event.b, event.time);
    const ParticleState &ta = (*members_)[event.a], &tb = (*members_)[event.b];
    ImpactBody bodyA = bodyOf(ta), bodyB = bodyOf(tb);
    RandomStream stream = randomStream(event.a, event.b);
    stream.next();                    // the first one gave the time
    const double factor = crossSectionFactor(ta, tb), chance = stream.next();
    const Vector3 passing = bodyA.velocity - bodyB.velocity;
    const bool hit = norm(passing) > 0
        && collide(bodyA, bodyB, randomNormal(passing, stream), laws_.pairs()(ta.material, tb.material));
    const bool hitsA = hit && chance*factor < tb.weight, hitsB = hit && chance*factor < ta.weight;
    const auto met = [this](std::uint32_t member, const ImpactBody& after)
    {
        changed(member, after);
        ++states_[member].stochastic;
    };
    if (hitsA) met(event.a, bodyA);
    if (hitsB) met(event.b, bodyB);
    impacts_ += hitsA || hitsB;
    predictAfter(event, hitsA, hitsB);
}


/// Predicts the partners' further collisions, and those of the changed ones with all others.
void EventDriven::predictAfter(const Event& event, bool changedA, bool changedB)
{
    const auto [time, a, b, versionA, versionB, handOver] = event;
    for (std::uint32_t i = 0; i < states_.size() && (changedA || changedB); ++i)
    {
        if (i == a || i == b) continue;
        if (changedA) predictPair(std::min(a, i), std::max(a, i), time);
        if (changedB) predictPair(std::min(b, i), std::max(b, i), time);
    }
    if (b != wall) predictPair(std::min(a, b), std::max(a, b), time);
    if (changedA) predictWall(a, time);
    if (changedB) predictWall(b, time);
}


void EventDriven::changed(std::uint32_t a, const ImpactBody& after)
{
    ParticleState& t = (*members_)[a];
    t.flight.acceleration -= t.flight.rate*(after.velocity - t.flight.velocity);
    t.flight.velocity = after.velocity;
    t.spin = after.spin;
    pathChanged(a);
}


/// Its hit of the wall that it has flown to, where that answers.
void EventDriven::reportHit(const Event& event)
{
    const Walls::Image& image = states_[event.a].nextWall;
    const WallAnswer answer = walls_.answer(image.triangle);
    if (answer == WallAnswer::silent) return;
    const ParticleState& t = (*members_)[event.a];
    const Vector3 away = t.flight.position - walls_.nearestPoint(image, t.flight.position);
    hits_.push_back({t.id, image.triangle, answer, event.time, t.flight.position, t.flight.velocity,
                     (1/norm(away))*away});
}


void EventDriven::rest(std::uint32_t a)
{
    (*members_)[a].rest();
    pathChanged(a);
}


/// From now on: predictions made before are void.
void EventDriven::pathChanged(std::uint32_t a)
{
    const ParticleState& t = (*members_)[a];
    State& state = states_[a];
    state.bound = boundOf(t.flight, t.reach, end_ - state.since);
    state.end = t.flight.at(end_ - state.since).position;
    ++state.version;
    Path& segments = (*paths_)[a];
    if (segments.back().begin == state.since) segments.pop_back();
    segments.push_back({state.since, t.flight, 0});
}

} // namespace elutria::dem
