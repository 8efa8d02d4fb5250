#include "support/near.hpp"
#include "support/scenes.hpp"
#include "support/wallShapes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <random>

using namespace elutria::dem;

namespace
{

struct Uniform
{
    std::mt19937_64 generator;
    explicit Uniform(std::uint64_t seed) : generator(seed) {}
    double operator()(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(generator);
    }
    Vector3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size),
                                          (*this)(-size, size)}; }
};

Settings with(ContactTreatment treatment, const ContactLaw* law = &contactLaw<HertzMindlin>)
{
    Settings settings;
    settings.treatment = treatment;
    settings.law = law;
    return settings;
}

ContactMaterials grains(double restitution, double friction, double young = 1e7)
{
    PairProperties p;
    p.restitution = restitution;
    p.friction = friction;
    p.normalStiffness = young*1e-3;
    return scenes::oneMaterial(p, young);
}

void addGravity(Particles& p, double g = 9.81)
{
    p.acceleration.assign(p.size(), {0, 0, -g});
}

/// Spheres on a shaken lattice inside a box, with random velocities.
Particles cloud(Uniform& random, const Vector3& low, const Vector3& high, int perSide,
                double smallest, double largest, double speed)
{
    Particles p;
    const Vector3 spacing = (1.0/perSide)*(high - low);
    for (int i = 0; i < perSide*perSide*perSide; ++i)
    {
        const double r = smallest*std::pow(largest/smallest, random(0, 1));
        const double room = 0.5*std::min({spacing.x, spacing.y, spacing.z}) - largest;
        const Vector3 cell{i % perSide + 0.5, i/perSide % perSide + 0.5,
                           i/(perSide*perSide) + 0.5};
        const Vector3 x = low + Vector3{cell.x*spacing.x, cell.y*spacing.y, cell.z*spacing.z};
        scenes::addSphere(p, x + random.vector(room), r, 2500);
        p.velocity.set(p.size() - 1, random.vector(speed));
    }
    return p;
}

double potential(const Particles& p)
{
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
        if (!p.acceleration.empty()) sum -= p.mass[i]*dot(p.acceleration[i], p.position[i]);
    return sum;
}

double deepestOverlap(const Particles& p, const PeriodicBox& box = {})
{
    double deepest = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
        {
            const double gap = norm(box.shortest(p.position[i] - p.position[j]))
                               - p.radius[i] - p.radius[j];
            deepest = std::max(deepest, -gap/std::min(p.radius[i], p.radius[j]));
        }
    return deepest;
}

} // namespace


TEST_CASE("adaptive: two spheres collide alike with impacts and with the soft law, anywhere in a step")
{
    for (const ContactLaw* law : {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>})
        for (const double offset : {0.0, 0.4, 0.9})          // of the radii's sum: oblique
            for (const double gap : {1e-5, 4e-4, 9.99e-4, 1.4e-3})
            {
                CAPTURE(law->name);
                CAPTURE(offset);
                CAPTURE(gap);
                Particles start;
                scenes::addSphere(start, {0, 0, 0}, 1e-3, 2500);
                const double across = offset*1.5e-3;
                scenes::addSphere(start, {gap + std::sqrt(1.5e-3*1.5e-3 - across*across), across, 0},
                                  0.5e-3, 4000);
                start.velocity.set(0, {1, offset > 0 ? 0.1 : 0, 0});
                const auto materials = grains(0.8, 0.25, 1e11);
                Particles result[2];
                StepReport report;
                for (const bool soft : {false, true})
                {
                    Settings settings =
                        with(soft ? ContactTreatment::soft : ContactTreatment::automatic, law);
                    settings.stepFraction = 0.01;
                    Engine engine(settings, materials);
                    Particles& p = result[soft] = start;
                    for (int k = 0; k < 2; ++k)
                    {
                        report = engine.advance(p, 1e-3);
                        if (!soft) CHECK(report.subSteps == 0);
                    }
                }
                for (const std::size_t i : {0, 1})
                {
                    const double change = norm(result[1].velocity[i] - start.velocity[i]);
                    CHECK(norm(result[0].velocity[i] - result[1].velocity[i]) < 2e-3*change);
                    CHECK(norm(result[0].position[i] - result[1].position[i]) < 1e-5);
                }
                if (offset == 0)
                {
                    const double apart = result[0].velocity[1].x - result[0].velocity[0].x;
                    CHECK(apart == near(0.8, 1e-9));
                }
            }
}

TEST_CASE("adaptive: chains of impacts within one step as in many short steps")
{
    std::size_t merged = 0, impacts = 0;
    for (int seed = 0; seed < 10; ++seed)
    {
        Uniform random(100 + seed);
        const Vector3 low{0, 0, 0}, high{0.01, 0.01, 0.01};
        const Walls walls(shapes::box(low, high, 2));
        Particles once = cloud(random, low, high, 4, 0.2e-3, 0.9e-3, 1);
        addGravity(once);
        once.gasVelocity.assign(once.size(), {0.3, 0, 0});
        for (std::size_t i = 0; i < once.size(); ++i)
            once.dragRate.push_back(std::pow(10, random(-1, 2)));
        Particles often = once;
        const auto materials = grains(0.9, 0.3, 1e15);      // nothing lasts
        Engine a(with(ContactTreatment::automatic), materials, walls);
        Engine b(with(ContactTreatment::automatic), materials, walls);
        const StepReport report = a.advance(once, 2e-3);
        for (int k = 0; k < 32; ++k) b.advance(often, 2e-3/32);
        REQUIRE(report.subSteps == 0);
        merged += report.mergedIslands;
        impacts += report.impacts;
        for (std::size_t i = 0; i < once.size(); ++i)
        {
            CHECK(norm(once.position[i] - often.position[i]) < 1e-9);
            CHECK(norm(once.velocity[i] - often.velocity[i]) < 1e-6);
            CHECK(norm(once.spin[i] - often.spin[i]) < 1e-2);
        }
    }
    MESSAGE("impacts " << impacts << " merged islands " << merged);
    CHECK(merged > 20);
}

TEST_CASE("adaptive: three spheres that meet at once are handed to the soft law")
{
    Particles result[2];
    for (const bool soft : {false, true})
    {
        Particles& p = result[soft];
        scenes::addSphere(p, {-0.3e-3, 0, 0}, 1e-3, 2500);
        scenes::addSphere(p, {2e-3, 0.1e-3, 0}, 1e-3, 2500);
        scenes::addSphere(p, {2e-3 + 1.6e-3 + 1e-8, 0.1e-3 - 1.2e-3, 0}, 1e-3, 2500);
        p.velocity.set(0, {1, 0, 0});
        const Vector3 momentum = scenes::momentum(p), turning = scenes::angularMomentum(p);
        Settings settings = with(soft ? ContactTreatment::soft : ContactTreatment::automatic);
        settings.stepFraction = 0.005;
        Engine engine(settings, grains(0.8, 0.3, 1e9));
        std::size_t subSteps = 0;
        for (int k = 0; k < 2; ++k) subSteps += engine.advance(p, 5e-4).subSteps;
        CHECK(subSteps > 0);
        CHECK(norm(scenes::momentum(p) - momentum) < 1e-12*norm(momentum));
        CHECK(norm(scenes::angularMomentum(p) - turning) < 1e-8*norm(momentum)*1e-3);
    }
    for (const std::size_t i : {0, 1, 2})
    {
        CHECK(norm(result[0].velocity[i] - result[1].velocity[i]) < 2e-3);
        CHECK(norm(result[0].position[i] - result[1].position[i]) < 2e-6);
    }
}

TEST_CASE("adaptive: particles that meet nothing fly exactly, whatever the step")
{
    Uniform random(3);
    Particles start = cloud(random, {0, 0, 0}, {1, 1, 1}, 4, 1e-4, 1e-3, 5);
    addGravity(start);
    start.gasVelocity.assign(start.size(), {0, 0, 3});
    for (std::size_t i = 0; i < start.size(); ++i)
        start.dragRate.push_back(i % 7 == 0 ? 0 : std::pow(10, random(-2, 5)));
    Engine engine(with(ContactTreatment::automatic), grains(0.9, 0.3));
    Particles one = start, many = start;
    const StepReport report = engine.advance(one, 0.01);
    CHECK(report.freeParticles == start.size());
    CHECK(report.impacts + report.subSteps == 0);
    Vector3 impulse;
    for (int k = 0; k < 10; ++k)
    {
        engine.advance(many, 0.001);
        impulse += many.dragImpulse[1];
    }
    for (std::size_t i = 0; i < start.size(); ++i)
    {
        CHECK(norm(one.position[i] - many.position[i]) < 1e-14);
        const Vector3 gained = one.velocity[i] - start.velocity[i] - 0.01*start.acceleration[i];
        CHECK(norm(one.mass[i]*gained - one.dragImpulse[i]) < 1e-14*one.mass[i]);
    }
    CHECK(norm(impulse - one.dragImpulse[1]) < 1e-13*one.mass[1]);
}

TEST_CASE("adaptive: nothing tunnels, however fast")
{
    const Walls walls(shapes::box({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}, 3));
    for (const double speed : {1.0, 30.0, 300.0})
    {
        Particles p;
        scenes::addSphere(p, {-0.04, 0, 0}, 1e-4, 2500);
        scenes::addSphere(p, {0.04, 0, 0}, 1e-4, 2500);
        p.velocity.set(0, {speed, 0, 0});
        p.velocity.set(1, {-speed, 0, 0});
        Engine engine(with(ContactTreatment::automatic), grains(0.9, 0.3), walls);
        double energy = scenes::kineticEnergy(p);
        for (int k = 0; k < 50; ++k)
        {
            engine.advance(p, 1e-3);
            CHECK(p.position[0].x < p.position[1].x);
            for (const std::size_t i : {0, 1}) CHECK(std::abs(p.position[i].x) < 0.05 - 0.99e-4);
            CHECK(scenes::kineticEnergy(p) <= energy*(1 + 1e-12));
            energy = scenes::kineticEnergy(p);
        }
    }
}

TEST_CASE("adaptive: a dilute gas cools as with the soft law, momentum kept, energy never grows")
{
    PeriodicBox box{{0, 0, 0}, {0.02, 0.02, 0.02}, {true, true, true}};
    const double e = 0.8;
    double temperature[2];
    StepReport report;
    for (const bool soft : {false, true})
    {
        Uniform random(5);
        Particles p = cloud(random, box.low, box.high, 8, 0.5e-3, 0.5e-3, 1);
        Settings settings = with(soft ? ContactTreatment::soft : ContactTreatment::automatic);
        settings.box = box;
        if (soft) settings.stepFraction = 0.05;
        Engine engine(settings, grains(e, 0, 1e8));
        const Vector3 momentum = scenes::momentum(p);
        double energy = scenes::kineticEnergy(p), mass = 0;
        for (const double m : p.mass) mass += m;
        std::size_t impacts = 0, softSteps = 0;
        for (int k = 0; k < 60; ++k)
        {
            report = engine.advance(p, 5e-4);
            impacts += report.impacts;
            softSteps += report.subSteps;
            CHECK(norm(scenes::momentum(p) - momentum) < 1e-12*mass);
            if (!soft) CHECK(scenes::kineticEnergy(p) <= energy*(1 + 1e-9));
            energy = scenes::kineticEnergy(p);
        }
        temperature[soft] = 2*energy/(3*mass);
        if (!soft) MESSAGE("impacts " << impacts << " sub-steps " << softSteps);
        if (!soft) CHECK(impacts > 1000);
    }
    // Haff: sqrt(T0/T) = 1 + t/t0
    const double n = 512/8e-6, d = 1e-3, phi = n*3.14159265/6*d*d*d;
    const double g0 = (1 - phi/2)/std::pow(1 - phi, 3), T0 = 1.0/3;
    const double rate = (1 - e*e)/3*2*std::sqrt(3.14159265)*n*d*d*g0*std::sqrt(T0);
    const double haff = T0/std::pow(1 + 0.03*rate, 2);
    MESSAGE("temperature auto " << temperature[0] << " soft " << temperature[1] << " Haff " << haff);
    CHECK(temperature[0] == near(temperature[1], 0.04));
    CHECK(temperature[0] == near(haff, 0.08));
}

TEST_CASE("adaptive: the order of the particles does not show in the result")
{
    const Walls walls(shapes::box({0, 0, 0}, {0.064, 0.064, 0.064}, 2));
    Uniform random(9);
    Particles a = cloud(random, {0, 0, 0}, {0.064, 0.064, 0.064}, 21, 0.2e-3, 1e-3, 3);
    addGravity(a);
    Particles b;
    std::vector<std::size_t> order(a.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random.generator);
    for (const std::size_t i : order)
    {
        b.id.push_back(a.id[i]), b.material.push_back(0);
        b.radius.push_back(a.radius[i]), b.mass.push_back(a.mass[i]);
        b.position.push_back(a.position[i]), b.velocity.push_back(a.velocity[i]);
        b.spin.push_back(a.spin[i]);
    }
    addGravity(b);
    Settings threads = with(ContactTreatment::automatic);
    threads.threads = 2;
    Engine first(with(ContactTreatment::automatic), grains(0.7, 0.3, 1e6), walls);
    Engine second(threads, grains(0.7, 0.3, 1e6), walls);
    for (int k = 0; k < 6; ++k) first.advance(a, 5e-4), second.advance(b, 5e-4);
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        REQUIRE(norm(b.position[i] - a.position[order[i]]) == 0);
        REQUIRE(norm(b.velocity[i] - a.velocity[order[i]]) == 0);
        REQUIRE(norm(b.spin[i] - a.spin[order[i]]) == 0);
    }
}

TEST_CASE("adaptive: a bouncing ball comes to rest, without end to no bounces")
{
    const Walls walls(scenes::floorAt(0, 1));
    Particles p;
    scenes::addSphere(p, {0, 0, 0.01}, 1e-3, 2500);
    addGravity(p);
    const double radius = 1e-3, young = 1e7;
    Engine engine(with(ContactTreatment::automatic), grains(0.5, 0.3, young), walls);
    // of Hertz' spring, 2/5 of force times overlap
    const double stiffness = 4.0/3*young/(2*(1 - 0.3*0.3))*std::sqrt(radius);
    const double whole = potential(p);
    double energy = whole;
    for (int k = 0; k < 600; ++k)
    {
        engine.advance(p, 5e-4);
        const double held =
            0.4*stiffness*std::pow(std::max(0.0, radius - p.position.z[0]), 2.5);
        const double now = potential(p) + scenes::kineticEnergy(p) + held;
        CHECK(now <= energy + 1e-4*whole);
        energy = now;
    }
    CHECK(norm(p.velocity[0]) < 1e-4);
    CHECK(p.position[0].z == near(1e-3, 1e-3));
}

TEST_CASE("adaptive: weight that works during a contact takes as much as with the soft law")
{
    // drop of 0.4 m (MFiX DEM02, e 0.9): contacts of 46 and 4.6 ms against falls of 0.3 s
    for (const double stiffness : {5e4, 5e6, 5e8})
    {
        double apex[2] = {0, 0};
        for (const auto treatment : {ContactTreatment::soft, ContactTreatment::automatic})
        {
            Particles p;
            scenes::addSphere(p, {0, 0, 0.5}, 0.1, 2600);
            addGravity(p);
            Settings settings = with(treatment, &contactLaw<LinearSpringDashpot>);
            settings.stepFraction = 0.005;
            PairProperties pair;
            pair.restitution = 0.9, pair.friction = 0, pair.normalStiffness = stiffness;
            Engine engine(settings, scenes::oneMaterial(pair), Walls(scenes::floorAt(0, 1)));
            double& highest = apex[treatment == ContactTreatment::soft ? 0 : 1];
            int bounces = 0;
            bool falling = true;
            for (int step = 0; step < 1000 && bounces < 10; ++step)
            {
                const StepReport r = engine.advance(p, 1e-2);
                const double v = p.velocity.z[0];
                if (falling && v > 0 && r.wallTouching == 0) ++bounces, falling = false;
                if (v < 0) falling = true;
                highest = p.position.z[0] + 0.5*v*v/9.81;
            }
            REQUIRE(bounces == 10);
        }
        CAPTURE(stiffness);
        CHECK(apex[1] == near(apex[0], 5e-4));
    }
}


TEST_CASE("adaptive: overlaps without a history give no energy")
{
    for (const double depth : {1e-4, 0.01, 0.3, 0.9, 1.0})
    {
        CAPTURE(depth);
        Particles p;
        scenes::addSphere(p, {0, 0, 0}, 1e-3, 2500);
        scenes::addSphere(p, {(2 - depth*2)*1e-3, 0, 0}, 1e-3, 2500);
        scenes::addSphere(p, {0, 2.5e-3, 0}, 1e-3, 2500);
        p.velocity.set(0, {0.01, 0, 0});
        Engine engine(with(ContactTreatment::automatic), grains(0.9, 0.3));
        const double energy = scenes::kineticEnergy(p);
        const Vector3 momentum = scenes::momentum(p);
        std::size_t separated = 0;
        for (int k = 0; k < 20; ++k) separated += engine.advance(p, 1e-3).separated;
        CHECK(separated > 0);
        CHECK(scenes::kineticEnergy(p) <= energy*(1 + 1e-9));
        CHECK(norm(scenes::momentum(p) - momentum) < 1e-12*norm(momentum));
        CHECK(deepestOverlap(p) < 1e-2);
    }
    // a ball half in the floor
    const Walls walls(scenes::floorAt(0, 1));
    Particles p;
    scenes::addSphere(p, {0, 0, 0.5e-3}, 1e-3, 2500);
    Engine engine(with(ContactTreatment::automatic), grains(0.9, 0.3), walls);
    for (int k = 0; k < 20; ++k) engine.advance(p, 1e-3);
    CHECK(norm(p.velocity[0]) == 0);
    CHECK(p.position[0].z >= 1e-3);
}

TEST_CASE("adaptive: a heap falls and comes to rest as with the soft law")
{
    const Walls walls(shapes::box({0, 0, 0}, {8e-3, 8e-3, 60e-3}, 2));
    double height[2], energy[2], whole = 0;
    for (const bool soft : {false, true})
    {
        Uniform random(21);
        Particles p = cloud(random, {0, 0, 0}, {8e-3, 8e-3, 16e-3}, 5, 0.4e-3, 0.7e-3, 0.1);
        addGravity(p);
        whole = potential(p);
        Engine engine(with(soft ? ContactTreatment::soft : ContactTreatment::automatic),
                      grains(0.6, 0.4, 1e6), walls);
        StepReport report;
        for (int k = 0; k < 600; ++k) report = engine.advance(p, 5e-4);
        height[soft] = 0;
        for (std::size_t i = 0; i < p.size(); ++i) height[soft] += p.position[i].z/double(p.size());
        energy[soft] = scenes::kineticEnergy(p);
        CHECK(deepestOverlap(p) < 0.05);
        CHECK(report.touching > p.size());
    }
    MESSAGE("mean height " << height[0] << " soft " << height[1] << " energy " << energy[0]
            << " soft " << energy[1]);
    CHECK(height[0] == near(height[1], 0.03));
    CHECK(energy[0] < 1e-4*whole);
    CHECK(energy[1] < 1e-4*whole);
}

TEST_CASE("adaptive: a sphere that falls along a wall, just clear of it, takes no sub-steps")
{
    WallGeometry wall;
    shapes::addSheet(wall, {0, -1, -1}, {0, 2, 0}, {0, 0, 2}, 4, 4);
    Particles p;
    const double radius = 5e-4;
    scenes::addSphere(p, {(1 + 1e-6)*radius, 0.1, 0.9}, radius, 2650);
    scenes::addSphere(p, {(3 + 2e-6)*radius, 0.1, 0.9}, radius, 2650);    // and along another
    addGravity(p);
    p.gasVelocity.assign(2, {0, 0, 8});
    p.dragRate = {0.8, 0.9};
    Engine engine(with(ContactTreatment::automatic), grains(0.8, 0), Walls(wall));
    for (int k = 0; k < 100; ++k)
    {
        const StepReport report = engine.advance(p, 4e-3);
        REQUIRE(report.subSteps + report.impacts == 0);
    }
    CHECK(p.position[0].x == near((1 + 1e-6)*radius, 1e-9));
}

TEST_CASE("adaptive: a particle in a corner stays there and rests")
{
    const Walls walls(shapes::box({0, 0, 0}, {0.01, 0.01, 0.01}, 3));
    Particles p;
    scenes::addSphere(p, {1.2e-3, 1.2e-3, 1.2e-3}, 1e-3, 2500);
    p.acceleration.assign(1, {-5, -5, -9});
    Engine engine(with(ContactTreatment::automatic), grains(0.6, 0.3), walls);
    for (int k = 0; k < 400; ++k) engine.advance(p, 5e-4);
    for (int axis = 0; axis < 3; ++axis)
        CHECK(p.position[0][axis] == near(1e-3, 2e-3));
    CHECK(norm(p.velocity[0]) < 1e-4);
}

TEST_CASE("adaptive: a restart with the exported contacts goes on alike")
{
    const Walls walls(shapes::box({0, 0, 0}, {8e-3, 8e-3, 40e-3}, 2));
    for (const int restartAt : {20, 70, 140})
    {
        Uniform random(33);
        Particles p = cloud(random, {0, 0, 0}, {8e-3, 8e-3, 20e-3}, 4, 0.4e-3, 0.7e-3, 0.1);
        addGravity(p);
        const auto materials = grains(0.6, 0.4, 1e6);
        Engine engine(with(ContactTreatment::automatic), materials, walls);
        for (int k = 0; k < restartAt; ++k) engine.advance(p, 5e-4);
        Particles q = p;
        Engine other(with(ContactTreatment::automatic), materials, walls);
        other.importContacts(engine.exportContacts());
        for (int k = 0; k < 10; ++k) engine.advance(p, 5e-4), other.advance(q, 5e-4);
        for (std::size_t i = 0; i < p.size(); ++i)
            CHECK(norm(p.position[i] - q.position[i]) < 1e-9);
    }
}

TEST_CASE("adaptive: soak of random scenes: no nan, no escape, energy bounded")
{
    const char* longSoak = std::getenv("ELUTRIA_SOAK_STEPS");
    const int total = longSoak ? std::atoi(longSoak) : 2000, perScene = 50;
    for (int scene = 0; scene < total/perScene; ++scene)
    {
        CAPTURE(scene);
        Uniform random(1000 + scene);
        const double size = 0.01;
        PeriodicBox box{{0, 0, 0}, {size, size, size}, {false, false, false}};
        Settings settings = with(ContactTreatment(scene % 5 == 4 ? 2 : 0),
                                 random(0, 1) < 0.5 ? &contactLaw<LinearSpringDashpot> : &contactLaw<HertzMindlin>);
        settings.stepFraction = random(0.01, 0.05);
        WallGeometry geometry = shapes::box(box.low, box.high, 1 + scene % 4);
        if (scene % 3 == 0)
        {
            geometry = {};
            shapes::addSheet(geometry, {0, 0, 0}, {size, 0, 0}, {0, size, 0}, 3, 2);
            shapes::addSheet(geometry, {0, 0, size}, {size, 0, 0}, {0, size, 0});
            box.periodic = settings.box.periodic = {true, true, false};
            settings.box = box;
        }
        const Walls walls(geometry, settings.box);
        const int perSide = 2 + scene % 4;
        const double largest = random(0.1, 0.3)*size/perSide;
        const double smallest = largest*std::pow(10, random(-1.2, 0));
        const double speed = std::pow(10, random(-2, 1));
        Particles p = cloud(random, box.low, box.high, perSide, smallest, largest, speed);
        for (std::size_t i = 0; i < p.size(); ++i) p.spin.set(i, random.vector(500));
        addGravity(p, random(0, 20));
        // stiff enough that the soft law's overlaps stay small beside the radii
        const double young = 2e3*2500*(speed + 1)*(speed + 1)*std::pow(10, random(0, 1.5));
        const bool drag = scene % 2;
        const Vector3 gas = random.vector(3);
        if (drag)
        {
            p.gasVelocity.assign(p.size(), gas);
            const double strongest = 1e-3*young/(2500*largest*(norm(gas) + speed));
            for (std::size_t i = 0; i < p.size(); ++i)
                p.dragRate.push_back(std::pow(10, random(-2, std::log10(strongest))));
        }
        Engine engine(settings, grains(random(0.1, 1), random(0, 1), young), walls);
        double energy = scenes::kineticEnergy(p) + potential(p);
        const double scale = scenes::kineticEnergy(p) + std::abs(potential(p));
        const double duration = engine.stepLimit(p)*std::pow(10, random(0, 3.5));
        for (int k = 0; k < perScene; ++k)
        {
            const StepReport report = engine.advance(p, duration);
            double mass = 0;
            for (std::size_t i = 0; i < p.size(); ++i)
            {
                const Vector3 x = p.position[i];
                CAPTURE(report.largestOverlap);
                REQUIRE(std::isfinite(norm(x) + norm(p.velocity[i]) + norm(p.spin[i])));
                mass += p.mass[i];
                for (int axis = 0; axis < 3; ++axis)
                {
                    REQUIRE(x[axis] >= 0);
                    REQUIRE(x[axis] <= size);
                }
            }
            const double now = scenes::kineticEnergy(p) + potential(p);
            const double fed = drag ? mass*(norm(gas) + 2)*(norm(gas) + 2) : 0;
            CHECK(now <= energy + 0.02*scale + fed);
            if (!drag) energy = std::min(energy, now);
        }
    }
}
