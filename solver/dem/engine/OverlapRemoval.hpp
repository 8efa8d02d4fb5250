#pragma once

#include "core/Particles.hpp"
#include "core/PeriodicBox.hpp"
#include "parallel/Exchange.hpp"
#include "walls/Walls.hpp"

#include <cstdint>

namespace elutria::dem
{

/// Removes the overlaps of spheres that enter between calls, with walls and with other spheres, so
/// that no contact energy comes from nowhere (the adaptive integrator separates overlapping spheres
/// itself). Entering spheres have larger ids than all before; those of the first call are taken as
/// they are.
class OverlapRemoval
{
public:
    /// Moves entering spheres only, out of walls and, if asked, out of `spheres`; in a crowd some
    /// overlap may stay.
    /// All ranks call it.
    void place(Particles& particles, const Walls& walls, const PeriodicBox& box, bool spheres,
               Exchange& exchange = alone());

private:
    bool first_ = true;
    std::uint64_t latest_ = 0;
};

} // namespace elutria::dem
