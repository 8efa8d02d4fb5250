#pragma once

#include "core/Vector3.hpp"

#include <algorithm>
#include <cmath>

// Exact motion of a particle without contacts, under a forcing that is constant in time:
//   dv/dt = a + k (u - v)
// With the initial acceleration A = a + k (u - v_0) and s = k t
//   v(t) = v_0 + A t phi1(s),        phi1(s) = (1 - exp(-s))/s
//   x(t) = x_0 + v_0 t + A t^2 phi2(s), phi2(s) = (s - 1 + exp(-s))/s^2
// so that k = 0 is ballistic flight and k t -> infinity drifts with u + a/k.

namespace elutria::dem
{

/// phi1 and phi2 above, to rounding for any s >= 0.
struct FlightFactors
{
    double phi1, phi2, decay;                      // decay = exp(-s)

    explicit FlightFactors(double s)
    {
        if (s < 0.125)
        {
            // Taylor series of phi2; its first term left out is below 1e-17.
            double term = 0;
            for (int n = 11; n >= 3; --n) term = (1 - term)*s/n;
            phi2 = 0.5*(1 - term);
            phi1 = 1 - s*phi2;
            decay = 1 - s*phi1;
        }
        else
        {
            decay = std::exp(-s);
            phi1 = (1 - decay)/s;
            phi2 = (1 - phi1)/s;
        }
    }
};

/// A free flight: state at time 0 and the forcing in the form above.
struct Flight
{
    Vector3 position, velocity;                    // m, m/s
    Vector3 acceleration;                          // m/s^2: A, at time 0
    double rate = 0;                               // 1/s: k >= 0

    Flight() = default;
    Flight(const Vector3& x, const Vector3& v, const Vector3& force, const Vector3& gasVelocity,
           double dragRate)
        : position(x), velocity(v), acceleration(force + dragRate*(gasVelocity - v)),
          rate(dragRate)
    {}

    /// The same flight, seen from `time` on.
    Flight at(double time) const
    {
        const FlightFactors f(rate*time);
        Flight later;
        later.position = position + time*velocity + (time*time*f.phi2)*acceleration;
        later.velocity = velocity + (time*f.phi1)*acceleration;
        later.acceleration = f.decay*acceleration;
        later.rate = rate;
        return later;
    }

    /// Velocity gained from the drag alone during `time`, m/s; `force` is a.
    Vector3 dragGain(double time, const Vector3& force) const
    {
        const double s = rate*time;
        const FlightFactors f(s);
        if (s > 1) return (time*f.phi1)*acceleration - time*force;
        return time*(acceleration - force - (s*f.phi2)*acceleration);
    }

    /// Bound of the distance between path and chord during `time`, m.
    double chordDeviation(double time) const
    {
        const double a = norm(acceleration), s = rate*time;
        return a*time*time*(s > 2.8284271247461903 ? 1/(s*s) : 0.125);
    }
};

} // namespace elutria::dem
