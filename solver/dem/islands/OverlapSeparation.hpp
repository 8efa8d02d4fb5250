#pragma once

#include "core/PeriodicBox.hpp"
#include "islands/CandidateSearch.hpp"
#include "parallel/Exchange.hpp"
#include "walls/Walls.hpp"

#include <vector>

namespace elutria::dem
{

/// Separates overlaps that no contact explains (a feed that put spheres into each other): the two
/// move apart by the same distance, and out of walls. Velocities stay, so that no energy comes out
/// of it; no move takes a centre through a wall that its sphere is out of. What is crowded may keep
/// some overlap.
void separate(std::vector<ParticleState>& particles, const std::vector<Overlap>& overlaps,
              const Walls& walls, const PeriodicBox& box);

/// The overlaps of all ranks, in the order in which one rank would find them.
struct OverlapsOfAll
{
    std::vector<ParticleState> particles;    // that overlap, by ascending id
    std::vector<Overlap> overlaps;           // places in `particles`
};

/// `states`: own ones by ascending id, ghosts behind; `overlaps`: places in it.
OverlapsOfAll overlapsOfAll(Exchange& exchange, const std::vector<ParticleState>& states,
                            std::size_t own, const std::vector<Overlap>& overlaps);

} // namespace elutria::dem
