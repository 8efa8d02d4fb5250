#include "laws/SelfInducedVelocity.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::laws
{

namespace
{


/// A larger share is not attributed to the particle itself.
constexpr double largestShare = 0.5;

/// Below it a solid fraction is none.
constexpr double tiny = 1e-300;


double square(double x)
{
    return x*x;
}


/// What is still felt of a disturbance left behind, so many widths ago.
double felt(double widths)
{
    return (1 + std::erf(widths/std::sqrt(2.0)))*std::exp(-square(0.25*std::max(widths, 0.0)));
}


/// Part of inertia in how the deposit leaves its cell.
double inertiaShare(const DepositSurroundings& gas, double slip)
{
    const double reynolds = slip*gas.cellSize/gas.nu;
    return reynolds/(12 + reynolds);
}


/// Standard deviation [m] of the Gaussian that a deposit acts as.
double width(const DepositSurroundings& gas, double inertia)
{
    const double ratio = gas.kernel/gas.cellSize;
    return gas.cellSize*std::sqrt(
        (1 - inertia)*(square(0.337) + square(ratio)*std::min(1.0, 0.28 + 0.57*ratio)) +
        inertia*(square(0.277) + square(ratio)*std::min(1.0, 0.75*ratio)));
}

} // namespace


double selfInducedShare(double dragRate, const DepositMotion& motion,
                        const DepositSurroundings& gas)
{
    const double slip = std::max(motion.slip, tiny);
    const double inertia = inertiaShare(gas, slip);
    const double w = width(gas, inertia);
    const double ofCell = inertia*square(0.277*gas.cellSize/w);
    const double ahead = std::max(std::min(motion.velocity/slip, 0.4), -0.4);
    const double alone =
        std::sqrt(2/pi)/w/(1 + 0.5*slip*w/gas.nu)*(1 + 1.3*ahead*ofCell);
    const double b = std::max(alone - 2.837/gas.spacing, 0.0)/(6*pi*gas.mu);

    return std::min(dragRate*b*felt(motion.distance/w), largestShare);
}


bool outOfDisturbance(double distance, double kernel, double cellSize)
{
    const double widths = distance/std::hypot(kernel, 0.337*cellSize);
    if (widths > -4.8 && widths < 15.2) return false;    // felt falls on both sides
    return felt(widths) < 1e-6;
}


double depositKept(double kernel, double cellSize)
{
    const double y = std::min(square(kernel/cellSize), 100.0);
    const double part = std::exp(-y)*std::cyl_bessel_i(0, y);
    return part*(part*part);
}


double neighbourSpacing(double solidFraction, double parcelVolume, double ownFraction)
{
    return std::cbrt(parcelVolume/std::max(solidFraction - 1.2*ownFraction, tiny));
}

} // namespace elutria::laws
