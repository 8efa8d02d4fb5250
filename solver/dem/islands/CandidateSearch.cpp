#include "islands/CandidateSearch.hpp"

#include "core/forEach.hpp"
#include "impacts/EventDriven.hpp"
#include "impacts/FirstContact.hpp"
#include "impacts/StochasticCollisions.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

namespace
{

/// Squared distance of the origin from the segment d + s*along, 0 <= s <= 1.
double squaredDistanceOfSegment(const Vector3& d, const Vector3& along)
{
    const double length2 = squaredNorm(along);
    const double s = length2 > 0 ? std::clamp(-dot(d, along)/length2, 0.0, 1.0) : 0;
    return squaredNorm(d + s*along);
}

} // namespace


void CandidateSearch::find(const Piece& piece, const FreeFlights& flights, Candidates& found)
{
    found.clear();
    boundPairs_.find(flights.bounds);
    boundPairs_.forEach([&](std::uint32_t i, std::uint32_t j)
    {
        if (i >= piece.own()) return;          // two ghosts: their own ranks look at them
        if (piece.start[i].id < piece.start[j].id) checkPair(piece, flights, i, j, found);
        else checkPair(piece, flights, j, i, found);
    });
    if (walls_.empty()) return;
    wallLooks_.resize(piece.own());
    forElements(settings_.threads, wallLooks_.size(),
                [&](std::size_t i) { wallLooks_[i] = lookForWalls(piece, flights, i); });
    for (std::uint32_t i = 0; i < wallLooks_.size(); ++i)
    {
        if (wallLooks_[i] == WallLook::away) continue;
        if (wallLooks_[i] == WallLook::overlaps) found.overlaps.push_back({i, Overlap::wall});
        if (wallLooks_[i] == WallLook::touches) found.touching.push_back(i);
        found.atWall.push_back(i);
    }
}


void CandidateSearch::checkPair(const Piece& piece, const FreeFlights& flights, std::uint32_t i,
                                std::uint32_t j, Candidates& found) const
{
    const ParticleState &first = piece.start[i], &second = piece.start[j];
    const Flight &a = first.flight, &b = second.flight;
    const Vector3 &endA = flights.end[i].position, &endB = flights.end[j].position;
    if (isWeighted(first, second))
    {
        const Passage passage(0, piece.duration, a.position, endA, b.position, endB,
                              settings_.box);
        const RandomStream stream(piece.seed, first, 0, second, 0);
        if (stochasticCollision(first, second, passage, stream) < never)
            found.pairs.push_back({i, j});
        return;
    }
    const Vector3 centres = flights.bounds[i].centre - flights.bounds[j].centre;
    const Vector3 offset = settings_.box.image(centres);
    const Vector3 apart = a.position - b.position - offset;
    const Vector3 moved = (endA - a.position) - (endB - b.position);
    const double sum = first.radius + second.radius;
    const double close = sum + flights.slack[i] + flights.slack[j];
    if (squaredDistanceOfSegment(apart, moved) >= close*close) return;
    const double distance2 = squaredNorm(apart);
    found.pairs.push_back({i, j});
    if (distance2 >= sum*sum) return;
    if (piece.history.holdsPair(first.id, second.id))
        found.touching.push_back(i), found.touching.push_back(j);
    else if (distance2 < sum*sum*(1 - 2*EventDriven::shallow))
        found.overlaps.push_back({i, j});
}


CandidateSearch::WallLook CandidateSearch::lookForWalls(const Piece& piece,
                                                        const FreeFlights& flights,
                                                        std::size_t i) const
{
    const Flight& flight = piece.start[i].flight;
    const double radius = piece.start[i].radius, shallow = radius*(1 - EventDriven::shallow);
    thread_local std::vector<Walls::Image> images;
    walls_.collect(flight.position, flights.end[i].position, radius + flights.slack[i], images);
    bool meets = false;
    double nearestAtStart = never;
    for (const Walls::Image& image : images)
    {
        const auto nearest = [&](const Vector3& p) { return walls_.nearestPoint(image, p); };
        const double distance = norm(flight.position - nearest(flight.position));
        nearestAtStart = std::min(nearestAtStart, distance);
        meets = meets || distance < shallow
            || firstWallContact(flight, radius, 0, piece.duration, nearest).time < never;
    }
    if (nearestAtStart < radius)
    {
        if (piece.history.holdsWall(piece.start[i].id)) return WallLook::touches;
        if (nearestAtStart < shallow) return WallLook::overlaps;
    }
    return meets ? WallLook::meets : WallLook::away;
}

} // namespace elutria::dem
