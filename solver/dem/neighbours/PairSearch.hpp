#pragma once

#include "core/PeriodicBox.hpp"
#include "core/Untouched.hpp"
#include "laws/Settings.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace elutria::dem
{

/// Spheres as the neighbour searches see them: borrowed arrays of equal length, positions
/// `stride` doubles from one to the next.
struct Spheres
{
    std::size_t size;
    const double *x, *y, *z;
    const double* radius;     // m
    double skin = 0;          // m; neighbours are closer than the sum of radii plus the skin
    std::size_t stride = 1;   // of the positions

    double reach(std::size_t i) const { return radius[i] + 0.5*skin; }
    Vector3 position(std::size_t i) const { return {x[i*stride], y[i*stride], z[i*stride]}; }
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

/// All pairs of neighbours, each once, by first: those of `i` are
/// second[begin[i]] .. second[begin[i + 1] - 1], ascending, all above i.
struct PairList
{
    Untouched<std::uint32_t> begin, second;

    std::size_t size() const { return second.size(); }
    std::vector<Pair> pairs() const;
};

struct SearchGrids;

/// Finds all pairs of neighbours; periodic directions by the shortest image, for which the box must
/// be at least twice the largest sum of reaches wide.
///  bruteForce              every pair is tried
///  cells                   one grid; `cellLayers` layers of cells span the largest reach
///  verlet                  one grid with cells as wide as the largest reach
///  hierarchical, automatic grids of doubling width, each particle in the one of its size
/// The result does not depend on the method nor on the number of threads.
/// Keeps its memory for the next search.
class PairSearch
{
public:
    PairSearch();
    ~PairSearch();

    void find(const Spheres& spheres, const PeriodicBox& box, NeighbourSearch method,
              int cellLayers, unsigned threads, PairList& list);

    /// Of the same pairs those with at least one of the spheres `asked`, which are few; each is named
    /// once.
    void findWith(const std::vector<std::uint32_t>& asked, const Spheres& spheres,
                  const PeriodicBox& box, unsigned threads, PairList& list);

private:
    void start(unsigned threads, const PairList& list);

    std::unique_ptr<SearchGrids> grids_;
    std::vector<char> isAsked_;
};

/// The same in one array of pairs, ascending.
std::vector<Pair> findPairs(const Spheres& spheres, const PeriodicBox& box, NeighbourSearch method,
                            int cellLayers = 1);

} // namespace elutria::dem
