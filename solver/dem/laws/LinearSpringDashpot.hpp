#pragma once

#include "laws/ContactMaterials.hpp"
#include "laws/ForceForm.hpp"

namespace elutria::dem
{

/// Linear spring and dashpot: S = k_n, k_t = ratio*k_n. The tangential dashpot has the same damping
/// ratio on the tangential effective mass 2/7 m of solid spheres.
struct LinearSpringDashpot
{
    using Coefficients = laws::Coefficients;

    static constexpr const char* name = "linearSpringDashpot";
    static constexpr bool givenStiffness = true;     // normalStiffness instead of elastic moduli
    static constexpr bool givenDamping = false;      // the restitution is given
    static constexpr bool dashpotJumps = true;       // dashpot constant at any overlap

    static Coefficients coefficients(const ContactMaterial&, const ContactMaterial&,
                                     const PairProperties& p)
    {
        Coefficients c;
        const double zeta = laws::dampingRatio(p.restitution);
        c.stiffness = p.normalStiffness;
        c.elastic = 1;
        c.damping = 2*zeta;
        c.shear = p.tangentialRatio;
        c.shearDamping = 2*zeta*std::sqrt(p.tangentialRatio*2/7);
        return c;
    }

    template<class Real>
    ELUTRIA_INLINE static Real stiffness(const laws::CoefficientsOf<Real>& c, Real, Real)
    {
        return c.stiffness;
    }

    template<class Real>
    ELUTRIA_INLINE static laws::Force<Real> force(const laws::CoefficientsOf<Real>& c,
                                                  const laws::Kinematics<Real>& k)
    {
        const laws::Slip<Real> slip = laws::split(k);
        const Real s = c.stiffness, damped = laws::root(s*k.mass);
        laws::Force<Real> f = laws::normalForce(c, k, c.elastic*s*k.overlap, damped, slip.approach);
        laws::addFriction(f, c, k, slip.sliding, c.shear*s, c.shearDamping*damped);
        return f;
    }

    /// Contact times scale with sqrt(m/k).
    static double timeScale(const Coefficients& c, double, double mass, double)
    {
        return std::sqrt(mass/c.stiffness);
    }

    /// s: pi/(omega sqrt(1 - zeta^2)), omega^2 = k/m.
    static double contactTime(const Coefficients& c, double, double mass, double)
    {
        const double zeta = 0.5*c.damping;
        return laws::pi*std::sqrt(mass/c.stiffness)/std::sqrt(1 - zeta*zeta);
    }

    /// Contact time times speed over largest overlap, elastic.
    static constexpr double wayOverOverlap = 3.14159265358979;

    /// Of an elastic impact, m: v sqrt(m/k).
    static double largestOverlap(const Coefficients& c, double, double mass, double speed)
    {
        return speed*std::sqrt(mass/c.stiffness);
    }

    /// J: k overlap^2/2.
    static double storedEnergy(const Coefficients& c, double, double overlap)
    {
        return 0.5*c.stiffness*overlap*overlap;
    }

    /// The outcome depends on the ratio of sliding to closing speed alone, so one table holds it.
    static bool impactSuffices(const Coefficients&) { return true; }
};

} // namespace elutria::dem
