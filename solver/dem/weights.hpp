#pragma once

#include "events.hpp"
#include "laws.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

// Impacts of spheres that stand for several particles each, or for a share of one.
//
// In a dilute cloud sphere i must meet the n_j particles of sphere j as often as those would meet
// it. So the cross-section of a pair is f = max(n_i, n_j, 1) times the spheres' own, and a meeting
// is n_j/f impacts for i, n_i/f for j: chances below one (Schmidt & Rutland 2000, J. Comput. Phys.
// 164, 62: collisions of parcels of unequal numbers). f stays below a limit, the smaller the more
// the spheres crowd; beyond it a meeting is several impacts, the further ones at random places of
// the spheres. Frequencies, and the mean exchange of momentum between any two kinds, are those of
// the particles; a single event need not conserve it.

namespace elutria::dem
{

/// Largest limit of f: a pair's distance of meeting stays within 4 times its own.
constexpr double largestCrossSection = 16;

inline bool isWeighted(const Traveller& a, const Traveller& b)
{
    return a.number != 1 || b.number != 1;
}

/// By how much a pair's cross-section is larger than its spheres'.
inline double crossSectionFactor(const Traveller& a, const Traveller& b, double limit)
{
    return std::min(std::max({a.number, b.number, 1.0}), limit);
}

/// Distance of centres at which a pair meets, m.
inline double meetingDistance(const Traveller& a, const Traveller& b, double limit)
{
    const double sum = a.radius + b.radius;
    return isWeighted(a, b) ? sum*std::sqrt(crossSectionFactor(a, b, limit)) : sum;
}

/// By how much the spheres' reach grows with that, at most.
inline double widening(const std::vector<Traveller>& spheres, double limit)
{
    double most = 1;
    for (const Traveller& t : spheres) most = std::max(most, t.number);
    return std::sqrt(std::min(most, limit));
}

/// Reproducible numbers in [0, 1) for a meeting.
class MeetingChances
{
public:
    MeetingChances(const Traveller& a, const Traveller& b, double time)
    {
        const Vector3& at = a.flight.position;
        const double place = at.x + 3*at.y + 7*at.z + time;
        static_assert(sizeof state_ == sizeof place);
        std::memcpy(&state_, &place, sizeof state_);
        state_ = scrambled(scrambled(scrambled(state_) + a.id) + b.id);
    }

    double next()
    {
        state_ += 0x9e3779b97f4a7c15ULL;       // SplitMix64, Steele, Lea & Flood 2014
        return double(scrambled(state_) >> 11)*0x1.0p-53;
    }

private:
    static std::uint64_t scrambled(std::uint64_t z)
    {
        z = (z ^ (z >> 33))*0xff51afd7ed558ccdULL;
        z = (z ^ (z >> 33))*0xc4ceb9fe1a85ec53ULL;
        return z ^ (z >> 33);
    }

    std::uint64_t state_;
};

/// Whole number with the mean `expected`.
inline std::uint64_t wholeNumber(double expected, MeetingChances& chances)
{
    return static_cast<std::uint64_t>(expected + chances.next());
}

/// Unit vector from b to a where they touch, for a place of touching as likely as any other.
inline Vector3 randomNormal(const Vector3& velocityOfAFromB, MeetingChances& chances)
{
    const Vector3 along = velocityOfAFromB*(1/norm(velocityOfAFromB));
    const Vector3 any = std::abs(along.x) < 0.7 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    const Vector3 across = cross(along, any)*(1/norm(cross(along, any)));
    const double sine2 = chances.next(), turn = 2*laws::pi*chances.next();
    const Vector3 aside = std::cos(turn)*across + std::sin(turn)*cross(along, across);
    return std::sqrt(sine2)*aside - std::sqrt(1 - sine2)*along;
}

} // namespace elutria::dem
