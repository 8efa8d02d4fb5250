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

    /// Share of the mass, and of the log size axis or of what focusOn made of it, below a diameter (m);
    /// and that of the mass at a share u of the latter.
    double massFiner(double diameter) const { return finer(diameter_, massFiner_, diameter); }
    double evenFiner(double diameter) const { return finer(diameter_, sizeFiner_, diameter); }
    double massOfEven(double u) const { return finer(sizeFiner_, massFiner_, u); }

    /// From here on half of the log size axis' share lies around a diameter (m), the other half is
    /// even as before; nothing changes where there is no mass.
    void focusOn(double diameter);

    /// Mean of d^3 over the particle numbers, m3.
    double meanCube() const noexcept { return meanCube_; }

    double min() const { return diameter_.front(); }
    double max() const { return diameter_.back(); }

    /// Sizes at which classes meet, the smallest and the largest among them, m.
    const std::vector<double>& limits() const { return limit_; }

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

    /// Class in which a rising list passes a value.
    static std::size_t classAt(const Shares& rising, double value);

    /// One curve's value where another has x, linear between their points.
    static double finer(const Shares& of, const Shares& value, double x);

    /// Cumulative curve with each class' share times d^power, power +-3.
    Shares reweighted(const Shares& finer, int power) const;

    double quantile(const Shares& shares, double u) const { return finer(shares, diameter_, u); }

    std::vector<double> diameter_, limit_;
    Shares numberFiner_, massFiner_;
    Shares sizeFiner_;      // of the log size axis, where it holds any mass
    double meanCube_;
};

} // namespace elutria::laws
