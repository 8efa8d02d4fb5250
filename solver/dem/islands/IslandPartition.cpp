#include "islands/IslandPartition.hpp"

#include "core/DisjointSets.hpp"

#include <algorithm>

namespace elutria::dem
{

void IslandPartition::add(std::uint32_t particle, std::uint32_t island)
{
    islandOf[particle] = island;
    placeIn[particle] = std::uint32_t(islands[island].particles.size());
    islands[island].particles.push_back(particle);
}


std::size_t IslandPartition::largestWithoutContacts() const
{
    std::size_t largest = 0;
    for (const Island& island : islands)
        if (!island.touching) largest = std::max(largest, island.particles.size());
    return largest;
}


void partition(std::size_t particles, const Candidates& candidates, IslandPartition& made)
{
    DisjointSets sets(particles);
    made.islandOf.assign(particles, IslandPartition::none);
    made.placeIn.resize(particles);
    std::vector<std::uint32_t> involved(candidates.atWall);
    for (const Pair& pair : candidates.pairs)
    {
        sets.join(pair.first, pair.second);
        involved.push_back(pair.first);
        involved.push_back(pair.second);
    }
    involved.insert(involved.end(), candidates.touching.begin(), candidates.touching.end());
    std::sort(involved.begin(), involved.end());
    involved.erase(std::unique(involved.begin(), involved.end()), involved.end());

    made.islands.clear();
    for (const std::uint32_t i : involved)      // a set's smallest number, its root, comes first
    {
        const std::uint32_t root = sets.root(i);
        if (root == i)
        {
            made.islandOf[i] = std::uint32_t(made.islands.size());
            made.islands.emplace_back();
        }
        made.add(i, made.islandOf[root]);
    }
    for (const std::uint32_t i : candidates.touching)
        made.islands[made.islandOf[i]].touching = true;
}


std::vector<std::uint32_t> IslandPartition::merge(const std::vector<Pair>& pairs,
                                                  std::size_t& mergedAway)
{
    for (const Pair& pair : pairs)
        for (const std::uint32_t i : {pair.first, pair.second})
            if (isFree(i))
            {
                islands.emplace_back();
                add(i, std::uint32_t(islands.size() - 1));
            }
    DisjointSets sets(islands.size());
    std::vector<bool> involved(islands.size(), false);
    for (const Pair& pair : pairs)
    {
        sets.join(islandOf[pair.first], islandOf[pair.second]);
        involved[islandOf[pair.first]] = involved[islandOf[pair.second]] = true;
    }
    std::vector<std::uint32_t> grown;
    for (std::uint32_t k = 0; k < islands.size(); ++k)
    {
        if (!involved[k]) continue;
        const std::uint32_t root = sets.root(k);
        if (root == k)
        {
            grown.push_back(k);
            continue;
        }
        Island& into = islands[root];
        into.touching = into.touching || islands[k].touching;
        into.particles.insert(into.particles.end(), islands[k].particles.begin(),
                              islands[k].particles.end());
        islands[k] = {};
        ++mergedAway;
    }
    for (const std::uint32_t k : grown)
    {
        std::vector<std::uint32_t> particles;
        particles.swap(islands[k].particles);
        std::sort(particles.begin(), particles.end());
        for (const std::uint32_t i : particles) add(i, k);
    }
    return grown;
}

} // namespace elutria::dem
