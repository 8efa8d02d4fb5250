#pragma once

#include "core/Particles.hpp"
#include "laws/ContactMaterials.hpp"
#include "laws/Settings.hpp"
#include "parallel/Exchange.hpp"
#include "walls/Walls.hpp"

// Spheres in a box that is periodic sideways, with a floor and a lid.

struct BoxScene
{
    double width = 0.075, depth = 0.075, height = 0.25;     // m
    double step = 1e-5;                                     // s

    elutria::dem::Walls walls() const;
    /// Contact steps for all, Hertz's law.
    elutria::dem::Settings settings(unsigned threads) const;
    /// Spheres at random places of a jittered lattice that fills the box, falling at `speed`.
    elutria::dem::Particles fill(std::size_t count, double diameter, double speed) const;
    /// Of all particles those of one of the ranks: these have blocks along x and y, as square as they get.
    elutria::dem::Particles ofRank(const elutria::dem::Particles& all,
                                   const elutria::dem::Exchange& exchange) const;
};

elutria::dem::ContactMaterials grain(double young, double poisson, double restitution,
                                     double friction);
