#pragma once

#include "core/ContactRecord.hpp"
#include "impacts/EventDriven.hpp"
#include "islands/IslandPartition.hpp"
#include "islands/Piece.hpp"
#include "soft/SoftIntegrator.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace elutria::dem
{

/// What happens in an island during a piece, for each of its particles.
struct IslandResult
{
    std::vector<ParticleState> end;
    std::vector<Path> paths;
    std::vector<ContactRecord> contacts;       // that last beyond the piece
    std::vector<WallHit> hits;                 // of walls that answer
    std::size_t impacts = 0, subSteps = 0;
    double shortestStep = 0;                   // s
    double largestOverlap = 0;                 // over the smaller radius
    double impactSeconds = 0, softSeconds = 0; // wall time
    bool finished = true;                      // false: the piece's work was not enough

    bool soft() const { return subSteps > 0; }
    /// Impacts and sub-steps times particles; each costs as much as some particles by itself.
    double work() const { return double(impacts + subSteps)*(double(end.size()) + 20); }
};

/// Fourth stage: carries an island through a piece: impacts as long as its contacts are short and
/// binary, the soft law with sub-steps of the island's own for as long as something in it touches,
/// then impacts again. Contacts that last for very many sub-steps take longer ones, as the energy
/// that the island can bring to a contact needs them. Gives up where that takes more than the piece's work.
class IslandStepper
{
public:
    /// Longest sub-step (s) for contacts at a speed (m/s); 0: at the particles' own.
    using StepLimit = std::function<double(const Particles&, double speed)>;

    IslandStepper(const Settings& settings, const LawTables& laws, const Walls& walls,
                  const ImpactLaws& impacts, StepLimit stepLimit);
    IslandStepper(const IslandStepper&) = delete;

    void run(const Piece& piece, const Island& island, IslandResult& result);

private:
    double softChunk(IslandResult& result, double begin, double end, bool& touching);
    void startSoft(const std::vector<ContactRecord>& history);
    void gather(const std::vector<ParticleState>& members);
    double longestStep(const IslandResult& result);
    double meetingSpeed(double time);
    double wallSpeed(double time);
    Vector3 forcing(std::size_t i) const;

    Settings settings_;
    const LawTables& laws_;
    const Walls& walls_;
    StepLimit stepLimit_;
    EventDriven events_;
    std::optional<SoftIntegrator> soft_;
    double overlap_ = 0;                       // over the smallest radius, in the last chunk
    Particles gathered_;                       // those that no wall has taken
    std::vector<std::uint32_t> memberOf_;      // of each in gathered_
    std::vector<Walls::Image> images_;         // scratch of wallSpeed()
    std::vector<WallContact> wall_;
};

/// Steps many islands, on as many threads as the settings say.
class IslandSteppers
{
public:
    IslandSteppers(const Settings& settings, const LawTables& laws, const Walls& walls,
                   const ImpactLaws& impacts, const IslandStepper::StepLimit& stepLimit);

    /// Steps the islands listed in `which`; results[k] is that of island k.
    void run(const Piece& piece, const std::vector<Island>& islands,
             const std::vector<std::uint32_t>& which, std::vector<IslandResult>& results);

private:
    unsigned threads_;
    std::vector<std::unique_ptr<IslandStepper>> steppers_;   // one per thread
};

} // namespace elutria::dem
