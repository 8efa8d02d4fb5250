#pragma once

#include "../Form.hpp"
#include "kinds.hpp"
#include "../MeasuredDrag.hpp"
#include "SchillerNaumann.hpp"

namespace elutria::laws
{

/// The drag of each material's measured terminal velocities (MeasuredDrag.hpp); of a material without
/// them Schiller and Naumann's.
struct MeasuredVelocity : OfGrains
{
    static constexpr const char* name = "MeasuredVelocityDrag";
    static constexpr const char* title = "measured velocity";
    static constexpr double maxRe = 2e5;

    static double CdRe(double Re, double alpha, const Form& form)
    {
        return form.measured ? form.measured->CdRe(Re) : SchillerNaumann::CdRe(Re, alpha, form);
    }
};

} // namespace elutria::laws
