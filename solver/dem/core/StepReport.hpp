#pragma once

#include "core/WallHit.hpp"
#include "core/Warning.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace elutria::dem
{

/// What one advance() did, in numbers.
struct StepCounts
{
    std::size_t particles = 0;
    std::size_t ghosts = 0;              // particles of other ranks that could meet own ones
    std::size_t subSteps = 0;
    double step = 0;                     // s, smallest sub-step taken
    std::size_t candidates = 0;          // pairs in the neighbour list
    std::size_t touching = 0;            // particle pairs touching at the end
    std::size_t wallTouching = 0;        // particle-wall contacts at the end
    std::size_t freeParticles = 0;       // particles without a candidate: free flight
    std::size_t impacts = 0;             // collisions resolved as one impulse
    std::size_t islands = 0;             // groups of particles that could touch each other
    std::size_t sharedIslands = 0;       // of these: have particles of several ranks
    std::size_t softIslands = 0;         // of these: took sub-steps of the soft law
    std::size_t mergedIslands = 0;       // stepped again because a changed path met another
    std::size_t separated = 0;           // overlaps without a contact history, separated
    std::size_t pieces = 0;              // pieces that the step was cut into
    std::size_t softParticles = 0;       // particles that took sub-steps
    double searchSeconds = 0, impactSeconds = 0, softSeconds = 0;   // wall time of each part
    std::size_t listBuilds = 0;          // neighbour lists made
    double largestOverlap = 0;           // over the smaller radius, seen during the call
    std::size_t bytes = 0;               // memory held by the engine

    /// Adds what another rank did in the same step: numbers and memory are sums, times the longest.
    void add(const StepCounts& other);
};

/// What one advance() did, on all ranks.
struct StepReport : StepCounts
{
    StepCounts own;                      // this rank's part
    std::vector<WallHit> hits;           // own ones, of walls that answer, in order of time
    std::vector<Warning> warnings;
};


inline void StepCounts::add(const StepCounts& other)
{
    for (const auto count :
         {&StepCounts::particles, &StepCounts::ghosts, &StepCounts::subSteps, &StepCounts::candidates, &StepCounts::touching,
          &StepCounts::wallTouching, &StepCounts::freeParticles, &StepCounts::impacts,
          &StepCounts::islands,
          &StepCounts::sharedIslands, &StepCounts::softIslands, &StepCounts::mergedIslands,
          &StepCounts::separated, &StepCounts::softParticles, &StepCounts::listBuilds,
          &StepCounts::bytes})
        this->*count += other.*count;
    for (const auto most : {&StepCounts::searchSeconds, &StepCounts::impactSeconds,
                            &StepCounts::softSeconds, &StepCounts::largestOverlap})
        this->*most = std::max(this->*most, other.*most);
    pieces = std::max(pieces, other.pieces);
    if (other.step > 0) step = step > 0 ? std::min(step, other.step) : other.step;
}

} // namespace elutria::dem
