#pragma once

#include <cmath>

// Contact laws: stateless functions of one contact, SI units. They are plain arithmetic without
// branches on memory, so that the same code runs for one contact and for many at a time.
//
// All laws share one form with a stiffness S:
//   elastic normal force    F_e = elastic*S*overlap
//   normal dashpot          g_n = damping*sqrt(S*m)
//   tangential stiffness    k_t = shear*S
//   tangential dashpot      g_t = shearDamping*sqrt(S*m)
// with m the effective mass 1/(1/m_i + 1/m_j). Linear law: S = k_n. Hertz: S = E*a with the contact
// radius a = sqrt(R*overlap), 1/R = 1/R_i + 1/R_j.
// Cohesion is a simplified JKR: a pull of cohesion energy density times contact area 4 pi R overlap
// (the circle in which two spheres intersect, small overlaps).

namespace elutria::dem
{

enum class ContactLaw { linear, hertz, springSliderDashpot };

namespace laws
{

constexpr double pi = 3.14159265358979323846;

/// Coefficients of a pair of materials in the form above.
template<class Real>
struct CoefficientsOf
{
    Real stiffness = 0;       // k_n, N/m (linear) or E*, Pa (Hertz)
    Real elastic = 1;
    Real damping = 0;
    Real shear = 0;
    Real shearDamping = 0;
    Real friction = 0;
    Real cohesion = 0;        // J/m^3
    Real rolling = 0;
    Real exponent = Real(1.5);   // of the overlap, spring-slider-dashpot only
};
using Coefficients = CoefficientsOf<double>;

/// Damping ratio of a linear oscillator that rebounds with restitution e:
/// -ln e/sqrt(pi^2 + ln^2 e). Exact for the linear law (contact ends at overlap 0; Schwager and
/// Poeschel 2007, doi 10.1007/s10035-007-0065-z) and, in the Hertz dashpot below, for Hertz (Tsuji
/// et al. 1992, doi 10.1016/0032-5910(92)88030-L; Antypov and Elliott 2011,
/// doi 10.1209/0295-5075/94/50004).
inline double dampingRatio(double restitution)
{
    const double l = std::log(restitution);
    return -l/std::sqrt(pi*pi + l*l);
}

/// Linear spring-dashpot: k_n, k_t = ratio*k_n. The tangential dashpot has the same damping ratio on
/// the tangential effective mass 2/7 m of solid spheres.
inline Coefficients linear(double normalStiffness, double tangentialRatio, double restitution)
{
    Coefficients c;
    const double zeta = dampingRatio(restitution);
    c.stiffness = normalStiffness;
    c.elastic = 1;
    c.damping = 2*zeta;
    c.shear = tangentialRatio;
    c.shearDamping = 2*zeta*std::sqrt(tangentialRatio*2/7);
    return c;
}

/// Effective Young's modulus, Pa: 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j.
inline double effectiveYoung(double Ei, double nui, double Ej, double nuj)
{
    return 1/((1 - nui*nui)/Ei + (1 - nuj*nuj)/Ej);
}

/// Effective shear modulus, Pa: 1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j, G = E/(2(1 + nu)).
inline double effectiveShear(double Ei, double nui, double Ej, double nuj)
{
    return 1/(2*(2 - nui)*(1 + nui)/Ei + 2*(2 - nuj)*(1 + nuj)/Ej);
}

/// Hertz-Mindlin with dashpots 2 sqrt(5/6) beta sqrt(S_n m), S_n = 2 E* a, and 2 sqrt(5/6) beta
/// sqrt(k_t m), k_t = 8 G* a (no slip; Mindlin 1949; dashpots: Tsuji et al. 1992).
inline Coefficients hertz(double young, double shear, double restitution)
{
    Coefficients c;
    const double beta = dampingRatio(restitution);
    c.stiffness = young;
    c.elastic = 4.0/3;
    c.damping = 2*std::sqrt(5.0/6)*beta*std::sqrt(2.0);
    c.shear = 8*shear/young;
    c.shearDamping = 2*std::sqrt(5.0/6)*beta*std::sqrt(c.shear);
    return c;
}

/// Spring-slider-dashpot as stock OpenFOAM states it: F_e = 4/3 E* sqrt(R) overlap^b,
/// both dashpots alpha sqrt(m k) overlap^(1/4) with k = 4/3 E* sqrt(R), k_t = 8 G* a.
inline Coefficients springSliderDashpot(double young, double shear, double alpha, double b)
{
    Coefficients c;
    c.stiffness = young;
    c.elastic = 4.0/3;
    c.damping = alpha*std::sqrt(4.0/3);
    c.shear = 8*shear/young;
    c.shearDamping = c.damping;
    c.exponent = b;
    return c;
}

/// Duration of a linear contact, s: pi/(omega sqrt(1 - zeta^2)), omega^2 = k/m.
inline double linearContactTime(double stiffness, double effectiveMass, double restitution)
{
    const double zeta = dampingRatio(restitution);
    return pi*std::sqrt(effectiveMass/stiffness)/std::sqrt(1 - zeta*zeta);
}

/// Duration of an elastic Hertz contact at impact speed v, s:
/// 2.8683 (m^2/(R E*^2 v))^(1/5) (Johnson 1985, Contact Mechanics, eq. 11.24: 2.94 overlap/v).
inline double hertzContactTime(double young, double effectiveRadius, double effectiveMass,
                               double speed)
{
    return 2.8683*std::pow(effectiveMass*effectiveMass
                           /(effectiveRadius*young*young*speed), 0.2);
}

/// Largest overlap of an elastic Hertz impact, m: (15 m v^2/(16 E* sqrt(R)))^(2/5).
inline double hertzOverlap(double young, double effectiveRadius, double effectiveMass, double speed)
{
    return std::pow(15*effectiveMass*speed*speed/(16*young*std::sqrt(effectiveRadius)), 0.4);
}

/// Largest overlap of an elastic linear impact, m: v sqrt(m/k).
inline double linearOverlap(double stiffness, double effectiveMass, double speed)
{
    return speed*std::sqrt(effectiveMass/stiffness);
}

/// Weight of a dashpot force ~ overlap^p in the first step of a contact that touched during the
/// fraction `theta` of that step, so that the sum over steps keeps second order:
/// -zeta(-p, 1 + theta) with Hurwitz' zeta function, that is 1/2 + theta for p = 0 (linear);
/// for p = 1/4 (Hertz) a Chebyshev fit good to 1e-4. It multiplies the force at an overlap of
/// one whole step, so it stands for theta^p and its quadrature correction together.
inline double onsetWeight(double theta, bool hertzian)
{
    return hertzian
        ? 0.3203419 + theta*(0.8638905 + theta*(0.1641759 - theta*0.0280252))
        : 0.5 + theta;
}

template<class Real>
struct Triple
{
    Real x, y, z;
};

/// A contact that touches, at one moment. Velocities are of first against second.
template<class Real>
struct Touch
{
    Triple<Real> normal;      // unit, from second to first
    Triple<Real> slip;        // m/s, velocity where they touch
    Triple<Real> turning;     // 1/s, rate of change of the normal
    Triple<Real> stretch;     // m, elastic tangential displacement so far
    Real overlap;             // m
    Real radius, mass;        // effective, m and kg
    Real before, after;       // s, half the step before and after this moment
};

/// Force on first, N, and the tangential displacement carried on.
template<class Real>
struct Push
{
    Real normal;              // along Touch::normal: elastic, dashpot and cohesion
    Real elastic, dashpot;    // elastic part, N; dashpot constant, kg/s
    Triple<Real> tangential;
    Triple<Real> stretch;
};

#define ELUTRIA_INLINE __attribute__((always_inline)) inline

ELUTRIA_INLINE float root(float a) { return __builtin_sqrtf(a); }
ELUTRIA_INLINE double root(double a) { return __builtin_sqrt(a); }
ELUTRIA_INLINE float power(float a, float b) { return __builtin_powf(a, b); }
ELUTRIA_INLINE double power(double a, double b) { return __builtin_pow(a, b); }

/// The stiffness S.
template<ContactLaw law, class Real>
ELUTRIA_INLINE Real stiffness(const CoefficientsOf<Real>& c, Real radius, Real overlap)
{
    return law == ContactLaw::linear ? c.stiffness : c.stiffness*root(radius*overlap);
}

/// Force of a touching contact.
///
/// The stretch follows the contact plane (its normal part goes, its length stays to second order in
/// the turn) and grows with the sliding velocity over the half steps on both sides. Coulomb's
/// limit uses the elastic part of the normal force: over a whole contact both parts bring the same
/// impulse, and the elastic part never pulls. The spring carries at most that limit, the dashpot
/// what the spring leaves of it. Spring-slider-dashpot, as stock OpenFOAM has it, limits by the whole
/// normal force, slides along the velocity and starts again from an unstretched spring.
template<ContactLaw law, bool otherExponent = false, class Real>
ELUTRIA_INLINE Push<Real> push(const CoefficientsOf<Real>& c, const Touch<Real>& t)
{
    Push<Real> p;
    const Triple<Real> n = t.normal, v = t.slip;
    const Real approach = v.x*n.x + v.y*n.y + v.z*n.z;      // negative while closing
    const Triple<Real> slide = {v.x - approach*n.x, v.y - approach*n.y, v.z - approach*n.z};
    const Real s = stiffness<law>(c, t.radius, t.overlap), damped = root(s*t.mass);
    p.elastic = c.elastic*s*t.overlap;
    if (otherExponent) p.elastic *= power(t.overlap, c.exponent - Real(1.5));
    p.dashpot = c.damping*damped;
    p.normal = p.elastic - p.dashpot*approach
               - c.cohesion*Real(4*pi)*t.radius*t.overlap;

    const Real along = t.stretch.x*n.x + t.stretch.y*n.y + t.stretch.z*n.z;
    const Triple<Real> stretch = {
        t.stretch.x - along*(n.x - t.before*t.turning.x) + t.before*slide.x,
        t.stretch.y - along*(n.y - t.before*t.turning.y) + t.before*slide.y,
        t.stretch.z - along*(n.z - t.before*t.turning.z) + t.before*slide.z};
    const Real spring = c.shear*s, dashpot = c.shearDamping*damped;
    if (law == ContactLaw::springSliderDashpot)
    {
        const Real total = p.normal < 0 ? -p.normal : p.normal, limit = c.friction*total;
        const Real length2 = stretch.x*stretch.x + stretch.y*stretch.y + stretch.z*stretch.z;
        const Real speed2 = slide.x*slide.x + slide.y*slide.y + slide.z*slide.z;
        const bool slips = spring*spring*length2 > limit*limit;
        const Real drag = slips ? limit/root(speed2 > 0 ? speed2 : Real(1)) : dashpot;
        const Real held = slips ? Real(0) : Real(1), pull = slips ? Real(0) : spring;
        p.tangential = {-pull*stretch.x - drag*slide.x, -pull*stretch.y - drag*slide.y,
                        -pull*stretch.z - drag*slide.z};
        p.stretch = {held*stretch.x + t.after*slide.x, held*stretch.y + t.after*slide.y,
                     held*stretch.z + t.after*slide.z};
    }
    else
    {
        const Triple<Real> f = {-spring*stretch.x - dashpot*slide.x,
                                -spring*stretch.y - dashpot*slide.y,
                                -spring*stretch.z - dashpot*slide.z};
        const Real limit = c.friction*p.elastic, trial2 = f.x*f.x + f.y*f.y + f.z*f.z;
        const bool slips = trial2 > limit*limit;
        const Real scale = slips ? limit/root(trial2 > 0 ? trial2 : Real(1)) : Real(1);
        const Real back = -1/(spring > 0 ? spring : Real(1));
        p.tangential = {scale*f.x, scale*f.y, scale*f.z};
        // The spring gives way only beyond the limit: were it set to carry what the dashpot adds,
        // it would give back energy that it never took.
        const Real length2 = stretch.x*stretch.x + stretch.y*stretch.y + stretch.z*stretch.z;
        const Real most = limit*(-back);
        const Real keep = length2 > most*most ? most/root(length2) : Real(1);
        p.stretch = {keep*stretch.x + t.after*slide.x,
                     keep*stretch.y + t.after*slide.y,
                     keep*stretch.z + t.after*slide.z};
    }
    return p;
}

} // namespace laws
} // namespace elutria::dem
