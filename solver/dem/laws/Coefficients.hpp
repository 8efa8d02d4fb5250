#pragma once

#include <cmath>

// What all contact laws share. SI units.
//
// All laws have one form with a stiffness S:
//   elastic normal force    F_e = elastic*S*overlap
//   normal dashpot          g_n = damping*sqrt(S*m)
//   tangential stiffness    k_t = shear*S
//   tangential dashpot      g_t = shearDamping*sqrt(S*m)
// with m the effective mass 1/(1/m_i + 1/m_j). Linear law: S = k_n. Hertz: S = E*a with the contact
// radius a = sqrt(R*overlap), 1/R = 1/R_i + 1/R_j.
// Cohesion is a simplified JKR: a pull of cohesion energy density times contact area 4 pi R overlap
// (the circle in which two spheres intersect, small overlaps).

namespace elutria::dem::laws
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
/// Poeschel 2007, doi 10.1007/s10035-007-0065-z) and, in the Hertz dashpot, for Hertz (Tsuji
/// et al. 1992, doi 10.1016/0032-5910(92)88030-L; Antypov and Elliott 2011,
/// doi 10.1209/0295-5075/94/50004).
inline double dampingRatio(double restitution)
{
    const double l = std::log(restitution);
    return -l/std::sqrt(pi*pi + l*l);
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

} // namespace elutria::dem::laws
