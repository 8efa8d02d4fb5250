#include "RateTable.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace elutria::laws
{

namespace
{

[[noreturn]] void refuse(const char* what, double value, const char* allowed)
{
    std::ostringstream text;
    text << what << value << ", allowed: " << allowed;
    throw std::invalid_argument(text.str());
}

} // namespace


RateTable::RateTable(std::vector<double> times, std::vector<double> rates)
    : time_(std::move(times)), rate_(std::move(rates)), mass_(time_.size(), 0.0)
{
    if (time_.size() < 2 || rate_.size() != time_.size())
        refuse("the number of its times is ", double(time_.size()), "two or more, each with a rate");
    for (std::size_t i = 0; i < time_.size(); ++i)
    {
        if (!(rate_[i] >= 0 && std::isfinite(rate_[i])))
            refuse("it has the rate ", rate_[i], "0 or more (kg/s)");
        if (!std::isfinite(time_[i]) || (i > 0 && !(time_[i] > time_[i - 1])))
            refuse("it has the time ", time_[i], "rising times (s)");
        if (i > 0)
            mass_[i] = mass_[i - 1] + 0.5*(rate_[i] + rate_[i - 1])*(time_[i] - time_[i - 1]);
    }
}


double RateTable::peak() const
{
    return *std::max_element(rate_.begin(), rate_.end());
}


double RateTable::until(double time) const
{
    if (!(time > begin())) return 0;
    if (!(time < end())) return mass_.back();
    const std::size_t k =
        std::size_t(std::upper_bound(time_.begin(), time_.end(), time) - time_.begin()) - 1;
    const double slope = (rate_[k + 1] - rate_[k])/(time_[k + 1] - time_[k]);
    const double t = time - time_[k];
    return mass_[k] + t*(rate_[k] + 0.5*slope*t);
}


double RateTable::timeOf(double mass, double from) const
{
    const double wanted = std::min(until(from) + mass, mass_.back());
    const std::size_t k =
        std::size_t(std::lower_bound(mass_.begin(), mass_.end(), wanted) - mass_.begin());
    if (k == 0) return std::max(from, begin());

    // Of rate t + slope t^2/2 = more the root that stays finite where the slope vanishes
    const double slope = (rate_[k] - rate_[k - 1])/(time_[k] - time_[k - 1]);
    const double rate = rate_[k - 1], more = wanted - mass_[k - 1];
    const double root = std::sqrt(std::max(rate*rate + 2*slope*more, 0.0));
    const double t = rate + root > 0 ? 2*more/(rate + root) : 0;
    return std::max(from, std::min(time_[k - 1] + t, time_[k]));
}

} // namespace elutria::laws
