#pragma once

#include "core/StepReport.hpp"
#include "islands/BoundPairs.hpp"
#include "islands/CandidateSearch.hpp"
#include "islands/Census.hpp"
#include "islands/FreeFlight.hpp"
#include "islands/Ghosts.hpp"
#include "islands/IslandPartition.hpp"
#include "islands/IslandStepper.hpp"
#include "islands/OverlapSeparation.hpp"
#include "islands/ParticleStates.hpp"
#include "islands/PathCheck.hpp"
#include "islands/SharedIslands.hpp"
#include "islands/SortedContacts.hpp"

#include <vector>

namespace elutria::dem
{

/// Moves all particles through a gas step, each with the work that its own surroundings need.
///
///  1. FreeFlight: the closed form of all flights; a sphere bounds each swept path.
///  2. CandidateSearch: who could touch whom, or a wall. Overlaps that no contact explains are
///     separated first (OverlapSeparation).
///  3. IslandPartition: a particle without candidate has its flight as its result; the others form
///     islands, the connected components of candidates.
///  4. IslandStepper: each island on its own, with impacts where they suffice and the soft law where
///     contacts last.
///  5. PathCheck: a path that a contact has changed is checked against all others. A hit merges
///     islands, which start again from the saved state, until none is left: merging can only go on
///     until all is one island.
///
/// A step too long for its density, where candidates crowd, is cut into halves. Where most particles
/// touch, halving no longer helps, or the step is but a few sub-steps long, all take the soft law,
/// until few touch. So do they for the rest of a step that has taken several times the work of that:
/// no input makes a step endless. What would take too much even so is refused (TooMuchWork).
///
/// Where particles are distributed over ranks, each rank does this for its own, and islands that reach
/// over several ranks are shared (Ghosts, SharedIslands); all decisions are made alike, from what all
/// have. An island's outcome depends on its members, their history and the seed alone, so that the
/// result is to the bit that of one rank; that of the soft law for all is so to rounding.
class AdaptiveIntegrator
{
public:
    /// `soft` is the engine's own soft integrator; all references must outlive this object.
    AdaptiveIntegrator(const Settings& settings, const ContactMaterials& materials,
                       const LawTables& laws, const Walls& walls, SoftIntegrator& soft,
                       IslandStepper::StepLimit stepLimit, Exchange& exchange);
    AdaptiveIntegrator(const AdaptiveIntegrator&) = delete;

    /// `report` is of this rank's part.
    void advance(Particles& particles, double duration, StepReport& report);

    /// History that this rank holds: contacts of which the first particle was its own when they were
    /// seen last. What is imported is handed to the rank whose particle it is with the next step.
    std::vector<ContactRecord> exportContacts() const;
    void importContacts(const std::vector<ContactRecord>& records);

    /// Hands the contact history to the soft integrator, for a caller that asks it for forces.
    void useSoft();

private:
    enum class Outcome { done, tooLong, contactsRule };

    void runSoft(Particles& particles, double duration, bool continued, StepReport& report);
    void load(const Particles& particles, bool weighted);
    Outcome advancePiece(double duration, std::uint64_t seed, bool mayCut, StepReport& report);
    bool findCandidates(const Piece& piece, StepReport& report);
    bool flyFreely(const Piece& piece);
    void findAmongRanks(const Piece& piece, StepReport& report);
    void separateOverlaps();
    std::size_t formIslands();
    Outcome stepIslands(const Piece& piece, bool mayCut);
    double workOfRound() const;
    bool crowds() const;
    bool mergeWhatMeets(const Piece& piece, StepReport& report);
    void dropShared();
    bool mergeWhatMeetsAmongRanks(const Piece& piece, StepReport& report);
    void finishPiece(const Piece& piece, StepReport& report);
    void runRestSoft(Particles& particles, double duration, double done, StepReport& report);

    const Settings& settings_;
    const Walls& walls_;
    SoftIntegrator& soft_;
    IslandStepper::StepLimit stepLimit_;
    Exchange& exchange_;
    ImpactLaws impacts_;

    ParticleStates states_;
    SortedContacts contacts_;
    double pieceBegin_ = 0;                    // s, since the step began
    double workLeft_ = 0;                      // of the step, sub-steps or impacts times particles
    bool softRules_ = false;                   // the soft integrator steps and holds the history
    std::size_t contactEnds_ = 0;              // of this rank's records; two per pair, one per wall
    Census all_;                               // of the step

    BoundPairs boundPairs_;
    CandidateSearch search_;
    IslandSteppers steppers_;
    PathCheck pathCheck_;
    Ghosts ghosts_;
    SharedIslands shared_;

    FreeFlights flights_;
    Candidates candidates_;
    IslandPartition partition_;
    std::vector<IslandResult> results_;        // of each island
    std::vector<std::uint32_t> toStep_;        // own islands of this round
    OverlapsOfAll overlaps_;                   // where there are several ranks
    std::vector<IdPair> acrossRanks_;          // candidates of an own particle and a ghost
};

} // namespace elutria::dem
