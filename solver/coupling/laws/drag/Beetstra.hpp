#pragma once

#include <algorithm>
#include <cmath>

namespace elutria::laws
{

/// Beetstra, van der Hoef & Kuipers 2007, doi 10.1002/aic.11065, lattice Boltzmann simulations,
/// monodisperse; superficial Re < 1000: F = drag/(3 pi mu d alpha u), Cd Re = 24 F.
struct Beetstra
{
    static constexpr const char* name = "BeetstraDrag";
    static constexpr const char* title = "Beetstra";
    static constexpr double maxRe = 1e3;
    static constexpr double minAlpha = 0.36;
    static constexpr bool knowsVoid = true;
    static constexpr bool knowsShape = false;

    static double CdRe(double Re, double alpha, double)
    {
        const double phi = 1 - alpha;
        const double R = std::max(alpha*Re, 1e-12);
        const double stokes =
            10*phi/(alpha*alpha) + alpha*alpha*(1 + 1.5*std::sqrt(phi));
        const double inertial =
            0.413*R/(24*(alpha*alpha))
           *(1/alpha + 3*alpha*phi + 8.4*std::pow(R, -0.343))
           /(1 + std::pow(10.0, 3*phi)*std::pow(R, -0.5*(1 + 4*phi)));

        // F is per particle with the whole pressure gradient in the gas
        return 24*(stokes + inertial);
    }
};

} // namespace elutria::laws
