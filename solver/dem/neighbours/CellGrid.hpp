#pragma once

#include "core/PeriodicBox.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace elutria::dem
{

/// Cells over the spheres of one size class. Entries of all grids lie in one array, sorted by cell,
/// x fastest; begin[c] is the first entry of cell c.
struct Grid
{
    double largestReach = 0;        // m
    std::size_t spheres = 0;
    std::size_t firstCell = 0;      // among the cells of all grids
    bool halves = false;            // cells meet their neighbours from one side only

    /// Cells at least `width` wide, wider where the grid would outgrow its spheres.
    void shape(const PeriodicBox& box, const Vector3& lowest, const Vector3& highest, double width)
    {
        Vector3 length;
        for (int a = 0; a < 3; ++a)
        {
            periodic_[a] = box.periodic[a];
            low_[a] = periodic_[a] ? box.low[a] : lowest[a];
            length[a] = (periodic_[a] ? box.high[a] : highest[a]) - low_[a];
        }
        for (;; width *= 1.26)
        {
            double count = 1;
            for (int a = 0; a < 3; ++a) count *= std::max(1.0, std::floor(length[a]/width));
            if (count <= 2.0*double(spheres) + 64) break;
        }
        halves = true;
        for (int a = 0; a < 3; ++a)
        {
            cells_[a] = std::max(1, int(length[a]/width));
            inverse_[a] = length[a] > 0 ? cells_[a]/length[a] : 0;
            const double layers = std::floor(2*largestReach*inverse_[a]) + 1;
            halves = halves && (!periodic_[a] || 2*layers + 1 <= cells_[a]);
        }
    }

    std::size_t size() const { return std::size_t(cells_[0])*cells_[1]*cells_[2]; }

    std::size_t cellOf(const Vector3& x) const
    {
        return row(along(1, x.y), along(2, x.z)) + along(0, x.x);
    }

    /// Calls visit(first, last) for runs of entries, among them all within `reach` of x.
    template<class Visit>
    void around(const Vector3& x, double reach, const std::uint32_t* begin,
                const Visit& visit) const
    {
        const Range rx = range(0, x.x, reach), ry = range(1, x.y, reach), rz = range(2, x.z, reach);
        for (int cz = rz.from; cz <= rz.to; ++cz)
        {
            for (int cy = ry.from; cy <= ry.to; ++cy) runs(row(cy, cz), rx, begin, visit);
        }
    }

    /// The same for entry k at x, which meets what follows it in its row and in the rows behind;
    /// the others meet it. Only where `halves`.
    template<class Visit>
    void behind(std::uint32_t k, const Vector3& x, double reach, const std::uint32_t* begin,
                const Visit& visit) const
    {
        const Range rx = range(0, x.x, reach), ry = range(1, x.y, reach), rz = range(2, x.z, reach);
        const int y = along(1, x.y), z = along(2, x.z);
        visit(k + 1, begin[row(y, z) + std::min(rx.to, cells_[0] - 1) + 1]);
        runs(row(y, z), {cells_[0], rx.to}, begin, visit);
        for (int cy = y + 1; cy <= ry.to; ++cy) runs(row(cy, z), rx, begin, visit);
        for (int cz = z + 1; cz <= rz.to; ++cz)
        {
            for (int cy = ry.from; cy <= ry.to; ++cy) runs(row(cy, cz), rx, begin, visit);
        }
    }

private:
    struct Range
    {
        int from, to;
    };

    int along(int a, double x) const
    {
        return std::clamp(int((x - low_[a])*inverse_[a]), 0, cells_[a] - 1);
    }

    int wrapped(int a, int c) const
    {
        return c < 0 ? c + cells_[a] : c >= cells_[a] ? c - cells_[a] : c;
    }

    /// First cell of a row.
    std::size_t row(int cy, int cz) const
    {
        return firstCell + (std::size_t(wrapped(2, cz))*cells_[1] + wrapped(1, cy))*cells_[0];
    }

    /// Cells within `reach` of x along an axis, not wrapped.
    Range range(int a, double x, double reach) const
    {
        // limited before they become integers: particles may lie in a plane but for rounding
        const double first = std::floor((x - reach - low_[a])*inverse_[a]);
        const double last = std::floor((x + reach - low_[a])*inverse_[a]);
        const int from = int(std::max(first, -1.0*cells_[a]));
        const int to = int(std::min(last, 2.0*cells_[a]));
        if (!periodic_[a]) return {std::max(from, 0), std::min(to, cells_[a] - 1)};
        return to - from >= cells_[a] ? Range{0, cells_[a] - 1} : Range{from, to};
    }

    template<class Visit>
    void runs(std::size_t row, Range cells, const std::uint32_t* begin, const Visit& visit) const
    {
        for (int c = cells.from; c <= cells.to;)
        {
            const int start = wrapped(0, c), more = std::min(cells.to - c, cells_[0] - 1 - start);
            visit(begin[row + start], begin[row + start + more + 1]);
            c += more + 1;
        }
    }

    bool periodic_[3];
    Vector3 low_;
    int cells_[3];
    double inverse_[3];             // 1/m, of the cells' width
};

} // namespace elutria::dem
