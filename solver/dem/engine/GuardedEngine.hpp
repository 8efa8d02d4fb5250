#pragma once

#include "engine/Engine.hpp"
#include "engine/OverlapRemoval.hpp"

#include <memory>
#include <string>

namespace elutria::dem
{

/// Moves particles as an Engine does, and checks each call's result: all values finite, and no more
/// kinetic energy than the particles had, the forcing can have given them and the contacts can have
/// held. A call that fails is made again from the state before it with half the sub-step, which is
/// kept from then on. With the soft law for all, spheres that enter are made room for first (the
/// other treatments do so themselves).
class GuardedEngine
{
public:
    /// A sub-step that was asked for in seconds (Settings::step) is lowered, with a warning, where it
    /// is longer than `largestFraction` of the shortest contact.
    explicit GuardedEngine(std::unique_ptr<Engine> engine, double largestFraction = 1e300)
      : engine_(std::move(engine)), largestFraction_(largestFraction)
    {}

    /// As Engine::advance(). Energy that smaller sub-steps do not remove is reported and kept: it is
    /// that of overlaps. After other troubles and `retakes` throws std::runtime_error that says
    /// which particle and why, with the particles and the contacts as they were before.
    StepReport advance(Particles& particles, double duration, int retakes);

    Engine& engine() { return *engine_; }
    const Engine& engine() const { return *engine_; }

private:
    double energyAllowed(const Particles& before, const Particles& after, double duration) const;
    std::string unsound(const Particles& before, const Particles& after, double duration) const;
    void refine(double factor, const std::vector<ContactRecord>& history);
    void reset(const Settings& settings);

    std::unique_ptr<Engine> engine_;
    OverlapRemoval overlapRemoval_;
    double largestFraction_;
    bool overlapKnown_ = false;     // of the contacts at the start of the next call
    double overlap_ = 0;            // over the smaller radius
    std::size_t contacts_ = 0;
};

} // namespace elutria::dem
