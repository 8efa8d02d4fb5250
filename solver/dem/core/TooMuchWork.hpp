#pragma once

#include "core/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace elutria::dem
{

/// A call would not end within minutes. Smaller sub-steps cannot help.
struct TooMuchWork : std::runtime_error
{
    /// Sub-steps times particles of one call, at most.
    static constexpr double most = 1e10;

    /// What another rank found.
    explicit TooMuchWork(const std::string& message) : std::runtime_error(message) {}

    TooMuchWork(double duration, double steps, std::size_t particles)
      : std::runtime_error(
            "a step of " + text(duration) + " s takes " + text(steps) + " contact steps of "
            + text(duration/steps) + " s for " + std::to_string(particles)
            + " particles, allowed: " + text(most) + " contact steps times particles. Lower deltaT,"
            " youngsModulus or normalStiffness")
    {}
};

/// How many equal steps of at most `longest` make a duration.
inline double stepsOf(double duration, double longest)
{
    return std::max(1.0, std::ceil(duration/longest*(1 - 1e-12)));
}

inline void refuseTooMuchWork(double duration, double steps, std::size_t particles)
{
    if (steps*double(particles) > TooMuchWork::most)
        throw TooMuchWork(duration, steps, particles);
}

} // namespace elutria::dem
