#pragma once

#include "engine/Engine.hpp"
#include "laws/LawList.hpp"

#include <cmath>

namespace scenes
{

using namespace elutria::dem;

inline constexpr double pi = 3.14159265358979323846;

/// Adds a solid sphere at rest; returns its index.
inline std::size_t addSphere(Particles& p, Vector3 position, double radius, double density,
                             std::uint32_t material = 0)
{
    p.id.push_back(p.id.size() + 1);
    p.material.push_back(material);
    p.radius.push_back(radius);
    p.mass.push_back(4.0/3*pi*radius*radius*radius*density);
    p.position.push_back(position);
    p.velocity.push_back({});
    p.spin.push_back({});
    return p.size() - 1;
}

/// The plane z = height, a square of `size` round the origin.
inline WallGeometry floorAt(double height, double size, std::uint32_t material = 0)
{
    const double s = size/2;
    return {{{-s, -s, height}, {s, -s, height}, {s, s, height}, {-s, s, height}},
            {{0, 1, 2}, {0, 2, 3}},
            {material, material}};
}

/// One material against itself.
inline ContactMaterials oneMaterial(PairProperties properties, double young = 1e7,
                                    double poisson = 0.3)
{
    ContactMaterials materials;
    materials.add({"grain", young, poisson});
    materials.setPair(0, 0, properties);
    return materials;
}

inline double kineticEnergy(const Particles& p)
{
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        sum += 0.5*p.mass[i]*(squaredNorm(p.velocity[i])
                              + 0.4*p.radius[i]*p.radius[i]*squaredNorm(p.spin[i]));
    }
    return sum;
}

inline Vector3 momentum(const Particles& p)
{
    Vector3 sum;
    for (std::size_t i = 0; i < p.size(); ++i) sum += p.mass[i]*p.velocity[i];
    return sum;
}

inline Vector3 angularMomentum(const Particles& p)
{
    Vector3 sum;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        sum += p.mass[i]*cross(p.position[i], p.velocity[i])
               + 0.4*p.mass[i]*p.radius[i]*p.radius[i]*p.spin[i];
    }
    return sum;
}

} // namespace scenes
