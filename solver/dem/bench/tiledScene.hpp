#pragma once

#include "boxScene.hpp"

#include <string>
#include <vector>

// The scenes of the benchmarks of threads and ranks: spheres of 2.5 mm in a box that is periodic sideways,
// falling through it or settled in it. The settled bed is a narrow one, repeated sideways: 6250 spheres
// each.

/// Parts of a text between commas.
std::vector<std::string> listed(const std::string& text);
/// Numbers in a text; where it is empty, 1, 2, 4, 8 and 16, as far as the cores go.
std::vector<unsigned> numbersListed(const std::string& text);

BoxScene sceneOf(std::size_t particles);

/// Makes settled beds from one that has settled once.
class Scenes
{
public:
    /// `name`: settled or falling.
    elutria::dem::Particles make(const std::string& name, std::size_t particles);

private:
    elutria::dem::Particles tile_;
};

/// Sub-steps in which `work` particle-steps are done, ten times as many where spheres fall.
std::size_t stepsFor(const std::string& scene, double work, std::size_t particles);

/// FNV-1a of the bits of positions, velocities and spins.
std::uint64_t checksum(const elutria::dem::Particles& p);
