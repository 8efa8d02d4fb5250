#pragma once

#include "core/Vector3.hpp"
#include "laws/laws.hpp"

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
    Vector3 turning = {}; // 1/s, rate of change of the normal
};

/// What lasts from one evaluation to the next.
struct ContactHistory
{
    Vector3 tangential;      // m, elastic displacement of first against second
    bool touching = false;
};

/// Force on first, N: normal + tangential.
struct ContactForce
{
    double normal = 0;       // along Encounter::normal
    double elastic = 0;      // the elastic part of it
    Vector3 tangential;
};

/// Dashpot force in the first step of a contact or the step after its last, N. A dashpot's force
/// sets in with a jump (linear) or a root (Hertz) at a moment inside the step; weighting it by the
/// part of the step during which it acts keeps second order. See laws::onsetWeight.
template<ContactLaw law>
inline double transitionDashpot(const laws::Coefficients& c, const Encounter& e, double approach,
                                StepWeights w)
{
    constexpr bool hertzian = law != ContactLaw::linear;
    const double h = w.step(), travel = h*std::abs(approach);
    if (!(travel > 0)) return 0;
    const bool onset = e.overlap > 0;
    const double theta = std::clamp((onset ? 0 : 1) + e.overlap/travel, 0.0, 1.0);
    const double sample = hertzian ? std::sqrt(std::sqrt(theta)) : 1;
    const double weight = laws::onsetWeight(theta, hertzian)*h
                          + sample*(onset ? w.after - 0.5*h : -h);
    const double dashpot = c.damping*std::sqrt(laws::stiffness<law>(c, e.radius, travel)*e.mass);
    return -dashpot*approach*weight/(w.before + w.after);
}

/// Force of one contact, also in the step in which it begins or ends; advances its history.
template<ContactLaw law>
inline ContactForce contactForce(const laws::Coefficients& c, const Encounter& e,
                                 ContactHistory& history, StepWeights w)
{
    const double approach = dot(e.slip, e.normal);      // negative while closing
    const bool onset = e.overlap > 0 && !history.touching && w.before > 0 && approach < 0;
    const bool end = e.overlap <= 0 && history.touching && w.before > 0 && approach > 0;
    const double transition = onset || end ? transitionDashpot<law>(c, e, approach, w) : 0;
    if (e.overlap <= 0)
    {
        history = {};
        return {transition, 0, {}};
    }
    const double touched = !onset ? 1 : std::min(1.0, -e.overlap/(approach*w.step()));
    const Vector3 &n = e.normal, &v = e.slip, &t = e.turning, &s = history.tangential;
    const laws::Touch<double> touch{
        {n.x, n.y, n.z}, {v.x, v.y, v.z}, {t.x, t.y, t.z}, {s.x, s.y, s.z},
        e.overlap, e.radius, e.mass, onset ? 2*touched*w.before : w.before, w.after};
    const laws::Push<double> p = law == ContactLaw::springSliderDashpot && c.exponent != 1.5
        ? laws::push<law, true>(c, touch) : laws::push<law>(c, touch);
    history = {{p.stretch.x, p.stretch.y, p.stretch.z}, true};
    return {onset ? p.normal + p.dashpot*approach + transition : p.normal, p.elastic,
            {p.tangential.x, p.tangential.y, p.tangential.z}};
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
