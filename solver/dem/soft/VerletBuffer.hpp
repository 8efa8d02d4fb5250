#pragma once

#include "neighbours/PairSearch.hpp"
#include "soft/Chunks.hpp"
#include "soft/SoftCloud.hpp"

#include <vector>

namespace elutria::dem
{

/// How chunks of particles move: a frame goes with each chunk's mean velocity.
struct ChunkMotion
{
    Vector3 frame;                       // m/s
    double speed = 0, wallSpeed = 0;     // m/s, of the fastest: in the frame, at rest with the walls
    double wallWay = 0;                  // m, of the fastest since walls were collected
};

/// For each chunk the others that its particles may meet.
using ChunkNeighbours = std::vector<std::vector<std::uint32_t>>;

/// Neighbours are chunks whose boxes around all surfaces are nearer than `reach`, m.
ChunkNeighbours chunkNeighbours(const SoftCloud& cloud, const Chunks& chunks, double reach);

/// Verlet buffer of a neighbour list, particle by particle, and what is left of it.
///
/// A list holds the pairs whose gap is below the sum of both buffers. A particle's buffer is its speed
/// times the planned rebuild interval plus a margin that each chunk adapts from the last interval: a
/// few fast particles make the lists of the others neither long nor short-lived. Between steps only
/// bounds are kept, by chunk: displacements add up in the chunk's frame, frames shift against each
/// other. measure() replaces the accumulated bound by the true displacement, which is smaller for
/// oscillating particles.
class VerletBuffer
{
public:
    /// Forgets the adapted margins.
    void forget() { runs_ = Chunks(), chunks_.clear(), anchors_.clear(); }

    /// Chunks that were there before keep what they have.
    void resize(const Chunks& chunks);
    std::size_t chunks() const { return runs_.count(); }

    /// First guess of the speed by which a chunk's margin grows, m/s.
    void expect(std::size_t chunk, double rate);
    /// Adapts the margin to what measure() found after `elapsed` s, neighbouring chunks' shifts
    /// included.
    void learn(std::size_t chunk, double elapsed, const ChunkNeighbours& neighbours);
    /// Mean speed at which buffers are consumed, m/s.
    double meanRate() const;

    /// Gives all particles of the chunk a new buffer for `interval` s, from `least` to `most`, m,
    /// and at least twice that of `others`.
    void grant(std::size_t chunk, const SoftCloud& cloud, const Vector3& frame, double interval,
               double least, double most, const VerletBuffer* others = nullptr);
    /// The same, equal for all, m.
    void grant(std::size_t chunk, const SoftCloud& cloud, double equal);

    /// Subtracts the displacement of the fastest particle in the frame, and moves the frame.
    void use(std::size_t chunk, double way, const Vector3& shift);
    /// Measures what is left, less the buffers of `others`.
    void measure(std::size_t chunk, const SoftCloud& cloud, const VerletBuffer* others = nullptr);

    /// False if pairs of the chunk with its neighbours may have come closer by more than their
    /// buffers less `reserve`, m.
    bool suffices(std::size_t chunk, const ChunkNeighbours& neighbours, double reserve = 0) const;
    /// True if all chunks suffice and no two particles may have come closer by `most`, m.
    bool suffices(const ChunkNeighbours& neighbours, double most) const;
    /// Least that is left of a buffer in the chunk against what has moved by `common`, m.
    double spare(std::size_t chunk, const Vector3& common) const
    {
        return chunks_[chunk].left - norm(chunks_[chunk].shift - common);
    }
    /// Bound of the approach of any two particles, m.
    double farthest() const;

    float of(std::size_t particle) const { return anchors_[particle].buffer; }
    std::size_t bytes() const;

private:
    struct Anchor
    {
        float x, y, z;                   // m, from the chunk's origin
        float buffer;                    // m
    };
    struct Chunk
    {
        Vector3 origin, shift;           // m
        double share = 0;                // m, margin in each buffer
        double left = 0, way = 0;        // m, least left and largest displacement of a particle
        double meanWay = 0;              // m
        double rate = 0, meanRate = 0;   // m/s
        double rounding = 0;             // m, of the anchors
    };

    bool surelySuffices(double most) const;
    void anchor(std::size_t chunk, const SoftCloud& cloud);
    std::size_t begin(std::size_t c) const { return runs_.begin(c); }
    std::size_t end(std::size_t c) const { return runs_.end(c); }

    Chunks runs_;
    std::vector<Chunk> chunks_;
    Untouched<Anchor> anchors_;
};

} // namespace elutria::dem
