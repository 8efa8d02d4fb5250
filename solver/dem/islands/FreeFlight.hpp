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
};

/// First stage: the closed form of every particle's flight, and a sphere that bounds its path.
/// Returns false where a path is too long for the periodic box to tell images apart.
bool flyFreely(const Piece& piece, const Settings& settings, FreeFlights& flights);

} // namespace elutria::dem
