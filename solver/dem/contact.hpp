#pragma once

#include "Settings.hpp"
#include "laws.hpp"

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

/// The stiffness S of laws.hpp.
template<ContactLaw law>
inline double contactStiffness(const laws::Coefficients& c, double radius, double overlap)
{
    return law == ContactLaw::linear ? c.stiffness : c.stiffness*std::sqrt(radius*overlap);
}

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
    const double dashpot =
        c.damping*std::sqrt(contactStiffness<law>(c, e.radius, travel)*e.mass);
    return -dashpot*approach*weight/(w.before + w.after);
}

/// Normal, tangential and cohesive force of one contact; advances its history.
///
/// The Coulomb limit uses the elastic part of the normal force: over a whole contact both parts
/// bring the same impulse, and the elastic part never pulls. In sliding the spring keeps the
/// stretch that just carries the friction force.
template<ContactLaw law>
inline ContactForce contactForce(const laws::Coefficients& c, const Encounter& e,
                                 ContactHistory& history, StepWeights w)
{
    ContactForce force;
    const double approach = dot(e.slip, e.normal);      // negative while closing
    const bool onset = e.overlap > 0 && !history.touching && w.before > 0 && approach < 0;
    const bool end = e.overlap <= 0 && history.touching && w.before > 0 && approach > 0;
    if (onset || end) force.normal = transitionDashpot<law>(c, e, approach, w);
    if (e.overlap <= 0)
    {
        history = {};
        return force;
    }
    const double stiffness = contactStiffness<law>(c, e.radius, e.overlap);
    const double dashpot = std::sqrt(stiffness*e.mass);
    force.elastic = c.elastic*stiffness*e.overlap;
    if (law == ContactLaw::springSliderDashpot && c.exponent != 1.5)
    {
        force.elastic *= std::pow(e.overlap, c.exponent - 1.5);
    }
    if (!onset) force.normal = -c.damping*dashpot*approach;
    force.normal += force.elastic - laws::cohesionForce(c.cohesion, e.radius, e.overlap);

    const Vector3 sliding = e.slip - approach*e.normal;
    Vector3 stretch = history.tangential;
    if (history.touching)
    {
        // turn with the contact plane: drop the normal part, keep the length
        const double along = dot(stretch, e.normal), length2 = squaredNorm(stretch);
        stretch -= along*e.normal;
        const double left = length2 - along*along;
        stretch *= left > 0 ? std::sqrt(length2/left) : 0;
        stretch += w.before*sliding;
    }
    else if (onset)
    {
        stretch = std::min(1.0, -e.overlap/(approach*w.step()))*2*w.before*sliding;
    }
    const double spring = c.shear*stiffness;
    force.tangential = -spring*stretch - c.shearDamping*dashpot*sliding;
    const double limit = c.friction*force.elastic;
    const double trial2 = squaredNorm(force.tangential);
    if (trial2 > limit*limit)
    {
        force.tangential *= limit/std::sqrt(trial2);
        stretch = (-1/spring)*force.tangential;
    }
    history.tangential = stretch + w.after*sliding;
    history.touching = true;
    return force;
}

} // namespace elutria::dem
