#pragma once

#include "core/PeriodicBox.hpp"
#include "islands/CandidateSearch.hpp"
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

} // namespace elutria::dem
