#include "Settling.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::laws
{

namespace
{

/// Where an expression that rises with its argument passes 0, between two positive limits.
template<class Expression>
double zero(double low, double high, const Expression& expression)
{
    for (int halving = 0; halving < 40; ++halving)
    {
        const double middle = std::sqrt(low*high);
        (expression(middle) < 0 ? low : high) = middle;
    }
    return low;
}

/// Cd Re of a single grain
double CdRe(Drag drag, const Grain& grain, double diameter, double slip, const Gas& gas)
{
    Form form = grain.form;
    form.densityRatio = grain.density/gas.density;
    return drag(gas.density*slip*diameter/gas.viscosity, 1, form);
}


/// Drag per volume of a particle, N/m3
double dragPerVolume(Drag drag, const Grain& grain, double diameter, double slip, const Gas& gas)
{
    return 0.75*gas.viscosity*slip/(diameter*diameter)
          *CdRe(drag, grain, diameter, slip, gas);
}

} // namespace


double relaxationTime(Drag drag, const Grain& grain, double diameter, double slip, const Gas& gas)
{
    return grain.density*diameter*diameter
          /(0.75*gas.viscosity*CdRe(drag, grain, diameter, slip, gas));
}


double terminalVelocity(Drag drag, const Grain& grain, double diameter, const Gas& gas,
                        double gravity)
{
    const double weight = (grain.density - gas.density)*gravity;
    if (!(weight > 0)) return 0;

    const double stokes = weight*diameter*diameter/(18*gas.viscosity);
    const auto excess = [&](double speed)
    { return dragPerVolume(drag, grain, diameter, speed, gas) - weight; };
    double fastest = 3*stokes;
    while (excess(fastest) < 0) fastest *= 3;       // measured grains may have less drag than spheres
    return zero(1e-6*std::min(stokes, 1.0), fastest, excess);
}


double settlingSize(Drag drag, const Grain& grain, double speed, const Gas& gas, double gravity,
                    double low, double high)
{
    const auto excess = [&](double diameter)
    {
        return (grain.density - gas.density)*gravity
             - dragPerVolume(drag, grain, diameter, speed, gas);
    };
    return excess(low) < 0 && excess(high) > 0 ? zero(low, high, excess) : 0;
}

} // namespace elutria::laws
