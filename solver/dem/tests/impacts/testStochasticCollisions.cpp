#include "engine/Engine.hpp"
#include "impacts/StochasticCollisions.hpp"
#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <random>

using namespace elutria::dem;

// Spheres that stand for several particles, or for a share of one, collide as often as those.

namespace
{

constexpr double side = 0.2, duration = 0.2;
constexpr unsigned steps = 200;

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
        all.statisticalWeight.push_back(kind.number);
        all.position.push_back({place(random), place(random), place(random)});
        all.velocity.push_back(kind.velocity);
        all.spin.push_back({});
    }
}

/// The linear law in a box of that width that goes on in all directions.
Settings periodicBox(double width)
{
    Settings settings;
    settings.law = &contactLaw<LinearSpringDashpot>;
    for (int axis = 0; axis < 3; ++axis) settings.box.periodic[axis] = true;
    settings.box.high = {width, width, width};
    return settings;
}

struct Result { double heavyMomentum, lightMomentum, lightEnergy; };

const Kind heavy{1, 2000, 1e-3, 2000, {}};
const Kind light{1, 10000, 0.5e-3, 2000, {1, 0, 0}};
const Kind dust{1, 40000, 0.25e-3, 2000, {1, 0, 0}};

Kind inGroups(Kind kind, double number)
{
    kind.number = number;
    return kind;
}

/// Light particles fly through heavy ones at rest; what each kind has at the end.
Result meet(const Kind& heavy, const Kind& light, std::uint32_t seed)
{
    Particles all;
    add(all, heavy, seed);
    const std::size_t first = all.size();
    add(all, light, seed + 100);

    PairProperties pair;
    pair.restitution = 0.8, pair.friction = 0.2, pair.normalStiffness = 1e3;
    Engine engine(periodicBox(side), scenes::oneMaterial(pair));
    for (; all.stepIndex < steps; ++all.stepIndex) engine.advance(all, duration/steps);

    Result result{};
    for (std::size_t i = 0; i < all.size(); ++i)
    {
        const double mass = all.statisticalWeight[i]*all.mass[i];
        const Vector3 v = all.velocity[i];
        (i < first ? result.heavyMomentum : result.lightMomentum) += mass*v.x;
        if (i >= first) result.lightEnergy += 0.5*mass*squaredNorm(v);
    }
    return result;
}

Result meanOf(const Kind& heavy, const Kind& light)
{
    Result sum{};
    constexpr int runs = 4;
    for (int k = 0; k < runs; ++k)
    {
        const Result one = meet(heavy, light, 10u*unsigned(k));
        sum.heavyMomentum += one.heavyMomentum/runs;
        sum.lightMomentum += one.lightMomentum/runs;
        sum.lightEnergy += one.lightEnergy/runs;
    }
    return sum;
}

} // namespace


TEST_CASE("spheres of many particles and of shares of one exchange momentum as their particles do")
{
    const Result single = meanOf(heavy, light);
    const Result weighted = meanOf(inGroups(heavy, 0.5), inGroups(light, 5));
    // of 60 runs each: heavy -5.9 +- 0.3 %, light +1.9 +- 0.2 %, from several impacts a passage;
    // one run has standard deviations of 2.3 and 1.3 %
    CHECK(weighted.heavyMomentum == near(single.heavyMomentum, 0.07));
    CHECK(weighted.lightMomentum == near(single.lightMomentum, 0.02));
    CHECK(weighted.lightEnergy == near(single.lightEnergy, 0.02));
    const double total = single.heavyMomentum + single.lightMomentum;
    CHECK(weighted.heavyMomentum + weighted.lightMomentum == near(total, 0.02));
}


TEST_CASE("spheres of more particles than their distance of meeting can tell hit as often")
{
    // the more impacts a meeting is, the more of them find the spheres already slowed
    const Result single = meanOf(heavy, dust);
    for (const auto& [number, share] : {std::pair{40., 0.1}, {160., 0.2}})
    {
        const Result weighted = meanOf(heavy, inGroups(dust, number));
        CHECK(weighted.heavyMomentum == near(single.heavyMomentum, share));
        CHECK(weighted.lightMomentum == near(single.lightMomentum, 0.04));
        CHECK(weighted.lightEnergy == near(single.lightEnergy, 0.04));
    }
}


/// Spheres that fall about in a box, some of them lying on its floor.
struct Crowd
{
    Settings settings;
    ContactMaterials materials;
    std::unique_ptr<Engine> engine;
    Particles all;

    Crowd(double height, double number)
    {
        constexpr double radius = 0.3e-3;
        settings.law = &contactLaw<LinearSpringDashpot>;
        settings.box.periodic[0] = settings.box.periodic[1] = true;
        settings.box.high = {height, height, 2*height};
        materials.add({"grain", 1e7, 0.3});
        PairProperties pair;
        pair.restitution = 0.8, pair.friction = 0.2, pair.normalStiffness = 1e3;
        materials.setPair(0, 0, pair);
        engine = std::make_unique<Engine>(settings, materials,
                                          Walls(scenes::floorAt(0, height)));
        std::mt19937_64 random(3);
        std::uniform_real_distribution<double> place(0, height);
        std::normal_distribution<double> speed(0, 0.2);
        for (std::size_t i = 0; i < 1500; ++i)
        {
            const bool lies = i < 20;
            scenes::addSphere(all, {place(random), place(random),
                                    lies ? radius*0.999 : radius + place(random)}, radius, 2500);
            if (!lies) all.velocity.set(i, {speed(random), speed(random), speed(random)});
        }
        all.statisticalWeight.assign(all.size(), number);
        all.acceleration.assign(all.size(), {0, 0, -9.81});
    }

    double fastest() const
    {
        double speed = 0;
        for (std::size_t i = 0; i < all.size(); ++i) speed = std::max(speed, norm(all.velocity[i]));
        return speed;
    }
};


TEST_CASE("spheres of many particles that crowd do not take each other into contact steps")
{
    Crowd crowd(0.02, 16);      // 2 % solids; meetings join all
    std::size_t soft = 0;
    for (; crowd.all.stepIndex < 5; ++crowd.all.stepIndex)
        soft += crowd.engine->advance(crowd.all, 1e-3).softParticles;
    CHECK(soft < 500);
}


TEST_CASE("spheres that pass through each other get no energy from contact steps")
{
    Crowd crowd(0.012, 0.25);       // 10 % solids
    const double before = crowd.fastest();
    std::size_t soft = 0;
    for (; crowd.all.stepIndex < 5; ++crowd.all.stepIndex)
        soft += crowd.engine->advance(crowd.all, 1e-3).softParticles;
    REQUIRE(soft > 10);
    CHECK(crowd.fastest() < 1.2*before);
}


namespace
{

/// Momentum that spheres at rest get from those that fly among them, tenth of the volume solid,
/// placed as spheres are that have met long enough; mean of as many runs.
double passedOn(double number, double solidFraction, unsigned runs)
{
    constexpr double width = 0.03, radius = 0.5e-3, mass = 1e-6;
    const Settings settings = periodicBox(width);
    PairProperties pair;
    pair.restitution = 1, pair.normalStiffness = 1e5;
    Engine engine(settings, scenes::oneMaterial(pair));

    double momentum = 0;
    constexpr std::size_t particles = 5160;
    for (unsigned run = 0; run < runs; ++run)
    {
        Particles all;
        std::mt19937_64 random(run);
        std::uniform_real_distribution<double> place(0, width);
        while (double(all.size())*number < particles)
        {
            const Vector3 x{place(random), place(random), place(random)};
            bool free = true;
            for (std::size_t j = 0; number == 1 && free && j < all.size(); ++j)
                free = norm(settings.box.shortest(x - all.position[j])) > 2*radius;
            if (!free) continue;
            scenes::addSphere(all, x, radius, 2500);
            all.mass.back() = mass;
            const double turn = 200*place(random)/width;
            all.velocity.set(all.size() - 1, {std::cos(turn), std::sin(turn), std::sin(7*turn)});
        }
        all.statisticalWeight.assign(all.size(), number);
        all.solidFraction.assign(all.size(), solidFraction);
        for (; all.stepIndex < 100; ++all.stepIndex) engine.advance(all, 1e-4);
        all.velocity.assign(all.size(), {});
        for (std::size_t i = 1; i < all.size(); i += 2) all.velocity.set(i, {0, 0, 1});
        for (; all.stepIndex < 110; ++all.stepIndex) engine.advance(all, 0.5e-4);
        for (std::size_t i = 0; i < all.size(); i += 2) momentum += number*mass*all.velocity[i].z;
    }
    return momentum/runs;
}

} // namespace


TEST_CASE("where solids take a tenth of the room, spheres of many particles meet as often as those")
{
    // one run has a standard deviation of 4 %, one of spheres of four 8 %
    const double particles = passedOn(1, 0, 8);
    CHECK(passedOn(4, 0.1, 32) == near(particles, 0.04));
    CHECK(passedOn(4, 0, 32) < 0.85*particles);
}


TEST_CASE("a sphere of more particles reaches further, up to sixteen radii")
{
    CHECK(collisionReach(2, 0.1) == near(4, 1e-9));
    CHECK(collisionReach(2, 2) == near(4, 1e-9));
    CHECK(collisionReach(2, 8) == near(8, 1e-9));
    CHECK(collisionReach(2, 1e6) == near(32, 1e-9));
}
