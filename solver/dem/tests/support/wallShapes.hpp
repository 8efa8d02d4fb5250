#pragma once

#include "walls/Walls.hpp"

#include <cmath>

namespace shapes
{

using namespace elutria::dem;

/// Adds a parallelogram of nu x nv cells, two triangles each.
inline void addSheet(WallGeometry& g, const Vector3& origin, const Vector3& u, const Vector3& v,
                     int nu = 1, int nv = 1, std::uint32_t material = 0)
{
    const auto base = static_cast<std::uint32_t>(g.points.size());
    for (int j = 0; j <= nv; ++j)
        for (int i = 0; i <= nu; ++i)
            g.points.push_back(origin + (double(i)/nu)*u + (double(j)/nv)*v);
    const auto row = static_cast<std::uint32_t>(nu + 1);
    for (std::uint32_t j = 0; j < std::uint32_t(nv); ++j)
        for (std::uint32_t i = 0; i < std::uint32_t(nu); ++i)
        {
            const std::uint32_t a = base + j*row + i, b = a + 1, c = a + row, d = c + 1;
            if ((i + j) % 2) { g.triangles.push_back({a, b, d}); g.triangles.push_back({a, d, c}); }
            else { g.triangles.push_back({a, b, c}); g.triangles.push_back({b, d, c}); }
            g.material.insert(g.material.end(), 2, material);
        }
}

/// The six sides of a box, n x n cells each.
inline WallGeometry box(const Vector3& low, const Vector3& high, int n = 1)
{
    const Vector3 s = high - low, x{s.x, 0, 0}, y{0, s.y, 0}, z{0, 0, s.z};
    WallGeometry g;
    addSheet(g, low, x, y, n, n);
    addSheet(g, low + z, x, y, n, n);
    addSheet(g, low, y, z, n, n);
    addSheet(g, low + x, y, z, n, n);
    addSheet(g, low, x, z, n, n);
    addSheet(g, low + y, x, z, n, n);
    return g;
}

/// A tube along z made of flat facets.
inline WallGeometry tube(double radius, double length, int facets, int rings)
{
    WallGeometry g;
    const double pi = std::acos(-1.0);
    for (int f = 0; f < facets; ++f)
    {
        const double a = 2*pi*f/facets, b = 2*pi*(f + 1)/facets;
        const Vector3 from{radius*std::cos(a), radius*std::sin(a), 0};
        const Vector3 to{radius*std::cos(b), radius*std::sin(b), 0};
        addSheet(g, from, to - from, {0, 0, length}, 1, rings);
    }
    return g;
}

} // namespace shapes
