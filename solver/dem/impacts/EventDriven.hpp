#pragma once

#include "impacts/ImpactLaw.hpp"
#include "impacts/ParticleState.hpp"
#include "impacts/StochasticCollisions.hpp"
#include "walls/Walls.hpp"

#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// Event-driven (hard-sphere) steps of a small group of spheres: exact flights between impacts.
///
///  1. All possible collisions are predicted and queued by time (ties: lower index first).
///  2. The earliest valid one is resolved; both partners' later predictions become invalid, and new
///     ones are made against all other members.
///  3. It stops at the end, or hands over to the soft law where an impulse cannot stand for a
///     contact: spheres that overlap or stay together, a contact law without impacts, or too many
///     impacts of one sphere (so that it ends). A second impact of a sphere within the duration of
///     its first one takes the group back to the time before the first.
class EventDriven
{
public:
    static constexpr double shallow = 1e-6;   // overlap over radii sum that counts as touching

    /// `forced`: all contacts are impacts, also where they follow each other closely.
    EventDriven(const ImpactLaws& laws, const Walls& walls, const PeriodicBox& box, bool forced)
        : laws_(laws), walls_(walls), box_(box), forced_(forced)
    {}

    /// Members are at `begin`; on return they are at the time returned: `end`, or the time of
    /// hand-over, at the latest after `mostImpacts`. `segments[i]` gets each new segment of member
    /// i's path. `seed`: of the stochastic collisions.
    double run(std::vector<ParticleState>& members, double begin, double end, std::uint64_t seed,
               std::vector<Path>& segments, double mostImpacts = 1e300);

    std::size_t impacts() const { return impacts_; }
    /// Of walls that answer, in order of time.
    const std::vector<WallHit>& hits() const { return hits_; }
    /// That the impacts would have had, over the radius.
    double largestOverlap() const { return largestOverlap_; }

private:
    static constexpr std::uint32_t wall = 0xffffffffu;

    struct Event
    {
        double time;
        std::uint32_t a, b;              // b == wall: the wall that a meets next
        std::uint32_t versionA, versionB;
        bool handOver;

        bool operator<(const Event& other) const    // the queue's top is the earliest
        {
            if (time != other.time) return time > other.time;
            return a != other.a ? a > other.a : b > other.b;
        }
    };
    struct State
    {
        double since;                    // time at which the particle's flight is given
        Bound bound;                     // of the path from there to the end
        Vector3 end;                     // of the path
        std::uint32_t version = 0, impacts = 0, stochastic = 0;   // stochastic: collisions
        double busyUntil = -1;           // end of the last impact, had it a duration
        Walls::Image nextWall{};
    };

    void predictAll();
    void predictPair(std::uint32_t a, std::uint32_t b, double from);
    RandomStream randomStream(std::uint32_t a, std::uint32_t b) const;
    void predictWall(std::uint32_t a, double from);
    enum class Verdict { done, handOver, crowded };
    bool tooMany(const Event&) const;
    Verdict carryOut(const Event&);
    void reportHit(const Event&);
    void rest(std::uint32_t a);
    void collideStochastically(const Event&);
    void predictAfter(const Event&, bool changedA, bool changedB);
    void fly(std::uint32_t a, double to);
    void changed(std::uint32_t a, const ImpactBody& after);
    void pathChanged(std::uint32_t a);
    void push(const Event& event);
    void remember(double time);
    double goBack();

    /// The last time at which no impact was going on.
    struct Checkpoint
    {
        double time = 0;
        std::vector<ParticleState> members;
        std::vector<double> since;
        std::vector<std::size_t> segments;
        std::size_t impacts = 0, hits = 0;
    };

    const ImpactLaws& laws_;
    const Walls& walls_;
    const PeriodicBox& box_;
    bool forced_;
    std::size_t impacts_ = 0;
    double largestOverlap_ = 0;
    std::vector<WallHit> hits_;

    std::vector<ParticleState>* members_ = nullptr;
    std::vector<Path>* paths_ = nullptr;
    double end_ = 0;
    std::uint64_t seed_ = 0;
    std::vector<State> states_;
    std::vector<Event> queue_;
    std::vector<Walls::Image> images_;
    Checkpoint checkpoint_;
    double busyUntil_ = -1;
};

} // namespace elutria::dem
