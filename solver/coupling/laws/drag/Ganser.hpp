#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include <cmath>

namespace elutria::laws
{

/// Ganser 1993, doi 10.1016/0032-5910(93)80051-B, isometric particles: Stokes' factor K1 and Newton's
/// factor K2 from the sphericity; Re K1 K2 < 1e5. With the published coefficients a sphere has up to
/// 27 % less drag than the standard curve (Re 100).
struct Ganser : OfShapes
{
    static constexpr const char* name = "GanserDrag";
    static constexpr const char* title = "Ganser";
    static constexpr double maxRe = 1e5;

    static double CdRe(double Re, double, const Form& form)
    {
        const double K1 = 3/(1 + 2/std::sqrt(form.sphericity));
        const double K2 = std::pow(10.0, 1.8148*std::pow(-std::log10(form.sphericity), 0.5743));
        const double ReK = Re*K1*K2;

        return 24/K1*(1 + 0.1118*std::pow(ReK, 0.6567)) + Re*K2*0.4305*ReK/(ReK + 3305);
    }
};

} // namespace elutria::laws
