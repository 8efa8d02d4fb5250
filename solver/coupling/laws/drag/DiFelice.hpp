#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::laws
{

/// Di Felice 1994, doi 10.1016/0301-9322(94)90011-6: single-particle law of Dallavalle times
/// alpha^(2 - chi), superficial Re. The single-particle limit is 29 % high above Re 500: not for a
/// dilute column of coarse grains.
struct DiFelice : OfSuspensions
{
    static constexpr const char* name = "DiFeliceDrag";
    static constexpr const char* title = "Di Felice";
    static constexpr double maxRe = 1e4;
    static constexpr double minAlpha = 0.4;

    static double CdRe(double Re, double alpha, const Form&)
    {
        const double ReSuperficial = std::max(alpha*Re, 1e-12);
        const double chi = 3.7 - 0.65*std::exp(-0.5*std::pow(1.5 - std::log10(ReSuperficial), 2));
        const double root = 0.63*std::sqrt(ReSuperficial) + 4.8;

        return root*root*std::pow(alpha, -chi);
    }
};

} // namespace elutria::laws
