#pragma once

#include "Vector3.hpp"
#include "kernels.hpp"
#include "search.hpp"

#include <vector>

namespace elutria::dem
{

/// How far particles can have come towards each other, chunk by chunk.
///
/// Each chunk of particles has a frame that moves with its mean velocity; the way of its fastest
/// particle in that frame is summed over the steps. Two particles of chunks a and b can have
/// approached by no more than the ways of a and b since then and the distance that the two frames
/// have shifted against each other.
class Drift
{
public:
    /// Starts anew for a neighbour list.
    void reset(const PairList& list, std::size_t particles, std::size_t chunkSize);

    /// Frame of a chunk for the next step, m/s; set from the mean velocity of the last one.
    const Vector3& frame(std::size_t chunk) const { return chunks_[chunk].frame; }
    void setFrame(std::size_t chunk, const Vector3& frame) { chunks_[chunk].frame = frame; }

    /// Adds the step that `work` has done in the chunk's frame.
    void add(std::size_t chunk, const MoveWork& work);
    /// Adds a way from outside the steps, for all chunks.
    void add(double way);

    /// Most that pairs owned by the chunk can have approached since reset(), m.
    double sinceReset(std::size_t chunk) const;
    /// The same since mark(chunk).
    double sinceMark(std::size_t chunk) const;
    void mark(std::size_t chunk);

    /// Way of the chunk's fastest particle since markWalls(), at rest with the walls, m.
    double sinceWalls(std::size_t chunk) const { return chunks_[chunk].wallWay; }
    void markWalls(std::size_t chunk) { chunks_[chunk].wallWay = 0; }

    /// Speed of the chunk's fastest particle, m/s: in its frame and with the walls at rest.
    double speed(std::size_t chunk) const { return chunks_[chunk].speed; }
    double speed() const;                // of all chunks
    std::size_t chunks() const { return chunks_.size(); }
    double wallSpeed(std::size_t chunk) const { return chunks_[chunk].wallSpeed; }
    void setSpeeds(std::size_t chunk, double speed, double wallSpeed)
    {
        chunks_[chunk].speed = speed, chunks_[chunk].wallSpeed = wallSpeed;
    }
    std::size_t bytes() const;

private:
    struct Mark
    {
        double way;
        Vector3 shift;
    };
    struct Chunk
    {
        Vector3 frame, shift;            // m/s, m
        double way = 0, wallWay = 0;     // m
        double speed = 0, wallSpeed = 0; // m/s
        std::vector<std::uint32_t> neighbours;      // chunks of its pairs' second particles
        std::vector<Mark> marks;         // of itself and its neighbours
    };

    std::vector<Chunk> chunks_;
};

} // namespace elutria::dem
