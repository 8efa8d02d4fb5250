#include "islands/AdaptiveIntegrator.hpp"

#include "impacts/FirstContact.hpp"
#include "impacts/StochasticCollisions.hpp"
#include "neighbours/PairSearch.hpp"

#include <algorithm>
#include <cmath>

// Who could meet whom, or a wall, during a step.

namespace elutria::dem
{

namespace
{

constexpr int separationSweeps = 20;

/// Squared distance of the origin from the segment d + s*along, 0 <= s <= 1.
double squaredDistanceOfSegment(const Vector3& d, const Vector3& along)
{
    const double length2 = squaredNorm(along);
    const double s = length2 > 0 ? std::clamp(-dot(d, along)/length2, 0.0, 1.0) : 0;
    return squaredNorm(d + s*along);
}

} // namespace


/// False where a path is too long for the periodic box to tell images apart.
bool AdaptiveIntegrator::bounds(double duration)
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
                      start_[i].reach + 0.5*norm(moved) + slack_[i]};
    });
    double largest = 0;
    for (const Bound& bound : bounds_) largest = std::max(largest, bound.reach);
    for (int axis = 0; axis < 3; ++axis)
        if (settings_.box.periodic[axis]
            && 4*largest > settings_.box.high[axis] - settings_.box.low[axis]) return false;
    return true;
}


void AdaptiveIntegrator::findCandidates(double duration, StepReport& report)
{
    candidates_.clear(), atWall_.clear(), touching_.clear(), overlaps_.clear();
    findBoundPairs();
    report.candidates += pairs_.size();
    forBoundPairs([&](std::uint32_t i, std::uint32_t j) { checkPair(i, j, duration); });
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


void AdaptiveIntegrator::findBoundPairs()
{
    const std::size_t n = bounds_.size();
    centres_.resize(n), reach_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
    {
        centres_.set(i, settings_.box.wrapped(bounds_[i].centre));
        reach_[i] = bounds_[i].reach;
    }
    search_.find({n, centres_.x.data(), centres_.y.data(), centres_.z.data(), reach_.data()},
              settings_.box, NeighbourSearch::automatic, 1, threadsFor(n), pairs_);
}


void AdaptiveIntegrator::checkPair(std::uint32_t i, std::uint32_t j, double duration)
{
    const Flight &a = start_[i].flight, &b = start_[j].flight;
    if (isWeighted(start_[i], start_[j]))
    {
        const Passage passage(0, duration, a.position, ends_[i].position, b.position,
                              ends_[j].position, settings_.box);
        const RandomStream stream(seed_, start_[i], 0, start_[j], 0);
        if (stochasticCollision(start_[i], start_[j], passage, stream) < never)
            candidates_.push_back({i, j});
        return;
    }
    const Vector3 centres = bounds_[i].centre - bounds_[j].centre;
    const Vector3 offset = centres - settings_.box.shortest(centres);
    const Vector3 apart = a.position - b.position - offset;
    const Vector3 moved = (ends_[i].position - a.position) - (ends_[j].position - b.position);
    const double sum = start_[i].radius + start_[j].radius;
    const double close = sum + slack_[i] + slack_[j];
    if (squaredDistanceOfSegment(apart, moved) >= close*close) return;
    const double distance2 = squaredNorm(apart);
    candidates_.push_back({i, j});
    if (distance2 >= sum*sum) return;
    const std::uint64_t a0 = start_[i].id, b0 = start_[j].id;
    const ContactRecord key{std::min(a0, b0), std::max(a0, b0), false, {}};
    const auto at = std::lower_bound(records_.begin(), records_.end(), key, recordBefore);
    const bool known = at != records_.end() && !recordBefore(key, *at);
    if (known) touching_.push_back(i), touching_.push_back(j);
    else if (distance2 < sum*sum*(1 - 2*EventDriven::shallow)) overlaps_.push_back({i, j});
}


AdaptiveIntegrator::WallLook AdaptiveIntegrator::lookForWalls(std::size_t i, double duration) const
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
            || firstWallContact(flight, radius, 0, duration, nearest).time < never;
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


/// Moves the listed overlaps apart, both alike, and out of walls; velocities stay. No move takes a
/// centre through a wall that its sphere is out of.
void AdaptiveIntegrator::separateOverlaps(StepReport& report)
{
    report.separated += overlaps_.size();
    for (int sweep = 0; sweep < separationSweeps; ++sweep)
        for (const Candidate& overlap : overlaps_)
        {
            ParticleState& a = start_[overlap.first];
            moveOutOfWalls(a);
            if (overlap.second == none) continue;
            ParticleState& b = start_[overlap.second];
            moveOutOfWalls(b);
            Vector3 apart = settings_.box.shortest(a.flight.position - b.flight.position);
            const double distance = norm(apart), sum = a.radius + b.radius;
            if (distance >= sum) continue;
            apart = distance > 0 ? (1/distance)*apart : Vector3{0, 0, 1};
            const double move = 0.5*(sum - distance)*(1 + 1e-9);
            a.flight.position += std::min(move, 0.5*a.radius)*apart;
            b.flight.position -= std::min(move, 0.5*b.radius)*apart;
        }
    for (const Candidate& overlap : overlaps_)
    {
        moveOutOfWalls(start_[overlap.first]);
        if (overlap.second != none) moveOutOfWalls(start_[overlap.second]);
    }
}


void AdaptiveIntegrator::moveOutOfWalls(ParticleState& t) const
{
    t.flight.position = walls_.movedOut(t.flight.position, t.radius);
}

} // namespace elutria::dem
