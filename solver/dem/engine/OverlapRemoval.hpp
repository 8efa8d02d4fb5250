#pragma once

#include "core/Particles.hpp"
#include "core/PeriodicBox.hpp"
#include "walls/Walls.hpp"

#include <cstdint>

namespace elutria::dem
{

/// Makes room for spheres that enter between calls: one that overlaps a wall or another sphere is
/// moved out of it, so that no contact energy comes from nowhere (of spheres, the impacts' search
/// takes care). OverlapRemoval have larger ids than
/// all before; those of the first call are taken as they are.
class OverlapRemoval
{
public:
    /// Moves only newcomers, out of walls and, if asked, of `spheres`; a crowd may leave some
    /// overlap.
    void place(Particles& particles, const Walls& walls, const PeriodicBox& box, bool spheres);

private:
    bool first_ = true;
    std::uint64_t latest_ = 0;
};

} // namespace elutria::dem
