// Feeds of intergrown grains: exact masses, and the stated densities at every size.
#include "DensityScatter.hpp"
#include "FeedRules.hpp"
#include "StratifiedFeed.hpp"

#include "near.hpp"

#include <cmath>

using namespace elutria::laws;

namespace
{

constexpr double pi = 3.14159265358979323846;

const double spread[]{4000, 300};

DensityScatter normal()
{
    return DensityScatter(truncated(*findSizeLaw("normal"), spread, 3200, 4800, largestDensity));
}

SizeCurves sizes()
{
    const double parameters[]{9e-4, 3};
    return SizeCurves(truncated(*findSizeLaw("RosinRammler"), parameters, 3e-4, 2e-3),
                      Weighting::mass);
}

/// Share of the mass below a density, truncated
double lighter(double density)
{
    const auto law = [](double x) { return 0.5*std::erfc((4000 - x)/(300*std::sqrt(2.0))); };
    return (law(density) - law(3200))/(law(4800) - law(3200));
}

} // namespace

TEST_SUITE("density scatter")
{

TEST_CASE("quantiles by mass are the law's, those by number have the mass over the density")
{
    const DensityScatter scatter = normal();
    for (double u = 0.05; u < 1; u += 0.1)
        CHECK(lighter(scatter.quantileByMass(u)) == near(u, 1e-4));
    CHECK(scatter.meanByMass() == near(4000, 1e-6));    // the law is symmetric

    double mean = 0, heavy = 0;
    const int n = 200000;
    for (int i = 0; i < n; ++i)
    {
        const double density = scatter.quantileByNumber((i + 0.5)/n);
        mean += density/n;
        heavy += density < 3900 ? density : 0;
    }
    CHECK(scatter.meanByNumber() == near(mean, 1e-6));
    CHECK(heavy/n/mean == near(lighter(3900), 1e-4));   // drawn by number, weighed: the mass' share
}

TEST_CASE("masses are exact as without scatter, and every density has its share at every size")
{
    const DensityScatter scatter = normal();
    const SizeCurves curves = sizes();
    const std::vector<Ingredient> materials{{0.7, scatter.meanByNumber(), &curves, &scatter},
                                            {0.3, 2650, &curves}};
    for (const Sampling sampling : {Sampling::evenMass, Sampling::evenSizes})
        for (std::uint64_t seed = 0; seed < 10; ++seed)
        {
            CAPTURE(int(sampling));
            CAPTURE(seed);
            const StratifiedFeed feed(materials, sampling, seed, 1e-6, {1000});
            double all = 0, light = 0, coarse = 0, coarseLight = 0, other = 0;
            for (std::size_t i = 0; i < 1000; ++i)
            {
                const FedParcel p = feed[i];
                if (p.material == 1)
                {
                    other += p.mass;
                    CHECK(p.density == 2650);
                    continue;
                }
                all += p.mass;
                light += p.density < 3900 ? p.mass : 0;
                if (p.diameter < 9e-4) continue;
                coarse += p.mass;
                coarseLight += p.density < 3900 ? p.mass : 0;
            }
            CHECK(all == near(0.7e-3, 1e-12));
            CHECK(other == near(0.3e-3, 1e-12));
            CHECK(std::abs(light/all - lighter(3900)) < 0.02);      // chance alone: 0.018 and more
            CHECK(std::abs(coarseLight/coarse - lighter(3900)) < 0.05);
        }
}

TEST_CASE("densities do not follow the order of entry")
{
    const DensityScatter scatter = normal();
    const SizeCurves curves = sizes();
    const StratifiedFeed feed({{1, scatter.meanByNumber(), &curves, &scatter}}, Sampling::evenMass,
                              3, 1e-6, {2000});
    for (std::size_t first = 0; first < 2000; first += 100)
    {
        double light = 0;
        for (std::size_t i = first; i < first + 100; ++i) light += feed[i].density < 4000;
        CAPTURE(first);
        CHECK(std::abs(light/100 - 0.5) < 0.12);    // of 100 at random: 0.05 is one deviation
    }
}

TEST_CASE("whole particles of several densities have the asked mass within one of the largest")
{
    const DensityScatter scatter = normal();
    const SizeCurves curves = sizes();
    const Ingredient ore{1, scatter.meanByNumber(), &curves, &scatter};
    for (std::uint64_t seed = 0; seed < 10; ++seed)
    {
        const StratifiedFeed feed({ore}, Sampling::particles, seed, ore.meanMass(), {3000.3});
        double all = 0, light = 0;
        for (std::size_t i = 0; i < feed.parcels(); ++i)
        {
            const FedParcel p = feed[i];
            CHECK(p.mass == near(p.density*pi/6*std::pow(p.diameter, 3), 1e-12));
            all += p.mass;
            light += p.density < 3900 ? p.mass : 0;
        }
        CAPTURE(seed);
        CHECK(std::abs(all - 3000.3*ore.meanMass()) < 4800*pi/6*std::pow(2e-3, 3));
        CHECK(std::abs(light/all - lighter(3900)) < 0.03);
    }
}

}
