#include "core/TooMuchWork.hpp"
#include "engine/GuardedEngine.hpp"
#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

using namespace elutria::dem;

namespace
{

/// Two grains one above the other in rising gas, the upper one a little too heavy for it and the
/// lower one a little too light, and five that hover far away; `aside`: of the upper one, in radii.
Particles hoveringPair(double aside)
{
    const double radius = 50e-6, gravity = 9.81;
    Particles p;
    scenes::addSphere(p, {0, 0, 0}, radius, 4860);
    scenes::addSphere(p, {aside*radius, 0, radius*std::sqrt(4 - aside*aside)}, radius, 4860);
    for (int k = 1; k < 6; ++k) scenes::addSphere(p, {k*1e-2, 0, 0}, radius, 4860);
    p.acceleration.assign(p.size(), {0, 0, -gravity});
    p.gasVelocity.assign(p.size(), {0, 0, 1});
    p.dragRate.assign(p.size(), gravity);
    p.dragRate[0] *= 1.0005;
    p.dragRate[1] *= 0.9995;
    return p;
}

std::size_t subStepsOf(Particles& p, ContactTreatment treatment, const ContactLaw& law,
                       const WallGeometry& walls = {})
{
    PairProperties pair;
    pair.restitution = 0.8;
    pair.normalStiffness = 1000;
    Settings settings;
    settings.treatment = treatment;
    settings.law = &law;
    Engine engine(settings, scenes::oneMaterial(pair), Walls(walls));
    std::size_t subSteps = 0;
    for (int k = 0; k < 3; ++k) subSteps += engine.advance(p, 0.01).subSteps;
    return subSteps;
}

} // namespace

TEST_CASE("grains that hover side by side and press each other lightly take few contact steps")
{
    Particles adaptive = hoveringPair(0.1), soft = adaptive;
    const ContactLaw& law = contactLaw<HertzMindlin>;
    const std::size_t few = subStepsOf(adaptive, ContactTreatment::automatic, law);
    const std::size_t many = subStepsOf(soft, ContactTreatment::soft, law);
    CAPTURE(few);
    CAPTURE(many);
    CHECK(few < many/3);
    for (const std::size_t i : {0, 1})
    {
        const double way = norm(soft.position[i] - hoveringPair(0.1).position[i]);
        CHECK(way > 1e-8);
        CHECK(norm(adaptive.position[i] - soft.position[i]) < 1e-3*way);
    }
}

TEST_CASE("a grain that hovers along a wall and leans on it takes few contact steps")
{
    const double radius = 50e-6, gravity = 9.81;
    Particles start;
    scenes::addSphere(start, {0, 0, radius}, radius, 4860);
    for (int k = 1; k < 6; ++k) scenes::addSphere(start, {0, k*1e-2, 1}, radius, 4860);
    start.acceleration.assign(start.size(), {gravity, 0, 0});
    start.gasVelocity.assign(start.size(), {-1, 0, -1e-5});
    start.dragRate.assign(start.size(), gravity);
    start.dragRate[0] *= 0.999;

    Particles adaptive = start, soft = start;
    const ContactLaw& law = contactLaw<HertzMindlin>;
    const WallGeometry floor = scenes::floorAt(0, 1);
    const std::size_t few = subStepsOf(adaptive, ContactTreatment::automatic, law, floor);
    const std::size_t many = subStepsOf(soft, ContactTreatment::soft, law, floor);
    CAPTURE(few);
    CAPTURE(many);
    CHECK(few < many/3);
    const double way = norm(soft.position[0] - start.position[0]);
    CHECK(way > 1e-8);
    CHECK(norm(adaptive.position[0] - soft.position[0]) < 1e-3*way);
    CHECK(adaptive.position[0].z < radius);
}

TEST_CASE("a crowd of parcels that collide without end ends, and is told of")
{
    std::mt19937_64 generator(1);
    std::uniform_real_distribution<double> place(0, 2e-3), speed(-1, 1);
    Particles p;
    for (int i = 0; i < 300; ++i)
    {
        const std::size_t k = scenes::addSphere(p, {place(generator), place(generator), 0}, 20e-6, 2500);
        p.velocity.set(k, {speed(generator), speed(generator), 0});
    }
    p.statisticalWeight.assign(p.size(), 1e6);
    PairProperties pair;
    pair.restitution = 1;
    Settings settings;
    settings.step = 1e-5;
    Engine engine(settings, scenes::oneMaterial(pair));
    const StepReport report = engine.advance(p, 1e-3);
    bool told = false;
    for (const Warning& warning : report.warnings) told = told || warning.name == "stepWork";
    CHECK(told);
    for (std::size_t i = 0; i < p.size(); ++i) CHECK(std::isfinite(norm(p.position[i])));
}

TEST_CASE("what would take hours is refused at once, and not tried again in smaller steps")
{
    Particles p = hoveringPair(0.1);
    const Particles before = p;
    Settings settings;
    settings.treatment = ContactTreatment::soft;
    settings.step = 1e-13;
    PairProperties pair;
    pair.restitution = 0.8;
    GuardedEngine engine(std::make_unique<Engine>(settings, scenes::oneMaterial(pair)), 0.1);
    try
    {
        engine.advance(p, 0.01, 5);
        FAIL("it was tried");
    }
    catch (const TooMuchWork& refused)
    {
        CHECK(std::string(refused.what()).find("allowed: 1e+10") != std::string::npos);
    }
    CHECK(p.position[1].z == before.position[1].z);
}
