#pragma once

#include "impacts/Flight.hpp"

#include <algorithm>
#include <cmath>

// When do two particles in free flight, or a particle and a piece of wall, touch first?
//
// The distance of a point that moves straight from a convex body is a convex function of time, so
// its tangent bounds it from below. Of the flights' curvature only what points along the shortest
// way n between the two can close the gap further: the body lies behind the plane across n. With gap
// g, its rate g' and a bound D(s) of what the accelerations do along n,
//   gap(t + s) >= g + g' s - D(s)  until s,
// so a step to the root of the right side never passes the first touch, and steps repeat until the
// gap is closed, quadratically where the flights meet head-on. D is bounded in two ways:
//   D <= A s^2/2  root s = 2 g/(sqrt(g'^2 + 2 A g) - g')   A = acceleration along n
//   D <= B s      root s = g/(B - g')                      B = speed along n still to be gained

namespace elutria::dem
{

constexpr double never = 1e300;

struct FirstContact
{
    double time = never;      // s, of the first touch
    bool lasting = false;     // they stay close for so long that it is no single impact
};

namespace detail
{

struct Curvature { double acceleration, speed; };   // A, B

inline Curvature curvature(double acceleration, double rate)
{
    return {acceleration, rate > 0 ? acceleration/rate : never};
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
FirstContact march(double time, double end, double closed, State state)
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

/// From one to the other; where they are in one place, away from each other.
inline Vector3 direction(const Vector3& apart, double length, const Vector3& velocity)
{
    if (length > 0) return (1/length)*apart;
    const double speed = norm(velocity);
    return speed > 0 ? (1/speed)*velocity : Vector3{};
}

} // namespace detail


/// First touch of two spheres whose centres come as close as `distance`, both flights given from
/// the same moment, looked for from `begin` to `end`; `offset` is added to b's position (periodic
/// image).
inline FirstContact firstContact(const Flight& a, const Flight& b, const Vector3& offset, double distance,
                       double begin, double end)
{
    const double closed = 1e-10*distance;
    return detail::march(begin, end, closed, [&](double t)
    {
        const Flight p = a.at(t), q = b.at(t);
        const Vector3 d = p.position - q.position - offset;
        const double length = norm(d);
        const Vector3 n = detail::direction(d, length, p.velocity - q.velocity);
        const double first = dot(p.acceleration, n), second = dot(q.acceleration, n);
        detail::Curvature c = detail::curvature(std::max(second - first, 0.0), a.rate);
        if (a.rate != b.rate)
        {
            const detail::Curvature u = detail::curvature(std::abs(first), a.rate),
                                    v = detail::curvature(std::abs(second), b.rate);
            // With different rates k, A e^(-kt) spread by at most |dk| t before the end.
            const double spread = -std::expm1(-std::abs(a.rate - b.rate)*(end - t));
            c.acceleration = std::min(u.acceleration + v.acceleration,
                std::abs(first - second) + spread*std::min(u.acceleration, v.acceleration));
            c.speed = std::max(u.speed, v.speed) < 1e100 ? u.speed + v.speed : never;
        }
        return detail::Approach{length - distance, dot(p.velocity - q.velocity, n), c};
    });
}


/// First touch of a sphere and one convex piece of wall, given by its nearest point to a position.
template<class NearestPoint>
FirstContact firstWallContact(const Flight& a, double radius, double begin, double end,
                    NearestPoint nearestPoint)
{
    const double closed = 1e-10*radius;
    return detail::march(begin, end, closed, [&](double t)
    {
        const Flight p = a.at(t);
        const Vector3 d = p.position - nearestPoint(p.position);
        const double length = norm(d);
        const Vector3 n = detail::direction(d, length, p.velocity);
        const double closing = std::max(-dot(p.acceleration, n), 0.0);
        return detail::Approach{length - radius, dot(p.velocity, n),
                                detail::curvature(closing, p.rate)};
    });
}

} // namespace elutria::dem
