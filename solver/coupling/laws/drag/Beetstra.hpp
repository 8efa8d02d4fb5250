#pragma once

#include "../Form.hpp"
#include "kinds.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::laws
{

/// Beetstra, van der Hoef & Kuipers 2007, doi 10.1002/aic.11065, lattice Boltzmann simulations;
/// superficial Re < 1000: F = drag/(3 pi mu d alpha u), Cd Re = 24 F.
///
/// Several sizes (van der Hoef, Beetstra & Kuipers 2005, doi 10.1017/S0022112004003295): F is that of
/// the Sauter mean <d>, times alpha y + phi y^2 + 0.064 alpha y^3 with y = d/<d>. That was found at
/// solid fractions phi of 0.1 to 0.6 and does not end in the drag of a single sphere: below 0.1 the
/// factor goes linearly to 1, and Re to the particle's own.
struct Beetstra : OfSuspensions
{
    static constexpr const char* name = "BeetstraDrag";
    static constexpr const char* title = "Beetstra";
    static constexpr double maxRe = 1e3;
    static constexpr double minAlpha = 0.36;
    static constexpr bool knowsMean = true;

    /// Of the only size, or of the Sauter mean
    static double monodisperse(double Re, double alpha)
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

    static double CdRe(double Re, double alpha, const Form& form)
    {
        const double y = form.overMean, phi = 1 - alpha;
        const double own = monodisperse(Re, alpha);
        if (std::abs(y - 1) < 1e-9) return own;

        const double factor = alpha*y + phi*y*y + 0.064*alpha*y*y*y;
        const double dense = std::min(phi/0.1, 1.0);
        return (1 - dense)*own + dense*factor*monodisperse(Re/y, alpha);
    }
};

} // namespace elutria::laws
