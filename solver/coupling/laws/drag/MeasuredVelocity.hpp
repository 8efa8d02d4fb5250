#pragma once

#include "../Form.hpp"
#include "../MeasuredDrag.hpp"
#include "SchillerNaumann.hpp"

namespace elutria::laws
{

/// The drag of each material's measured terminal velocities (MeasuredDrag.hpp); of a material without
/// them Schiller and Naumann's.
struct MeasuredVelocity
{
    static constexpr const char* name = "MeasuredVelocityDrag";
    static constexpr const char* title = "measured velocity";
    static constexpr double maxRe = 2e5;
    static constexpr double minAlpha = 0.9;
    static constexpr bool knowsVoid = false;
    static constexpr bool knowsShape = false;
    static constexpr bool knowsMean = false;

    static double CdRe(double Re, double alpha, const Form& form)
    {
        return form.measured ? form.measured->CdRe(Re) : SchillerNaumann::CdRe(Re, alpha, form);
    }
};

} // namespace elutria::laws
