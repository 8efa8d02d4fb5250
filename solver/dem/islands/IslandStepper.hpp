#pragma once

#include "core/ContactRecord.hpp"
#include "core/StepReport.hpp"
#include "impacts/EventDriven.hpp"
#include "soft/SoftIntegrator.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace elutria::dem
{

/// Spheres that may meet each other during a step, and no others.
struct Island
{
    std::vector<std::uint32_t> particles;      // ascending
    bool touching = false;                     // contacts with a history at the start

    // results
    std::vector<ParticleState> end;                // of each particle
    std::vector<std::vector<PathSegment>> segments;        // its path
    std::vector<ContactRecord> contacts;       // that last beyond the step
    std::size_t impacts = 0, subSteps = 0;
    double shortestStep = 0, largestOverlap = 0;
    double impactSeconds = 0, softSeconds = 0;

    bool soft() const { return subSteps > 0; }
};

/// Carries islands through a step: impacts as long as they are the right picture, the soft law with
/// sub-steps of the island's own for as long as something in it touches, then impacts again.
class IslandStepper
{
public:
    using StepLimit = std::function<double(const Particles&)>;

    IslandStepper(const Settings& settings, const ContactMaterials& materials, const Walls& walls,
                  const ImpactTable& laws, StepLimit stepLimit);
    IslandStepper(const IslandStepper&) = delete;

    /// From the `start` of each of the island's particles (indexed by particle) on; `history` holds
    /// the island's contacts; `seed`: see weights.hpp.
    void run(Island& island, const std::vector<ParticleState>& start, double duration,
             std::uint64_t seed, const std::vector<ContactRecord>& history);

private:
    double softChunk(Island& island, double begin, double end, bool& touching);
    void startSoft(const std::vector<ContactRecord>& history);
    void gather(const std::vector<ParticleState>& members);

    Settings settings_;
    const ContactMaterials& materials_;
    const Walls& walls_;
    StepLimit stepLimit_;
    EventDriven events_;
    std::optional<SoftIntegrator> soft_;
    Particles gathered_;
};

/// Whether two spheres meet before `duration` on their paths.
bool pathsMeet(const ParticleState& a, const std::vector<PathSegment>& pathA, const ParticleState& b,
               const std::vector<PathSegment>& pathB, std::uint64_t seed, const PeriodicBox& box,
               double duration);

/// Bound of a whole path, in a frame that moves with `frame`.
Bound boundOf(const std::vector<PathSegment>& segments, double radius, double duration, const Vector3& frame);

} // namespace elutria::dem
