#pragma once

#include "laws/Coefficients.hpp"

// The arithmetic of a contact's force: plain, without branches on memory, so that the same code runs
// for one contact (double) and for many at a time (float, in vector registers).

namespace elutria::dem::laws
{

#define ELUTRIA_INLINE __attribute__((always_inline)) inline

template<class Real>
struct Triple
{
    Real x, y, z;
};

/// Kinematics of a touching contact. Velocities are of first against second.
template<class Real>
struct Kinematics
{
    Triple<Real> normal;        // unit, from second to first
    Triple<Real> slip;          // m/s, velocity at the contact point
    Triple<Real> normalRate;    // 1/s, rate of change of the normal
    Triple<Real> displacement;  // m, elastic tangential displacement so far
    Real overlap;               // m
    Real radius, mass;          // effective, m and kg
    Real before, after;         // s, half the step before and after this time
};

/// Force on first, N, and the tangential displacement carried on, m.
template<class Real>
struct Force
{
    Real normal;                // along Kinematics::normal: elastic, dashpot and cohesion
    Real elastic, dashpot;      // elastic part, N; dashpot constant, kg/s
    Triple<Real> tangential;
    Triple<Real> displacement;
};

ELUTRIA_INLINE float root(float a) { return __builtin_sqrtf(a); }
ELUTRIA_INLINE double root(double a) { return __builtin_sqrt(a); }
ELUTRIA_INLINE float power(float a, float b) { return __builtin_powf(a, b); }
ELUTRIA_INLINE double power(double a, double b) { return __builtin_pow(a, b); }

/// Velocity at the contact point, split along the normal and across it.
template<class Real>
struct Slip
{
    Real approach;              // m/s, negative while closing
    Triple<Real> sliding;       // m/s
};

template<class Real>
ELUTRIA_INLINE Slip<Real> split(const Kinematics<Real>& k)
{
    const Triple<Real> n = k.normal, v = k.slip;
    const Real approach = v.x*n.x + v.y*n.y + v.z*n.z;
    return {approach, {v.x - approach*n.x, v.y - approach*n.y, v.z - approach*n.z}};
}

/// The normal part of the form in Coefficients.hpp, for a given elastic force; `damped` is
/// sqrt(S*m).
template<class Real>
ELUTRIA_INLINE Force<Real> normalForce(const CoefficientsOf<Real>& c, const Kinematics<Real>& k,
                                       Real elastic, Real damped, Real approach)
{
    Force<Real> f{};        // a law without friction leaves the rest 0
    f.elastic = elastic;
    f.dashpot = c.damping*damped;
    f.normal = f.elastic - f.dashpot*approach - c.cohesion*Real(4*pi)*k.radius*k.overlap;
    return f;
}

/// The tangential displacement at this time: it follows the contact plane (its normal part goes, its
/// length stays to second order in the rotation) and grows with the sliding velocity.
template<class Real>
ELUTRIA_INLINE Triple<Real> displacementNow(const Kinematics<Real>& k, const Triple<Real>& sliding)
{
    const Triple<Real> n = k.normal, d = k.displacement, rate = k.normalRate;
    const Real along = d.x*n.x + d.y*n.y + d.z*n.z;
    return {d.x - along*(n.x - k.before*rate.x) + k.before*sliding.x,
            d.y - along*(n.y - k.before*rate.y) + k.before*sliding.y,
            d.z - along*(n.z - k.before*rate.z) + k.before*sliding.z};
}

/// Spring and dashpot of stiffness `spring`, N/m, and constant `dashpot`, kg/s, with Coulomb
/// friction. The limit uses the elastic part of the normal force: over a whole contact both parts
/// bring the same impulse, and the elastic part never pulls. The spring carries at most that limit,
/// the dashpot what the spring leaves of it.
template<class Real>
ELUTRIA_INLINE void addFriction(Force<Real>& force, const CoefficientsOf<Real>& c,
                                const Kinematics<Real>& k, const Triple<Real>& sliding,
                                Real spring, Real dashpot)
{
    const Triple<Real> d = displacementNow(k, sliding);
    const Triple<Real> f = {-spring*d.x - dashpot*sliding.x, -spring*d.y - dashpot*sliding.y,
                            -spring*d.z - dashpot*sliding.z};
    const Real limit = c.friction*force.elastic, trial2 = f.x*f.x + f.y*f.y + f.z*f.z;
    const bool slips = trial2 > limit*limit;
    const Real scale = slips ? limit/root(trial2 > 0 ? trial2 : Real(1)) : Real(1);
    const Real back = -1/(spring > 0 ? spring : Real(1));
    force.tangential = {scale*f.x, scale*f.y, scale*f.z};
    // The spring gives way only beyond the limit: were it set to carry what the dashpot adds,
    // it would give back energy that it never took.
    const Real length2 = d.x*d.x + d.y*d.y + d.z*d.z;
    const Real most = limit*(-back);
    const Real keep = length2 > most*most ? most/root(length2) : Real(1);
    force.displacement = {keep*d.x + k.after*sliding.x, keep*d.y + k.after*sliding.y,
                          keep*d.z + k.after*sliding.z};
}

} // namespace elutria::dem::laws
