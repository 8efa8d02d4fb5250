#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include <cmath>

namespace elutria::laws
{

/// Standard curve of Clift, Grace & Weber 1978, table 5.2, piecewise to Re = 1e6 (w = log10 Re).
struct Clift : OfGrains
{
    static constexpr const char* name = "CliftDrag";
    static constexpr const char* title = "Clift";
    static constexpr double maxRe = 1e6;

    static double CdRe(double Re, double, const Form&)
    {
        if (Re < 0.01) return 24 + 4.5*Re;

        const double w = std::log10(Re);
        const auto power = [](double x) { return std::pow(10.0, x); };
        if (Re <= 20) return 24*(1 + 0.1315*std::pow(Re, 0.82 - 0.05*w));
        if (Re <= 260) return 24*(1 + 0.1935*std::pow(Re, 0.6305));
        if (Re <= 1500) return Re*power(1.6435 - 1.1242*w + 0.1558*w*w);
        if (Re <= 1.2e4) return Re*power(-2.4571 + 2.5558*w - 0.9295*w*w + 0.1049*w*w*w);
        if (Re <= 4.4e4) return Re*power(-1.9181 + 0.6370*w - 0.0636*w*w);
        if (Re <= 3.38e5) return Re*power(-4.3390 + 1.5809*w - 0.1546*w*w);
        if (Re <= 4e5) return Re*(29.78 - 5.3*w);
        return Re*(0.1*w - 0.49);
    }
};

} // namespace elutria::laws
