// A single particle in gas: how fast it falls, which size falls at a speed, how soon it follows the
// gas. SI units.
#pragma once

#include "DragLaws.hpp"

namespace elutria::laws
{

struct Gas
{
    double density;      // kg/m3
    double viscosity;    // Pa s, dynamic
};

struct Grain
{
    double density;      // kg/m3
    Form form;           // its density ratio is worked out with the gas
};

using Drag = double (*)(double Re, double alpha, const Form&);    // Cd Re

/// Time in which the drag at a slip speed would stop that slip, s: 4/3 rho_p d^2/(mu Cd Re).
double relaxationTime(Drag, const Grain&, double diameter, double slip, const Gas&);

/// Speed in gas at rest at which drag equals weight less buoyancy, m/s; 0 for a particle that is
/// not denser than the gas. Known to 2e-11 of itself.
double terminalVelocity(Drag, const Grain&, double diameter, const Gas&, double gravity);

/// Size between two limits whose terminal velocity is `speed`, m: the cut in uniform gas. 0 where
/// all sizes between rise, or all fall. Known to log(high/low) 1e-12 of itself.
double settlingSize(Drag, const Grain&, double speed, const Gas&, double gravity, double low,
                    double high);

} // namespace elutria::laws
