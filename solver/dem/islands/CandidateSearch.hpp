#pragma once

#include "islands/BoundPairs.hpp"
#include "islands/FreeFlight.hpp"
#include "islands/Piece.hpp"
#include "walls/Walls.hpp"

#include <vector>

namespace elutria::dem
{

/// Two overlapping spheres, or a sphere and a wall.
struct Overlap
{
    static constexpr std::uint32_t wall = 0xffffffffu;

    std::uint32_t first, second;             // second == wall: some wall
};

/// Who could touch whom, or a wall, during a piece; numbers are places in Piece::start.
struct Candidates
{
    std::vector<Pair> pairs;
    std::vector<std::uint32_t> atWall;       // ascending
    std::vector<std::uint32_t> touching;     // particles with a contact that lasts; may repeat
    std::vector<Overlap> overlaps;           // without a contact history

    void clear() { pairs.clear(), atWall.clear(), touching.clear(), overlaps.clear(); }
};

/// Second stage: pairs of overlapping bounds whose relative chord, plus slack for its curvature,
/// comes within touch, or that a stochastic collision awaits; particles whose flight meets a wall.
class CandidateSearch
{
public:
    /// All references must outlive this object.
    CandidateSearch(const Settings& settings, const Walls& walls, BoundPairs& boundPairs)
      : settings_(settings), walls_(walls), boundPairs_(boundPairs)
    {}

    void find(const Piece& piece, const FreeFlights& flights, Candidates& found);

private:
    enum class WallLook : std::uint8_t { away, meets, touches, overlaps };   // touches: known

    void checkPair(const Piece& piece, const FreeFlights& flights, std::uint32_t i,
                   std::uint32_t j, Candidates& found) const;
    WallLook lookForWalls(const Piece& piece, const FreeFlights& flights, std::size_t i) const;

    const Settings& settings_;
    const Walls& walls_;
    BoundPairs& boundPairs_;
    std::vector<WallLook> wallLooks_;
};

} // namespace elutria::dem
