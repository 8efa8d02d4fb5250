#pragma once

#include "bench.hpp"
#include "boxScene.hpp"

#include <functional>
#include <string>

// The scenes of the benchmarks of threads and ranks: spheres of 2.5 mm in a box that is periodic sideways,
// falling through it or settled in it. The settled bed is a narrow one, repeated sideways: 6250 spheres
// each.

/// What is to be measured: a scene with so many threads, or ranks.
struct TiledRun
{
    const BoxScene& box;
    const std::string& name;             // settled or falling
    const elutria::dem::Particles& particles;
    std::size_t steps;
    unsigned number;
    bool first;                          // of the numbers

    /// us of a particle in a step, from s of all of them.
    double each(double seconds) const
    {
        return 1e6*seconds/(double(steps)*double(particles.size()));
    }
};

/// Each scene with each number of the option `numbers`; where it is not given, with 1, 2, 4, 8 and 16, as
/// far as the cores go. Options beside: particles, scene, and work, the particle-steps measured of settled
/// spheres; ten times as many of falling ones.
void forRuns(const Options& options, const std::string& numbers,
             const std::function<void(const TiledRun&)>& measure);

/// FNV-1a of the bits of positions, velocities and spins.
std::uint64_t checksum(const elutria::dem::Particles& p);
