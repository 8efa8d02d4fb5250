#include "islands/FreeFlight.hpp"

#include "core/forEach.hpp"

#include <algorithm>

namespace elutria::dem
{

bool flyFreely(const Piece& piece, const Settings& settings, FreeFlights& flights)
{
    fly(piece, settings, 0, flights);
    flights.frame = (1/(piece.duration*double(piece.start.size())))*sumOfWays(piece, flights);
    return bound(piece, settings, 0, flights);
}


void fly(const Piece& piece, const Settings& settings, std::size_t first, FreeFlights& flights)
{
    flights.resize(piece.start.size());
    forElements(settings.threads, piece.start.size() - first, [&](std::size_t i)
    {
        flights.end[first + i] = piece.start[first + i].flight.at(piece.duration);
    });
}


Vector3 sumOfWays(const Piece& piece, const FreeFlights& flights)
{
    Vector3 sum;
    for (std::size_t i = 0; i < piece.start.size(); ++i)
        sum += flights.end[i].position - piece.start[i].flight.position;
    return sum;
}


bool bound(const Piece& piece, const Settings& settings, std::size_t first, FreeFlights& flights)
{
    forElements(settings.threads, piece.start.size() - first, [&](std::size_t k)
    {
        const std::size_t i = first + k;
        const Flight& flight = piece.start[i].flight;
        const Vector3 moved =
            flights.end[i].position - flight.position - piece.duration*flights.frame;
        flights.slack[i] = flight.chordDeviation(piece.duration);
        flights.bounds[i] = {flight.position + 0.5*moved,
                             piece.start[i].reach + 0.5*norm(moved) + flights.slack[i]};
    });
    double largest = 0;
    for (const Bound& b : flights.bounds) largest = std::max(largest, b.reach);
    for (int axis = 0; axis < 3; ++axis)
        if (settings.box.periodic[axis]
            && 4*largest > settings.box.high[axis] - settings.box.low[axis]) return false;
    return true;
}

} // namespace elutria::dem
