#include "islands/PathCheck.hpp"

#include "impacts/EventDriven.hpp"
#include "impacts/FirstContact.hpp"
#include "impacts/StochasticCollisions.hpp"

#include <algorithm>

namespace elutria::dem
{

namespace
{

constexpr std::size_t fewChanged = 32;       // changed paths, each checked against all particles

double endOf(const Path& path, std::size_t k, double duration)
{
    return k + 1 < path.size() ? path[k + 1].begin : duration;
}

bool onFreeFlight(const ParticleState& start, const PathSegment& segment)
{
    const Vector3 &v = segment.flight.velocity, &free = start.flight.velocity;
    return segment.begin == 0 && segment.slack == 0 && v.x == free.x && v.y == free.y
           && v.z == free.z;
}

bool flightsMeet(const Flight& a, const Flight& b, double distance, const PeriodicBox& box,
                 double duration)
{
    const Vector3 d = a.position - b.position, shortest = box.shortest(d);
    return norm(shortest) < distance*(1 - EventDriven::shallow)
        || firstContact(a, b, d - shortest, distance, 0, duration).time < never;
}

} // namespace


bool pathsMeet(const ParticleState& a, const Path& pathA, const ParticleState& b,
               const Path& pathB, std::uint64_t seed, const PeriodicBox& box, double duration)
{
    std::size_t i = 0, j = 0;
    while (i < pathA.size() && j < pathB.size())
    {
        const PathSegment &segmentA = pathA[i], &segmentB = pathB[j];
        const double endA = endOf(pathA, i, duration), endB = endOf(pathB, j, duration);
        const double begin = std::max(segmentA.begin, segmentB.begin), end = std::min(endA, endB);
        const bool stillFree =                   // looked at before
            onFreeFlight(a, segmentA) && onFreeFlight(b, segmentB);
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


Bound boundOf(const Path& path, double radius, double duration, const Vector3& frame)
{
    Vector3 low = path[0].flight.position, high = low;
    double slack = 0;
    for (std::size_t k = 0; k < path.size(); ++k)
    {
        const double time = endOf(path, k, duration) - path[k].begin;
        slack = std::max(slack, path[k].slack + path[k].flight.chordDeviation(time));
        for (const double t : {0.0, time})
        {
            const Vector3 p = path[k].flight.at(t).position - (path[k].begin + t)*frame;
            for (int axis = 0; axis < 3; ++axis)
            {
                low[axis] = std::min(low[axis], p[axis]);
                high[axis] = std::max(high[axis], p[axis]);
            }
        }
    }
    return {0.5*(low + high), radius + 0.5*norm(high - low) + slack};
}


/// Calls check(i, j) for the changed paths and all others with an overlapping bound.
template<class Check>
void PathCheck::checkFew(const std::vector<std::uint32_t>& changed,
                         const std::vector<Bound>& bounds, const Check& check) const
{
    for (const std::uint32_t i : changed)
        for (std::uint32_t j = 0; j < bounds.size(); ++j)
        {
            if (j == i || (isChanged_[j] && j < i)) continue;
            const double reach = bounds[i].reach + bounds[j].reach;
            const Vector3 d = settings_.box.shortest(bounds[i].centre - bounds[j].centre);
            if (squaredNorm(d) < reach*reach) check(i, j);
        }
}


std::vector<Pair> PathCheck::find(const Piece& piece, const IslandPartition& partition,
                                  const std::vector<IslandResult>& results,
                                  const std::vector<std::uint32_t>& stepped, const Vector3& frame,
                                  std::vector<Bound>& bounds)
{
    std::vector<std::uint32_t> changed;
    for (const std::uint32_t k : stepped)
    {
        const Island& island = partition.islands[k];
        for (std::size_t p = 0; p < island.particles.size(); ++p)
        {
            const std::uint32_t i = island.particles[p];
            const Path& path = results[k].paths[p];
            bounds[i] = boundOf(path, piece.start[i].reach, piece.duration, frame);
            if (path.size() > 1 || path[0].slack > 0) changed.push_back(i);
        }
    }
    std::vector<Pair> hits;
    if (changed.empty()) return hits;
    isChanged_.assign(piece.start.size(), false);
    for (const std::uint32_t i : changed) isChanged_[i] = true;

    const auto pathOf = [&](std::uint32_t i, Path& free) -> const Path&
    {
        if (!partition.isFree(i)) return results[partition.islandOf[i]].paths[partition.placeIn[i]];
        free.assign(1, {0, piece.start[i].flight, 0});
        return free;
    };
    Path freeA, freeB;
    const auto check = [&](std::uint32_t i, std::uint32_t j)
    {
        if (partition.share(i, j)) return;
        if (pathsMeet(piece.start[i], pathOf(i, freeA), piece.start[j], pathOf(j, freeB),
                      piece.seed, settings_.box, piece.duration))
            hits.push_back({i, j});
    };
    if (changed.size() < fewChanged)
    {
        checkFew(changed, bounds, check);
        return hits;
    }
    boundPairs_.find(bounds);
    boundPairs_.forEach([&](std::uint32_t i, std::uint32_t j)
    {
        if (isChanged_[i] || isChanged_[j]) check(i, j);
    });
    return hits;
}

} // namespace elutria::dem
