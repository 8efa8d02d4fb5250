#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include <cmath>

namespace elutria::laws
{

/// Hoelzer & Sommerfeld 2008, doi 10.1016/j.powtec.2007.08.021, equation 9, any shape:
///
///     Cd = 8/(Re sqrt(lengthwise)) + 16/(Re sqrt(s)) + 3/(sqrt(Re) s^(3/4))
///          + 0.42 10^(0.4 (-log10 s)^0.2)/crosswise
///
/// for a grain of random orientation. Its mean projected area is a quarter of its surface (Cauchy,
/// convex grains), so that the crosswise sphericity, the sphere's cross-section over it, and the
/// lengthwise one, over half the surface less it, are both the sphericity s. A grain that falls flat
/// has more drag: a cube by a third in Newton's range. A sphere has 16 % less drag than the standard
/// curve at Re 50, and 20 % more at Re 2500.
struct HoelzerSommerfeld : OfShapes
{
    static constexpr const char* name = "HoelzerSommerfeldDrag";
    static constexpr const char* title = "Hoelzer-Sommerfeld";
    static constexpr double maxRe = 3e5;

    static double CdRe(double Re, double, const Form& form)
    {
        const double s = form.sphericity;
        const double newton = 0.42*std::pow(10.0, 0.4*std::pow(-std::log10(s), 0.2))/s;

        return 24/std::sqrt(s) + 3*std::sqrt(Re)/std::pow(s, 0.75) + newton*Re;
    }
};

} // namespace elutria::laws
