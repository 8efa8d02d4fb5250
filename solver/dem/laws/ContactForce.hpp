#pragma once

#include "core/Vector3.hpp"
#include "laws/ForceForm.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

/// How one evaluation of the forces stands in time, s: it ends the step before it and starts the
/// step after it, and counts for half of each.
struct StepWeights
{
    double before;     // half the step before; 0 at the start of an advance
    double after;      // half the step after; 0 at its end

    double step() const { return 2*std::max(before, after); }
};

/// One contact at the moment of evaluation. Velocities are those predicted for this moment.
struct Encounter
{
    Vector3 normal;       // unit, from second to first
    double overlap;       // m, negative when apart
    Vector3 slip;         // m/s, velocity of first against second where they touch
    double radius, mass;  // effective, m and kg
    Vector3 normalRate = {};   // 1/s, rate of change of the normal
};

/// What lasts from one evaluation to the next.
struct ContactHistory
{
    Vector3 displacement;    // m, elastic tangential displacement of first against second
    bool touching = false;
};

/// Force on first, N: normal + tangential.
struct ContactForce
{
    double normal = 0;       // along Encounter::normal
    double elastic = 0;      // the elastic part of it
    Vector3 tangential;
};

namespace laws
{

/// Weight of a dashpot force ~ overlap^p in the first step of a contact that touched during the
/// fraction `theta` of that step, so that the sum over steps keeps second order:
/// -zeta(-p, 1 + theta) with Hurwitz' zeta function, that is 1/2 + theta for p = 0 (a dashpot that
/// `jumps`); for p = 1/4 (Hertz) a Chebyshev fit good to 1e-4. It multiplies the force at an overlap
/// of one whole step, so it stands for theta^p and its quadrature correction together.
inline double onsetWeight(double theta, bool jumps)
{
    return jumps ? 0.5 + theta
                 : 0.3203419 + theta*(0.8638905 + theta*(0.1641759 - theta*0.0280252));
}

} // namespace laws

/// Dashpot force in the first step of a contact or the step after its last, N. A dashpot's force
/// sets in with a jump (linear) or a root (Hertz) at a time inside the step; weighting it by the
/// part of the step during which it acts keeps second order. See laws::onsetWeight.
template<class Law>
inline double transitionDashpot(const laws::Coefficients& c, const Encounter& e, double approach,
                                StepWeights w)
{
    const double h = w.step(), travel = h*std::abs(approach);
    if (!(travel > 0)) return 0;
    const bool onset = e.overlap > 0;
    const double theta = std::clamp((onset ? 0 : 1) + e.overlap/travel, 0.0, 1.0);
    const double sample = Law::dashpotJumps ? 1 : std::sqrt(std::sqrt(theta));
    const double weight = laws::onsetWeight(theta, Law::dashpotJumps)*h
                          + sample*(onset ? w.after - 0.5*h : -h);
    const double dashpot = c.damping*std::sqrt(Law::stiffness(c, e.radius, travel)*e.mass);
    return -dashpot*approach*weight/(w.before + w.after);
}

/// Force of one contact, also in the step in which it begins or ends; advances its history.
template<class Law>
inline ContactForce contactForce(const laws::Coefficients& c, const Encounter& e,
                                 ContactHistory& history, StepWeights w)
{
    const double approach = dot(e.slip, e.normal);      // negative while closing
    const bool onset = e.overlap > 0 && !history.touching && w.before > 0 && approach < 0;
    const bool end = e.overlap <= 0 && history.touching && w.before > 0 && approach > 0;
    const double transition = onset || end ? transitionDashpot<Law>(c, e, approach, w) : 0;
    if (e.overlap <= 0)
    {
        history = {};
        return {transition, 0, {}};
    }
    const double touched = !onset ? 1 : std::min(1.0, -e.overlap/(approach*w.step()));
    const Vector3 &n = e.normal, &v = e.slip, &r = e.normalRate, &d = history.displacement;
    const laws::Kinematics<double> kinematics{
        {n.x, n.y, n.z}, {v.x, v.y, v.z}, {r.x, r.y, r.z}, {d.x, d.y, d.z},
        e.overlap, e.radius, e.mass, onset ? 2*touched*w.before : w.before, w.after};
    const laws::Force<double> f = Law::force(c, kinematics);
    history = {{f.displacement.x, f.displacement.y, f.displacement.z}, true};
    return {onset ? f.normal + f.dashpot*approach + transition : f.normal, f.elastic,
            {f.tangential.x, f.tangential.y, f.tangential.z}};
}

/// Torque on first that resists rolling, N m: coefficient x elastic force x effective radius against
/// the relative spin (Zhou et al. 1999, doi 10.1016/S0378-4371(99)00183-1, model A), but never
/// more than stops the spin within the step. `inertia` is 1/(1/I_i + 1/I_j).
inline Vector3 rollingTorque(const laws::Coefficients& c, double elastic, double radius,
                             double inertia, const Vector3& relativeSpin, StepWeights w)
{
    const double speed = norm(relativeSpin);
    if (!(speed > 0)) return {};
    const double torque = std::min(c.rolling*elastic*radius, inertia*speed/w.step());
    return (-torque/speed)*relativeSpin;
}

} // namespace elutria::dem
