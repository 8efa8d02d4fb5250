#include "islands/AdaptiveIntegrator.hpp"

#include "core/Stopwatch.hpp"
#include "impacts/StochasticCollisions.hpp"

#include <algorithm>
#include <numeric>

// Islands: made, stepped, checked against all others and merged.

namespace elutria::dem
{

namespace
{

constexpr std::size_t manyIslands = 32;      // worth a second thread
constexpr std::size_t fewChanged = 32;       // changed paths, each checked against all particles

} // namespace


void AdaptiveIntegrator::makeIslands()
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


void AdaptiveIntegrator::add(std::uint32_t particle, std::uint32_t island)
{
    islandOf_[particle] = island;
    placeIn_[particle] = std::uint32_t(islands_[island].particles.size());
    islands_[island].particles.push_back(particle);
}


void AdaptiveIntegrator::runIslands(double duration)
{
    const std::size_t threads = rerun_.size() < manyIslands ? 1 : steppers_.size();
    forEach(settings_.threads, threads, [&](std::size_t t)
    {
        for (std::size_t k = t; k < rerun_.size(); k += threads)
            runIsland(islands_[rerun_[k]], *steppers_[t], duration);
    });
}


void AdaptiveIntegrator::runIsland(Island& island, IslandStepper& stepper, double duration) const
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
    stepper.run(island, start_, duration, seed_, history);
}


const std::vector<PathSegment>& AdaptiveIntegrator::path(std::uint32_t i, std::vector<PathSegment>& free) const
{
    if (islandOf_[i] != none) return islands_[islandOf_[i]].segments[placeIn_[i]];
    free.assign(1, {0, start_[i].flight, 0});
    return free;
}


/// Looks for hits between paths changed in the last round and paths outside their islands, merges
/// the islands concerned; true if there are any to step again.
bool AdaptiveIntegrator::mergeIslands(double duration, StepReport& report)
{
    std::vector<std::uint32_t> changed;
    for (const std::uint32_t k : rerun_)
    {
        const Island& island = islands_[k];
        for (std::size_t p = 0; p < island.particles.size(); ++p)
        {
            const std::uint32_t i = island.particles[p];
            const std::vector<PathSegment>& segments = island.segments[p];
            bounds_[i] = boundOf(segments, start_[i].reach, duration, frame_);
            if (segments.size() > 1 || segments[0].slack > 0) changed.push_back(i);
        }
    }
    rerun_.clear();
    if (changed.empty()) return false;
    const Stopwatch watch(report.searchSeconds);
    isChanged_.assign(start_.size(), false);
    for (const std::uint32_t i : changed) isChanged_[i] = true;

    std::vector<Candidate> hits;
    std::vector<PathSegment> freeA, freeB;
    const auto check = [&](std::uint32_t i, std::uint32_t j)
    {
        if (islandOf_[i] == islandOf_[j] && islandOf_[i] != none) return;
        if (pathsMeet(start_[i], path(i, freeA), start_[j], path(j, freeB), seed_, settings_.box,
                      duration))
            hits.push_back({i, j});
    };
    if (changed.size() < fewChanged)
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


void AdaptiveIntegrator::merge(const std::vector<Candidate>& hits, StepReport& report)
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

} // namespace elutria::dem
