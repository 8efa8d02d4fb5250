/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/SizeDistribution.H"
#include "foam/foamVersion.H"

#include <algorithm>
#include <cmath>
#include <functional>

namespace Foam
{

namespace
{

//- Classes of the grid on which the curves are kept
constexpr label nClasses = 4096;

scalar readPositive(const dictionary& dict, const word& entry)
{
    const scalar value = dict.get<scalar>(entry);

    if (!(value > 0) || !std::isfinite(value))
    {
        FatalIOErrorInFunction(dict)
            << entry << " is " << value << ", allowed: a size > 0"
            << exit(FatalIOError);
    }
    return value;
}


//- The stated cumulative law, not yet truncated
std::function<scalar(scalar)> statedLaw(const dictionary& dict)
{
    const word type(dict.get<word>("type"));

    if (type == "RosinRammler")
    {
        const scalar d63 = readPositive(dict, "d63");
        const scalar n = readPositive(dict, "n");
        return [=](scalar d) { return 1 - std::exp(-std::pow(d/d63, n)); };
    }
    if (type == "logNormal")
    {
        const scalar d50 = readPositive(dict, "d50");
        const scalar sigma = readPositive(dict, "sigma");
        if (sigma <= 1)
        {
            FatalIOErrorInFunction(dict)
                << "sigma is " << sigma
                << ", allowed: a geometric standard deviation > 1"
                << exit(FatalIOError);
        }
        return [=](scalar d)
        {
            return
                0.5*std::erfc(-std::log(d/d50)/(std::sqrt(2.0)*std::log(sigma)));
        };
    }
    if (type == "normal")
    {
        const scalar mean = readPositive(dict, "mean");
        const scalar deviation = readPositive(dict, "standardDeviation");
        return [=](scalar d)
        {
            return 0.5*std::erfc(-(d - mean)/(std::sqrt(2.0)*deviation));
        };
    }
    if (type == "uniform")
    {
        return [](scalar d) { return d; };
    }

    FatalIOErrorInFunction(dict)
        << "sizeDistribution type is " << type << ", allowed: RosinRammler,"
        << " logNormal, normal, uniform, fixedValue, table"
        << exit(FatalIOError);
    return nullptr;
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void SizeDistribution::buildStatedCurve
(
    const dictionary& dict,
    scalarList& finer
)
{
    const word type(dict.get<word>("type"));

    if (type == "fixedValue")
    {
        diameter_ = scalarList(2, readPositive(dict, "value"));
        finer = scalarList({0, 1});
        return;
    }
    if (type == "table")
    {
        dict.readEntry("diameters", diameter_);
        dict.readEntry("cumulative", finer);

        const bool shapeOk =
            diameter_.size() == finer.size() && diameter_.size() >= 2;

        bool ordered =
            shapeOk && diameter_.first() > 0
         && finer.first() == 0 && finer.last() == 1;

        for (label i = 1; ordered && i < diameter_.size(); ++i)
        {
            ordered =
                diameter_[i] > diameter_[i-1] && finer[i] >= finer[i-1];
        }
        if (!ordered)
        {
            FatalIOErrorInFunction(dict)
                << "diameters and cumulative must be lists of the same length,"
                << " increasing, diameters > 0, cumulative from 0 to 1"
                << exit(FatalIOError);
        }

        // A fine grid between the sieves, so that the change of weighting
        // within one sieve class is followed
        const scalarList sieve(std::move(diameter_)), passing(std::move(finer));
        diameter_.resize(nClasses + 1);
        finer.resize(nClasses + 1);
        label k = 0;
        forAll(diameter_, i)
        {
            const scalar s = scalar(i)/nClasses*(sieve.size() - 1);
            k = Foam::min(label(s), sieve.size() - 2);
            diameter_[i] = sieve[k] + (s - k)*(sieve[k+1] - sieve[k]);
            finer[i] = passing[k] + (s - k)*(passing[k+1] - passing[k]);
        }
        return;
    }

    const auto law = statedLaw(dict);
    const scalar low = readPositive(dict, "min");
    const scalar high = readPositive(dict, "max");
    if (high <= low || !(law(high) > law(low)))
    {
        FatalIOErrorInFunction(dict)
            << "min is " << low << " and max is " << high
            << ", allowed: 0 < min < max with some share of the law between"
            << exit(FatalIOError);
    }

    diameter_.resize(nClasses + 1);
    finer.resize(nClasses + 1);
    const scalar share = law(high) - law(low);
    forAll(diameter_, i)
    {
        diameter_[i] = low*std::pow(high/low, scalar(i)/nClasses);
        finer[i] = (law(diameter_[i]) - law(low))/share;
    }
}


scalar SizeDistribution::classCube(const label i) const
{
    const scalar a = diameter_[i-1], b = diameter_[i];
    return 0.25*(a + b)*(sqr(a) + sqr(b));
}


scalarList SizeDistribution::reweighted
(
    const scalarList& finer,
    const int power
) const
{
    scalarList shares(finer.size(), Zero);
    for (label i = 1; i < finer.size(); ++i)
    {
        const scalar weight = power > 0 ? classCube(i) : 1/classCube(i);
        shares[i] = shares[i-1] + (finer[i] - finer[i-1])*weight;
    }
    for (scalar& share : shares)
    {
        share /= shares.last();
    }
    return shares;
}


scalarList SizeDistribution::evenlyAround
(
    const scalar diameter,
    const scalar factor
) const
{
    scalarList shares(massFiner_.size(), Zero);
    for (label i = 1; i < shares.size(); ++i)
    {
        const scalar low = diameter_[i-1], high = diameter_[i];
        const bool filled =
            massFiner_[i] > massFiner_[i-1]
         && low*factor >= diameter && high <= factor*diameter;
        shares[i] = shares[i-1] + (filled ? std::log(high/low) : 0);
    }
    if (!(shares.last() > 0))
    {
        return scalarList();
    }
    for (scalar& share : shares)
    {
        share /= shares.last();
    }
    return shares;
}


void SizeDistribution::focusOn(const scalar diameter)
{
    const scalarList around(evenlyAround(diameter, focusFactor));
    forAll(around, i)
    {
        sizeFiner_[i] = 0.5*(sizeFiner_[i] + around[i]);
    }
}


label SizeDistribution::classAt
(
    const scalarList& finer,
    const scalar u
) const
{
    const auto upper = std::upper_bound(finer.cbegin(), finer.cend(), u);
    return Foam::min
    (
        Foam::max(label(upper - finer.cbegin()), label(1)),
        finer.size() - 1
    );
}


scalar SizeDistribution::massOverEven(const scalar u) const
{
    const label i = classAt(sizeFiner_, u);
    return
        (massFiner_[i] - massFiner_[i-1])/(sizeFiner_[i] - sizeFiner_[i-1]);
}


scalar SizeDistribution::quantile
(
    const scalarList& finer,
    const scalar u
) const
{
    const label i = classAt(finer, u);
    const scalar low = finer[i-1], high = finer[i];
    const scalar s = high > low ? (u - low)/(high - low) : 0;

    return diameter_[i-1] + s*(diameter_[i] - diameter_[i-1]);
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

SizeDistribution::SizeDistribution(const dictionary& dict)
:
    meanCube_(0)
{
    scalarList stated;
    buildStatedCurve(dict, stated);

    const word weighting(dict.getOrDefault<word>("weighting", "mass"));
    if (weighting == "mass")
    {
        massFiner_ = stated;
        numberFiner_ = reweighted(stated, -3);
    }
    else if (weighting == "number")
    {
        numberFiner_ = stated;
        massFiner_ = reweighted(stated, 3);
    }
    else
    {
        FatalIOErrorInFunction(dict)
            << "weighting is " << weighting << ", allowed: mass, number"
            << exit(FatalIOError);
    }

    sizeFiner_ = evenlyAround(diameter_.first(), GREAT);
    if (sizeFiner_.empty())
    {
        sizeFiner_ = massFiner_;        // a single size
    }
    for (label i = 1; i < diameter_.size(); ++i)
    {
        meanCube_ += (numberFiner_[i] - numberFiner_[i-1])*classCube(i);
    }
}


} // End namespace Foam
