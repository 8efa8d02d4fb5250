#pragma once

#include "flight.hpp"

#include <algorithm>
#include <cmath>

// When do two particles in free flight, or a particle and a piece of wall, touch first?
//
// The distance of a point that moves straight from a convex body is a convex function of time, so
// its tangent bounds it from below; what the flights' curvature can add is bounded by
// Flight::tangentDeviation. With gap g, its rate g' and that bound D(s),
//   gap(t + s) >= g + g' s - D(s)  until s,
// so a step to the root of the right side never passes the first touch, and steps repeat until the
// gap is closed, quadratically where the flights meet head-on. D is bounded in two ways:
//   D <= A s^2/2  root s = 2 g/(sqrt(g'^2 + 2 A g) - g')   A = sum of the accelerations
//   D <= B s      root s = g/(B - g')                      B = sum of the speeds still to be gained

namespace elutria::dem
{

constexpr double never = 1e300;

struct Meeting
{
    double time = never;      // s, when they touch
    bool lasting = false;     // they stay too close for too long: not a matter of one impact
};

namespace detail
{

struct Curvature { double acceleration, speed; };   // A, B

inline Curvature curvature(const Flight& f)
{
    const double a = norm(f.acceleration);
    return {a, f.rate > 0 ? a/f.rate : never};
}

inline double safeStep(double gap, double rate, const Curvature& c)
{
    const double root = std::sqrt(rate*rate + 2*c.acceleration*gap);
    double step = never;
    if (rate < 0) step = 2*gap/(root - rate);
    else if (c.acceleration > 0) step = (root + rate)/c.acceleration;
    if (c.speed < 1e100)
        step = c.speed > rate ? std::max(step, gap/(c.speed - rate)) : never;
    return step;
}

/// Marches to the first touch before `end`. `state(t)` gives gap, its rate and the curvature.
template<class State>
Meeting march(double time, double end, double closed, State state)
{
    constexpr int manySteps = 60;
    for (int i = 0; i < manySteps; ++i)
    {
        const auto s = state(time);
        if (s.gap <= closed && s.rate < 0) return {time, false};
        const double step = safeStep(std::max(s.gap, 0.0), s.rate, s.curvature);
        time += step;
        if (!(time < end)) return {};
        if (s.gap <= closed && step <= 1e-12*end) break;
    }
    return {time, true};
}

struct Approach { double gap, rate; Curvature curvature; };

} // namespace detail


/// First touch of two spheres whose centres come as close as `distance`, both flights given from
/// the same moment, looked for from `begin` to `end`; `offset` is added to b's position (periodic
/// image).
inline Meeting meeting(const Flight& a, const Flight& b, const Vector3& offset, double distance,
                       double begin, double end)
{
    const double closed = 1e-10*distance;
    return detail::march(begin, end, closed, [&](double t)
    {
        const Flight p = a.at(t), q = b.at(t);
        const Vector3 d = p.position - q.position - offset;
        const double length = norm(d);
        detail::Curvature c;
        if (a.rate == b.rate)
        {
            c.acceleration = norm(p.acceleration - q.acceleration);
            c.speed = a.rate > 0 ? c.acceleration/a.rate : never;
        }
        else
        {
            const detail::Curvature u = detail::curvature(p), v = detail::curvature(q);
            // With different rates k, A e^(-kt) spread by at most |dk| t before the end.
            const double spread = -std::expm1(-std::abs(a.rate - b.rate)*(end - t));
            c.acceleration = std::min(u.acceleration + v.acceleration,
                norm(p.acceleration - q.acceleration)
                + spread*std::min(u.acceleration, v.acceleration));
            c.speed = std::max(u.speed, v.speed) < 1e100 ? u.speed + v.speed : never;
        }
        const double rate =
            length > 0 ? dot(p.velocity - q.velocity, d)/length
                       : norm(p.velocity - q.velocity);
        return detail::Approach{length - distance, rate, c};
    });
}


/// First touch of a sphere and one convex piece of wall, given by its nearest point to a position.
template<class NearestPoint>
Meeting wallMeeting(const Flight& a, double radius, double begin, double end,
                    NearestPoint nearestPoint)
{
    const double closed = 1e-10*radius;
    return detail::march(begin, end, closed, [&](double t)
    {
        const Flight p = a.at(t);
        const Vector3 d = p.position - nearestPoint(p.position);
        const double length = norm(d);
        const double rate =
            length > 0 ? dot(p.velocity, d)/length : norm(p.velocity);
        return detail::Approach{length - radius, rate, detail::curvature(p)};
    });
}

} // namespace elutria::dem
