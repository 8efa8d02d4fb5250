#include "core/text.hpp"
#include "engine/GuardedEngine.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <exception>
#include <functional>
#include <stdexcept>
#include <string>

// What a user reads: the value in digits that show it, and what is allowed.

using namespace scenes;

namespace
{

/// The message of what `work` throws; empty if it throws nothing.
std::string messageOf(const std::function<void()>& work)
{
    try
    {
        work();
    }
    catch (const std::exception& error)
    {
        return error.what();
    }
    return "";
}

Particles grains(std::size_t count)
{
    Particles p;
    for (std::size_t i = 0; i < count; ++i) addSphere(p, {0.01*double(i), 0, 0}, 1e-4, 2500);
    return p;
}

std::string refusal(const Particles& particles)
{
    Particles p = particles;
    return messageOf([&] { Engine({}, oneMaterial({})).advance(p, 1e-3); });
}

} // namespace

TEST_SUITE_BEGIN("messages");

TEST_CASE("numbers keep their digits, however small")
{
    CHECK(text(1.2345678e-7) == "1.23457e-07");
    CHECK(text(0.05) == "0.05");
    CHECK(text(-3) == "-3");
    CHECK(text(1e7) == "1e+07");
}

TEST_CASE("a value of a particle that is not allowed")
{
    Particles p = grains(2);
    p.radius[1] = -2e-7;
    CHECK(refusal(p) == "radius of particle 2 is -2e-07; allowed: above 0 m");
    p = grains(2);
    p.mass[0] = -1e-12;
    CHECK(refusal(p) == "mass of particle 1 is -1e-12; allowed: above 0 kg");
    p = grains(2);
    p.material[0] = 3;
    CHECK(refusal(p) == "material of particle 1 is 3; allowed: 0 to 0");
    p = grains(2);
    p.statisticalWeight = {1, 0};
    CHECK(refusal(p) == "statisticalWeight of particle 2 is 0; allowed: above 0");
    p = grains(2);
    p.dragRate = {1, -1e-8};
    CHECK(refusal(p) == "dragRate of particle 2 is -1e-08; allowed: 0 1/s or more");
}

TEST_CASE("a column too short is named, for every column")
{
    const auto check = [](const char* name, const std::string& allowed,
                          const std::function<void(Particles&)>& shorten)
    {
        Particles p = grains(3);
        shorten(p);
        CHECK(refusal(p) == std::string("particle array ") + name + " has 2 entries; allowed: "
                            + allowed);
    };
    check("material", "3", [](Particles& p) { p.material.resize(2); });
    check("radius", "3", [](Particles& p) { p.radius.resize(2); });
    check("mass", "3", [](Particles& p) { p.mass.resize(2); });
    check("position", "3", [](Particles& p) { p.position.resize(2); });
    check("velocity", "3", [](Particles& p) { p.velocity.resize(2); });
    check("spin", "3", [](Particles& p) { p.spin.resize(2); });
    check("statisticalWeight", "3 or 0", [](Particles& p) { p.statisticalWeight.resize(2, 1); });
    check("solidFraction", "3 or 0", [](Particles& p) { p.solidFraction.resize(2); });
    check("dragRate", "3 or 0", [](Particles& p) { p.dragRate.resize(2); });
    check("gasVelocity", "3 or 0", [](Particles& p) { p.gasVelocity.resize(2); });
    check("acceleration", "3 or 0", [](Particles& p) { p.acceleration.resize(2); });
    CHECK(refusal(grains(3)) == "");
}

TEST_CASE("drag without a gas velocity is drag of a gas at rest")
{
    Particles p = grains(1);
    p.dragRate = {10};
    p.velocity.set(0, {1, 0, 0});
    GuardedEngine engine(std::make_unique<Engine>(Settings{}, oneMaterial({})));
    for (int k = 0; k < 2; ++k) engine.advance(p, 0.05, 2);
    CHECK(p.velocity.x[0] == doctest::Approx(std::exp(-1)));
}

TEST_CASE("settings and materials")
{
    CHECK(messageOf([] { Settings s; s.step = -1e-7; Engine(s, oneMaterial({})); })
          == "step is -1e-07; allowed: 0 s (automatic) or more");
    CHECK(messageOf([] { Settings s; s.stepFraction = 3; Engine(s, oneMaterial({})); })
          == "stepFraction is 3; allowed: above 0, up to 2");
    CHECK(messageOf([] { Particles p = grains(1); Engine({}, oneMaterial({})).advance(p, -1e-9); })
          == "duration is -1e-09; allowed: above 0 s");
    CHECK(messageOf([] { PairProperties p; p.friction = -1e-7; Engine({}, oneMaterial(p)); })
          == "friction of pair 'grain' - 'grain' is -1e-07; allowed: 0 or more");
    CHECK(messageOf([] { Engine({}, oneMaterial({}), Walls(floorAt(0, 1, 7))); })
          == "wall material is 7; allowed: 0 to 0");
    Settings narrow;
    narrow.treatment = ContactTreatment::soft;
    narrow.box = {{}, {3e-4, 1, 1}, {true, false, false}};
    CHECK(messageOf([&] { Particles p = grains(1); Engine(narrow, oneMaterial({})).advance(p, 1e-4); })
              .find("periodic box is 0.0003 m wide in x; allowed: at least 0.000") == 0);
}

TEST_CASE("overlaps that no contact explains")
{
    Particles p = grains(2);
    p.position.set(1, {1.5e-4, 0, 0});
    Engine engine({}, oneMaterial({}));
    const StepReport report = engine.advance(p, 1e-4);
    REQUIRE(report.warnings.size() == 1);
    CHECK(report.warnings[0].text()
          == "particles that overlapped each other or a wall without a contact were separated: 1 of "
             "them in a step; widen the feed's patch or zone: it inserts particles into each other "
             "or into a wall");
    CHECK(engine.advance(p, 1e-4).warnings.empty());
}

TEST_CASE("an overlap too deep is given in per cent, beside what is recommended")
{
    Settings settings;
    settings.treatment = ContactTreatment::soft;
    settings.law = &contactLaw<LinearSpringDashpot>;
    PairProperties soft;
    soft.normalStiffness = 1e-1;
    Particles p = grains(2);
    p.position.set(1, {2.001e-4, 0, 0});
    p.velocity.set(1, {-0.1, 0, 0});
    const StepReport report = Engine(settings, oneMaterial(soft)).advance(p, 5e-4);
    REQUIRE(report.warnings.size() == 1);
    CHECK(report.warnings[0].howMuch.find("% of a particle's radius, allowed: 5 %")
          != std::string::npos);
}

TEST_SUITE_END();
