#include "SizeLaws.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace elutria::laws
{

namespace
{

/// Classes of the grid on which a curve is kept
constexpr int nClasses = 4096;


/// Standard normal distribution, of a distance over sqrt(2) deviations
double normalShare(double scaled)
{
    return 0.5*std::erfc(-scaled);
}


void require(bool allowed, const char* name, double value, const char* what)
{
    if (allowed) return;
    std::ostringstream text;
    text << name << " is " << value << ", allowed: " << what;
    throw std::invalid_argument(text.str());
}


void requirePositive(const char* name, double value)
{
    require(value > 0 && std::isfinite(value), name, value, "a number > 0");
}

} // namespace


const std::vector<SizeLaw>& sizeLaws()
{
    static const std::vector<SizeLaw> all{
        {"RosinRammler", {"d63", "n"},
         [](double d, const double* p) { return 1 - std::exp(-std::pow(d/p[0], p[1])); }},
        {"logNormal", {"d50", "sigma"},
         [](double d, const double* p)
         { return normalShare(std::log(d/p[0])/(std::sqrt(2.0)*std::log(p[1]))); }},
        {"normal", {"mean", "standardDeviation"},
         [](double d, const double* p) { return normalShare((d - p[0])/(std::sqrt(2.0)*p[1])); }},
        {"GatesGaudinSchuhmann", {"d100", "m"},
         [](double d, const double* p) { return std::min(std::pow(d/p[0], p[1]), 1.0); }},
        {"uniform", {}, [](double d, const double*) { return d; }},
    };
    return all;
}


const SizeLaw* findSizeLaw(const std::string& name)
{
    for (const SizeLaw& law : sizeLaws())
        if (name == law.name) return &law;
    return nullptr;
}


CumulativeCurve truncated(const SizeLaw& law, const double* parameters, double min, double max)
{
    for (std::size_t i = 0; i < law.parameters.size(); ++i)
    {
        requirePositive(law.parameters[i], parameters[i]);
        if (law.parameters[i] == std::string("sigma"))
            require(parameters[i] > 1, "sigma", parameters[i],
                    "a geometric standard deviation > 1");
    }
    requirePositive("min", min);
    requirePositive("max", max);

    const double below = law.finer(min, parameters), share = law.finer(max, parameters) - below;
    if (max <= min || !(share > 0))
    {
        std::ostringstream text;
        text << "min is " << min << " and max is " << max
             << ", allowed: 0 < min < max with some share of the law between";
        throw std::invalid_argument(text.str());
    }

    CumulativeCurve curve;
    for (int i = 0; i <= nClasses; ++i)
    {
        const double d = min*std::pow(max/min, double(i)/nClasses);
        curve.diameter.push_back(d);
        curve.finer.push_back((law.finer(d, parameters) - below)/share);
    }
    return curve;
}


CumulativeCurve sieved(const std::vector<double>& diameters, const std::vector<double>& finer)
{
    const std::size_t n = diameters.size();
    bool ordered = n >= 2 && finer.size() == n && diameters.front() > 0 && finer.front() == 0
                && finer.back() == 1;
    for (std::size_t i = 1; ordered && i < n; ++i)
        ordered = diameters[i] > diameters[i - 1] && finer[i] >= finer[i - 1];
    if (!ordered)
        throw std::invalid_argument("diameters, cumulative: allowed: lists of the same length,"
                                    " increasing, diameters > 0, cumulative from 0 to 1");

    // A fine grid between the sieves, so that the change of weighting within one sieve class is
    // followed
    CumulativeCurve curve;
    for (int i = 0; i <= nClasses; ++i)
    {
        const double s = double(i)/nClasses*(n - 1);
        const std::size_t k = std::min(std::size_t(s), n - 2);
        const auto between = [&](const std::vector<double>& values)
        { return values[k] + (s - k)*(values[k + 1] - values[k]); };
        curve.diameter.push_back(between(diameters));
        curve.finer.push_back(between(finer));
    }
    return curve;
}


CumulativeCurve single(double diameter)
{
    requirePositive("value", diameter);
    return {{diameter, diameter}, {0, 1}};
}

} // namespace elutria::laws
