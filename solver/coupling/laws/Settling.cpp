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

/// Drag per volume of a particle, N/m3
double dragPerVolume(Drag drag, const Grain& grain, double diameter, double slip, const Gas& gas)
{
    return 0.75*gas.viscosity*slip/(diameter*diameter)
          *drag(gas.density*slip*diameter/gas.viscosity, 1, grain.sphericity);
}

} // namespace


double relaxationTime(Drag drag, const Grain& grain, double diameter, double slip, const Gas& gas)
{
    const double Re = gas.density*slip*diameter/gas.viscosity;
    return grain.density*diameter*diameter/(0.75*gas.viscosity*drag(Re, 1, grain.sphericity));
}


double terminalVelocity(Drag drag, const Grain& grain, double diameter, const Gas& gas,
                        double gravity)
{
    const double weight = (grain.density - gas.density)*gravity;
    if (!(weight > 0)) return 0;

    const double stokes = weight*diameter*diameter/(18*gas.viscosity);
    return zero(1e-6*std::min(stokes, 1.0), 3*stokes,
                [&](double speed)
                { return dragPerVolume(drag, grain, diameter, speed, gas) - weight; });
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
