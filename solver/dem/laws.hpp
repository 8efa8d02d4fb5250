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

namespace elutria::dem::laws
{

constexpr double pi = 3.14159265358979323846;

/// Coefficients of a pair of materials in the form above.
struct Coefficients
{
    double stiffness = 0;       // k_n, N/m (linear) or E*, Pa (Hertz)
    double elastic = 1;
    double damping = 0;
    double shear = 0;
    double shearDamping = 0;
    double friction = 0;
    double rolling = 0;
    double cohesion = 0;        // J/m^3
    double exponent = 1.5;      // of the overlap, spring-slider-dashpot only
};

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

/// Pull of a simplified JKR contact, N: cohesion energy density times contact area
/// 2 pi overlap 2 R (R effective; circle in which the two spheres intersect, small overlaps).
inline double cohesionForce(double cohesion, double effectiveRadius, double overlap)
{
    return cohesion*4*pi*effectiveRadius*overlap;
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

} // namespace elutria::dem::laws
