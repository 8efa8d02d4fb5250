#pragma once

#include "core/Particles.hpp"
#include "parallel/Exchange.hpp"

namespace elutria::dem
{

/// What decisions need to know of the particles of all ranks: all ranks decide alike.
struct Census
{
    std::size_t particles = 0;
    std::size_t contactEnds = 0;         // sides in contact: two per pair, one per wall
    bool weighted = false;               // has any a statistical weight other than one?
    Vector3 velocity;                    // m/s, mean
    Particles extremes;                  // spheres with the smallest sizes and largest speeds of all

    /// What decides on the length of contact steps: the extremes; a rank that is alone has its own
    /// particles instead.
    const Particles& decisive(const Particles& own) const { return extremes.size() > 0 ? extremes : own; }
};

/// All ranks call it; a rank that is alone counts its particles only.
Census takeCensus(Exchange& exchange, const Particles& particles, std::size_t contactEnds);

/// One sphere per material, as small, as light and as fast as any of it.
Particles extremesOf(const Particles& particles);

} // namespace elutria::dem
