#include "Form.hpp"

#include <cmath>

namespace elutria::laws
{

double ellipsoidSphericity(double flatness, double elongation)
{
    // Half axes a >= b >= c. Surface by Legendre's integrals:
    // 2 pi (c^2 + a b/sin(phi) (E(phi, k) sin(phi)^2 + F(phi, k) cos(phi)^2)), cos(phi) = c/a
    const double b = elongation, c = flatness*elongation;
    const double cosine = c, sine2 = 1 - c*c;
    const double sphere = 4*M_PI*std::cbrt(b*b*c*c);
    if (sine2 < 1e-12) return 1;

    const double phi = std::acos(cosine), sine = std::sqrt(sine2);
    const double k = std::sqrt((b*b - c*c)/(b*b*sine2));
    const double surface =
        2*M_PI*(c*c + b/sine*(std::ellint_2(k, phi)*sine2 + std::ellint_1(k, phi)*cosine*cosine));
    return sphere/surface;
}

} // namespace elutria::laws
