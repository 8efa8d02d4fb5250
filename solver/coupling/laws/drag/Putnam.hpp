#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include <cmath>

namespace elutria::laws
{

/// Putnam 1961: Cd Re = 24 (1 + Re^(2/3)/6) up to Re 1000; Cd = 0.424 above. OpenFOAM has it itself.
struct Putnam : OfGrains
{
    static constexpr const char* name = "sphereDrag";
    static constexpr const char* title = "Putnam";
    static constexpr double maxRe = 2e5;

    static double CdRe(double Re, double, const Form&)
    {
        return Re > 1000 ? 0.424*Re : 24*(1 + std::pow(Re, 2.0/3)/6);
    }
};

} // namespace elutria::laws
