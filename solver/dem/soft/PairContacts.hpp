#pragma once

#include "laws/ContactForce.hpp"
#include "laws/LawTable.hpp"
#include "neighbours/PairSearch.hpp"
#include "soft/Chunks.hpp"
#include "soft/SoftCloud.hpp"
#include "soft/VerletBuffer.hpp"
#include "soft/kernels/Kernels.hpp"

#include <vector>

namespace elutria::dem
{

/// A contact between two particles of the cloud that lasts; displacement of first against second.
struct LastingPair
{
    std::uint32_t first, second;      // first < second
    float x, y, z;
};

/// The pairs that touch or nearly touch, with their history, and their forces.
///
/// Particles are cut into chunks in the cloud's order. A pair belongs to the chunk
/// of its first particle; where its second belongs to another chunk, the force on it is stored
/// and added later by that chunk, in a fixed order. So chunks can be worked on by any number of
/// threads with bitwise the same sums. The second of a pair may be a ghost: what acts on it is left
/// to its own rank, which has the pair too, with the same bits of its history.
///
/// The neighbour list holds pairs within a wide buffer, this table only those within a much smaller
/// one (near pairs); refresh() chooses them anew before any particle can have consumed it.
class PairContacts
{
public:
    PairContacts(const LawTable& laws, unsigned threads);

    const Chunks& chunks() const { return runs_; }

    /// Forgets everything and takes these contacts as touching.
    void reset(const Chunks& chunks, const std::vector<LastingPair>& lasting);

    /// Chooses the pairs of the list within their buffer; keeps the history of those that touch.
    /// After the last of the chunks, connect().
    void refresh(std::size_t chunk, const SoftCloud& cloud, const PairList& list,
                 const VerletBuffer& buffer);
    void connect();

    /// Forces of the pairs of one chunk onto its own particles; chunks may run side by side.
    void evaluate(std::size_t chunk, SoftCloud& cloud, StepWeights weights);

    /// Adds the rolling resistance of the pairs that touch, after evaluate().
    void addRolling(std::size_t chunk, SoftCloud& cloud, StepWeights weights);

    /// Adds the forces of other chunks' pairs on the particles of this one.
    void receive(std::size_t chunk, SoftCloud& cloud);

    /// True if the loads of the chunk's particles hold sums; else all are zero, whatever memory holds.
    bool loaded(std::size_t chunk) const { return chunks_[chunk].loaded; }
    void startSums(std::size_t chunk, SoftCloud& cloud);
    void forgetSums(std::size_t chunk) { chunks_[chunk].loaded = false; }

    /// Largest overlap met since the last call, over twice the effective radius.
    double takeLargestOverlap();

    /// All contacts that touch, chunk by chunk.
    std::vector<LastingPair> lasting() const;
    std::size_t touching() const;
    std::size_t size() const;
    std::size_t bytes() const;

private:
    struct Arrays
    {
        std::vector<std::uint32_t> first, second;
        std::vector<float> x, y, z;         // tangential displacement, m
        std::vector<std::uint8_t> touching;
        std::size_t count = 0;              // in use; room for contactBlock more is behind them
        std::size_t inside = 0;             // the first of them have both partners in the chunk

        void makeRoom(std::size_t more);
        void push(std::uint32_t i, std::uint32_t j, float sx, float sy, float sz,
                  std::uint8_t touches)
        {
            first[count] = i, second[count] = j;
            x[count] = sx, y[count] = sy, z[count] = sz;
            touching[count++] = touches;
        }
        std::size_t bytes() const;
    };
    struct Incoming
    {
        std::uint32_t chunk, slot, particle;
    };
    struct alignas(64) Chunk
    {
        Arrays current;
        std::vector<Contribution> across;
        std::vector<Incoming> incoming;
        float largestOverlap = 0;
        bool loaded = false, acrossActs = false;
    };
    class OldContacts;
    struct Job;

    std::size_t touching(std::size_t chunk) const;
    static Contribution transition(void* job, std::size_t k);
    static void evaluateSingly(PairWork& work);

    const LawTable& laws_;
    std::size_t kernel_;                // place in the list of laws; its size: not listed
    std::vector<laws::CoefficientsOf<float>> coefficients_;
    unsigned threads_;
    Chunks runs_;
    std::vector<Chunk> chunks_;
};

} // namespace elutria::dem
