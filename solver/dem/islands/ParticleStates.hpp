#pragma once

#include "core/Particles.hpp"
#include "impacts/ParticleState.hpp"
#include "laws/Settings.hpp"

#include <vector>

namespace elutria::dem
{

/// The caller's particles as states by ascending id: neither the caller's order nor the number of
/// threads shows in a result.
class ParticleStates
{
public:
    explicit ParticleStates(const Settings& settings) : settings_(settings) {}

    /// `weighted`: any particle of other ranks has a statistical weight other than one.
    /// Throws std::invalid_argument for an id that is given twice.
    void load(const Particles& particles, bool weighted = false);
    /// Gives positions (inside the box), velocities, spins and dragImpulse back.
    void store(Particles& particles) const;
    /// The same of those that walls have taken alone; true if there are any.
    bool storeTaken(Particles& particles) const;
    /// From now on those that walls have taken are not among all().
    void setTakenAside();

    std::size_t size() const { return all_.size(); }
    std::vector<ParticleState>& all() { return all_; }
    const std::vector<ParticleState>& all() const { return all_; }

    /// True if any, of any rank, has a statistical weight other than one.
    bool weighted() const { return weighted_; }

private:
    void prepareStochasticCollisions(const Particles& particles);

    const Settings& settings_;
    static void store(const ParticleState&, std::uint32_t place, const PeriodicBox&, Particles&);

    std::vector<ParticleState> all_, taken_;
    std::vector<std::uint32_t> order_;         // own index -> caller's index
    std::vector<std::uint32_t> orderOfTaken_;
    bool weighted_ = false;
};

} // namespace elutria::dem
