#pragma once

#include "core/Vector3.hpp"

#include <cstdint>

namespace elutria::dem
{

/// The memory of one lasting contact, for restart and for passing particles between processes.
struct ContactRecord
{
    std::uint64_t first = 0;     // particle id
    std::uint64_t second = 0;    // particle id (> first), or the wall feature's key
    bool wall = false;
    Vector3 tangential;          // m, elastic tangential displacement of first against second
};

/// Pairs before walls, by ascending first, second.
inline bool pairsFirst(const ContactRecord& a, const ContactRecord& b)
{
    if (a.wall != b.wall) return b.wall;
    return a.first != b.first ? a.first < b.first : a.second < b.second;
}

} // namespace elutria::dem
