// The drag of grains whose terminal velocities were measured.
#pragma once

#include <string>
#include <vector>

namespace elutria::laws
{

/// Terminal velocity of a grain of this size.
struct TerminalVelocity
{
    double diameter, velocity;      // m, m/s
};

/// From a csv with a header of two columns, its rows in any order:
///
///     diameter_m, diameter_mm or diameter_um
///     velocity_m_s
///
/// Throws std::invalid_argument that says what is allowed.
std::vector<TerminalVelocity> velocityTable(const std::string& csv);


/// An effective drag over Re. At each measured size drag is weight less buoyancy at the measured
/// velocity; the ratio of that drag to a sphere's (Schiller & Naumann) is interpolated linearly over
/// log Re, and is that of the nearest size beyond. Grains of all sizes are taken to have one shape.
class MeasuredDrag
{
    std::vector<double> logRe_, logRatio_;
    double smallest_, largest_;

public:

    /// Sizes and velocities, both rising; grains of a density, gas of a density and viscosity, SI.
    /// Throws std::invalid_argument that says what is allowed.
    MeasuredDrag(std::vector<TerminalVelocity>, double density, double gasDensity,
                 double gasViscosity, double gravity = 9.81);

    double CdRe(double Re) const;

    double largestRe() const;
    double smallest() const { return smallest_; }      // m, measured
    double largest() const { return largest_; }
};

} // namespace elutria::laws
