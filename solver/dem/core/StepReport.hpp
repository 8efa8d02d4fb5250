#pragma once

#include "core/Warning.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace elutria::dem
{

/// What one advance() did.
struct StepReport
{
    std::size_t subSteps = 0;
    double step = 0;                     // s, smallest sub-step taken
    std::size_t candidates = 0;          // pairs in the neighbour list
    std::size_t touching = 0;            // particle pairs touching at the end
    std::size_t wallTouching = 0;        // particle-wall contacts at the end
    std::size_t freeParticles = 0;       // particles without a candidate: free flight
    std::size_t impacts = 0;             // collisions resolved as one impulse
    std::size_t islands = 0;             // groups of particles that could touch each other
    std::size_t softIslands = 0;         // of these: took sub-steps of the soft law
    std::size_t mergedIslands = 0;       // stepped again because a changed path met another
    std::size_t separated = 0;           // overlaps without a contact history, separated
    std::size_t pieces = 0;              // pieces that the step was cut into
    std::size_t softParticles = 0;       // particles that took sub-steps
    double searchSeconds = 0, impactSeconds = 0, softSeconds = 0;   // wall time of each part
    std::size_t listBuilds = 0;          // neighbour lists made
    double largestOverlap = 0;           // over the smaller radius, seen during the call
    std::size_t bytes = 0;               // memory held by the engine
    std::vector<Warning> warnings;
};

} // namespace elutria::dem
