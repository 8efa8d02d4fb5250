#pragma once

#include "core/Untouched.hpp"
#include "core/forEach.hpp"

namespace elutria::dem
{

/// Adds one and returns what was there; other threads may do so too if `shared`.
inline std::uint32_t addOne(std::uint32_t& value, bool shared)
{
    return shared ? __atomic_fetch_add(&value, 1u, __ATOMIC_RELAXED) : value++;
}

/// Each value becomes the sum of all up to it.
inline void sumUp(unsigned mostThreads, Untouched<std::uint32_t>& values)
{
    const std::vector<std::uint32_t> sums =
        forBlocks(mostThreads, values.size(), [&](std::size_t begin, std::size_t end)
    {
        for (std::size_t i = begin + 1; i < end; ++i) values[i] += values[i - 1];
        return values[end - 1];
    });
    std::vector<std::uint32_t> before(sums.size(), 0);
    for (std::size_t b = 1; b < sums.size(); ++b) before[b] = before[b - 1] + sums[b - 1];
    forElements(mostThreads, values.size(),
                [&](std::size_t i) { values[i] += before[i/elementBlock]; });
}

/// Parts of a range, one for each thread, and how many elements of each group each of them has:
/// a stable counting sort, whose result does not depend on the number of parts.
class Grouping
{
public:
    Grouping(unsigned threads, std::size_t count, std::size_t groups)
      : parts_(std::max(1u, threadsFor(count, threads))), count_(count), groups_(groups),
        places_(parts_*groups)
    {}

    /// group(k): of element k, below the number of groups.
    template<class Group>
    void read(const Group& group)
    {
        forEach(unsigned(parts_), parts_, [&](std::size_t part)
        {
            std::uint32_t* counts = places_.data() + part*groups_;
            for (std::size_t k = begin(part); k < begin(part + 1); ++k) ++counts[group(k)];
        });
        begin_.assign(groups_ + 1, 0);
        std::uint32_t before = 0;
        for (std::size_t g = 0; g < groups_; ++g)
        {
            begin_[g] = before;
            for (std::size_t part = 0; part < parts_; ++part)
            {
                std::uint32_t& place = places_[part*groups_ + g];
                const std::uint32_t here = place;
                place = before, before += here;
            }
        }
        begin_[groups_] = before;
    }
    /// put(k, place) for each element, after read() of the same groups.
    template<class Group, class Put>
    void write(const Group& group, const Put& put)
    {
        forEach(unsigned(parts_), parts_, [&](std::size_t part)
        {
            std::uint32_t* places = places_.data() + part*groups_;
            for (std::size_t k = begin(part); k < begin(part + 1); ++k) put(k, places[group(k)]++);
        });
    }
    /// First place of a group; that of the number of groups is the end.
    std::size_t place(std::size_t group) const { return begin_[group]; }

private:
    std::size_t begin(std::size_t part) const { return count_*part/parts_; }

    std::size_t parts_, count_, groups_;
    std::vector<std::uint32_t> places_, begin_;
};

} // namespace elutria::dem
