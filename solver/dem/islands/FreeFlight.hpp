#pragma once

#include "islands/Piece.hpp"
#include "laws/Settings.hpp"

#include <vector>

namespace elutria::dem
{

/// Where all particles would fly if none touched anything.
struct FreeFlights
{
    std::vector<Flight> end;         // at the end of the piece
    std::vector<double> slack;       // m, largest deviation of the path from its chord
    std::vector<Bound> bounds;       // of the swept paths, in the moving frame
    Vector3 frame;                   // m/s, mean velocity of all

    void resize(std::size_t n) { end.resize(n), slack.resize(n), bounds.resize(n); }
};

/// First stage: the closed form of every particle's flight, and a sphere that bounds its path in a
/// frame that moves with the mean of all.
/// Returns false where a path is too long for the periodic box to tell images apart.
bool flyFreely(const Piece& piece, const Settings& settings, FreeFlights& flights);

/// Its two parts, for particles from `first` on: the flights, and the bounds in a frame that is given.
void fly(const Piece& piece, const Settings& settings, std::size_t first, FreeFlights& flights);
bool bound(const Piece& piece, const Settings& settings, std::size_t first, FreeFlights& flights);

/// Sum of the ways that the piece's particles fly, m.
Vector3 sumOfWays(const Piece& piece, const FreeFlights& flights);

} // namespace elutria::dem
