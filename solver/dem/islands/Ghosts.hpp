#pragma once

#include "islands/FreeFlight.hpp"
#include "islands/Piece.hpp"
#include "laws/Settings.hpp"
#include "parallel/Hull.hpp"

#include <vector>

namespace elutria::dem
{

/// A path of another rank's particle that a contact has changed.
struct GhostPath
{
    ParticleState start;
    std::uint64_t island;            // shared island that it is in, or SharedIslands::none
    Path path;
};

/// Fetches the particles of other ranks that could meet own ones: those whose bounds reach into the
/// hull of the own bounds.
class Ghosts
{
public:
    /// Both references must outlive this object.
    Ghosts(const Settings& settings, Exchange& exchange) : settings_(settings), exchange_(exchange) {}

    /// Tells all where the own particles fly. Returns the sum of all ranks' numbers.
    std::size_t announce(const std::vector<Bound>& bounds, std::size_t number);

    /// Ghosts of the last hulls announced, with the contacts of which they are the first.
    void fetch(const Piece& piece, const std::vector<Bound>& bounds,
               std::vector<ParticleState>& ghosts, std::vector<ContactRecord>& contacts);

    /// The same of changed paths. pathOf(i) and islandOf(i) are asked for the own ones in `changed`.
    template<class PathOf, class IslandOf>
    std::vector<GhostPath> fetchPaths(const Piece& piece, const std::vector<std::uint32_t>& changed,
                                      const std::vector<Bound>& bounds, const PathOf& pathOf,
                                      const IslandOf& islandOf);

private:
    /// Calls send(r) for every other rank whose hull a bound touches.
    template<class Send>
    void forEachTouched(const Bound& bound, const Send& send) const
    {
        for (std::size_t r = 0; r < hulls_.size(); ++r)
            if (int(r) != exchange_.rank() && hulls_[r].touches(bound, settings_.box)) send(r);
    }

    const Settings& settings_;
    Exchange& exchange_;
    std::vector<Hull> hulls_;                  // of each rank
};


template<class PathOf, class IslandOf>
std::vector<GhostPath> Ghosts::fetchPaths(const Piece& piece,
                                          const std::vector<std::uint32_t>& changed,
                                          const std::vector<Bound>& bounds, const PathOf& pathOf,
                                          const IslandOf& islandOf)
{
    std::vector<Outgoing> toEach(exchange_.ranks());
    for (const std::uint32_t i : changed)
        forEachTouched(bounds[i], [&](std::size_t r)
        {
            toEach[r] << piece.start[i] << islandOf(i) << pathOf(i);
        });
    std::vector<GhostPath> paths;
    for (const Bytes& bytes : exchange_.swap(taken(toEach)))
        for (Incoming in(bytes); !in.atEnd();)
        {
            GhostPath& ghost = paths.emplace_back();
            in >> ghost.start >> ghost.island >> ghost.path;
        }
    return paths;
}

} // namespace elutria::dem
