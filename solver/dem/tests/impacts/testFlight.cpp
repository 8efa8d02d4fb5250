#include "impacts/FirstContact.hpp"
#include "support/near.hpp"
#include "support/wallShapes.hpp"
#include "walls/Walls.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

using namespace elutria::dem;

namespace
{

/// The same motion in long double, by many small exact-in-the-mean steps (classical Runge-Kutta).
void integrate(long double& x, long double& v, long double a, long double u, long double k,
               long double time)
{
    const int steps = 20000;
    const long double h = time/steps;
    const auto f = [&](long double w) { return a + k*(u - w); };
    for (int i = 0; i < steps; ++i)
    {
        const long double f1 = f(v), f2 = f(v + h/2*f1), f3 = f(v + h/2*f2), f4 = f(v + h*f3);
        x += h*v + h*h/6*(f1 + f2 + f3);
        v += h/6*(f1 + 2*f2 + 2*f3 + f4);
    }
}

struct Uniform
{
    std::mt19937_64 generator{7};
    double operator()(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(generator);
    }
    Vector3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size),
                                          (*this)(-size, size)}; }
};

/// First time the gap closes, by scanning densely and bisecting.
double firstTouch(const Flight& a, const Flight& b, double distance, double duration)
{
    const auto gap = [&](double t)
    {
        return norm(a.at(t).position - b.at(t).position) - distance;
    };
    const int samples = 5000;
    for (int i = 1; i <= samples; ++i)
    {
        double low = duration*(i - 1)/samples, high = duration*i/samples;
        if (gap(high) > 0) continue;
        for (int k = 0; k < 60; ++k) (gap(0.5*(low + high)) > 0 ? low : high) = 0.5*(low + high);
        return high;
    }
    return never;
}

} // namespace


TEST_CASE("flight: agrees with direct integration from no drag to strong drag")
{
    const double a = -9.81, u = 3, v0 = -1, x0 = 0.5, time = 1e-2;
    for (const double kh : {0.0, 1e-12, 1e-6, 1e-3, 0.1, 0.1249999, 0.1250001, 0.9, 1.1, 5.0, 50.0})
    {
        CAPTURE(kh);
        const double k = kh/time;
        const Flight flight({x0, 0, 0}, {v0, 0, 0}, {a, 0, 0}, {u, 0, 0}, k);
        const Flight end = flight.at(time);
        long double x = x0, v = v0;
        integrate(x, v, a, u, k, time);
        CHECK(std::abs(end.position.x - double(x)) < 1e-14);
        CHECK(std::abs(end.velocity.x - double(v)) < 1e-13);
        const double gain = flight.dragGain(time, {a, 0, 0}).x;
        CHECK(std::abs(gain - double(v - v0 - (long double)a*time)) < 1e-14 + 1e-10*std::abs(gain));
    }
}

TEST_CASE("flight: limits of no drag and of infinitely strong drag")
{
    const Flight ballistic({0, 0, 0}, {1, 2, 3}, {0, 0, -10}, {5, 5, 5}, 0);
    CHECK(ballistic.at(0.5).position.z == near(1.5 - 1.25, 1e-15));
    for (const double kh : {1e4, 1e8})
    {
        const double h = 1e-3, k = kh/h;
        const Flight dust({0, 0, 0}, {-4, 0, 0}, {0, 0, -9.81}, {2, 0, 0}, k);
        const Flight end = dust.at(h);
        CHECK(std::abs(end.velocity.x - 2) < 1e-13);
        CHECK(std::abs(end.velocity.z + 9.81/k) < 1e-15);
        CHECK(std::abs(end.position.x - (2*h - 6/k)) < 1e-15);
        CHECK(std::abs(dust.dragGain(h, {0, 0, -9.81}).x - 6) < 1e-12);
        CHECK(std::abs(dust.dragGain(h, {0, 0, -9.81}).z - (-9.81/k + 9.81*h)) < 1e-13);
    }
    CHECK(std::isfinite(Flight({0, 0, 0}, {1, 0, 0}, {0, 0, -10}, {9, 9, 9}, 1e300).at(1).position.x));
}

TEST_CASE("flight: two halves are one whole")
{
    Uniform random;
    for (int trial = 0; trial < 200; ++trial)
    {
        const double rate = std::pow(10, random(-3, 6)), h = 1e-3;
        const Flight f(random.vector(1), random.vector(5), random.vector(10), random.vector(5), rate);
        const Flight one = f.at(h), two = f.at(0.3*h).at(0.7*h);
        CHECK(norm(one.position - two.position) < 2e-15);
        CHECK(norm(one.velocity - two.velocity) < 1e-13);
    }
}

TEST_CASE("flight: the bound of the deviation from the chord holds and is not wasteful")
{
    Uniform random;
    double sharpest = 0;
    for (int trial = 0; trial < 500; ++trial)
    {
        const double rate = std::pow(10, random(-2, 6)), h = 1e-3;
        const Flight f({0, 0, 0}, random.vector(5), random.vector(10), random.vector(5), rate);
        const Vector3 end = f.at(h).position;
        double chord = 0;
        for (int i = 1; i < 200; ++i)
        {
            const double t = h*i/200;
            const Vector3 p = f.at(t).position;
            chord = std::max(chord, norm(p - (t/h)*end));
        }
        CHECK(chord <= f.chordDeviation(h)*(1 + 1e-9) + 1e-15);
        sharpest = std::max(sharpest, chord/f.chordDeviation(h));
    }
    CHECK(sharpest > 0.95);
}

TEST_CASE("meeting: first touch of two flights is found, early or late, fast or slow drag")
{
    Uniform random;
    int hits = 0;
    for (int trial = 0; trial < 2500; ++trial)
    {
        const double h = 1e-3, distance = 1e-3;
        const Flight a(random.vector(1.2e-3), random.vector(5), {0, 0, -9.81}, random.vector(5),
                       std::pow(10, random(-2, 5)));
        const Flight b(random.vector(1.2e-3), random.vector(5), {0, 0, -9.81}, random.vector(5),
                       random(0, 1) < 0.3 ? a.rate : std::pow(10, random(-2, 5)));
        if (norm(a.position - b.position) < distance) continue;
        const double expected = firstTouch(a, b, distance, h);
        const FirstContact found = firstContact(a, b, {}, distance, 0, h);
        CHECK_FALSE(found.lasting);
        if (expected < never)
        {
            ++hits;
            REQUIRE(found.time < never);
            CHECK(std::abs(found.time - expected) < 1e-8*h + 1e-12/norm(a.velocity - b.velocity));
        }
        else if (found.time < never)       // closer than the scan can see
        {
            CHECK(norm(a.at(found.time).position - b.at(found.time).position) < distance*(1 + 2e-10));
        }
    }
    CHECK(hits > 200);
}

TEST_CASE("meeting: particles that rest on each other are reported as lasting")
{
    const Flight a({0, 0, 1e-3}, {0, 0, 0}, {0, 0, -10}, {0, 0, 0}, 0);
    const Flight b({0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0);
    CHECK(firstContact(a, b, {}, 1e-3, 0, 1e-3).lasting);
}

TEST_CASE("meeting: touch of a wall, at face, edge and corner")
{
    const Walls walls(shapes::box({0, 0, 0}, {1, 1, 1}));
    Uniform random;
    int hits = 0;
    for (int trial = 0; trial < 600; ++trial)
    {
        const double radius = 0.05, h = 0.1;
        Vector3 x = random.vector(1);
        x += {0.5, 0.5, 0.5};
        const Flight f(x, random.vector(10), {0, 0, -9.81}, random.vector(5), random(0, 1e3));
        const auto gap = [&](double t)
        {
            double nearest = never;
            const Vector3 p = f.at(t).position;
            for (std::uint32_t k = 0; k < walls.size(); ++k)
                nearest = std::min(nearest, norm(p - walls.nearestPoint({k, {}}, p)));
            return nearest - radius;
        };
        if (gap(0) <= 0) continue;
        double first = never;
        for (std::uint32_t k = 0; k < walls.size(); ++k)
        {
            const FirstContact m = firstWallContact(f, radius, 0, h,
                [&](const Vector3& p) { return walls.nearestPoint({k, {}}, p); });
            CHECK_FALSE(m.lasting);
            first = std::min(first, m.time);
        }
        double smallest = never;
        const int samples = 2000;
        for (int i = 0; i <= samples; ++i)
        {
            const double t = h*i/samples;
            if (t < first) smallest = std::min(smallest, gap(t));
        }
        CHECK(smallest > -1e-9);               // nothing touched before
        if (first < never)
        {
            ++hits;
            CHECK(std::abs(gap(first)) < 1e-9*radius);
        }
    }
    CHECK(hits > 50);
}
