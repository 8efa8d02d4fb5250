#pragma once

#include "islands/BoundPairs.hpp"
#include "islands/Ghosts.hpp"
#include "islands/IslandPartition.hpp"
#include "islands/IslandStepper.hpp"
#include "islands/Piece.hpp"
#include "islands/SharedIslands.hpp"

#include <vector>

namespace elutria::dem
{

/// Last stage: a path that an impact or a contact has changed is checked against the paths of all
/// particles outside its island.
class PathCheck
{
public:
    /// All references must outlive this object.
    PathCheck(const Settings& settings, BoundPairs& boundPairs)
      : settings_(settings), boundPairs_(boundPairs)
    {}

    /// The pairs that touch on the new paths of the islands just `stepped`; `bounds` (in the moving
    /// frame) become those of the new paths.
    std::vector<Pair> find(const Piece& piece, const IslandPartition& partition,
                           const std::vector<IslandResult>& results,
                           const std::vector<std::uint32_t>& stepped, const Vector3& frame,
                           std::vector<Bound>& bounds);

    /// Particles whose paths the last find() saw changed, ascending for each island.
    const std::vector<std::uint32_t>& changed() const { return changed_; }

    /// The pairs of a ghost and an own particle that touch, where they share no island.
    std::vector<IdPair> meetGhosts(const Piece& piece, const IslandPartition& partition,
                                   const std::vector<IslandResult>& results,
                                   const SharedIslands& shared, const std::vector<GhostPath>& ghosts,
                                   const Vector3& frame, const std::vector<Bound>& bounds);

private:
    template<class Check>
    void checkFew(const std::vector<std::uint32_t>& changed, const std::vector<Bound>& bounds,
                  const Check& check) const;

    const Settings& settings_;
    BoundPairs& boundPairs_;
    std::vector<std::uint32_t> changed_;
    std::vector<bool> isChanged_;
};

/// An own particle's path in a piece; `free` is room for one that nothing has changed.
const Path& pathOf(std::uint32_t i, const Piece& piece, const IslandPartition& partition,
                   const std::vector<IslandResult>& results, Path& free);

/// Whether two spheres meet before `duration` on their paths.
bool pathsMeet(const ParticleState& a, const Path& pathA, const ParticleState& b,
               const Path& pathB, std::uint64_t seed, const PeriodicBox& box, double duration);

/// Bound of a whole path, in a frame that moves with `frame`.
Bound boundOf(const Path& path, double radius, double duration, const Vector3& frame);

} // namespace elutria::dem
