#pragma once

#include "PeriodicBox.hpp"
#include "Settings.hpp"

#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// Spheres as the neighbour searches see them: borrowed arrays of equal length.
struct Spheres
{
    std::size_t size;
    const double *x, *y, *z;
    const double* reach;      // m; two spheres are neighbours when closer than the sum of theirs
};

struct Pair
{
    std::uint32_t first, second;   // first < second

    bool operator==(const Pair& b) const { return first == b.first && second == b.second; }
    bool operator<(const Pair& b) const
    {
        return first != b.first ? first < b.first : second < b.second;
    }
};

/// All pairs of neighbours, each once, ascending; periodic directions by the shortest image, for
/// which the box must be at least twice the largest sum of reaches wide.
void findPairs(const Spheres& spheres, const PeriodicBox& box, NeighbourSearch method,
               int cellLayers, std::vector<Pair>& pairs);

} // namespace elutria::dem
