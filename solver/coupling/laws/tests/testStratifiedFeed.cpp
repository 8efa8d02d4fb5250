// What is fed against what was asked: laws as formulas, masses as given, over random feeds.
#include "RandomNumber.hpp"
#include "StratifiedFeed.hpp"

#include "near.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

using namespace elutria::laws;

namespace
{

constexpr double pi = 3.14159265358979323846;

/// A feed drawn at random from a seed: one to three materials, any law of parcels
struct RandomFeed
{
    std::uint64_t seed;
    Sampling sampling;
    std::deque<SizeCurves> sizes;
    std::vector<double> d63, spread;
    std::vector<Ingredient> materials;
    std::size_t parcels;
    double massOfParcel, slots, mass;

    double random(std::uint64_t key) const { return uniform(seed, 1000 + key); }

    RandomFeed(std::uint64_t s, Sampling of) : seed(s), sampling(of)
    {
        const int n = 1 + int(3*random(0));
        double sum = 0;
        for (int m = 0; m < n; ++m)
        {
            d63.push_back(3e-4 + 6e-4*random(10*m + 1));
            spread.push_back(1.5 + 3*random(10*m + 2));
            const double parameters[]{d63[m], spread[m]};
            sizes.emplace_back(truncated(*findSizeLaw("RosinRammler"), parameters, 1e-4, 2e-3),
                               Weighting::mass);
            if (random(10*m + 3) < 0.5) sizes[m].focusOn(4e-4 + 6e-4*random(10*m + 4));
            materials.push_back({0.05 + random(10*m + 5), 1500 + 4000*random(10*m + 6), &sizes[m]});
            sum += materials[m].massFraction;
        }
        double number = 0;
        for (Ingredient& m : materials) m.massFraction /= sum, number += m.massFraction/m.meanMass();
        slots = 300 + 6000*random(7);
        parcels = std::size_t(std::round(slots));
        massOfParcel = sampling == Sampling::particles ? 1/number : 1e-6;
        mass = slots*massOfParcel;
    }

    StratifiedFeed feed() const
    {
        return StratifiedFeed(materials, sampling, seed, massOfParcel, {slots});
    }

    /// Share of a material's mass below d, of the law as its formula
    double finer(int m, double d) const
    {
        const auto law = [&](double x) { return 1 - std::exp(-std::pow(x/d63[m], spread[m])); };
        return (law(d) - law(1e-4))/(law(2e-3) - law(1e-4));
    }

    double particle(int m, double d) const { return materials[m].density*pi/6*d*d*d; }
};

/// Mass of each material between two sizes
std::vector<double> fed(const RandomFeed& asked, const StratifiedFeed& feed, double low, double high)
{
    std::vector<double> mass(asked.materials.size());
    for (std::size_t i = 0; i < asked.parcels; ++i)
        if (feed[i].diameter >= low && feed[i].diameter < high)
            mass[feed[i].material] += feed[i].mass;
    return mass;
}

const double sieves[]{1e-4, 1.4e-4, 2.24e-4, 3.15e-4, 5e-4, 7.1e-4, 1e-3, 1.6e-3, 2.1e-3};

double sum(const std::vector<double>& all)
{
    double s = 0;
    for (const double x : all) s += x;
    return s;
}

} // namespace

TEST_SUITE("stratified feed")
{

TEST_CASE("of 20 random feeds each material and the whole have exactly the asked mass, particles within one")
{
    int exact = 0, all = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed)
        for (const Sampling sampling : {Sampling::particles, Sampling::evenMass, Sampling::evenSizes})
        {
            const RandomFeed asked(seed, sampling);
            const StratifiedFeed feed = asked.feed();
            CAPTURE(seed);
            CAPTURE(int(sampling));
            const std::vector<double> mass = fed(asked, feed, 0, 1);
            if (sampling != Sampling::particles) CHECK(sum(mass) == near(asked.mass, 1e-12));
            for (std::size_t m = 0; m < mass.size(); ++m)
            {
                const double due = asked.mass*asked.materials[m].massFraction;
                const bool same = std::abs(mass[m] - due) < 1e-12*due;
                exact += same, all += 1;
                if (sampling == Sampling::particles)
                    CHECK(std::abs(mass[m] - due) < asked.particle(int(m), 2e-3));
                else
                    CHECK(same);
            }
        }
    REQUIRE(all > 90);
    CHECK(exact > all - 10);    // also of whole particles, but for a surplus of a large one
}

TEST_CASE("of 20 random feeds each size class has the share that its law says, particles within three")
{
    for (std::uint64_t seed = 0; seed < 20; ++seed)
        for (const Sampling sampling : {Sampling::particles, Sampling::evenMass, Sampling::evenSizes})
        {
            const RandomFeed asked(seed, sampling);
            const StratifiedFeed feed = asked.feed();
            CAPTURE(seed);
            CAPTURE(int(sampling));
            for (std::size_t k = 1; k < std::size(sieves); ++k)
            {
                const double high = std::min(sieves[k], 2e-3);
                const std::vector<double> mass = fed(asked, feed, sieves[k - 1], sieves[k]);
                for (std::size_t m = 0; m < mass.size(); ++m)
                {
                    const double due = asked.mass*asked.materials[m].massFraction
                        *(asked.finer(int(m), high) - asked.finer(int(m), sieves[k - 1]));
                    CAPTURE(high);
                    if (sampling == Sampling::particles)
                        CHECK(std::abs(mass[m] - due) < 3*asked.particle(int(m), high));
                    else
                        CHECK(std::abs(mass[m] - due) < 1e-12*asked.mass);
                }
            }
        }
}

TEST_CASE("sizes within a class follow the law, and the focus has its half of the parcels")
{
    RandomFeed asked(3, Sampling::evenSizes);
    const StratifiedFeed feed = asked.feed();
    // no sieve of the series: only as good as the strata
    const std::vector<double> mass = fed(asked, feed, 0, 6.7e-4);
    for (std::size_t m = 0; m < mass.size(); ++m)
        CHECK(std::abs(mass[m]/(asked.mass*asked.materials[m].massFraction) - asked.finer(int(m), 6.7e-4))
              < 5e-3);

    const double parameters[]{9e-4, 3};
    SizeCurves focused(truncated(*findSizeLaw("RosinRammler"), parameters, 1e-4, 2e-3), Weighting::mass);
    focused.focusOn(7e-4);
    const StratifiedFeed some({{1, 2650, &focused}}, Sampling::evenSizes, 1, 1e-6, {3000});
    int near = 0;
    for (std::size_t i = 0; i < 3000; ++i)
        near += some[i].diameter > 7e-4/1.3 && some[i].diameter < 7e-4*1.3;
    CHECK(near > 1600);
    CHECK(near < 1800);         // half of all, and the even half's share of 0.18
}

TEST_CASE("any stretch of the feed has nearly its composition")
{
    const RandomFeed asked(5, Sampling::evenMass);
    const StratifiedFeed feed = asked.feed();
    for (std::size_t first = 0; first + 100 < asked.parcels; first += 100)
    {
        double all = 0, ofFirst = 0;
        for (std::size_t i = first; i < first + 100; ++i)
            all += feed[i].mass, ofFirst += feed[i].material == 0 ? feed[i].mass : 0;
        CHECK(std::abs(ofFirst/all - asked.materials[0].massFraction) < 0.03);
    }
}

TEST_CASE("a parcel depends on the seed and its number, not on the order asked or on a longer feed")
{
    for (const Sampling sampling : {Sampling::particles, Sampling::evenMass, Sampling::evenSizes})
    {
        RandomFeed asked(8, sampling);
        const StratifiedFeed feed = asked.feed(), backwards = asked.feed();
        const FedParcel late = backwards[asked.parcels - 1];
        CHECK(late.diameter == feed[asked.parcels - 1].diameter);

        const StratifiedFeed longer(asked.materials, sampling, asked.seed, asked.massOfParcel,
                                    {asked.slots + 5000});
        const StratifiedFeed goesOn(asked.materials, sampling, asked.seed, asked.massOfParcel,
                                    {asked.slots, asked.slots + 5000});
        asked.seed = 9;
        const StratifiedFeed other = asked.feed();
        REQUIRE(feed.lastBlock() > 0);
        REQUIRE(feed.lastBlock() < asked.parcels);
        bool same = true, differs = false;
        const auto equal = [](const FedParcel& a, const FedParcel& b)
        { return a.diameter == b.diameter && a.material == b.material && a.mass == b.mass; };
        for (std::size_t i = 0; i < asked.parcels; ++i)
        {
            same = same && equal(goesOn[i], feed[i]) && (i >= feed.lastBlock() || equal(longer[i], feed[i]));
            differs = differs || !equal(other[i], feed[i]);
        }
        double fedMass = 0;
        for (std::size_t i = 0; i < goesOn.parcels(); ++i) fedMass += goesOn[i].mass;
        if (sampling != Sampling::particles)
            CHECK(fedMass == near((asked.slots + 5000)*asked.massOfParcel, 1e-12));
        CHECK(same);
        CHECK(differs);
    }
}

TEST_CASE("few parcels, one size, a trace: still the asked mass")
{
    const SizeCurves one(single(5e-4), Weighting::mass);
    const double parameters[]{9e-4, 3};
    const SizeCurves many(truncated(*findSizeLaw("RosinRammler"), parameters, 3e-4, 2e-3),
                          Weighting::mass);
    for (const std::size_t parcels : {2, 3, 10, 40})
    {
        const StratifiedFeed feed({{1e-4, 2650, &one}, {1 - 1e-4, 2650, &many}},
                                  Sampling::evenSizes, 1, 1e-6, {double(parcels)});
        double trace = 0, all = 0;
        for (std::size_t i = 0; i < parcels; ++i)
            all += feed[i].mass, trace += feed[i].material == 0 ? feed[i].mass : 0;
        CHECK(all == near(parcels*1e-6, 1e-12));
        CHECK(trace == near(parcels*1e-10, 1e-9));
    }
    // Whole grains of one size: within half of one
    const double grain = one.meanCube()*2650*pi/6;
    const StratifiedFeed grains({{1, 2650, &one}}, Sampling::particles, 1, grain, {10.4});
    CHECK(grains[9].mass == near(grain, 1e-12));
}

}
