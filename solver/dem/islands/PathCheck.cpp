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

bool touch(const Bound& a, const Bound& b, const PeriodicBox& box)
{
    const double reach = a.reach + b.reach;
    return squaredNorm(box.shortest(a.centre - b.centre)) < reach*reach;
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


const Path& pathOf(std::uint32_t i, const Piece& piece, const IslandPartition& partition,
                   const std::vector<IslandResult>& results, Path& free)
{
    if (!partition.isFree(i)) return results[partition.islandOf[i]].paths[partition.placeIn[i]];
    free.assign(1, {0, piece.start[i].flight, 0});
    return free;
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
            if (touch(bounds[i], bounds[j], settings_.box)) check(i, j);
        }
}


std::vector<Pair> PathCheck::find(const Piece& piece, const IslandPartition& partition,
                                  const std::vector<IslandResult>& results,
                                  const std::vector<std::uint32_t>& stepped, const Vector3& frame,
                                  std::vector<Bound>& bounds)
{
    std::vector<std::uint32_t>& changed = changed_;
    changed.clear();
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

    Path freeA, freeB;
    const auto check = [&](std::uint32_t i, std::uint32_t j)
    {
        if (partition.share(i, j)) return;
        if (pathsMeet(piece.start[i], pathOf(i, piece, partition, results, freeA), piece.start[j],
                      pathOf(j, piece, partition, results, freeB), piece.seed, settings_.box,
                      piece.duration))
            hits.push_back({i, j});
    };
    if (changed.size() < fewChanged)
    {
        checkFew(changed, bounds, check);
        return hits;
    }
    boundPairs_.findWith(changed, bounds);
    boundPairs_.forEach([&](std::uint32_t i, std::uint32_t j)
    {
        if (isChanged_[i] || isChanged_[j]) check(i, j);
    });
    return hits;
}


std::vector<IdPair> PathCheck::meetGhosts(const Piece& piece, const IslandPartition& partition,
                                          const std::vector<IslandResult>& results,
                                          const SharedIslands& shared,
                                          const std::vector<GhostPath>& ghosts,
                                          const Vector3& frame, const std::vector<Bound>& bounds)
{
    std::vector<IdPair> hits;
    Path free;
    const auto check = [&](std::uint32_t i, const GhostPath& ghost)
    {
        if (!partition.isFree(i) && ghost.island != SharedIslands::none
            && shared.nameOf(partition.islandOf[i]) == ghost.island) return;
        const ParticleState& own = piece.start[i];
        const Path& path = pathOf(i, piece, partition, results, free);
        const bool meet = own.id < ghost.start.id
            ? pathsMeet(own, path, ghost.start, ghost.path, piece.seed, settings_.box, piece.duration)
            : pathsMeet(ghost.start, ghost.path, own, path, piece.seed, settings_.box, piece.duration);
        if (meet) hits.push_back({own.id, ghost.start.id});
    };
    std::vector<Bound> all = bounds;
    for (const GhostPath& ghost : ghosts)
        all.push_back(boundOf(ghost.path, ghost.start.reach, piece.duration, frame));
    if (ghosts.size() < fewChanged)
    {
        for (std::size_t g = 0; g < ghosts.size(); ++g)
            for (std::uint32_t i = 0; i < bounds.size(); ++i)
                if (touch(all[i], all[bounds.size() + g], settings_.box)) check(i, ghosts[g]);
        return hits;
    }
    boundPairs_.find(all);
    boundPairs_.forEach([&](std::uint32_t i, std::uint32_t j)
    {
        if (i < bounds.size() && j >= bounds.size()) check(i, ghosts[j - bounds.size()]);
    });
    return hits;
}

} // namespace elutria::dem
