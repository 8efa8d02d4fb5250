#pragma once

#include "laws/ContactMaterials.hpp"
#include "laws/ForceForm.hpp"

namespace elutria::dem
{

/// Hertz-Mindlin with dashpots 2 sqrt(5/6) beta sqrt(S_n m), S_n = 2 E* a, and 2 sqrt(5/6) beta
/// sqrt(k_t m), k_t = 8 G* a (no slip; Mindlin 1949; dashpots: Tsuji et al. 1992).
struct HertzMindlin
{
    using Coefficients = laws::Coefficients;

    static constexpr const char* name = "hertzMindlin";
    static constexpr bool givenStiffness = false;
    static constexpr bool givenDamping = false;
    static constexpr bool dashpotJumps = false;      // it grows with overlap^(1/4)

    static Coefficients coefficients(const ContactMaterial& a, const ContactMaterial& b,
                                     const PairProperties& p)
    {
        const double young = laws::effectiveYoung(a.youngsModulus, a.poissonRatio,
                                                  b.youngsModulus, b.poissonRatio);
        const double shear = laws::effectiveShear(a.youngsModulus, a.poissonRatio,
                                                  b.youngsModulus, b.poissonRatio);
        Coefficients c;
        const double beta = laws::dampingRatio(p.restitution);
        c.stiffness = young;
        c.elastic = 4.0/3;
        c.damping = 2*std::sqrt(5.0/6)*beta*std::sqrt(2.0);
        c.shear = 8*shear/young;
        c.shearDamping = 2*std::sqrt(5.0/6)*beta*std::sqrt(c.shear);
        return c;
    }

    template<class Real>
    ELUTRIA_INLINE static Real stiffness(const laws::CoefficientsOf<Real>& c, Real radius,
                                         Real overlap)
    {
        return c.stiffness*laws::root(radius*overlap);
    }

    template<class Real>
    ELUTRIA_INLINE static laws::Force<Real> force(const laws::CoefficientsOf<Real>& c,
                                                  const laws::Kinematics<Real>& k)
    {
        const laws::Slip<Real> slip = laws::split(k);
        const Real s = stiffness(c, k.radius, k.overlap), damped = laws::root(s*k.mass);
        laws::Force<Real> f = laws::normalForce(c, k, c.elastic*s*k.overlap, damped, slip.approach);
        laws::addFriction(f, c, k, slip.sliding, c.shear*s, c.shearDamping*damped);
        return f;
    }

    /// Contact times scale with (m^2/(E*^2 R v))^(1/5).
    static double timeScale(const Coefficients& c, double radius, double mass, double speed)
    {
        const double m = mass/c.stiffness;
        return std::pow(m*m/(radius*speed), 0.2);
    }

    /// Of an elastic contact, s: 2.8683 (m^2/(R E*^2 v))^(1/5) (Johnson 1985, Contact Mechanics,
    /// eq. 11.24: 2.94 overlap/v).
    static double contactTime(const Coefficients& c, double radius, double mass, double speed)
    {
        return 2.8683*std::pow(mass*mass/(radius*c.stiffness*c.stiffness*speed), 0.2);
    }

    /// Contact time times speed over largest overlap, elastic.
    static constexpr double wayOverOverlap = 2.9432;

    /// Of an elastic impact, m: (15 m v^2/(16 E* sqrt(R)))^(2/5).
    static double largestOverlap(const Coefficients& c, double radius, double mass, double speed)
    {
        return std::pow(15*mass*speed*speed/(16*c.stiffness*std::sqrt(radius)), 0.4);
    }

    /// J: 8/15 E* sqrt(R) overlap^(5/2).
    static double storedEnergy(const Coefficients& c, double radius, double overlap)
    {
        return 8.0/15*c.stiffness*std::sqrt(radius)*std::pow(overlap, 2.5);
    }

    /// The outcome depends on the ratio of sliding to closing speed alone, so one table holds it.
    static bool impactSuffices(const Coefficients&) { return true; }
};

} // namespace elutria::dem
