#pragma once

#include "engine/Engine.hpp"
#include "engine/OverlapRemoval.hpp"

#include <memory>
#include <string>

namespace elutria::dem
{

/// An Engine whose steps are checked: all values are finite, and the kinetic energy is no more than
/// before, plus the work of the forcing and of moving walls, plus what contacts can have stored. A step
/// that fails is rejected and repeated from the state before it with half the sub-step, which is kept
/// from then on. Overlaps of particles that enter are removed first (OverlapRemoval).
class GuardedEngine
{
public:
    /// A sub-step that was asked for in seconds (Settings::step) is lowered, with a warning, where it
    /// is longer than `largestFraction` of the shortest contact.
    explicit GuardedEngine(std::unique_ptr<Engine> engine, double largestFraction = 1e300)
      : engine_(std::move(engine)), largestFraction_(largestFraction)
    {}

    /// As Engine::advance() on all ranks, rejected steps included. Energy that smaller sub-steps do not
    /// remove is reported and kept: it is that of overlaps. After any other failure and `retakes`
    /// repetitions throws std::runtime_error that says which particle and why, with particles and
    /// contacts as they were before.
    StepReport advance(Particles& particles, double duration, int retakes);

    Engine& engine() { return *engine_; }
    const Engine& engine() const { return *engine_; }

private:
    struct Outcome
    {
        StepReport report;
        std::string trouble;        // empty: the step is sound
        bool broken = false;        // no overlap that was given explains it
    };
    std::vector<Warning> shortenStep(const Particles& particles,
                                     const std::vector<ContactRecord>& history);
    Outcome tryStep(Particles& particles, const Particles& before,
                    const std::vector<ContactRecord>& history, double duration, bool first);
    Warning repeated(int attempt) const;
    StepReport accepted(StepReport report, const std::vector<Warning>& warnings);
    double energyAllowed(const Particles& before, const Particles& after, double duration) const;
    double held(std::vector<double> radius) const;
    double sum(double ofRank) const;
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
