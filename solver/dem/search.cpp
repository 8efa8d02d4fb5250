#include "search.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

namespace
{

bool neighbours(const Spheres& s, const PeriodicBox& box, std::size_t i, std::size_t j)
{
    const Vector3 d = box.shortest({s.x[i] - s.x[j], s.y[i] - s.y[j], s.z[i] - s.z[j]});
    const double reach = s.reach[i] + s.reach[j];
    return squaredNorm(d) < reach*reach;
}

void bruteForce(const Spheres& s, const PeriodicBox& box, std::vector<Pair>& pairs)
{
    for (std::uint32_t i = 0; i < s.size; ++i)
    {
        for (std::uint32_t j = i + 1; j < s.size; ++j)
        {
            if (neighbours(s, box, i, j)) pairs.push_back({i, j});
        }
    }
}

/// A grid of cells over all spheres, each cell at least `width` wide.
struct Grid
{
    Vector3 low, inverse;
    int cells[3];
    bool periodic[3];

    Grid(const Spheres& s, const PeriodicBox& box, double width)
    {
        const double* coordinates[3] = {s.x, s.y, s.z};
        double extent[3];
        for (int a = 0; a < 3; ++a)
        {
            const auto range = std::minmax_element(coordinates[a], coordinates[a] + s.size);
            periodic[a] = box.periodic[a];
            low[a] = periodic[a] ? box.low[a] : *range.first;
            extent[a] = periodic[a] ? box.high[a] - low[a] : *range.second - low[a];
        }
        const double mostCells = 2.0*double(s.size) + 64;
        for (;; width *= 1.26)
        {
            double count = 1;
            for (int a = 0; a < 3; ++a) count *= std::max(1.0, std::floor(extent[a]/width));
            if (count <= mostCells) break;
        }
        for (int a = 0; a < 3; ++a)
        {
            cells[a] = std::max(1, int(std::floor(extent[a]/width)));
            inverse[a] = extent[a] > 0 ? cells[a]/extent[a] : 0;
        }
    }

    int along(int a, double x) const
    {
        int c = int(std::floor((x - low[a])*inverse[a]));
        if (periodic[a]) return ((c % cells[a]) + cells[a]) % cells[a];
        return std::clamp(c, 0, cells[a] - 1);
    }
};

void cellSearch(const Spheres& s, const PeriodicBox& box, int layers, std::vector<Pair>& pairs)
{
    const double width = 2*(*std::max_element(s.reach, s.reach + s.size))/layers;
    const Grid grid(s, box, width);
    const std::size_t count = std::size_t(grid.cells[0])*grid.cells[1]*grid.cells[2];
    std::vector<std::uint32_t> begin(count + 1, 0), cell(s.size), order(s.size);
    for (std::size_t i = 0; i < s.size; ++i)
    {
        cell[i] = std::uint32_t((std::size_t(grid.along(2, s.z[i]))*grid.cells[1]
                                 + grid.along(1, s.y[i]))*grid.cells[0] + grid.along(0, s.x[i]));
        ++begin[cell[i] + 1];
    }
    for (std::size_t c = 0; c < count; ++c) begin[c + 1] += begin[c];
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::uint32_t i = 0; i < s.size; ++i) order[next[cell[i]]++] = i;

    for (std::uint32_t i = 0; i < s.size; ++i)
    {
        const std::size_t start = pairs.size();
        int range[3][2];
        const double x[3] = {s.x[i], s.y[i], s.z[i]};
        for (int a = 0; a < 3; ++a)
        {
            const int c = grid.along(a, x[a]);
            const bool all = grid.periodic[a] && grid.cells[a] < 2*layers + 1;
            range[a][0] = all ? 0 : grid.periodic[a] ? c - layers : std::max(0, c - layers);
            range[a][1] = all ? grid.cells[a] - 1
                : grid.periodic[a] ? c + layers : std::min(grid.cells[a] - 1, c + layers);
        }
        const auto wrapped = [&](int a, int c) { return (c + grid.cells[a]) % grid.cells[a]; };
        for (int cz = range[2][0]; cz <= range[2][1]; ++cz)
        {
            for (int cy = range[1][0]; cy <= range[1][1]; ++cy)
            {
                const std::size_t row =
                    (std::size_t(wrapped(2, cz))*grid.cells[1] + wrapped(1, cy))*grid.cells[0];
                for (int cx = range[0][0]; cx <= range[0][1]; ++cx)
                {
                    const std::size_t c = row + wrapped(0, cx);
                    for (std::uint32_t k = begin[c]; k < begin[c + 1]; ++k)
                    {
                        const std::uint32_t j = order[k];
                        if (j > i && neighbours(s, box, i, j)) pairs.push_back({i, j});
                    }
                }
            }
        }
        std::sort(pairs.begin() + start, pairs.end());
    }
}

} // namespace

void findPairs(const Spheres& spheres, const PeriodicBox& box, NeighbourSearch method,
               int cellLayers, std::vector<Pair>& pairs)
{
    pairs.clear();
    if (spheres.size < 2) return;
    if (method == NeighbourSearch::bruteForce) bruteForce(spheres, box, pairs);
    else cellSearch(spheres, box, method == NeighbourSearch::cells ? cellLayers : 1, pairs);
}

} // namespace elutria::dem
