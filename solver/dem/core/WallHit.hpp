#pragma once

#include "core/Vector3.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// What a hit of a wall means beside the contact law.
enum class WallAnswer : std::uint8_t
{
    silent,    // nothing
    told,      // the hit is reported
    takes      // the hit is reported, and the particle rests there to the end of the call
};

/// The begin of a particle's contact with a wall.
struct WallHit
{
    std::uint64_t id;              // of the particle
    std::uint32_t triangle;
    WallAnswer answer;
    double time;                   // s, since the call began
    Vector3 position, velocity;    // m, m/s: of the centre, before the contact
    Vector3 normal;                // unit, from the wall to the centre
};

/// In an order that neither threads nor islands show in.
inline void sortHits(std::vector<WallHit>& hits)
{
    std::stable_sort(hits.begin(), hits.end(), [](const WallHit& a, const WallHit& b)
    { return a.time != b.time ? a.time < b.time : a.id < b.id; });
}

} // namespace elutria::dem
