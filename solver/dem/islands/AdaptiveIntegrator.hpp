#pragma once

#include "core/ContactRecord.hpp"
#include "core/DisjointSets.hpp"
#include "core/StepReport.hpp"
#include "core/forEach.hpp"
#include "impacts/StochasticCollisions.hpp"
#include "islands/IslandStepper.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace elutria::dem
{

/// Moves all particles through a gas step, each with the work that its own surroundings need.
///
///  1. Free flights of all are computed exactly; a sphere bounds each swept path in a frame that
///     moves with the mean velocity.
///  2. Pairs of overlapping bounds whose relative chord, plus slack for its curvature, comes within
///     touch are candidates; so is a particle whose flight meets a wall.
///  3. A particle without candidate has its flight as its result. The others form islands, the
///     connected components of candidates, and each island is stepped on its own (IslandStepper).
///  4. A path that an impact or a contact has changed is checked against all particles outside its
///     island, on theirs. A hit merges the islands, which start again from the saved state, until
///     none is left: merging can only go on until all is one island.
///  5. An overlap without a contact history is nobody's contact (a feed that put spheres into each
///     other): the two are moved apart before the step, their centre of mass kept, without
///     touching velocities, so that no energy comes out of it.
///  6. Spheres of many particles meet by chance instead (weights.hpp). A step too long for its
///     density, where candidates crowd, is cut into halves. Where most particles touch, halving no
///     longer helps, or the step is but a few sub-steps long, all take the soft law (the plain
///     engine), until few touch.
///
/// Particles are handled in the order of their ids: neither the caller's order nor the number of
/// threads shows in the result.
class AdaptiveIntegrator
{
public:
    /// `soft` is the engine's own soft integrator; all references must outlive this object.
    AdaptiveIntegrator(const Settings& settings, const ContactMaterials& materials, const Walls& walls,
           SoftIntegrator& soft, IslandStepper::StepLimit stepLimit);
    AdaptiveIntegrator(const AdaptiveIntegrator&) = delete;

    void advance(Particles& particles, double duration, StepReport& report);

    std::vector<ContactRecord> exportContacts() const;
    void importContacts(const std::vector<ContactRecord>& records);

    /// Hands the contact history to the soft integrator, for a caller that asks it for forces.
    void useSoft();

private:
    enum class Outcome { done, tooLong, contactsRule };
    enum class WallLook : std::uint8_t { away, meets, touches, overlaps };   // touches: known
    struct Candidate { std::uint32_t first, second; };
    static constexpr std::uint32_t none = 0xffffffffu;
    static constexpr std::size_t block = 2048;           // particles that a thread takes at a time
    static constexpr std::size_t manyParticles = 4*block;    // worth a second thread

    static bool recordBefore(const ContactRecord& a, const ContactRecord& b)
    {
        if (a.first != b.first) return a.first < b.first;
        return a.second != b.second ? a.second < b.second : a.wall < b.wall;
    }

    unsigned threadsFor(std::size_t particles) const
    {
        return particles < manyParticles ? 1 : settings_.threads;
    }

    /// Calls work(i) for every particle, in any order.
    template<class Work>
    void forParticles(const Work& work) const
    {
        const std::size_t n = start_.size();
        forEach(threadsFor(n), (n + block - 1)/block, [&](std::size_t k)
        {
            for (std::size_t i = k*block; i < std::min(n, (k + 1)*block); ++i) work(i);
        });
    }

    /// Calls visit(i, j) for every pair of particles whose bounds overlap.
    template<class Visit>
    void forBoundPairs(const Visit& visit) const
    {
        for (std::uint32_t i = 0; i < bounds_.size(); ++i)
            for (std::uint32_t k = pairs_.begin[i]; k < pairs_.begin[i + 1]; ++k)
                visit(i, pairs_.second[k]);
    }


    void load(const Particles& particles);
    void widen(const Particles& particles);
    void store(Particles& particles) const;
    void runSoft(Particles& particles, double duration, StepReport& report);

    Outcome piece(double duration, bool mayCut, StepReport& report);
    bool bounds(double duration);
    bool crowds() const;
    void findCandidates(double duration, StepReport& report);
    void findBoundPairs();
    void checkPair(std::uint32_t i, std::uint32_t j, double duration);
    WallLook lookForWalls(std::size_t i, double duration) const;
    void separateOverlaps(StepReport& report);
    void moveOutOfWalls(ParticleState& t) const;
    void makeIslands();
    void add(std::uint32_t particle, std::uint32_t island);
    void runIslands(double duration);
    void runIsland(Island& island, IslandStepper& stepper, double duration) const;
    bool mergeIslands(double duration, StepReport& report);
    void merge(const std::vector<Candidate>& hits, StepReport& report);
    const std::vector<PathSegment>& path(std::uint32_t i, std::vector<PathSegment>& free) const;
    void finishPiece(double duration, StepReport& report);

    const Settings& settings_;
    const Walls& walls_;
    SoftIntegrator& soft_;
    IslandStepper::StepLimit stepLimit_;
    ImpactTable laws_;
    std::vector<std::unique_ptr<IslandStepper>> steppers_;   // one per thread

    std::vector<ContactRecord> records_;       // sorted by first, second
    bool softRules_ = false;                  // the soft integrator steps and holds the history
    std::size_t contactEnds_ = 0;              // of the history, twice for a pair

    std::vector<std::uint32_t> order_;         // canonical index -> caller's index
    std::vector<ParticleState> start_;             // state at the start of the piece
    std::vector<Flight> ends_;                 // of the free flights
    std::vector<double> slack_;                // m, deviation from the chord
    bool weighted_ = false;                    // any of many particles, or of a share
    std::uint64_t seed_ = 0;                   // for the piece's meetings by chance
    std::vector<Bound> bounds_;                // in the frame moving with frame_
    Vector3 frame_;                            // m/s
    VectorArray centres_;
    std::vector<double> reach_;
    PairSearch search_;
    PairList pairs_;
    std::vector<Candidate> candidates_, overlaps_;    // overlaps_: without history; second none: wall
    std::vector<std::uint32_t> atWall_, touching_;
    std::vector<WallLook> wallLooks_;
    DisjointSets sets_;
    std::vector<Island> islands_;
    std::vector<std::uint32_t> islandOf_, placeIn_;   // of each particle; none: free
    std::vector<std::uint32_t> rerun_;                // islands to step in this round
    std::vector<bool> isChanged_;
};

} // namespace elutria::dem
