#pragma once

#include "core/ContactRecord.hpp"
#include "core/StepReport.hpp"
#include "laws/LawTable.hpp"
#include "neighbours/PairSearch.hpp"
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
class SoftIntegrator
{
public:
    /// All references must outlive this object.
    SoftIntegrator(const Settings& settings, const LawTables& laws, const Walls& walls);
    SoftIntegrator(const SoftIntegrator&) = delete;

    /// What a wall takes is back where it hit it at the end of at most `stepsOfTaken` sub-steps, and
    /// rests from then on.
    void run(Particles& particles, double duration, std::size_t subSteps, StepReport& report);
    static constexpr std::size_t stepsOfTaken = 32;

    void contactForces(const Particles& particles, double step, VectorArray& force,
                       VectorArray& torque);

    std::vector<ContactRecord> exportContacts() const;
    void importContacts(const std::vector<ContactRecord>& records);

private:
    void load(const Particles& particles, double step);
    void keep();
    void forgetLists();
    void install();
    void install(std::vector<LastingPair>& pairs, std::vector<LastingWall>& walls);
    void rebuild();
    void measureMotion();
    void measureMotion(std::size_t chunk);
    void checkBox() const;
    double widestBuffer() const;
    void grantNear();
    void grantBuffers();
    bool searchesEveryStep() const;
    void findNeighbours();
    void refresh();
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
    void follow(std::size_t chunk, const MoveWork& work);
    void finish();
    void kick(std::size_t chunk, double sign);
    void runAll(Particles& particles, double duration, std::size_t subSteps, StepReport& report);
    std::vector<bool> takeHits(Particles& particles, StepReport& report);
    std::size_t bytes() const;

    const Settings& settings_;
    const Walls& walls_;
    const LawTables& laws_;
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
};

} // namespace elutria::dem
