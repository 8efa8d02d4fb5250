// Size distributions against integrals of the literature's densities (scipy's quad of the densities
// in the package `fluids`: pdf_Rosin_Rammler, pdf_lognormal).
#include "SizeCurves.hpp"
#include "SizeTables.hpp"

#include "near.hpp"

#include <cmath>
#include <functional>
#include <stdexcept>

using namespace elutria::laws;

namespace
{

SizeCurves of(const char* law, std::vector<double> parameters, double min, double max,
              Weighting weighting = Weighting::mass)
{
    return SizeCurves(truncated(*findSizeLaw(law), parameters.data(), min, max), weighting);
}

double finer(const SizeCurves& sizes, const std::vector<double>& shares, double d)
{
    const auto& diameters = sizes.diameters();
    std::size_t i = 1;
    while (i + 1 < diameters.size() && diameters[i] < d) ++i;
    const double s = (d - diameters[i - 1])/(diameters[i] - diameters[i - 1]);
    return shares[i - 1] + s*(shares[i] - shares[i - 1]);
}

struct Row
{
    double d, mass, number, massOfNumber;
};

} // namespace

TEST_SUITE("sizes")
{

TEST_CASE("shares of mass and number are integrals of the density")
{
    const struct
    {
        const char* law;
        std::vector<double> parameters;
        double min, meanCube, meanCubeOfNumber;
        Row rows[4];
    } laws[]{
        {"RosinRammler", {9e-4, 3}, 3e-4, 2.549548644e-10, 7.558581615e-10,
         {{3.5e-4, 0.02154140, 0.16012282, 0.00099487}, {5e-4, 0.12578880, 0.50984521, 0.01246516},
          {9e-4, 0.61825093, 0.92037848, 0.26380263}, {15e-4, 0.98989104, 0.99935544, 0.94522134}}},
        {"logNormal", {5e-4, 1.5}, 1e-4, 5.980645903e-11, 2.584147828e-10,
         {{3.5e-4, 0.18954978, 0.63074929, 0.01829076}, {5e-4, 0.50013915, 0.88775295, 0.11348436},
          {9e-4, 0.92671192, 0.99615306, 0.60051555}, {15e-4, 0.99694404, 0.99995846, 0.94535238}}}};
    for (const auto& law : laws)
    {
        CAPTURE(law.law);
        const SizeCurves mass = of(law.law, law.parameters, law.min, 2e-3);
        const SizeCurves number = of(law.law, law.parameters, law.min, 2e-3, Weighting::number);
        for (const Row& row : law.rows)
        {
            CAPTURE(row.d);
            CHECK(std::abs(finer(mass, mass.massFiner(), row.d) - row.mass) < 2e-6);
            CHECK(std::abs(finer(mass, mass.numberFiner(), row.d) - row.number) < 2e-6);
            CHECK(std::abs(finer(number, number.numberFiner(), row.d) - row.mass) < 2e-6);
            CHECK(std::abs(finer(number, number.massFiner(), row.d) - row.massOfNumber) < 2e-6);
        }
        CHECK(mass.meanCube() == near(law.meanCube, 1e-6));
        CHECK(number.meanCube() == near(law.meanCubeOfNumber, 1e-6));
    }
}

TEST_CASE("a normal law has its mean in the middle and 68.27 % within a deviation")
{
    const SizeCurves sizes = of("normal", {5e-4, 5e-5}, 1e-4, 9e-4);
    CHECK(sizes.quantileByMass(0.5) == near(5e-4, 1e-6));
    CHECK(finer(sizes, sizes.massFiner(), 5.5e-4) - finer(sizes, sizes.massFiner(), 4.5e-4)
          == near(0.6826895, 1e-5));
}

TEST_CASE("of sizes uniform in number the mass below d goes as d^4")
{
    const SizeCurves sizes = of("uniform", {}, 1e-6, 1e-3, Weighting::number);
    CHECK(finer(sizes, sizes.numberFiner(), 5e-4) == near(0.5, 2e-3));
    CHECK(finer(sizes, sizes.massFiner(), 5e-4) == near(0.0625, 1e-3));
}

TEST_CASE("quantiles invert the curves")
{
    const SizeCurves sizes = of("RosinRammler", {9e-4, 3}, 3e-4, 2e-3);
    for (const double u : {0.01, 0.25, 0.5, 0.9})
    {
        CHECK(finer(sizes, sizes.massFiner(), sizes.quantileByMass(u)) == near(u, 1e-9));
        CHECK(finer(sizes, sizes.numberFiner(), sizes.quantileByNumber(u)) == near(u, 1e-9));
    }
    CHECK(sizes.quantileByMass(0) == sizes.min());
    CHECK(sizes.evenFiner(std::sqrt(3e-4*2e-3)) == near(0.5, 1e-3));
}

TEST_CASE("a sieve analysis is linear between its sieves")
{
    const SizeCurves sizes(sieved({1e-4, 2e-4, 4e-4}, {0, 0.3, 1}), Weighting::mass);
    CHECK(finer(sizes, sizes.massFiner(), 1.5e-4) == near(0.15, 1e-9));
    CHECK(finer(sizes, sizes.massFiner(), 3e-4) == near(0.65, 1e-9));
}

TEST_CASE("half of the log size axis lies within 1.3 of the focus, and holds the same mass")
{
    SizeCurves sizes = of("RosinRammler", {9e-4, 3}, 3e-4, 2e-3);
    const auto near = [&] { return sizes.evenFiner(8e-4*1.3) - sizes.evenFiner(8e-4/1.3); };
    const double even = 2*std::log(1.3)/std::log(2e-3/3e-4);
    CHECK(std::abs(near() - even) < 1e-3);

    sizes.focusOn(8e-4);
    CHECK(std::abs(near() - 0.5*(1 + even)) < 1e-3);
    for (const double d : {3.5e-4, 6e-4, 8e-4, 15e-4})
        CHECK(std::abs(sizes.massOfEven(sizes.evenFiner(d)) - sizes.massFiner(d)) < 1e-9);

    // Where there is no mass nothing changes
    const double median = sizes.evenFiner(8e-4);
    sizes.focusOn(1);
    CHECK(sizes.evenFiner(8e-4) == median);
}

TEST_CASE("shares at the limits of sieves and of the series R20 are exact")
{
    const auto law = [](double d) { return 1 - std::exp(-std::pow(d/9e-4, 3)); };
    const SizeCurves sizes = of("RosinRammler", {9e-4, 3}, 3e-4, 2e-3);
    for (const double d : {3.15e-4, 5e-4, 1.12e-3, 1.8e-3})
        CHECK(sizes.massFiner(d) == near((law(d) - law(3e-4))/(law(2e-3) - law(3e-4)), 1e-14));
    CHECK(sizes.limits().size() == 18);

    const SizeCurves sieves(sieved({1e-4, 1.7e-4, 3.3e-4, 4e-4}, {0, 0.3, 0.4, 1}), Weighting::mass);
    CHECK(sieves.massFiner(1.7e-4) == 0.3);
    CHECK(sieves.massFiner(3.3e-4) == 0.4);
}

TEST_CASE("one size")
{
    const SizeCurves sizes(single(5e-4), Weighting::mass);
    CHECK(sizes.quantileByNumber(0.3) == 5e-4);
    CHECK(sizes.meanCube() == near(1.25e-10, 1e-9));
}

TEST_CASE("what is not allowed is named, with its value and what is")
{
    const auto complaint = [](const std::function<void()>& work) -> std::string
    {
        try { work(); }
        catch (const std::invalid_argument& error) { return error.what(); }
        return "";
    };
    CHECK(complaint([] { of("RosinRammler", {-9e-4, 3}, 3e-4, 2e-3); })
          == "d63 is -0.0009, allowed: a number > 0");
    CHECK(complaint([] { of("logNormal", {5e-4, 0.9}, 1e-4, 2e-3); })
          == "sigma is 0.9, allowed: a geometric standard deviation > 1");
    CHECK(complaint([] { of("uniform", {}, 2e-3, 1e-3); })
          == "min is 0.002 and max is 0.001, allowed: 0 < min < max with some share of the law between");
    CHECK(complaint([] { sieved({2e-4, 1e-4}, {0, 1}); }) != "");
    CHECK(complaint([] { sieved({1e-4, 2e-4, 3e-4}, {0, 0.9, 0.8}); }) != "");
    CHECK(complaint([] { sieved({1e-4, 2e-4}, {0, 0.9}); }) != "");
    CHECK(complaint([] { single(0); }) != "");
}

TEST_CASE("Gates, Gaudin and Schuhmann's law: its quantiles, and the number mean of d^3")
{
    // m 2 between 0.2 and 1: the mass density is 2d/0.96, the number density 2/(0.96 d^2)
    const SizeCurves sizes = of("GatesGaudinSchuhmann", {1, 2}, 0.2, 1);
    for (const double u : {0.1, 0.5, 0.9})
        CHECK(sizes.quantileByMass(u) == near(std::sqrt(0.04 + 0.96*u), 1e-5));
    CHECK(sizes.meanCube() == near(0.96/2/(1/0.2 - 1), 1e-5));
    CHECK_THROWS_AS(of("GatesGaudinSchuhmann", {1, 2}, 2, 3), std::invalid_argument);
}

TEST_CASE("one sieve analysis as it is written in three ways")
{
    const char* ways[]{"diameter_m,cumulative\n1e-4,0\n2e-4,0.25\n4e-4,0.75\n8e-4,1\n",
                       "retained_g,diameter_um\r\n0,800\r\n50,400\r\n100,200\r\n50,100\r\n",
                       "\"diameter_mm\", \"cumulative_percent\", note\n0.8,99.8,\n0.2,25,x\n"
                       "0.4,75,\n1.6,100,\n0.1,0,\n0.05,0,\n"};
    for (const char* csv : ways)
    {
        CAPTURE(csv);
        const CumulativeCurve curve = sieveTable(csv, 0);
        CHECK(curve.diameter.front() == near(1e-4, 1e-12));
        const SizeCurves sizes(curve, Weighting::mass);
        CHECK(sizes.quantileByMass(0.25) == near(2e-4, 1e-3));
        CHECK(sizes.quantileByMass(0.5) == near(3e-4, 1e-3));
        CHECK(sizes.quantileByMass(0.75) == near(4e-4, 1e-3));
    }
}

TEST_CASE("what passed the finest sieve needs a smallest size")
{
    for (const char* csv : {"diameter_m,retained\n0,10\n1e-4,90\n2e-4,0\n",
                            "diameter_m,cumulative\n1e-4,0.1\n2e-4,1\n"})
    {
        CAPTURE(csv);
        CHECK_THROWS_WITH_AS(sieveTable(csv, 0),
                             "min is 0 and 10 % passed the finest sieve, allowed: a smallest size of"
                             " that above 0 and below 0.0001 m", std::invalid_argument);
        CHECK_THROWS_AS(sieveTable(csv, 1e-4), std::invalid_argument);
        const SizeCurves sizes(sieveTable(csv, 5e-5), Weighting::mass);
        CHECK(sizes.quantileByMass(0.05) == near(7.5e-5, 1e-3));
        CHECK(sizes.quantileByMass(0.55) == near(1.5e-4, 1e-3));
    }
}

TEST_CASE("sieve analyses that are none")
{
    const struct { const char* csv; const char* said; } wrong[]{
        {"diameter_m,cumulative\n1e-4,0\n2e-4,0.5\n3e-4,0.4\n4e-4,1\n",
         "cumulative falls from 0.5 to 0.4 at 0.0003 m, allowed: rising with the aperture"},
        {"diameter_m,cumulative\n1e-4,0\n2e-4,0.9\n",
         "cumulative ends at 0.9, allowed: 1 (100 percent) at the widest sieve"},
        {"diameter_m,retained_kg\n1e-4,1\n2e-4,1\n",
         "the widest sieve, 0.0002 m, retains 1, allowed: 0; add a wider sieve"},
        {"diameter_m,cumulative\n1e-4,0\n1e-4,1\n", "the sieve of 0.0001 m is there twice"},
        {"diameter_m,cumulative\n1e-4,0\n2e-4,much\n",
         "line 3 has 'much', allowed: a number >= 0"},
        {"diameter_m,cumulative\n1e-4\n2e-4,1\n", "line 2 has 1 columns, allowed: 2"},
        {"d,cumulative\n", "the first line is 'd,cumulative', allowed: one of diameter_m,"
                           " diameter_mm, diameter_um"},
        {"diameter_m,Q\n", "the first line is 'diameter_m,Q', allowed: one of cumulative,"
                           " cumulative_percent, retained, retained_UNIT"},
        {"diameter_m,cumulative\n1e-4,1\n", "it has fewer than two sieves, allowed: at least two"}};
    for (const auto& one : wrong)
        CHECK_THROWS_WITH_AS(sieveTable(one.csv, 0), one.said, std::invalid_argument);
}

TEST_CASE("a sum of two laws has the mass of each")
{
    const double none = 0;
    const CumulativeCurve fine = truncated(*findSizeLaw("uniform"), &none, 1e-4, 2e-4);
    const CumulativeCurve wide = truncated(*findSizeLaw("uniform"), &none, 1e-4, 5e-4);
    const CumulativeCurve far = truncated(*findSizeLaw("uniform"), &none, 6e-4, 7e-4);
    const SizeCurves two(mixed({fine, wide}, {3, 1}), Weighting::mass);
    CHECK(finer(two, two.massFiner(), 1.5e-4) == near(0.75*0.5 + 0.25*0.125, 1e-5));
    CHECK(finer(two, two.massFiner(), 3e-4) == near(0.75 + 0.25*0.5, 1e-5));
    const SizeCurves apart(mixed({fine, far}, {0.4, 0.6}), Weighting::mass);
    CHECK(finer(apart, apart.massFiner(), 3e-4) == near(0.4, 1e-5));
    CHECK(apart.quantileByMass(0.7) == near(6.5e-4, 1e-5));
    CHECK_THROWS_AS(mixed({fine}, {0.0}), std::invalid_argument);
    CHECK_THROWS_AS(mixed({single(1e-4)}, {1.0}), std::invalid_argument);
    CHECK_THROWS_AS(mixed({}, {}), std::invalid_argument);
}

}
