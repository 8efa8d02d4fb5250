#include "DensityScatter.hpp"

#include <algorithm>

namespace elutria::laws
{

DensityScatter::DensityScatter(const CumulativeCurve& byMass)
    : density_(byMass.diameter), massLighter_(byMass.finer), numberLighter_(density_.size(), 0.0)
{
    for (std::size_t i = 1; i < density_.size(); ++i)
    {
        const double middle = 0.5*(density_[i] + density_[i - 1]);
        const double share = massLighter_[i] - massLighter_[i - 1];
        meanByMass_ += share*middle;
        numberLighter_[i] = numberLighter_[i - 1] + share/middle;
    }
    meanByNumber_ = 1/numberLighter_.back();
    for (double& share : numberLighter_) share *= meanByNumber_;
}


double DensityScatter::quantile(const std::vector<double>& lighter, double u) const
{
    const auto above = std::upper_bound(lighter.begin(), lighter.end(), u);
    const std::size_t k =
        std::min(std::size_t(above - lighter.begin()), lighter.size() - 1);
    const double step = lighter[k] - lighter[k - 1];
    const double part = step > 0 ? (u - lighter[k - 1])/step : 0;
    return density_[k - 1] + part*(density_[k] - density_[k - 1]);
}

} // namespace elutria::laws
