#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include "WenYu.hpp"

#include <cmath>

namespace elutria::laws
{

/// Gidaspow 1994: Ergun's packed bed below alpha = 0.8, Wen & Yu above. Ergun per particle:
/// Cd Re = (4/3)[150 (1 - alpha)/alpha + 1.75 Re]/alpha.
struct Gidaspow : OfSuspensions
{
    static constexpr const char* name = "GidaspowDrag";
    static constexpr const char* title = "Gidaspow";
    static constexpr double maxRe = 2e5;
    static constexpr double minAlpha = 0.36;

    static double CdRe(double Re, double alpha, const Form& form)
    {
        return alpha < 0.8
            ? 4.0/3.0*(150*(1 - alpha)/alpha + 1.75*Re)/alpha
            : WenYu::CdRe(Re, alpha, form);
    }
};

} // namespace elutria::laws
