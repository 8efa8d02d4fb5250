#pragma once

#include "core/Particles.hpp"
#include "core/WallHit.hpp"
#include "parallel/Exchange.hpp"

#include <vector>

namespace elutria::dem
{

/// The particles of all ranks on the first one, for work that is not distributed. A single rank uses
/// its own in place.
class Gathered
{
public:
    /// All ranks call it; `particles` must outlive this object.
    Gathered(Exchange& exchange, Particles& particles);

    /// All particles on the first rank, none on the others.
    Particles& everyone() { return exchange_.alone() ? own_ : all_; }
    bool here() const { return exchange_.rank() == 0; }

    /// Brings positions, velocities, spins and drag impulses back to their ranks; of the hits that
    /// the first rank gives, each rank gets those of its own particles.
    void giveBack(std::vector<WallHit>& hits);
    void giveBack()
    {
        std::vector<WallHit> none;
        giveBack(none);
    }

private:
    Exchange& exchange_;
    Particles& own_;
    Particles all_;
    std::vector<std::size_t> from_;      // of each rank, its first particle in all_
};

} // namespace elutria::dem
