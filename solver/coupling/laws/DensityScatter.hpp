// Densities of a material whose grains are not all alike: intergrown ores, char, scrap.
//
// The stated curve is one of mass, as a float-and-sink analysis gives it, and the same at every size.
// At equal size a light grain brings less mass: the share of the numbers is that of the mass over the
// density.
#pragma once

#include "SizeLaws.hpp"

namespace elutria::laws
{

class DensityScatter
{
public:
    /// The curve's "diameters" are densities, kg/m3.
    explicit DensityScatter(const CumulativeCurve& byMass);

    /// Density below which the share u in [0, 1) of the mass, or of the numbers, lies, kg/m3.
    double quantileByMass(double u) const { return quantile(massLighter_, u); }
    double quantileByNumber(double u) const { return quantile(numberLighter_, u); }

    /// Means over the mass, and over the numbers, kg/m3.
    double meanByMass() const { return meanByMass_; }
    double meanByNumber() const { return meanByNumber_; }

    double min() const { return density_.front(); }
    double max() const { return density_.back(); }

private:
    double quantile(const std::vector<double>& lighter, double u) const;

    std::vector<double> density_, massLighter_, numberLighter_;
    double meanByMass_ = 0, meanByNumber_ = 0;
};

} // namespace elutria::laws
