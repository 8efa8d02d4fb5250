#include "islands/FreeFlight.hpp"

#include "core/forEach.hpp"

#include <algorithm>

namespace elutria::dem
{

bool flyFreely(const Piece& piece, const Settings& settings, FreeFlights& flights)
{
    const std::vector<ParticleState>& start = piece.start;
    const std::size_t n = start.size();
    flights.end.resize(n), flights.slack.resize(n), flights.bounds.resize(n);
    forElements(settings.threads, n,
                [&](std::size_t i) { flights.end[i] = start[i].flight.at(piece.duration); });
    Vector3 frame;
    for (std::size_t i = 0; i < n; ++i) frame += flights.end[i].position - start[i].flight.position;
    frame *= 1/(piece.duration*double(n));
    flights.frame = frame;
    forElements(settings.threads, n, [&](std::size_t i)
    {
        const Flight& flight = start[i].flight;
        const Vector3 moved = flights.end[i].position - flight.position - piece.duration*frame;
        flights.slack[i] = flight.chordDeviation(piece.duration);
        flights.bounds[i] = {flight.position + 0.5*moved,
                             start[i].reach + 0.5*norm(moved) + flights.slack[i]};
    });
    double largest = 0;
    for (const Bound& bound : flights.bounds) largest = std::max(largest, bound.reach);
    for (int axis = 0; axis < 3; ++axis)
        if (settings.box.periodic[axis]
            && 4*largest > settings.box.high[axis] - settings.box.low[axis]) return false;
    return true;
}

} // namespace elutria::dem
