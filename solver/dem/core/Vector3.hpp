#pragma once

#include <cmath>

namespace elutria::dem
{

/// Three Cartesian components.
struct Vector3
{
    double x = 0, y = 0, z = 0;

    double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
    double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }

    Vector3& operator+=(const Vector3& b) { x += b.x, y += b.y, z += b.z; return *this; }
    Vector3& operator-=(const Vector3& b) { x -= b.x, y -= b.y, z -= b.z; return *this; }
    Vector3& operator*=(double s) { x *= s, y *= s, z *= s; return *this; }
};

inline Vector3 operator+(Vector3 a, const Vector3& b) { return a += b; }
inline Vector3 operator-(Vector3 a, const Vector3& b) { return a -= b; }
inline Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
inline Vector3 operator*(double s, Vector3 a) { return a *= s; }
inline Vector3 operator*(Vector3 a, double s) { return a *= s; }

inline double dot(const Vector3& a, const Vector3& b) { return a.x*b.x + a.y*b.y + a.z*b.z; }

inline Vector3 cross(const Vector3& a, const Vector3& b)
{
    return {a.y*b.z - a.z*b.y, a.z*b.x - a.x*b.z, a.x*b.y - a.y*b.x};
}

inline double squaredNorm(const Vector3& a) { return dot(a, a); }
inline double norm(const Vector3& a) { return std::sqrt(dot(a, a)); }

} // namespace elutria::dem
