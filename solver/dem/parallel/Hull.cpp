#include "parallel/Hull.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace elutria::dem
{

namespace
{

constexpr int mostBoxes = 32;

/// Corners of a box that grows.
struct Corners
{
    Vector3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};

    bool empty() const { return low.x > high.x; }
    void add(const Vector3& place, double reach)
    {
        for (int axis = 0; axis < 3; ++axis)
        {
            low[axis] = std::min(low[axis], place[axis] - reach);
            high[axis] = std::max(high[axis], place[axis] + reach);
        }
    }
};

/// Cells along each axis of a box, as near to cubes as a few can be.
std::array<int, 3> divided(const Vector3& span)
{
    std::array<int, 3> cells{1, 1, 1};
    while (2*cells[0]*cells[1]*cells[2] <= mostBoxes)
    {
        int longest = 0;
        for (int axis = 1; axis < 3; ++axis)
            if (span[axis]/cells[axis] > span[longest]/cells[longest]) longest = axis;
        cells[longest] *= 2;
    }
    return cells;
}

} // namespace


Hull::Hull(const std::vector<Bound>& bounds)
{
    if (bounds.empty()) return;
    Corners centres, whole;
    for (const Bound& bound : bounds)
        centres.add(bound.centre, 0), whole.add(bound.centre, bound.reach);
    const Vector3 span = centres.high - centres.low;
    const std::array<int, 3> cells = divided(span);
    std::vector<Corners> parts(cells[0]*cells[1]*cells[2]);
    for (const Bound& bound : bounds)
    {
        int part = 0;
        for (int axis = 0; axis < 3; ++axis)
        {
            const double share = span[axis] > 0
                ? (bound.centre[axis] - centres.low[axis])/span[axis] : 0;
            part = part*cells[axis] + std::min(int(share*cells[axis]), cells[axis] - 1);
        }
        parts[part].add(bound.centre, bound.reach);
    }
    const auto add = [&](const Corners& c)
    {
        if (!c.empty()) boxes_.push_back({0.5*(c.low + c.high), 0.5*(c.high - c.low)});
    };
    add(whole);
    for (const Corners& part : parts) add(part);
}


bool Hull::touches(const Box& box, const Box& other, const PeriodicBox& space)
{
    constexpr double rounding = 1e-12;         // of the places: other ranks see it as a touch
    const Vector3 apart = space.shortest(other.centre - box.centre);
    for (int axis = 0; axis < 3; ++axis)
    {
        const double doubt =
            rounding*(std::abs(other.centre[axis]) + std::abs(box.centre[axis]) + box.half[axis]);
        if (std::abs(apart[axis]) > other.half[axis] + box.half[axis] + doubt) return false;
    }
    return true;
}


bool Hull::touches(const Box& other, const PeriodicBox& space) const
{
    if (boxes_.empty() || !touches(boxes_[0], other, space)) return false;
    return std::any_of(boxes_.begin() + 1, boxes_.end(),
                       [&](const Box& box) { return touches(box, other, space); });
}

} // namespace elutria::dem
