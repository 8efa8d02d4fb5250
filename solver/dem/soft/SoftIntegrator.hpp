#pragma once

#include "core/ContactRecord.hpp"
#include "core/StepReport.hpp"
#include "laws/LawTable.hpp"
#include "neighbours/PairSearch.hpp"
#include "parallel/Exchange.hpp"
#include "soft/Halo.hpp"
#include "soft/PairContacts.hpp"
#include "soft/SoftCloud.hpp"
#include "soft/VerletBuffer.hpp"
#include "soft/WallContacts.hpp"

#include <vector>

namespace elutria::dem
{

/// Moves spheres in equal sub-steps with the soft contact law.
///
/// Each sub-step follows the linear drag and the constant acceleration exactly and contacts with
/// second order (an exponential trapezoid; without drag it is velocity Verlet). With the contact
/// acceleration a and phi1, phi2 of Flight.hpp at k h:
///   x(t+h) = x + h phi1 v + h^2 phi2 (A + a)
///   v*     = exp(-k h) v + h phi1 (A + a)         predicted, for the forces of t+h
///   v(t+h) = v* + h phi2 (a(t+h) - a)
/// Between evaluations Base holds v* - h phi2 a, so that v = base + h phi2 a(t+h).
///
/// Three intervals: every sub-step moves the particles and evaluates the near pairs; these are chosen
/// anew from the neighbour list when a near buffer may be consumed; particles are sorted and the list
/// is made anew when its own buffer leaves no room for that (VerletBuffer). Buffers follow from speeds,
/// past consumption and a fixed cost model, never from a clock: the same input gives the same bits.
///
/// Particles may be distributed over ranks: then all ranks make the same calls, each with its own
/// particles. Each moves these and gets the ghosts that they could meet (Halo) in every sub-step; a pair
/// over two ranks is computed by both. Near pairs are a rank's own affair; a new list all make together.
/// A particle that is no ghost of a rank is out of its reach as long as both stay within their buffer in
/// the list and an allowance of their chunk, as seen from the common motion of all.
class SoftIntegrator
{
public:
    /// All references must outlive this object.
    SoftIntegrator(const Settings& settings, const LawTables& laws, const Walls& walls,
                   Exchange& exchange = alone());
    SoftIntegrator(const SoftIntegrator&) = delete;

    /// What a wall takes is back where it hit it at the end of at most `stepsOfTaken` sub-steps, and
    /// rests from then on. The report is of this rank's part; sub-steps and lists are the first one's.
    void run(Particles& particles, double duration, std::size_t subSteps, StepReport& report);
    static constexpr std::size_t stepsOfTaken = 32;

    void contactForces(const Particles& particles, double step, VectorArray& force,
                       VectorArray& torque);

    /// Contacts of which the first particle is an own one. What is imported is handed to its rank.
    std::vector<ContactRecord> exportContacts() const;
    void importContacts(const std::vector<ContactRecord>& records);

private:
    void load(const Particles& particles, double step);
    double loadTogether(const Particles& particles, double step);
    void keep();
    void forgetLists();
    void install();
    void install(std::vector<LastingPair>& pairs, std::vector<LastingWall>& walls);
    void rebuild();
    void rename(std::vector<LastingPair>& pairs, const Untouched<std::uint32_t>& now,
                const std::vector<std::uint64_t>& ghosts) const;
    void handRecords();
    void makeHalo();
    void measureHalo(bool listIsNew);
    bool haloHasRoom() const;
    bool haloSuffices() const;
    void followGhosts(double elapsed);
    bool agreeOnList(bool wanted);
    std::uint64_t idOf(std::uint32_t i) const;
    std::uint32_t placeOf(const std::vector<std::uint32_t>& byId, std::uint64_t id) const;
    std::size_t candidates() const;
    std::size_t touchingHere() const;
    void measureMotion();
    void measureMotion(std::size_t chunk);
    void checkBox() const;
    double widestBuffer() const;
    void grantNear(std::size_t from, std::size_t to);
    void grantBuffers(std::size_t from, std::size_t to);
    bool searchesEveryStep() const;
    void findNeighbours();
    bool refresh();
    void selectNear();
    std::vector<std::uint32_t> nearFailing(const std::vector<std::uint32_t>& among, bool reserve) const;
    bool nearSuffices();
    void refreshWalls(std::size_t chunk);
    void ensureLists();
    double nearInterval() const;
    double listInterval() const;

    void evaluate(StepWeights weights);
    void receive(std::size_t chunk, StepWeights weights);
    void start();
    void move(StepWeights weights, bool received);
    void takeMean(const Vector3& sum);
    void follow(std::size_t chunk, const MoveWork& work);
    void finish();
    void kick(std::size_t chunk, double sign);
    void runAll(Particles& particles, double duration, std::size_t subSteps, StepReport& report);
    std::vector<bool> takeHits(Particles& particles, StepReport& report);
    std::size_t bytes() const;

    const Settings& settings_;
    const Walls& walls_;
    const LawTables& laws_;
    Exchange& exchange_;
    SoftCloud cloud_;
    PairList list_;
    PairContacts contacts_;
    WallContacts atWalls_;
    VerletBuffer listBuffer_, nearBuffer_;             // of the neighbour list, of the near pairs
    std::vector<ChunkMotion> motion_;
    ChunkNeighbours neighbours_;
    double sinceList_ = 0, sinceNear_ = 0;   // s
    static constexpr double firstDensity = 3;
    double density_ = firstDensity;          // pairs per particle and radius of reach
    std::vector<ContactRecord> kept_;        // history waiting for lists, by id
    std::vector<MoveWork> works_;            // of the chunks

    double step_ = 0;
    double time_ = 0;                        // s, of the forces, since the run began
    Vector3 mean_;                           // m/s, of the predicted velocities
    bool valid_ = false;                     // lists fit the cloud
    std::vector<double> wallMargin_;         // m, of each chunk
    std::size_t rebuilds_ = 0;

    // of several ranks
    Halo halo_;
    std::size_t everyone_ = 0;               // particles of all ranks
    Vector3 sum_;                            // m/s, of the own particles' predicted velocities
    Vector3 wayOfAll_, wayOfAllNear_;        // m, common motion since lists, near pairs were made
    std::vector<double> allowance_;          // m, of each chunk, beside buffers in the list
    std::vector<double> leftForNear_;        // m, of these when near pairs were chosen
};

} // namespace elutria::dem
