#pragma once

#include "Engine.hpp"
#include "LawTable.hpp"
#include "contact.hpp"
#include "search.hpp"

#include <vector>

namespace elutria::dem
{

/// Moves spheres in equal sub-steps with the soft contact law.
///
/// Each sub-step: the linear drag and the constant acceleration are followed exactly, contacts
/// with second order (exponential trapezoid, which is velocity Verlet without drag). Forces are
/// evaluated at the new positions with velocities predicted for the end of the sub-step.
class SoftIntegrator
{
public:
    SoftIntegrator(const Settings& settings, const ContactMaterials& materials,
                   const Walls& walls);

    void run(Particles& particles, double duration, std::size_t subSteps, StepReport& report);

    void contactForces(const Particles& particles, double step, VectorArray& force,
                       VectorArray& torque);

    std::vector<ContactRecord> exportContacts() const;
    void importContacts(const std::vector<ContactRecord>& records);

private:
    struct PairContact
    {
        std::uint32_t first, second;
        ContactHistory history;
    };
    struct WallCandidate
    {
        std::uint32_t particle;
        std::vector<Walls::Image> images;
        std::vector<std::pair<std::uint64_t, ContactHistory>> histories;
    };

    void load(const Particles&);
    void store(Particles&) const;
    void buildLists(double skin);
    bool listsHold() const;
    void keepHistory();
    void evaluate(StepWeights, StepReport*);
    void evaluatePairs(StepWeights, StepReport*);
    void evaluateWalls(StepWeights, StepReport*);
    template<ContactLaw law> void evaluatePairsWith(StepWeights, StepReport*);
    void prepareStep(double step);
    void startStep();
    void finish();

    const Settings& settings_;
    const Walls& walls_;
    LawTable laws_;

    // in the engine's own order: along the cells, then by id
    std::vector<std::uint32_t> order_;           // engine index -> caller's index
    std::vector<std::uint64_t> id_;
    std::vector<std::uint32_t> material_;
    std::vector<double> radius_, mass_, dragRate_;
    VectorArray position_, velocity_, surface_;  // velocity and radius*spin, predicted
    VectorArray velocityBase_, surfaceBase_;     // without the step's own contact part
    VectorArray gasVelocity_, acceleration_, push_;   // push: acceleration + drag*gas velocity
    VectorArray force_, moment_;                 // moment: torque over radius
    VectorArray dragImpulse_;
    VectorArray built_;                          // positions the lists were made at
    std::vector<double> decay_, first_, second_; // exp(-k h), h phi1, h phi2
    double step_ = 0, skin_ = 0;
    bool drag_ = false;

    std::vector<PairContact> pairs_;
    std::vector<WallCandidate> wallCandidates_;
    std::vector<ContactRecord> kept_;            // sorted; history waiting for the next lists
};

} // namespace elutria::dem
