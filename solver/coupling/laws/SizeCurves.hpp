// What a material's sizes are, by number, by mass and along a log axis of size.
//
// The stated curve is one of mass or of number. Where it is of mass, the share of the particle
// *numbers* in a thin size class is proportional to dQ/d^3 (equal mass in small grains means more of
// them). All curves are kept on one fine grid; a size is drawn by inverting one of them.
#pragma once

#include "SizeLaws.hpp"

namespace elutria::laws
{

enum class Weighting { mass, number };

class SizeCurves
{
public:
    SizeCurves(CumulativeCurve stated, Weighting);

    /// Diameter below which the share u in [0, 1) of the numbers, or of the mass, lies, m.
    double quantileByNumber(double u) const { return quantile(numberFiner_, u); }
    double quantileByMass(double u) const { return quantile(massFiner_, u); }

    /// Diameter at the share u in [0, 1) of the log size axis, or of what focusOn made of it, m; and
    /// the mass there over that share.
    double quantileBySize(double u) const { return quantile(sizeFiner_, u); }
    double massOverEven(double u) const;

    /// From here on half of the log size axis' share lies around a diameter (m), the other half is
    /// even as before; nothing changes where there is no mass.
    void focusOn(double diameter);

    /// Mean of d^3 over the particle numbers, m3.
    double meanCube() const noexcept { return meanCube_; }

    double min() const { return diameter_.front(); }
    double max() const { return diameter_.back(); }

    /// The curves' points.
    const std::vector<double>& diameters() const { return diameter_; }
    const std::vector<double>& massFiner() const { return massFiner_; }
    const std::vector<double>& numberFiner() const { return numberFiner_; }

private:
    using Shares = std::vector<double>;

    /// Mean of d^3 in class i (equal shares per size step), m3.
    double classCube(std::size_t i) const;

    /// Cumulative length on a log axis of the classes within a factor of a diameter that are not
    /// empty, as a share; nothing where all are.
    Shares evenlyAround(double diameter, double factor) const;

    /// Class in which a cumulative curve passes a share.
    std::size_t classAt(const Shares& finer, double u) const;

    /// Cumulative curve with each class' share times d^power, power +-3.
    Shares reweighted(const Shares& finer, int power) const;

    double quantile(const Shares& finer, double u) const;

    std::vector<double> diameter_;
    Shares numberFiner_, massFiner_;
    Shares sizeFiner_;      // of the log size axis, where it holds any mass
    double meanCube_;
};

} // namespace elutria::laws
