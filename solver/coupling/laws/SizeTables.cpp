#include "SizeTables.hpp"

#include "CsvTable.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace elutria::laws
{

namespace
{

constexpr const char* shareColumns =
    "one of cumulative, cumulative_percent, retained, retained_UNIT";

/// Rounding of what laboratories report in percent
constexpr double rounding = 0.005;


[[noreturn]] void refuse(const std::string& what)
{
    throw std::invalid_argument(what);
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


/// What lies on each sieve, in some unit; not on it and all wider ones
bool isRetained(const std::string& name)
{
    return name == "retained"
        || (name.rfind("retained_", 0) == 0 && name.find("cum") == std::string::npos);
}


Analysis read(const std::string& csv)
{
    const CsvTable table(csv);
    const CsvTable::Column size = table.sizes();
    Analysis found{{}, false};
    int share = -1;
    double percent = 1;
    for (int k = 0; k < int(table.header().size()); ++k)
    {
        const std::string& name = table.header()[k];
        const bool cumulative = name == "cumulative" || name == "cumulative_percent";
        if (!cumulative && !isRetained(name)) continue;
        if (share >= 0) table.refuseHeader("one column of shares");
        share = k;
        found.cumulative = cumulative;
        percent = name == "cumulative_percent" ? 100 : 1;
    }
    if (share < 0) table.refuseHeader(shareColumns);
    for (std::size_t i = 0; i < table.size(); ++i)
        found.sieves.push_back({size.unit*table.number(i, size.index),
                                table.number(i, share)/percent});
    std::stable_sort(found.sieves.begin(), found.sieves.end(),
                     [](const Sieve& a, const Sieve& b) { return a.aperture < b.aperture; });
    for (std::size_t i = 1; i < found.sieves.size(); ++i)
        if (!(found.sieves[i].aperture > found.sieves[i - 1].aperture))
            refuse("the sieve of " + csvText(found.sieves[i].aperture) + " m is there twice");
    if (found.sieves.size() < 2) refuse("it has fewer than two sieves, allowed: at least two");
    return found;
}


/// From what lies on each sieve to what is finer than it
void accumulate(std::vector<Sieve>& sieves)
{
    if (sieves.back().share > 0)
        refuse("the widest sieve, " + csvText(sieves.back().aperture) + " m, retains "
               + csvText(sieves.back().share) + ", allowed: 0; add a wider sieve");
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
            refuse("cumulative falls from " + csvText(sieves[i - 1].share) + " to "
                   + csvText(sieves[i].share) + " at " + csvText(sieves[i].aperture)
                   + " m, allowed: rising with the aperture");
    if (std::abs(sieves.back().share - 1) > rounding)
        refuse("cumulative ends at " + csvText(sieves.back().share)
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
            refuse("min is " + csvText(min) + " and " + csvText(100*passed) + " % passed the finest sieve,"
                   + " allowed: a smallest size of that above 0 and below " + csvText(finest) + " m");
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
        if (!(one > 0) || !std::isfinite(one)) refuse("share is " + csvText(one) + ", allowed: a number > 0");
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
