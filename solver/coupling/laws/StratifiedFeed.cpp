#include "StratifiedFeed.hpp"

#include "RandomNumber.hpp"
#include "core/constants.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace elutria::laws
{

namespace
{

/// Parcels of a block, and at least so many for each class of each material
constexpr std::size_t leastBlock = 512, perCell = 4;


/// The digits of i in base 2, mirrored: van der Corput's sequence, in [0, 1)
double mirrored(std::uint32_t i)
{
    std::uint32_t m = 0;
    for (int bit = 0; bit < 32; ++bit) m = m << 1 | (i >> bit & 1);
    return m*0x1.0p-32;
}


/// The same in base 3
double mirroredTernary(std::uint32_t i)
{
    double m = 0, digit = 1.0/3;
    for (; i > 0; i /= 3, digit /= 3) m += (i % 3)*digit;
    return m;
}


double fraction(double x)
{
    return x - std::floor(x);
}


/// Whole numbers that add up to n, as near to the quotas (which do, too) as the least allow
std::vector<std::size_t> apportioned(const std::vector<double>& quota,
                                     const std::vector<std::size_t>& least, std::size_t n)
{
    std::vector<std::size_t> count(quota.size());
    for (std::size_t i = 0; i < quota.size(); ++i)
        count[i] = std::max(least[i], std::size_t(std::max(quota[i], 0.0)));

    const auto wanting = [&](std::size_t i) { return quota[i] - double(count[i]); };
    for (std::size_t sum = std::accumulate(count.begin(), count.end(), std::size_t(0)); sum != n;)
    {
        const bool add = sum < n;
        std::size_t chosen = quota.size();
        for (std::size_t i = 0; i < quota.size(); ++i)
        {
            if (add ? !(quota[i] > 0) : count[i] <= least[i]) continue;
            if (chosen == quota.size()
                || (add ? wanting(i) > wanting(chosen) : wanting(i) < wanting(chosen)))
                chosen = i;
        }
        if (chosen == quota.size()) throw std::logic_error("a feed without size classes");
        add ? ++count[chosen], ++sum : (--count[chosen], --sum);
    }
    return count;
}


/// Order in which the n strata of a block enter
std::vector<std::size_t> entryOrder(std::size_t n, double rotation)
{
    std::vector<double> key(n);
    for (std::size_t t = 0; t < n; ++t)
        key[t] = fraction(mirrored(std::uint32_t(t)) + rotation);
    std::vector<std::size_t> byKey(n), order(n);
    std::iota(byKey.begin(), byKey.end(), std::size_t(0));
    std::sort(byKey.begin(), byKey.end(),
              [&](std::size_t a, std::size_t b) { return key[a] < key[b]; });
    for (std::size_t rank = 0; rank < n; ++rank) order[byKey[rank]] = rank;
    return order;
}

} // namespace


double Ingredient::meanMass() const
{
    return density*pi/6*sizes->meanCube();
}


StratifiedFeed::StratifiedFeed(std::vector<Ingredient> materials, Sampling sampling,
                               std::uint64_t seed, double massOfParcel,
                               const std::vector<double>& ends)
    : materials_(std::move(materials)), sampling_(sampling), seed_(seed),
      massOfParcel_(massOfParcel), numberOverMass_(0), blocksDrawn_(0),
      drawnNumber_(materials_.size()), drawnMass_(materials_.size())
{
    for (const Ingredient& m : materials_) numberOverMass_ += m.massFraction/m.meanMass();
    for (const double end : ends) addBlocks(end);
}


void StratifiedFeed::addBlocks(double end)
{
    const std::size_t size = std::max(leastBlock, perCell*cells(true).size());
    const std::size_t first = blocks_.empty() ? 0 : blocks_.back().end;
    const std::size_t last = std::size_t(std::max(std::round(end), double(first + 1)));
    for (std::size_t next = first + size; next + size <= last; next += size)
        blocks_.push_back({next, false, massOfParcel_*double(next)});
    blocks_.push_back({last, true, massOfParcel_*end});
}


FedParcel StratifiedFeed::operator[](std::size_t i) const
{
    while (drawn_.size() <= i) drawBlock();
    return drawn_[i];
}


std::vector<StratifiedFeed::Cell> StratifiedFeed::cells(bool byClass) const
{
    std::vector<Cell> all;
    for (std::size_t m = 0; m < materials_.size(); ++m)
    {
        const SizeCurves& sizes = *materials_[m].sizes;
        const double share = materials_[m].massFraction;
        if (!(share > 0)) continue;
        if (!byClass || sizes.min() == sizes.max())
        {
            all.push_back({int(m), 0, 1, share});
            continue;
        }
        const auto finer = [&](double d)
        { return sampling_ == Sampling::evenSizes ? sizes.evenFiner(d) : sizes.massFiner(d); };
        for (std::size_t k = 1; k < sizes.limits().size(); ++k)
        {
            const double low = finer(sizes.limits()[k - 1]), high = finer(sizes.limits()[k]);
            if (high > low) all.push_back({int(m), low, high, share*(high - low)});
        }
    }
    return all;
}


std::vector<std::size_t> StratifiedFeed::counts(const std::vector<Cell>& cells,
                                                std::size_t n) const
{
    std::vector<double> quota;
    for (const Cell& cell : cells) quota.push_back(double(n)*cell.parcels);
    return apportioned(quota, std::vector<std::size_t>(cells.size(), n < cells.size() ? 0 : 1), n);
}


StratifiedFeed::Strata StratifiedFeed::weightedStrata(std::size_t n, double mass) const
{
    std::vector<Cell> all = cells(true);
    if (n < all.size()) all = cells(false);
    const std::vector<std::size_t> count = counts(all, n);

    Strata strata;
    for (std::size_t c = 0; c < all.size(); ++c)
    {
        const Ingredient& material = materials_[all[c].material];
        const SizeCurves& sizes = *material.sizes;
        const auto massFiner = [&](std::size_t j)
        {
            const double u = all[c].low + double(j)/double(count[c])*(all[c].high - all[c].low);
            return sampling_ == Sampling::evenSizes ? sizes.massOfEven(u) : u;
        };
        for (std::size_t j = 0; j < count[c]; ++j)
        {
            const double low = massFiner(j), high = massFiner(j + 1);
            strata.push_back({all[c].material, low, high, mass*material.massFraction*(high - low),
                              material.density});
        }
    }
    return strata;
}


StratifiedFeed::Strata StratifiedFeed::particleStrata(std::size_t first, std::size_t n) const
{
    std::vector<double> due;
    for (std::size_t m = 0; m < materials_.size(); ++m)
    {
        const Ingredient& material = materials_[m];
        const double share = material.massFraction/material.meanMass()/numberOverMass_;
        due.push_back(double(first + n)*share - drawnNumber_[m]);
    }
    const std::vector<std::size_t> count =
        apportioned(due, std::vector<std::size_t>(due.size(), 0), n);

    Strata strata;
    for (std::size_t m = 0; m < count.size(); ++m)
        for (std::size_t j = 0; j < count[m]; ++j)
            strata.push_back({int(m), double(j)/double(count[m]), double(j + 1)/double(count[m]), 0,
                              materials_[m].density});
    return strata;
}


double StratifiedFeed::diameter(const Stratum& stratum, double at) const
{
    const SizeCurves& sizes = *materials_[stratum.material].sizes;
    const double u = stratum.low + at*(stratum.high - stratum.low);
    return sampling_ == Sampling::particles ? sizes.quantileByNumber(u) : sizes.quantileByMass(u);
}


double StratifiedFeed::particleMass(const Stratum& stratum, double at) const
{
    const double d = diameter(stratum, at);
    return stratum.density*pi/6*d*d*d;
}


void StratifiedFeed::meetMass(double mass, const Strata& strata, std::vector<double>& at) const
{
    for (std::size_t m = 0; m < materials_.size(); ++m)
    {
        const double due = materials_[m].massFraction*mass - drawnMass_[m];
        const auto moved = [&](std::size_t j, double by) { return std::clamp(at[j] + by, 0.0, 1.0); };
        const auto massMoved = [&](double by)
        {
            double sum = 0;
            for (std::size_t j = 0; j < strata.size(); ++j)
                if (strata[j].material == int(m)) sum += particleMass(strata[j], moved(j, by));
            return sum;
        };
        double low = -1, high = 1;      // where the mass is too small and too large
        for (int halvings = 0; halvings < 100; ++halvings)
        {
            const double middle = 0.5*(low + high);
            (massMoved(middle) < due ? low : high) = middle;
        }
        for (std::size_t j = 0; j < strata.size(); ++j)
            if (strata[j].material == int(m)) at[j] = moved(j, high);
    }
}


void StratifiedFeed::scatterDensities(std::size_t block, Strata& strata) const
{
    const double rotation = uniform(scrambled(seed_), std::uint64_t(block));
    std::vector<std::uint32_t> next(materials_.size(), 0);
    for (Stratum& s : strata)
    {
        const DensityScatter* const scatter = materials_[s.material].scatter;
        if (!scatter) continue;
        const double u = fraction(mirroredTernary(next[s.material]++) + rotation);
        s.density = sampling_ == Sampling::particles ? scatter->quantileByNumber(u)
                                                     : scatter->quantileByMass(u);
    }
}


void StratifiedFeed::drawBlock() const
{
    const std::size_t block = blocksDrawn_++, first = drawn_.size();
    const Block& here = blocks_.at(block);
    const std::size_t n = here.end - first;
    const double before = block > 0 ? blocks_[block - 1].mass : 0;
    const bool whole = sampling_ == Sampling::particles;
    Strata strata = whole ? particleStrata(first, n) : weightedStrata(n, here.mass - before);
    scatterDensities(block, strata);

    std::vector<double> at(n);
    for (std::size_t j = 0; j < n; ++j)
        at[j] = fraction(mirrored(std::uint32_t(block)) + uniform(seed_, std::uint64_t(j) << 1));
    if (here.last && whole) meetMass(here.mass, strata, at);

    const std::uint64_t key = std::uint64_t(block) << 1 | 1;
    for (const std::size_t j : entryOrder(n, uniform(seed_, key)))
    {
        const Stratum& s = strata[j];
        const double mass = whole ? particleMass(s, at[j]) : s.mass;
        drawn_.push_back({s.material, diameter(s, at[j]), mass, s.density});
        drawnNumber_[s.material] += 1;
        drawnMass_[s.material] += mass;
    }
}

} // namespace elutria::laws
