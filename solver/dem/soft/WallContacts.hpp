#pragma once

#include "laws/ContactForce.hpp"
#include "laws/LawTable.hpp"
#include "soft/Chunks.hpp"
#include "soft/SoftCloud.hpp"
#include "walls/Walls.hpp"

#include <utility>
#include <vector>

namespace elutria::dem
{

/// A contact of a particle of the cloud with a wall feature that lasts.
struct LastingWall
{
    std::uint32_t particle;
    std::uint64_t feature;
    Vector3 displacement;
};

/// The particles near walls, the triangles each may touch, and the history of those that do.
/// Cut into the same chunks as PairContacts.
class WallContacts
{
public:
    WallContacts(const LawTable& laws, const Walls& walls);

    /// Forgets everything and takes these contacts, ascending by particle.
    void reset(const Chunks& chunks, const std::vector<LastingWall>& lasting);

    /// Collects what particles [begin, end) may touch before one of them has moved by `margin`.
    /// Returns the way it holds for: the margin, or more where no wall is near.
    double refresh(std::size_t chunk, const SoftCloud& cloud, std::size_t begin, std::size_t end,
                   double margin);

    /// True if walls are near particles of the chunk.
    bool near(std::size_t chunk) const { return chunks_[chunk].count > 0; }

    /// Adds the forces of the walls to the loads of a chunk's particles; `time` (s) is that of hits.
    void evaluate(std::size_t chunk, SoftCloud& cloud, StepWeights weights, double time);

    double takeLargestOverlap();
    /// Hits since the last call, of walls that answer, with times as they were given.
    std::vector<WallHit> takeHits();
    std::vector<LastingWall> lasting() const;
    std::size_t touching() const;
    std::size_t bytes() const;

private:
    using Memory = std::pair<std::uint64_t, ContactHistory>;
    struct Candidate
    {
        std::uint32_t particle;
        std::uint32_t below;                    // of images, where they are flat
        bool flat;
        std::vector<Walls::Image> images;
        std::vector<Memory> memories;
    };
    struct Chunk
    {
        std::vector<Candidate> current, next;
        std::size_t count = 0;                  // of current in use
        double margin = 0, largestOverlap = 0;
        std::vector<WallContact> found;
        std::vector<Memory> kept;
        std::vector<WallHit> hits;
    };

    const LawTable& laws_;
    const Walls& walls_;
    std::vector<Chunk> chunks_;
};

} // namespace elutria::dem
