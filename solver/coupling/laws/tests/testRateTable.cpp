// A feed's rate over time against sums of many small steps.
#include "RandomNumber.hpp"
#include "RateTable.hpp"

#include "near.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

using namespace elutria::laws;

namespace
{

/// Of a pause, a ramp from nothing, a step and a plateau
const RateTable pauses({1, 2, 3, 4, 4.001, 6}, {0, 2, 0, 0, 5, 5});

std::string complaint(const std::vector<double>& times, const std::vector<double>& rates)
{
    try
    {
        RateTable(times, rates);
    }
    catch (const std::invalid_argument& refused)
    {
        return refused.what();
    }
    return "";
}

} // namespace

TEST_SUITE("rate table")
{

TEST_CASE("the mass between two times is the area below the lines")
{
    CHECK(pauses.mass(1, 3) == near(2, 1e-15));
    CHECK(pauses.mass(1, 6) == near(2 + 0.0025 + 5*1.999, 1e-14));
    CHECK(pauses.mass(3, 4) == 0);
    CHECK(pauses.mass(1.5, 2.5) == near(1.5, 1e-14));
    CHECK(pauses.mass(0, 9) == pauses.mass(1, 6));
    CHECK(pauses.peak() == 5);

    // Another way: the midpoint rule over 1 million steps of a random table
    std::vector<double> times, rates;
    for (int i = 0; i < 7; ++i)
        times.push_back(i + uniform(1, i)), rates.push_back(3*uniform(2, i));
    const RateTable random(times, rates);
    double sum = 0;
    const double from = times[0] + 0.3, to = times[6] - 0.4;
    const int n = 1000000;
    for (int i = 0, k = 0; i < n; ++i)
    {
        const double t = from + (i + 0.5)/n*(to - from);
        while (times[k + 1] < t) ++k;
        const double s = (t - times[k])/(times[k + 1] - times[k]);
        sum += ((1 - s)*rates[k] + s*rates[k + 1])*(to - from)/n;
    }
    CHECK(random.mass(from, to) == near(sum, 1e-9));
}

TEST_CASE("the time of a mass is where that mass has come, and never in a pause")
{
    for (int i = 1; i < 200; ++i)
    {
        const double mass = i/200.0*pauses.mass(1.2, 6);
        const double time = pauses.timeOf(mass, 1.2);
        CHECK(pauses.mass(1.2, time) == near(mass, 1e-12));
        CHECK(!(time > 3.001 && time < 4));
    }
    CHECK(pauses.timeOf(2, 1) == near(3, 1e-12));       // the pause's begin, not its end
    CHECK(pauses.timeOf(100, 1) == 6);
    CHECK(pauses.timeOf(0, 1.5) == near(1.5, 1e-12));

    // An end without feed is not waited for
    CHECK(RateTable({0, 1, 2}, {1, 0, 0}).timeOf(0.5, 0) == near(1, 1e-12));
    CHECK(RateTable({0, 1, 2}, {1, 0, 0}).timeOf(0.5*(1 + 1e-15), 0) == near(1, 1e-7));
}

TEST_CASE("what no table is, is refused")
{
    CHECK(complaint({0, 1}, {1, 2}) == "");
    CHECK(complaint({0}, {1}) == "the number of its times is 1, allowed: two or more, each with a rate");
    CHECK(complaint({0, 2, 1}, {1, 1, 1}) == "it has the time 1, allowed: rising times (s)");
    CHECK(complaint({0, 1}, {1, -2}) == "it has the rate -2, allowed: 0 or more (kg/s)");
    CHECK(complaint({0, std::nan("")}, {1, 1}) != "");
    CHECK(complaint({0, 1}, {1, INFINITY}) != "");
}

}
