#pragma once

#include "core/Vector3.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace elutria::dem
{

/// N vectors, one array per component.
struct VectorArray
{
    std::vector<double> x, y, z;

    std::size_t size() const { return x.size(); }
    bool empty() const { return x.empty(); }

    void resize(std::size_t n, double value = 0)
    {
        x.resize(n, value), y.resize(n, value), z.resize(n, value);
    }
    void assign(std::size_t n, const Vector3& v)
    {
        x.assign(n, v.x), y.assign(n, v.y), z.assign(n, v.z);
    }
    void push_back(const Vector3& v) { x.push_back(v.x), y.push_back(v.y), z.push_back(v.z); }

    Vector3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
    void set(std::size_t i, const Vector3& v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
};

/// Spheres as structure of arrays, SI units, in the caller's order.
struct Particles
{
    std::vector<std::uint64_t> id;         // unique and stable: keys the contact history
    std::vector<std::uint32_t> material;   // index into ContactMaterials
    std::vector<double> radius, mass;      // m, kg; solid spheres: inertia 2/5 m r^2
    VectorArray position, velocity, spin;  // m, m/s, rad/s

    // Particles that each sphere stands for (see StochasticCollisions.hpp); empty: one
    std::vector<double> statisticalWeight;

    // Index of the gas step: the seed of stochastic collisions
    std::uint64_t stepIndex = 0;

    // Volume fraction of the solids around each sphere: spheres of a weight other than one collide
    // more often by its Enskog factor; empty: 0
    std::vector<double> solidFraction;

    // Forcing by the gas, constant during one advance():
    //   dv/dt = acceleration + dragRate*(gasVelocity - v) + contacts/mass
    // Each may stay empty: no such forcing.
    std::vector<double> dragRate;          // 1/s
    VectorArray gasVelocity, acceleration; // m/s, m/s^2
    VectorArray dragImpulse;               // out, kg m/s: received through the drag in advance()

    std::size_t size() const { return id.size(); }
};

/// Calls work(column) for every array of the particles, components apart.
template<class Work>
void forEachColumn(Particles& p, const Work& work)
{
    work(p.id), work(p.material);
    for (auto* column : {&p.radius, &p.mass, &p.statisticalWeight, &p.solidFraction, &p.dragRate})
        work(*column);
    for (auto* vectors : {&p.position, &p.velocity, &p.spin, &p.gasVelocity, &p.acceleration,
                          &p.dragImpulse})
        work(vectors->x), work(vectors->y), work(vectors->z);
}

/// Leaves the particles for which keep(i) says so; arrays that are empty stay so.
template<class Keep>
void keepOnly(Particles& p, const Keep& keep)
{
    const std::size_t n = p.size();
    forEachColumn(p, [&](auto& column)
    {
        if (column.size() != n) return;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < n; ++i)
            if (keep(i)) column[kept++] = column[i];
        column.resize(kept);
    });
}

} // namespace elutria::dem
