#pragma once

#include "impacts/Flight.hpp"

#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// A sphere during one gas step; `flight` is given at the time reached so far.
struct ParticleState
{
    std::uint64_t id = 0;
    std::uint32_t material = 0;
    bool taken = false;            // by a wall: it rests and meets nothing
    double radius = 0, mass = 0;   // m, kg
    double weight = 1;             // statistical: particles that it stands for
    double reach = 0;              // m: the radius, or the range of stochastic collisions
    double enskogFactor = 1;       // g0: collision rate over that of a dilute cloud
    Flight flight;
    Vector3 spin;                  // rad/s
    Vector3 force;                 // m/s^2: constant acceleration, without drag
    Vector3 gasVelocity;           // m/s
    Vector3 dragGain;              // m/s: velocity received from the drag so far

    /// Rests where it is, from now on.
    void rest()
    {
        taken = true;
        force = spin = {};
        const Vector3 place = flight.position;
        flight = {};
        flight.position = place;
    }
};

/// A segment of a path: a flight from `begin` on, known to within `slack`.
struct PathSegment
{
    double begin = 0;              // s
    Flight flight;
    double slack = 0;              // m
};

/// Segments in order of time, each up to the next one's begin.
using Path = std::vector<PathSegment>;

/// A sphere that holds a path during some time, radius included.
struct Bound
{
    Vector3 centre;                // m
    double reach = 0;              // m
};

/// Bound of a flight of `duration`, in a frame that moves with `frame` (m/s).
inline Bound boundOf(const Flight& flight, double radius, double duration, const Vector3& frame = {})
{
    const Vector3 moved = flight.at(duration).position - flight.position - duration*frame;
    return {flight.position + 0.5*moved,
            radius + 0.5*norm(moved) + flight.chordDeviation(duration)};
}

} // namespace elutria::dem
