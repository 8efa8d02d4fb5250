#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include <cmath>

namespace elutria::laws
{

/// Schiller & Naumann 1935: Cd Re = 24 (1 + 0.15 Re^0.687) up to Re 1000; Newton's Cd = 0.44 above.
struct SchillerNaumann : OfGrains
{
    static constexpr const char* name = "SchillerNaumannDrag";
    static constexpr const char* title = "Schiller-Naumann";
    static constexpr double maxRe = 2e5;

    static double CdRe(double Re, double, const Form&)
    {
        return Re > 1000 ? 0.44*Re : 24*(1 + 0.15*std::pow(Re, 0.687));
    }
};

} // namespace elutria::laws
