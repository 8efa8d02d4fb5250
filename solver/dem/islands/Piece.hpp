#pragma once

#include "impacts/ParticleState.hpp"
#include "islands/SortedContacts.hpp"

#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// A piece of a gas step: the whole of it, or a part where the step is too long for its density.
/// The input of all stages.
struct Piece
{
    const std::vector<ParticleState>& start;    // by ascending id; ghosts behind
    const SortedContacts& history;              // contacts that last from before
    double duration;                            // s
    std::uint64_t seed;                         // of the stochastic collisions
    double work = 1e300;                        // sub-steps or impacts, times particles, at most
    std::size_t ghosts = 0;                     // of these, particles of other ranks

    std::size_t own() const { return start.size() - ghosts; }
};

} // namespace elutria::dem
