#include "SizeLaws.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace elutria::laws
{

namespace
{

/// Steps of the grid on which a curve is kept
constexpr int nSteps = 4096;

/// Renard series R20 of ISO 3, 20 a decade: nominal apertures of ISO 565 sieves
constexpr const char* series[]{
    "1.0", "1.12", "1.25", "1.4", "1.6", "1.8", "2.0", "2.24", "2.5", "2.8",
    "3.15", "3.55", "4.0", "4.5", "5.0", "5.6", "6.3", "7.1", "8.0", "9.0"};


/// Members of the series between two sizes, rising; read as text, as the tools do
std::vector<double> seriesBetween(double min, double max)
{
    std::vector<double> found;
    for (int k = int(std::floor(std::log10(min))) - 1; k <= int(std::floor(std::log10(max))); ++k)
        for (const char* number : series)
        {
            const double size = std::stod(number + ("e" + std::to_string(k)));
            if (size > min && size < max) found.push_back(size);
        }
    return found;
}


/// All of both lists, rising; of two that differ by rounding the one of `kept`
std::vector<double> merged(const std::vector<double>& kept, const std::vector<double>& others)
{
    std::vector<double> all(kept);
    for (const double x : others)
    {
        const auto next = std::lower_bound(kept.begin(), kept.end(), x*(1 - 1e-12));
        if (next == kept.end() || *next > x*(1 + 1e-12)) all.push_back(x);
    }
    std::sort(all.begin(), all.end());
    return all;
}


/// A curve on the grid, with the given limits and those of the series
template<class Finer>
CumulativeCurve onGrid(const std::vector<double>& grid, const std::vector<double>& given,
                       const Finer& finer)
{
    CumulativeCurve curve;
    curve.limit = merged(given, seriesBetween(given.front(), given.back()));
    curve.diameter = merged(curve.limit, grid);
    for (const double d : curve.diameter) curve.finer.push_back(finer(d));
    curve.finer.front() = 0;
    curve.finer.back() = 1;
    return curve;
}


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


void requireUpTo(const char* name, double value, double most)
{
    std::ostringstream allowed;
    allowed << "a number > 0, up to " << most;
    require(value > 0 && value <= most, name, value, allowed.str().c_str());
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


CumulativeCurve truncated(const SizeLaw& law, const double* parameters, double min, double max,
                          double most)
{
    for (std::size_t i = 0; i < law.parameters.size(); ++i)
    {
        requirePositive(law.parameters[i], parameters[i]);
        if (law.parameters[i] == std::string("sigma"))
            require(parameters[i] > 1, "sigma", parameters[i],
                    "a geometric standard deviation > 1");
    }
    requireUpTo("min", min, most);
    requireUpTo("max", max, most);

    const double below = law.finer(min, parameters), share = law.finer(max, parameters) - below;
    if (max <= min || !(share > 0))
    {
        std::ostringstream text;
        text << "min is " << min << " and max is " << max
             << ", allowed: 0 < min < max with some share of the law between";
        throw std::invalid_argument(text.str());
    }

    std::vector<double> grid;
    for (int i = 1; i < nSteps; ++i) grid.push_back(min*std::pow(max/min, double(i)/nSteps));
    return onGrid(grid, {min, max},
                  [&](double d) { return (law.finer(d, parameters) - below)/share; });
}


CumulativeCurve sieved(const std::vector<double>& diameters, const std::vector<double>& finer,
                       const char* named, double most)
{
    const std::size_t n = diameters.size();
    bool ordered = n >= 2 && finer.size() == n && diameters.front() > 0 && finer.front() == 0
                && finer.back() == 1;
    for (std::size_t i = 1; ordered && i < n; ++i)
        ordered = diameters[i] > diameters[i - 1] && finer[i] >= finer[i - 1];
    if (!ordered)
        throw std::invalid_argument(std::string(named) + ", cumulative: allowed: lists of the same"
                                    " length, increasing, " + named + " > 0, cumulative from 0 to 1");
    requireUpTo(named, diameters.back(), most);

    // A fine grid between the sieves, so that the change of weighting within one sieve class is
    // followed
    std::vector<double> grid;
    for (int i = 1; i < nSteps; ++i)
    {
        const double s = double(i)/nSteps*(n - 1);
        const std::size_t k = std::min(std::size_t(s), n - 2);
        grid.push_back(diameters[k] + (s - k)*(diameters[k + 1] - diameters[k]));
    }
    return onGrid(grid, diameters, [&](double d)
    {
        const auto above = std::upper_bound(diameters.begin(), diameters.end(), d);
        const std::size_t k = std::min(std::size_t(above - diameters.begin()), n - 1);
        const double s = (d - diameters[k - 1])/(diameters[k] - diameters[k - 1]);
        return finer[k - 1] + s*(finer[k] - finer[k - 1]);
    });
}


CumulativeCurve single(double diameter)
{
    requireUpTo("value", diameter, largestSize);
    return {{diameter, diameter}, {0, 1}, {diameter, diameter}};
}

} // namespace elutria::laws
