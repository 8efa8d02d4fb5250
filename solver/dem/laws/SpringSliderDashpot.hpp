#pragma once

#include "laws/HertzMindlin.hpp"

#include <limits>

namespace elutria::dem
{

/// Spring-slider-dashpot as stock OpenFOAM states it: F_e = 4/3 E* sqrt(R) overlap^b, both dashpots
/// alpha sqrt(m k) overlap^(1/4) with k = 4/3 E* sqrt(R), k_t = 8 G* a. Friction is limited by the
/// whole normal force; a contact that slips slides along its velocity and starts again from an
/// unstretched spring. `anyExponent`: b may differ from 1.5 (a power for each contact).
template<bool anyExponent>
struct SpringSliderDashpotOf
{
    using Coefficients = laws::Coefficients;

    static constexpr const char* name =
        anyExponent ? "springSliderDashpot of any exponent" : "springSliderDashpot";
    static constexpr bool givenStiffness = false;
    static constexpr bool givenDamping = true;       // alpha instead of the restitution
    static constexpr bool dashpotJumps = false;

    static Coefficients coefficients(const ContactMaterial& a, const ContactMaterial& b,
                                     const PairProperties& p)
    {
        Coefficients c = HertzMindlin::coefficients(a, b, p);
        c.damping = p.damping*std::sqrt(4.0/3);
        c.shearDamping = c.damping;
        c.exponent = p.exponent;
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
        const laws::Triple<Real> slide = slip.sliding;
        const Real s = stiffness(c, k.radius, k.overlap), damped = laws::root(s*k.mass);
        Real elastic = c.elastic*s*k.overlap;
        if (anyExponent) elastic *= laws::power(k.overlap, c.exponent - Real(1.5));
        laws::Force<Real> f = laws::normalForce(c, k, elastic, damped, slip.approach);

        const laws::Triple<Real> d = laws::displacementNow(k, slide);
        const Real spring = c.shear*s, dashpot = c.shearDamping*damped;
        const Real total = f.normal < 0 ? -f.normal : f.normal, limit = c.friction*total;
        const Real length2 = d.x*d.x + d.y*d.y + d.z*d.z;
        const Real speed2 = slide.x*slide.x + slide.y*slide.y + slide.z*slide.z;
        const bool slips = spring*spring*length2 > limit*limit;
        const Real drag = slips ? limit/laws::root(speed2 > 0 ? speed2 : Real(1)) : dashpot;
        const Real held = slips ? Real(0) : Real(1), pull = slips ? Real(0) : spring;
        f.tangential = {-pull*d.x - drag*slide.x, -pull*d.y - drag*slide.y,
                        -pull*d.z - drag*slide.z};
        f.displacement = {held*d.x + k.after*slide.x, held*d.y + k.after*slide.y,
                          held*d.z + k.after*slide.z};
        return f;
    }

    static double timeScale(const Coefficients& c, double radius, double mass, double speed)
    {
        return HertzMindlin::timeScale(c, radius, mass, speed);
    }
    static double contactTime(const Coefficients& c, double radius, double mass, double speed)
    {
        return HertzMindlin::contactTime(c, radius, mass, speed);
    }
    static constexpr double wayOverOverlap = HertzMindlin::wayOverOverlap;
    static double largestOverlap(const Coefficients& c, double radius, double mass, double speed)
    {
        return HertzMindlin::largestOverlap(c, radius, mass, speed);
    }

    /// Without bound: a spring that starts again unstretched can give more than it took.
    static double storedEnergy(const Coefficients&, double, double)
    {
        return std::numeric_limits<double>::infinity();
    }

    /// The friction depends on the step, and with another exponent the restitution on the speed.
    static bool impactSuffices(const Coefficients& c)
    {
        return c.exponent == 1.5 && c.friction == 0;
    }
};

using SpringSliderDashpot = SpringSliderDashpotOf<false>;
using SpringSliderDashpotOfAnyExponent = SpringSliderDashpotOf<true>;

} // namespace elutria::dem
