#pragma once

#include "core/Particles.hpp"
#include "laws/Settings.hpp"
#include "walls/Walls.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace elutria::dem
{

/// The memory of one lasting contact, for restart and for passing particles between processes.
struct ContactRecord
{
    std::uint64_t first = 0;     // particle id
    std::uint64_t second = 0;    // particle id (> first), or the wall feature's key
    bool wall = false;
    Vector3 tangential;          // m, elastic tangential displacement of first against second
};

/// What one advance() did.
struct StepReport
{
    std::size_t subSteps = 0;
    double step = 0;                     // s, smallest sub-step taken
    std::size_t candidates = 0;          // pairs in the neighbour list
    std::size_t touching = 0;            // particle pairs touching at the end
    std::size_t wallTouching = 0;        // particle-wall contacts at the end
    std::size_t freeParticles = 0;       // particles that flew through in one step
    std::size_t impacts = 0;             // collisions resolved without sub-steps
    std::size_t islands = 0;             // groups of particles that could meet each other
    std::size_t softIslands = 0;         // of these: took sub-steps for a while
    std::size_t mergedIslands = 0;       // redone because a changed path led into another's way
    std::size_t separated = 0;           // overlaps without a history, moved apart
    std::size_t pieces = 0;              // parts that a crowded step was cut into
    std::size_t softParticles = 0;       // particles that took sub-steps
    double searchSeconds = 0, impactSeconds = 0, softSeconds = 0;   // wall time of each part
    std::size_t listBuilds = 0;          // neighbour lists made
    double largestOverlap = 0;           // over the smaller radius, seen during the call
    std::size_t bytes = 0;               // memory held by the engine
    std::vector<std::string> warnings;   // one line each, with the number
};

/// Moves spheres through contacts with each other and with walls.
///
/// The result does not depend on the number of threads, and not on the caller's particle order
/// as long as ids stay with their particles. Lists and contact history live on between calls.
class Engine
{
public:
    /// Throws std::invalid_argument with a one-line message.
    Engine(Settings settings, ContactMaterials materials, Walls walls = {});
    ~Engine();
    Engine(Engine&&) noexcept;
    Engine& operator=(Engine&&) noexcept;

    /// One gas step of `duration` seconds: sub-steps, contacts, walls. Updates position (kept
    /// inside a periodic box), velocity, spin and dragImpulse.
    /// Throws std::invalid_argument for arrays of unequal length or values not allowed,
    /// std::runtime_error where the motion diverges.
    StepReport advance(Particles& particles, double duration);

    /// One evaluation at the given positions, the tangential history advanced by `step` seconds:
    /// for callers that integrate themselves. force in N, torque in N m; both are overwritten.
    void contactForces(const Particles& particles, double step, VectorArray& force,
                       VectorArray& torque);

    /// History of the contacts that last, sorted by first, second. After importContacts() of the
    /// same records the engine continues as the one that exported them.
    std::vector<ContactRecord> exportContacts() const;
    void importContacts(const std::vector<ContactRecord>& records);

    /// Largest sub-step allowed, s: stepFraction of the contact time of the smallest, lightest
    /// pair that can meet at the given relative speed (m/s; 0: the particles' largest).
    double stepLimit(const Particles& particles, double speed = 0) const;

    /// Largest overlap over radius of two equal spheres that meet head-on at a relative speed, m/s,
    /// without damping, for the softest pair of materials: known before time is spent.
    double expectedOverlap(double radius, double density, double speed) const;

    const Settings& settings() const;
    const ContactMaterials& materials() const;
    const Walls& walls() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> self_;
};

} // namespace elutria::dem
