#include "engine/GuardedEngine.hpp"
#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <exception>
#include <random>
#include <stdexcept>
#include <string>

using namespace scenes;

TEST_SUITE_BEGIN("recovery");

namespace
{

/// Spheres thrown together in a periodic box; `step` s is asked of the soft law.
struct Crowd
{
    Settings settings;
    ContactMaterials materials;
    Particles particles;

    explicit Crowd(double step)
    {
        settings.treatment = ContactTreatment::soft;
        settings.step = step;
        PairProperties hard;
        hard.restitution = 1, hard.friction = 0;
        materials = oneMaterial(hard);
        const double side = 0.01, radius = 5e-4;
        settings.box.low = {}, settings.box.high = {side, side, side};
        for (int axis = 0; axis < 3; ++axis) settings.box.periodic[axis] = true;
        std::mt19937 random(3);
        std::normal_distribution<double> speed(0, 0.3);
        for (int i = 0; i < 6*6*6; ++i)
        {
            const Vector3 corner{double(i % 6), double(i/6 % 6), double(i/36)};
            const std::size_t k =
                addSphere(particles, (side/6)*(corner + Vector3{0.5, 0.5, 0.5}), radius, 2650);
            particles.velocity.set(k, {speed(random), speed(random), speed(random)});
        }
    }

    GuardedEngine engine() const
    {
        return GuardedEngine(std::make_unique<Engine>(settings, materials));
    }
};

} // namespace

TEST_CASE("a step far too large is taken again until it makes no energy")
{
    Crowd crowd(1e-4);     // a contact takes about 6e-5 s
    Crowd unchecked = crowd;
    const double before = kineticEnergy(crowd.particles);

    Engine plain(unchecked.settings, unchecked.materials);
    bool diverged = false;
    try
    {
        for (int k = 0; k < 50; ++k) plain.advance(unchecked.particles, 2e-4);
        diverged = kineticEnergy(unchecked.particles) > 10*before;
    }
    catch (const std::exception&) { diverged = true; }
    CHECK(diverged);

    GuardedEngine engine = crowd.engine();
    for (int k = 0; k < 50; ++k) engine.advance(crowd.particles, 2e-4, 8);
    CHECK(engine.engine().settings().step < crowd.settings.step);
    CHECK(kineticEnergy(crowd.particles) < 10*before);
}

TEST_CASE("an asked step is kept below a share of the shortest contact")
{
    Crowd crowd(1e-4);
    GuardedEngine engine(std::make_unique<Engine>(crowd.settings, crowd.materials), 0.2);
    const StepReport report = engine.advance(crowd.particles, 2e-4, 0);
    CHECK(!report.warnings.empty());
    CHECK(report.warnings.front().howMuch.find("0.0001 s, allowed: ") == 0);
    const double step = engine.engine().settings().step;
    CHECK(step == near(10*engine.engine().stepLimit(crowd.particles), 0.3));
}

TEST_CASE("a sound step is the engine's own")
{
    Crowd crowd(0), plain = crowd;
    GuardedEngine engine = crowd.engine();
    Engine bare(plain.settings, plain.materials);
    for (int k = 0; k < 5; ++k)
    {
        engine.advance(crowd.particles, 2e-4, 4);
        bare.advance(plain.particles, 2e-4);
    }
    CHECK(engine.engine().settings().stepFraction == crowd.settings.stepFraction);
    CHECK(crowd.particles.position.x == plain.particles.position.x);
    CHECK(crowd.particles.velocity.z == plain.particles.velocity.z);
}

TEST_CASE("a sphere that enters within another gives no energy")
{
    Crowd crowd(0);
    GuardedEngine engine = crowd.engine();
    engine.advance(crowd.particles, 2e-4, 0);
    const double before = kineticEnergy(crowd.particles);
    Particles& p = crowd.particles;
    for (int k = 0; k < 3; ++k)
        addSphere(p, p.position[40*std::size_t(k)] + Vector3{1e-4, 0, 5e-5}, 4e-4, 2650);
    for (int k = 0; k < 20; ++k) engine.advance(p, 2e-4, 0);
    CHECK(kineticEnergy(p) < 1.02*before);
}

TEST_CASE("a sphere that enters with a side in a wall is put beside it, and nothing is said")
{
    for (const ContactTreatment treatment : {ContactTreatment::automatic, ContactTreatment::soft})
    {
        Settings settings;
        settings.treatment = treatment;
        GuardedEngine engine(std::make_unique<Engine>(settings, oneMaterial({}),
                                                      Walls(floorAt(0, 1))));
        Particles p;
        addSphere(p, {0, 0, 0.01}, 1e-3, 2500);
        engine.advance(p, 1e-4, 0);
        addSphere(p, {0.01, 0, 4e-4}, 1e-3, 2500);
        const StepReport report = engine.advance(p, 1e-4, 0);
        CHECK(report.warnings.empty());
        CHECK(p.position[1].z == near(1e-3, 1e-6));
        CHECK(norm(p.velocity[1]) < 1e-9);
    }
}

TEST_CASE("spheres that enter between a wall and others stay on its side")
{
    for (const ContactTreatment treatment : {ContactTreatment::automatic, ContactTreatment::soft})
    {
        const int kind = int(treatment);
        CAPTURE(kind);
        Settings settings;
        settings.treatment = treatment;
        GuardedEngine engine(std::make_unique<Engine>(settings, oneMaterial({}),
                                                      Walls(floorAt(0, 1))));
        Particles p;
        addSphere(p, {0, 0, 1e-3}, 1e-3, 2500);
        engine.advance(p, 1e-5, 0);
        for (int k = 0; k < 6; ++k)     // on the floor, each with a side in the large one's
        {
            const double turn = elutria::dem::laws::pi/3*k, radius = 0.1e-3*(1 + k);
            addSphere(p, {0.3e-3*std::cos(turn), 0.3e-3*std::sin(turn), radius}, radius, 2500);
        }
        for (int step = 0; step < 20; ++step)
        {
            engine.advance(p, 1e-4, 5);
            for (std::size_t i = 0; i < p.size(); ++i)
            {
                CAPTURE(i);
                CHECK(p.position[i].z > 0.9*p.radius[i]);
                CHECK(norm(p.velocity[i]) < 0.1);
            }
        }
    }
}

TEST_CASE("what stays unsound ends with the state before it")
{
    Crowd crowd(1e-4);
    GuardedEngine engine = crowd.engine();
    engine.advance(crowd.particles, 1e-6, 0);
    Particles last = crowd.particles;
    try
    {
        for (int k = 0; k < 100; ++k)
        {
            last = crowd.particles;
            engine.advance(crowd.particles, 2e-4, 0);
        }
        FAIL("no step failed");
    }
    catch (const std::runtime_error& error)
    {
        CHECK(std::string(error.what()).find("likely causes") != std::string::npos);
        CHECK(crowd.particles.position.x == last.position.x);
        CHECK(crowd.particles.velocity.y == last.velocity.y);
    }
}

TEST_SUITE_END();
