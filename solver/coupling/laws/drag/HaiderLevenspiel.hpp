#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include <cmath>

namespace elutria::laws
{

/// Haider & Levenspiel 1989, doi 10.1016/0032-5910(89)80008-7, isometric particles of sphericity
/// 0.67-1 and disks below; Re < 2.6e5.
struct HaiderLevenspiel : OfShapes
{
    static constexpr const char* name = "HaiderLevenspielDrag";
    static constexpr const char* title = "Haider-Levenspiel";
    static constexpr double maxRe = 2.6e5;

    static double CdRe(double Re, double, const Form& form)
    {
        const double s = form.sphericity;
        const double A = std::exp(2.3288 - 6.4581*s + 2.4486*s*s);
        const double B = 0.0964 + 0.5565*s;
        const double C = std::exp(4.905 - 13.8944*s + 18.4222*s*s - 10.2599*s*s*s);
        const double D = std::exp(1.4681 + 12.2584*s - 20.7322*s*s + 15.8855*s*s*s);

        return 24*(1 + A*std::pow(Re, B)) + Re*C*Re/(Re + D);
    }
};

} // namespace elutria::laws
