#pragma once

#include "core/Vector3.hpp"

#include <array>
#include <cmath>

namespace elutria::dem
{

/// Directions in which space repeats; low and high matter only where periodic.
struct PeriodicBox
{
    Vector3 low, high;                              // m
    std::array<bool, 3> periodic{false, false, false};

    bool any() const { return periodic[0] || periodic[1] || periodic[2]; }

    /// Nearest whole number, for |a| < 2^51: the sum has no digits behind the point.
    static double nearest(double a)
    {
        constexpr double shift = 6755399441055744.0;      // 1.5*2^52
        return (a + shift) - shift;
    }

    /// Shortest image of a difference of two positions.
    Vector3 shortest(Vector3 difference) const
    {
        for (int axis = 0; axis < 3; ++axis)
        {
            if (!periodic[axis]) continue;
            const double length = high[axis] - low[axis];
            if (std::abs(difference[axis]) <= 0.5*length) continue;      // mostly: no division
            difference[axis] -= length*nearest(difference[axis]/length);
        }
        return difference;
    }

    /// Way from the shortest image of a difference to the difference: whole lengths of the box.
    Vector3 image(const Vector3& difference) const
    {
        Vector3 way;
        for (int axis = 0; axis < 3; ++axis)
        {
            if (!periodic[axis]) continue;
            const double length = high[axis] - low[axis];
            if (std::abs(difference[axis]) <= 0.5*length) continue;
            way[axis] = length*nearest(difference[axis]/length);
        }
        return way;
    }

    /// The image of a position inside [low, high).
    Vector3 wrapped(Vector3 position) const
    {
        for (int axis = 0; axis < 3; ++axis)
        {
            if (!periodic[axis]) continue;
            const double length = high[axis] - low[axis];
            position[axis] -= length*std::floor((position[axis] - low[axis])/length);
            if (position[axis] >= high[axis]) position[axis] = low[axis];
        }
        return position;
    }
};

} // namespace elutria::dem
