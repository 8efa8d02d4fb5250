#pragma once

#include "islands/IslandPartition.hpp"
#include "islands/IslandStepper.hpp"
#include "parallel/Message.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// Two particles, by their ids, that may meet.
struct IdPair
{
    std::uint64_t first, second;
};

/// Islands whose particles are on several ranks. Each is carried through a piece by the rank that has
/// most of its particles; the others send theirs, and get their ends and paths back. All ranks know
/// all of these islands. In a rank's own partition an island is made of the rank's own particles in it.
class SharedIslands
{
public:
    static constexpr std::uint64_t none = ~std::uint64_t(0);

    /// All references must outlive this object.
    SharedIslands(Exchange& exchange, IslandSteppers& steppers)
      : exchange_(exchange), steppers_(steppers)
    {}

    /// A piece begins: none is shared.
    void clear() { islands_.clear(), results_.clear(), sharedOf_.clear(); }

    /// Name of the shared island that an island of the own partition is part of, or none.
    std::uint64_t nameOf(std::size_t ownIsland) const;

    struct Joined
    {
        bool pairs;                            // had any rank some?
        std::size_t largest;                   // of all ranks' numbers
    };
    /// Joins the islands of each of these pairs and of those of all other ranks; the islands that
    /// grow are due, and counted if asked.
    Joined join(const std::vector<IdPair>& pairs, std::size_t number,
                const std::vector<ParticleState>& own, IslandPartition& partition,
                std::size_t* mergedAway = nullptr);

    /// Steps those that are due in three parts: members to the rank that steps them, the steps, their
    /// results to results[k] of each rank's own islands.
    void gather(const Piece& piece, const IslandPartition& partition);
    void run();
    void sendHome(std::vector<IslandResult>& results);

    /// Own islands that are parts of those that are due.
    std::vector<std::uint32_t> due() const;

    /// How many of them this rank steps.
    std::size_t steppedHere() const
    {
        return std::size_t(std::count_if(islands_.begin(), islands_.end(), [&](const SharedIsland& s)
                                         { return s.stepper == exchange_.rank(); }));
    }
    std::size_t largestWithoutContacts() const;

    /// Results of the islands that this rank steps; `stepped`: of those of the last run only.
    template<class Visit>
    void forEachResult(bool stepped, const Visit& visit) const
    {
        for (std::size_t k = 0; k < islands_.size(); ++k)
            if (islands_[k].stepper == exchange_.rank() && (!stepped || islands_[k].due))
                visit(results_[k]);
    }

private:
    struct SharedIsland
    {
        std::uint64_t name;                    // the smallest id in it
        std::vector<std::uint32_t> members;    // how many of each rank
        bool touching, due;
        int stepper;
        std::uint32_t ownIsland;               // in this rank's partition; nowhere: no member

        std::size_t size() const;
    };
    /// A particle of a pair, in its island.
    struct End
    {
        std::uint64_t particle, island;        // island: its smallest id known
        std::uint32_t members, ownIsland;
        bool touching;
        int rank;
    };
    std::vector<End> ownEnds(const std::vector<IdPair>& pairs, const std::vector<ParticleState>& own,
                             IslandPartition& partition) const;
    std::size_t combine(const std::vector<IdPair>& pairs, const std::vector<End>& ends,
                        IslandPartition& partition);
    std::vector<SharedIsland> takeParts(const std::vector<std::uint64_t>& ids,
                                        const std::vector<End>& ends);
    void unite(const SharedIsland& part, std::uint32_t& whole, const IslandPartition& partition,
               std::vector<Pair>& ownPairs);
    void mergeOwn(const std::vector<Pair>& ownPairs, IslandPartition& partition);
    void pack(std::uint32_t island, int rank, Outgoing& out) const;
    bool hasDue() const;

    static constexpr std::uint32_t nowhere = 0xffffffffu;

    Exchange& exchange_;
    IslandSteppers& steppers_;
    std::vector<SharedIsland> islands_;        // the same on all ranks
    std::vector<IslandResult> results_;        // of each that this rank steps
    std::vector<std::uint32_t> sharedOf_;      // of each own island, its place in islands_ or nowhere

    // Of the run at hand
    std::vector<ParticleState> start_;
    std::vector<int> rankOf_;                  // of each in start_
    std::vector<Island> members_;              // of each shared island, places in start_
    std::vector<ContactRecord> history_;
    double duration_ = 0, work_ = 0;
    std::uint64_t seed_ = 0;
};

} // namespace elutria::dem
