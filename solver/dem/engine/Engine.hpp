#pragma once

#include "core/ContactRecord.hpp"
#include "core/Particles.hpp"
#include "core/StepReport.hpp"
#include "laws/Settings.hpp"
#include "parallel/Exchange.hpp"
#include "walls/Walls.hpp"

#include <memory>
#include <vector>

namespace elutria::dem
{

/// Moves spheres through contacts with each other and with walls.
///
/// The result does not depend on the number of threads, and not on the caller's particle order
/// as long as ids stay with their particles. Lists and contact history live on between calls.
///
/// Particles may be distributed over ranks, each with an engine of the same settings, materials and
/// walls: then all ranks make the same calls, each with its own particles, whose ids are unique over
/// all ranks, and may hand particles to each other between calls. What is not allowed, or fails, on one
/// rank throws on all.
class Engine
{
public:
    /// Throws std::invalid_argument with a one-line message.
    /// `exchange` must outlive the engine.
    Engine(Settings settings, ContactMaterials materials, Walls walls = {},
           Exchange& exchange = alone());
    ~Engine();
    Engine(Engine&&) noexcept;
    Engine& operator=(Engine&&) noexcept;

    /// One gas step of `duration` seconds: sub-steps, contacts, walls. Updates position (kept
    /// inside a periodic box), velocity, spin and dragImpulse.
    /// Throws std::invalid_argument for arrays of unequal length or values not allowed,
    /// std::runtime_error where the motion diverges. The report is that of all ranks.
    StepReport advance(Particles& particles, double duration);

    /// One evaluation at the given positions, the tangential history advanced by `step` seconds:
    /// for callers that integrate themselves. force in N, torque in N m; both are overwritten.
    void contactForces(const Particles& particles, double step, VectorArray& force,
                       VectorArray& torque);

    /// History of the contacts that last, sorted by first, second. After importContacts() of the
    /// same records the engine continues as the one that exported them. Each rank has a part; on which
    /// ranks records are imported does not matter.
    std::vector<ContactRecord> exportContacts() const;
    void importContacts(const std::vector<ContactRecord>& records);

    /// How the walls move from now on; as many motions as WallGeometry had.
    void setWallMotions(std::vector<WallMotion> motions);

    /// What hits of walls mean from now on, by contact material; empty: nothing. Each rank's
    /// report has the hits of its own particles.
    void setWallAnswers(std::vector<WallAnswer> answers);

    /// Largest sub-step allowed, s: stepFraction of the contact time of the smallest, lightest
    /// pair that can meet at the given relative speed (m/s; 0: the particles' largest).
    double stepLimit(const Particles& particles, double speed = 0) const;

    /// Largest overlap over radius of two equal spheres that meet head-on at a relative speed, m/s,
    /// without damping, for the softest pair of materials: known before time is spent.
    double expectedOverlap(double radius, double density, double speed) const;

    /// Most elastic energy, J, that a contact of this effective radius can hold at an overlap, m.
    double storedEnergy(double radius, double overlap) const;

    const Settings& settings() const;
    const ContactMaterials& materials() const;
    const Walls& walls() const;
    Exchange& exchange() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> self_;
};

} // namespace elutria::dem
