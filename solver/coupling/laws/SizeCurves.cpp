#include "SizeCurves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elutria::laws
{

namespace
{

/// Largest size over that in the focus, and that over the smallest
constexpr double focusFactor = 1.3;


/// Cumulative, to end at 1
void scale(std::vector<double>& shares)
{
    for (double& share : shares) share /= shares.back();
}

} // namespace


SizeCurves::SizeCurves(CumulativeCurve stated, Weighting weighting)
    : diameter_(std::move(stated.diameter)), limit_(std::move(stated.limit)), meanCube_(0)
{
    const bool byMass = weighting == Weighting::mass;
    const Shares other = reweighted(stated.finer, byMass ? -3 : 3);
    massFiner_ = byMass ? stated.finer : other;
    numberFiner_ = byMass ? other : stated.finer;

    sizeFiner_ = evenlyAround(diameter_.front(), std::numeric_limits<double>::infinity());
    if (sizeFiner_.empty()) sizeFiner_ = massFiner_;        // a single size

    for (std::size_t i = 1; i < diameter_.size(); ++i)
        meanCube_ += (numberFiner_[i] - numberFiner_[i - 1])*classCube(i);
}


double SizeCurves::classCube(std::size_t i) const
{
    const double a = diameter_[i - 1], b = diameter_[i];
    return 0.25*(a + b)*(a*a + b*b);
}


SizeCurves::Shares SizeCurves::reweighted(const Shares& finer, int power) const
{
    Shares shares(finer.size(), 0.0);
    for (std::size_t i = 1; i < finer.size(); ++i)
    {
        const double weight = power > 0 ? classCube(i) : 1/classCube(i);
        shares[i] = shares[i - 1] + (finer[i] - finer[i - 1])*weight;
    }
    scale(shares);
    return shares;
}


SizeCurves::Shares SizeCurves::evenlyAround(double diameter, double factor) const
{
    Shares shares(massFiner_.size(), 0.0);
    for (std::size_t i = 1; i < shares.size(); ++i)
    {
        const double low = diameter_[i - 1], high = diameter_[i];
        const bool filled = massFiner_[i] > massFiner_[i - 1] && low*factor >= diameter
                         && high <= factor*diameter;
        shares[i] = shares[i - 1] + (filled ? std::log(high/low) : 0);
    }
    if (!(shares.back() > 0)) return {};
    scale(shares);
    return shares;
}


void SizeCurves::focusOn(double diameter)
{
    const Shares around = evenlyAround(diameter, focusFactor);
    for (std::size_t i = 0; i < around.size(); ++i)
        sizeFiner_[i] = 0.5*(sizeFiner_[i] + around[i]);
}


std::size_t SizeCurves::classAt(const Shares& rising, double value)
{
    const auto upper = std::upper_bound(rising.begin(), rising.end(), value) - rising.begin();
    return std::min(std::max(std::size_t(upper), std::size_t(1)), rising.size() - 1);
}


double SizeCurves::finer(const Shares& of, const Shares& value, double x)
{
    const std::size_t i = classAt(of, x);
    const double low = of[i - 1], high = of[i];
    const double s = high > low ? (x - low)/(high - low) : 0;
    return s < 1 ? value[i - 1] + s*(value[i] - value[i - 1]) : value[i];
}

} // namespace elutria::laws
