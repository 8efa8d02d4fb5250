#pragma once

#include "core/Particles.hpp"
#include "core/PeriodicBox.hpp"
#include "core/Untouched.hpp"
#include "soft/kernels/Kernels.hpp"

#include <vector>

namespace elutria::dem
{

/// Sums and extremes over particles.
struct CloudTotals
{
    std::size_t particles = 0;
    double smallest = 1e300, largest = 0, radii = 0;     // radius, m; its sum
    double strongestPush = 0;                            // m/s^2
    Vector3 velocities;                                  // m/s, sum
    bool materials = false, weighted = false;            // is one not 0, a weight not 1?

    void add(const CloudTotals& others);
};

/// The soft integrator's own copy of the particles, in an order that keeps neighbours in space
/// close in memory. The order depends on positions and ids alone, not on the caller's order.
/// Positions are not wrapped into a periodic box while the cloud is held.
///
/// Behind the particles there may be ghosts: particles of other ranks, which are not moved here.
class SoftCloud
{
public:
    std::size_t size() const { return ids_.size(); }       // without ghosts

    /// True if these are the particles it has, in the same caller's order.
    bool holds(const Particles& particles) const { return particles.id == ids_; }

    /// Takes the caller's state and forcing, for steps of length `step`, s. Keeps the cloud's order
    /// if it holds these particles; then returns by how much the surface of one of them can have
    /// moved since, m. Then settle().
    double load(const Particles& particles, double step);
    /// Of the particles that load() took.
    const CloudTotals& totals() const { return totals_; }
    /// Takes sizes and the common motion from these, be they of more particles.
    void settle(const CloudTotals& totals);

    /// Makes room for so many ghosts, whose rows, materials and weights are to be set.
    void resizeGhosts(std::size_t ghosts);
    void setGhost(std::size_t ghost, const Row& row)
    {
        const std::size_t i = size() + ghost;
        rows[i] = row;
        bases[i] = {frame.x + row.vx, frame.y + row.vy, frame.z + row.vz, row.inverseMass,
                    row.sx, row.sy, row.sz, row.radius};
    }

    /// Forgets the particles and their order.
    void forget() { ids_.clear(), rows.clear(); }

    /// Gives positions (inside the box), velocities, spins and dragImpulse back after `duration`.
    void store(Particles& particles, double duration) const;

    /// Sorts along a space-filling curve through cells of `width`; returns the new index of each
    /// old one. Loads do not follow.
    Untouched<std::uint32_t> sort(double width);

    std::uint64_t id(std::size_t i) const { return ids_[order_[i]]; }
    std::uint32_t caller(std::size_t i) const { return order_[i]; }

    /// Own indices by ascending id, to find particles with find().
    std::vector<std::uint32_t> byId() const;
    /// Own index of the particle with this id, or none.
    std::uint32_t find(const std::vector<std::uint32_t>& byId, std::uint64_t id) const;
    static constexpr std::uint32_t none = 0xffffffffu;

    Vector3 position(std::size_t i) const { return {rows[i].x, rows[i].y, rows[i].z}; }
    /// As kept between evaluations: without the step's own contact part.
    Vector3 velocity(std::size_t i) const { return {bases[i].vx, bases[i].vy, bases[i].vz}; }
    std::uint8_t material(std::size_t i) const { return materials.empty() ? 0 : materials[i]; }
    std::size_t bytes() const;

    PeriodicBox box;
    unsigned threads = 1;
    Untouched<Row> rows;
    Untouched<Base> bases;
    Untouched<Load> loads;                  // valid where PairContacts::loaded()
    Untouched<Forcing> forcing;             // empty without drag and with equal accelerations
    Untouched<std::uint8_t> materials;      // empty if all are 0
    Untouched<std::uint8_t> weighted;       // statistical weight not one; empty if none is
    Vector3 push;                           // m/s^2: of all, where forcing is empty
    Vector3 frame;                          // m/s: common velocity, taken off in the rows
    double smallest = 0, largest = 0, mean = 0;   // radius, m
    double strongestPush = 0;               // m/s^2

private:
    void take(const Particles& particles);
    double loadStates(const Particles& particles, bool same);
    template<class Values>
    void reorder(Values& values, const Untouched<std::uint32_t>& from) const;
    void loadForcing(const Particles& particles, double step);

    Untouched<std::uint32_t> order_;        // own index -> caller's index
    std::vector<std::uint32_t> byId_;       // caller's indices by ascending id
    std::vector<std::uint64_t> ids_;        // in the caller's order
    CloudTotals totals_;
};

} // namespace elutria::dem
