#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace elutria::dem
{

/// Disjoint sets of the numbers 0..size-1; the smallest member is a set's name.
class DisjointSets
{
public:
    explicit DisjointSets(std::size_t size = 0) { reset(size); }

    void reset(std::size_t size)
    {
        parent_.resize(size);
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    std::uint32_t root(std::uint32_t i)
    {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t i, std::uint32_t j)
    {
        i = root(i), j = root(j);
        parent_[std::max(i, j)] = std::min(i, j);
    }

private:
    std::vector<std::uint32_t> parent_;
};

} // namespace elutria::dem
