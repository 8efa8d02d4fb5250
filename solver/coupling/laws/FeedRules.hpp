// What a feed may be, where the solver and the tools both refuse or decide. SI units.
#pragma once

#include <algorithm>
#include <cmath>

namespace elutria::laws
{

/// Less is a foam, or a density in g/cm3, kg/m3.
constexpr double leastDensity = 10;

/// More is another unit, kg/m3.
constexpr double largestDensity = 3e4;

/// kg of solids per kg of gas, above which particles meet often enough that their number counts.
constexpr double largestDiluteLoading = 1;

/// Parcels that may be fed for each that is asked for, lest dust take forever.
constexpr double mostAdded = 10;

/// Parcels of a feed of so many particles that is not dilute: those asked for, or more where each
/// would be more than `mostInOne` particles.
inline double parcelsFed(double asked, double particles, double mostInOne)
{
    return std::max(asked, std::ceil(std::min(particles/mostInOne, mostAdded*asked)));
}

} // namespace elutria::laws
