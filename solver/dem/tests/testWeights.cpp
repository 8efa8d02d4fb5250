#include "Engine.hpp"
#include "weights.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

using namespace elutria::dem;

// Spheres that stand for several particles, or for a share of one, collide as often as those.

namespace
{

constexpr double side = 0.2, duration = 0.2;
constexpr int steps = 200;

struct Kind
{
    double number;             // particles that each sphere stands for
    std::size_t particles;
    double radius, density;
    Vector3 velocity;
};

void add(Particles& all, const Kind& kind, std::uint32_t seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(0, side);
    const double mass = kind.density*4/3.*3.14159265358979*std::pow(kind.radius, 3);
    const auto spheres = std::size_t(std::lround(double(kind.particles)/kind.number));
    for (std::size_t i = 0; i < spheres; ++i)
    {
        all.id.push_back(all.id.size());
        all.material.push_back(0);
        all.radius.push_back(kind.radius);
        all.mass.push_back(mass);
        all.number.push_back(kind.number);
        all.position.push_back({place(random), place(random), place(random)});
        all.velocity.push_back(kind.velocity);
        all.spin.push_back({});
    }
}

struct Result { double heavyMomentum, lightMomentum, lightEnergy; };

/// Light particles fly through heavy ones at rest; what each kind has at the end.
Result meet(double heavyNumber, double lightNumber, std::uint32_t seed)
{
    const Kind heavy{heavyNumber, 2000, 1e-3, 2000, {}};
    const Kind light{lightNumber, 10000, 0.5e-3, 2000, {1, 0, 0}};
    Particles all;
    add(all, heavy, seed);
    const std::size_t first = all.size();
    add(all, light, seed + 100);

    Settings settings;
    settings.law = ContactLaw::linear;
    for (int axis = 0; axis < 3; ++axis) settings.box.periodic[axis] = true;
    settings.box.high = {side, side, side};
    ContactMaterials materials;
    materials.add({"grain", 1e7, 0.3});
    PairProperties pair;
    pair.restitution = 0.8, pair.friction = 0.2, pair.normalStiffness = 1e3;
    materials.setPair(0, 0, pair);
    Engine engine(settings, materials);
    for (int k = 0; k < steps; ++k) engine.advance(all, duration/steps);

    Result result{};
    for (std::size_t i = 0; i < all.size(); ++i)
    {
        const double mass = all.number[i]*all.mass[i];
        const Vector3 v = all.velocity[i];
        (i < first ? result.heavyMomentum : result.lightMomentum) += mass*v.x;
        if (i >= first) result.lightEnergy += 0.5*mass*squaredNorm(v);
    }
    return result;
}

Result meanOf(double heavyNumber, double lightNumber)
{
    Result sum{};
    constexpr int runs = 2;
    for (int k = 0; k < runs; ++k)
    {
        const Result one = meet(heavyNumber, lightNumber, 10u*unsigned(k));
        sum.heavyMomentum += one.heavyMomentum/runs;
        sum.lightMomentum += one.lightMomentum/runs;
        sum.lightEnergy += one.lightEnergy/runs;
    }
    return sum;
}

} // namespace


TEST_CASE("spheres of many particles and of shares of one exchange momentum as their particles do")
{
    const Result single = meanOf(1, 1);
    const Result weighted = meanOf(0.5, 5);
    // about 3000 meetings: a standard deviation of 2 %, and as much for the few spheres
    CHECK(weighted.heavyMomentum == doctest::Approx(single.heavyMomentum).epsilon(0.07));
    CHECK(weighted.lightMomentum == doctest::Approx(single.lightMomentum).epsilon(0.02));
    CHECK(weighted.lightEnergy == doctest::Approx(single.lightEnergy).epsilon(0.02));
    const double total = single.heavyMomentum + single.lightMomentum;
    CHECK(weighted.heavyMomentum + weighted.lightMomentum == doctest::Approx(total).epsilon(0.02));
}


TEST_CASE("without weights a meeting distance is the sum of radii")
{
    Traveller a, b;
    a.radius = 1, b.radius = 2;
    CHECK(meetingDistance(a, b) == 3);
    b.number = 4;
    CHECK(meetingDistance(a, b) == doctest::Approx(6));
    b.number = 1e6;
    CHECK(meetingDistance(a, b) == doctest::Approx(3*std::sqrt(largestCollisionNumber)));
}
