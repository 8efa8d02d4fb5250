#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include "SchillerNaumann.hpp"

#include <cmath>

namespace elutria::laws
{

/// Wen & Yu 1966: Schiller-Naumann with the superficial Re, times alpha^-3.65.
struct WenYu : OfSuspensions
{
    static constexpr const char* name = "WenYuVoidDrag";
    static constexpr const char* title = "Wen-Yu";
    static constexpr double maxRe = 2e5;
    static constexpr double minAlpha = 0.45;

    static double CdRe(double Re, double alpha, const Form& form)
    {
        return SchillerNaumann::CdRe(alpha*Re, alpha, form)*std::pow(alpha, -3.65);
    }
};

} // namespace elutria::laws
