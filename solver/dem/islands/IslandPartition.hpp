#pragma once

#include "islands/CandidateSearch.hpp"

#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// Spheres that may touch each other during a piece, and no others.
struct Island
{
    std::vector<std::uint32_t> particles;      // ascending
    bool touching = false;                     // contacts that last from before
};

/// Third stage: a particle without a candidate is free; the others form islands, the connected
/// components of the candidates.
struct IslandPartition
{
    static constexpr std::uint32_t none = 0xffffffffu;

    std::vector<Island> islands;               // those that were merged into another are empty
    std::vector<std::uint32_t> islandOf;       // of each particle; none: free
    std::vector<std::uint32_t> placeIn;        // of each particle, in its island

    bool isFree(std::uint32_t particle) const { return islandOf[particle] == none; }
    bool share(std::uint32_t a, std::uint32_t b) const
    {
        return !isFree(a) && islandOf[a] == islandOf[b];
    }
    /// Particles of the largest island in which no contact lasts from before.
    std::size_t largestWithoutContacts() const;

    /// Joins the islands of each of these pairs, and free particles to them. Returns the islands
    /// that have grown, ascending; `mergedAway` counts those that are now part of another.
    std::vector<std::uint32_t> merge(const std::vector<Pair>& pairs, std::size_t& mergedAway);

    void add(std::uint32_t particle, std::uint32_t island);
};

void partition(std::size_t particles, const Candidates& candidates, IslandPartition& made);

} // namespace elutria::dem
