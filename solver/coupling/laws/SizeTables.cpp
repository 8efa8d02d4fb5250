#include "SizeTables.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace elutria::laws
{

namespace
{

constexpr const char* sizeColumns = "diameter_m, diameter_mm, diameter_um";
constexpr const char* shareColumns = "cumulative, cumulative_percent, retained, retained_UNIT";

/// Rounding of what laboratories report in percent
constexpr double rounding = 0.005;


[[noreturn]] void refuse(const std::string& what)
{
    throw std::invalid_argument(what);
}


std::string text(double value)
{
    std::ostringstream stream;
    stream << value;
    return stream.str();
}


std::vector<std::string> cells(const std::string& line)
{
    std::vector<std::string> found;
    std::istringstream stream(line + ',');
    for (std::string cell; std::getline(stream, cell, ',');)
    {
        const auto first = cell.find_first_not_of(" \t\r\""), last = cell.find_last_not_of(" \t\r\"");
        found.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    }
    return found;
}


double number(const std::string& cell, std::size_t line)
{
    std::size_t end = 0;
    double value = 0;
    try
    {
        value = std::stod(cell, &end);
    }
    catch (const std::exception&)
    {}
    if (end == 0 || end != cell.size() || !(value >= 0) || !std::isfinite(value))
        refuse("line " + std::to_string(line) + " has '" + cell + "', allowed: a number >= 0");
    return value;
}


struct Sieve
{
    double aperture, share;
};


struct Analysis
{
    std::vector<Sieve> sieves;      // from the finest
    bool cumulative;
};


Analysis read(const std::string& csv)
{
    std::istringstream stream(csv);
    std::string line;
    std::getline(stream, line);
    const std::vector<std::string> header = cells(line);

    Analysis found{{}, false};
    int size = -1, share = -1;
    double unit = 1, percent = 1;
    for (int k = 0; k < int(header.size()); ++k)
    {
        const std::string& name = header[k];
        if (name == "diameter_m" || name == "diameter_mm" || name == "diameter_um")
        {
            size = k;
            unit = name == "diameter_m" ? 1 : name == "diameter_mm" ? 1e-3 : 1e-6;
        }
        else if (name == "cumulative" || name == "cumulative_percent")
        {
            share = k;
            found.cumulative = true;
            percent = name == "cumulative" ? 1 : 100;
        }
        else if (name == "retained" || name.rfind("retained_", 0) == 0) share = k;
    }
    if (size < 0) refuse("the first line is '" + line + "', allowed: one of " + sizeColumns);
    if (share < 0) refuse("the first line is '" + line + "', allowed: one of " + shareColumns);

    for (std::size_t row = 2; std::getline(stream, line); ++row)
    {
        const std::vector<std::string> own = cells(line);
        if (own.empty() || (own.size() == 1 && own[0].empty())) continue;
        if (own.size() != header.size())
            refuse("line " + std::to_string(row) + " has " + std::to_string(own.size())
                   + " columns, allowed: " + std::to_string(header.size()));
        found.sieves.push_back({unit*number(own[size], row), number(own[share], row)/percent});
    }
    std::stable_sort(found.sieves.begin(), found.sieves.end(),
                     [](const Sieve& a, const Sieve& b) { return a.aperture < b.aperture; });
    for (std::size_t i = 1; i < found.sieves.size(); ++i)
        if (!(found.sieves[i].aperture > found.sieves[i - 1].aperture))
            refuse("the sieve of " + text(found.sieves[i].aperture) + " m is there twice");
    if (found.sieves.size() < 2) refuse("it has fewer than two sieves, allowed: at least two");
    return found;
}


/// From what lies on each sieve to what is finer than it
void accumulate(std::vector<Sieve>& sieves)
{
    if (sieves.back().share > 0)
        refuse("the widest sieve, " + text(sieves.back().aperture) + " m, retains "
               + text(sieves.back().share) + ", allowed: 0; add a wider sieve");
    double total = 0;
    for (Sieve& sieve : sieves)
    {
        const double retained = sieve.share;
        sieve.share = total;
        total += retained;
    }
    if (!(total > 0)) refuse("nothing is retained, allowed: some mass on a sieve");
    for (Sieve& sieve : sieves) sieve.share /= total;
}


void checkCumulative(std::vector<Sieve>& sieves)
{
    for (std::size_t i = 1; i < sieves.size(); ++i)
        if (sieves[i].share < sieves[i - 1].share)
            refuse("cumulative falls from " + text(sieves[i - 1].share) + " to "
                   + text(sieves[i].share) + " at " + text(sieves[i].aperture)
                   + " m, allowed: rising with the aperture");
    if (std::abs(sieves.back().share - 1) > rounding)
        refuse("cumulative ends at " + text(sieves.back().share)
               + ", allowed: 1 (100 percent) at the widest sieve");
    sieves.back().share = 1;
    for (Sieve& sieve : sieves) sieve.share = std::min(sieve.share, 1.0);
}


double share(const CumulativeCurve& curve, double d)
{
    if (d <= curve.diameter.front()) return 0;
    if (d >= curve.diameter.back()) return 1;
    const auto above = std::upper_bound(curve.diameter.begin(), curve.diameter.end(), d);
    const std::size_t i = above - curve.diameter.begin();
    const double s = (d - curve.diameter[i - 1])/(curve.diameter[i] - curve.diameter[i - 1]);
    return curve.finer[i - 1] + s*(curve.finer[i] - curve.finer[i - 1]);
}

} // namespace


CumulativeCurve sieveTable(const std::string& csv, double min)
{
    Analysis analysis = read(csv);
    std::vector<Sieve>& sieves = analysis.sieves;
    analysis.cumulative ? checkCumulative(sieves) : accumulate(sieves);

    if (sieves.front().aperture > 0 && sieves.front().share > 0)
        sieves.insert(sieves.begin(), Sieve{0, 0});        // the pan
    if (sieves.front().aperture == 0)
    {
        if (sieves.front().share > 0) refuse("cumulative is above 0 at aperture 0, allowed: 0");
        const double finest = sieves[1].aperture, passed = sieves[1].share;
        if (!(passed > 0)) sieves.erase(sieves.begin());
        else if (!(min > 0 && min < finest))
            refuse("min is " + text(min) + " and " + text(100*passed) + " % passed the finest sieve,"
                   + " allowed: a smallest size of that above 0 and below " + text(finest) + " m");
        else sieves.front().aperture = min;
    }
    std::vector<double> diameters, finer;
    for (const Sieve& sieve : sieves)
    {
        diameters.push_back(sieve.aperture);
        finer.push_back(sieve.share);
    }
    // Sieves finer than all, and wider than all that was fed
    while (finer.size() > 2 && finer[1] == 0)
    {
        diameters.erase(diameters.begin());
        finer.erase(finer.begin());
    }
    while (finer.size() > 2 && finer[finer.size() - 2] == 1)
    {
        diameters.pop_back();
        finer.pop_back();
    }
    return sieved(diameters, finer);
}


CumulativeCurve mixed(const std::vector<CumulativeCurve>& curves, const std::vector<double>& shares)
{
    double total = 0;
    for (const double one : shares)
    {
        if (!(one > 0) || !std::isfinite(one)) refuse("share is " + text(one) + ", allowed: a number > 0");
        total += one;
    }
    CumulativeCurve sum;
    for (const CumulativeCurve& curve : curves)
    {
        if (!(curve.diameter.back() > curve.diameter.front()))
            refuse("a part is a single size, allowed: a law or a table");
        sum.diameter.insert(sum.diameter.end(), curve.diameter.begin(), curve.diameter.end());
        sum.limit.insert(sum.limit.end(), curve.limit.begin(), curve.limit.end());
    }
    if (sum.diameter.empty()) refuse("there are no parts, allowed: at least one");
    for (std::vector<double>* const sizes : {&sum.diameter, &sum.limit})
    {
        std::sort(sizes->begin(), sizes->end());
        sizes->erase(std::unique(sizes->begin(), sizes->end()), sizes->end());
    }
    for (const double d : sum.diameter)
    {
        double finer = 0;
        for (std::size_t i = 0; i < curves.size(); ++i) finer += shares[i]/total*share(curves[i], d);
        sum.finer.push_back(finer);
    }
    sum.finer.front() = 0;
    sum.finer.back() = 1;
    return sum;
}

} // namespace elutria::laws
