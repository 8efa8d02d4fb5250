#pragma once

#include "events.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

// Impacts of spheres that stand for several particles each, or for a share of one.
//
// In a dilute cloud sphere i must meet the n_j particles of sphere j as often as those would meet
// it. So the cross-section of a pair is max(n_i, n_j, 1) times the spheres' own, and in a meeting
// i takes part with probability n_j/max, j with n_i/max (Schmidt & Rutland 2000, J. Comput. Phys.
// 164, 62: collisions of parcels of unequal numbers). Frequencies, and the mean exchange of
// momentum between any two kinds, are those of the particles; a single event need not conserve it.

namespace elutria::dem
{

/// Numbers above it count as this one: a pair's distance of meeting stays within 4 times its own.
constexpr double largestCollisionNumber = 16;

inline bool isWeighted(const Traveller& a, const Traveller& b)
{
    return a.number != 1 || b.number != 1;
}

/// By how much a pair's cross-section is larger than its spheres'.
inline double crossSectionFactor(const Traveller& a, const Traveller& b)
{
    return std::min(std::max({a.number, b.number, 1.0}), largestCollisionNumber);
}

/// Distance of centres at which a pair meets, m.
inline double meetingDistance(const Traveller& a, const Traveller& b)
{
    const double sum = a.radius + b.radius;
    return isWeighted(a, b) ? sum*std::sqrt(crossSectionFactor(a, b)) : sum;
}

/// Reproducible number in [0, 1) of a meeting, for its first or second party.
inline double chanceOf(const Traveller& a, const Traveller& b, double time, bool second)
{
    const auto scramble = [](std::uint64_t z)
    {
        z = (z ^ (z >> 33))*0xff51afd7ed558ccdULL;
        z = (z ^ (z >> 33))*0xc4ceb9fe1a85ec53ULL;
        return z ^ (z >> 33);
    };
    const double place = a.flight.position.x + 3*a.flight.position.y + 7*a.flight.position.z + time;
    std::uint64_t bits;
    static_assert(sizeof bits == sizeof place);
    std::memcpy(&bits, &place, sizeof bits);
    bits = scramble(scramble(scramble(bits) + a.id) + 2*b.id + second);
    return double(bits >> 11)*0x1.0p-53;
}

} // namespace elutria::dem
