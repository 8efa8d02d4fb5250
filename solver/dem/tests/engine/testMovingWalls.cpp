#include "engine/GuardedEngine.hpp"
#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <stdexcept>
#include <string>

// Walls that move along themselves: belts, rotors, decks that shake in their plane.

using namespace scenes;

namespace
{

/// The plane z = 0, moving.
WallGeometry belt(const WallMotion& motion)
{
    WallGeometry geometry = floorAt(0, 10);
    geometry.motions = {motion};
    geometry.motion = {0, 0};
    return geometry;
}

ContactMaterials grain(double friction, double restitution = 0.8)
{
    PairProperties p;
    p.friction = friction, p.restitution = restitution;
    return oneMaterial(p);
}

Settings with(ContactTreatment treatment, const ContactLaw* law = &contactLaw<HertzMindlin>)
{
    Settings settings;
    settings.treatment = treatment;
    settings.law = law;
    return settings;
}

} // namespace

TEST_SUITE_BEGIN("moving walls");

TEST_CASE("a belt drags a grain by friction until both move alike")
{
    for (const ContactTreatment treatment : {ContactTreatment::automatic, ContactTreatment::soft})
    {
        const double friction = 0.4, g = 9.81, belts = 1, radius = 1e-3;
        Engine engine(with(treatment), grain(friction), Walls(belt({{belts, 0, 0}, {}, {}})));
        Particles p;
        addSphere(p, {0, 0, radius}, radius, 2500);
        p.acceleration.assign(1, {0, 0, -g});
        double time = 0;
        for (; time < 0.02 - 1e-9; time += 1e-3) engine.advance(p, 1e-3);
        CHECK(p.velocity.x[0] == near(friction*g*time, 0.02));         // 0.0785 m/s
        // sliding ends when the sphere's surface has the belt's speed: mu g t (1 + 5/2) = v_belt
        for (; time < 0.12; time += 1e-3) engine.advance(p, 1e-3);
        const double surface = p.velocity.x[0] - radius*p.spin.y[0];
        CHECK(surface == near(belts, 1e-3));
        CHECK(p.velocity.x[0] == near(2*belts/7, 0.01));
        CHECK(std::abs(p.velocity.y[0]) < 1e-9);
    }
}

TEST_CASE("a moving wall is a wall at rest seen from a frame that moves")
{
    const Vector3 walls{0.7, -0.4, 0};
    for (const ContactTreatment treatment : {ContactTreatment::automatic, ContactTreatment::soft,
                                             ContactTreatment::impact})
        for (const ContactLaw* law : {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>})
        {
            CAPTURE(law->name);
            Particles moving;
            addSphere(moving, {0, 0, 1.4e-3}, 1e-3, 2500);
            addSphere(moving, {2.1e-3, 0.3e-3, 2.5e-3}, 0.7e-3, 1500);
            moving.velocity.set(0, {1, 0.2, -0.8});
            moving.velocity.set(1, {0.1, 0.3, -1.5});
            moving.spin.set(0, {200, -300, 50});
            Particles resting = moving;
            for (std::size_t i = 0; i < 2; ++i) resting.velocity.set(i, moving.velocity[i] - walls);
            const double before = kineticEnergy(resting);
            Settings settings = with(treatment, law);
            settings.step = 1e-6;                // it would follow from the speeds, which differ
            Engine a(settings, grain(0.3), Walls(belt({walls, {}, {}})));
            Engine b(settings, grain(0.3), Walls(floorAt(0, 10)));
            for (int k = 0; k < 40; ++k) a.advance(moving, 1e-4), b.advance(resting, 1e-4);
            for (std::size_t i = 0; i < 2; ++i)
            {
                CHECK(norm(moving.velocity[i] - resting.velocity[i] - walls) < 1e-5);
                CHECK(norm(moving.spin[i] - resting.spin[i]) < 1e-2);
                CHECK(norm(moving.position[i] - resting.position[i] - 4e-3*walls) < 1e-8);
            }
            CHECK(kineticEnergy(resting) < 0.95*before);       // both did hit the wall
        }
}

TEST_CASE("a wall's work is its speed times the impulse that it gives, less what friction takes")
{
    // One bounce off a belt, gross sliding: J_n = (1 + e) m c, J_t = mu J_n
    const double e = 0.8, friction = 0.1, closing = 1, belts = 5, radius = 1e-3;
    Particles p;
    addSphere(p, {0, 0, 1.01e-3}, radius, 2500);
    p.velocity.set(0, {0, 0, -closing});
    const double mass = p.mass[0], before = kineticEnergy(p);
    Engine engine(with(ContactTreatment::impact), grain(friction, e),
                  Walls(belt({{belts, 0, 0}, {}, {}})));
    engine.advance(p, 1e-3);
    const double impulse = friction*(1 + e)*mass*closing;
    CHECK(mass*p.velocity.x[0] == near(impulse, 1e-9));
    CHECK(0.4*mass*radius*radius*p.spin.y[0] == near(-radius*impulse, 1e-9));
    // sliding distance times force, on average at the mean of the sliding speeds before and after
    const double slides = belts - 0.5*3.5*impulse/mass;
    const double lost = 0.5*mass*closing*closing*(1 - e*e) + impulse*slides;
    CHECK(kineticEnergy(p) == near(before + belts*impulse - lost, 1e-9));
}

TEST_CASE("a turning disc throws a grain along its circle, faster further out")
{
    for (const double distance : {0.05, 0.2})
    {
        const double turn = 20, radius = 1e-3;
        Engine engine(with(ContactTreatment::impact, &contactLaw<LinearSpringDashpot>), grain(2, 1),
                      Walls(belt({{}, {0, 0, turn}, {0.01, 0, 0}})));
        Particles p;
        addSphere(p, {0.01 + distance, 0, 1.01e-3}, radius, 2500);
        p.velocity.set(0, {0, 0, -20});
        engine.advance(p, 1e-4);
        // sticks; springs with k_t = 2/7 k_n turn the sliding round: 2/7 (1 + 1) of it
        CHECK(p.velocity.y[0] == near(4.0/7*turn*distance, 0.01));
        CHECK(std::abs(p.velocity.x[0]) < 1e-9);
    }
}

TEST_CASE("a shaking deck: the motion of every step counts, what points out of the deck does not")
{
    Engine engine(with(ContactTreatment::soft), grain(0.4), Walls(belt({{1, 0, 0.5}, {}, {}})));
    Particles p;
    addSphere(p, {0, 0, 1e-3}, 1e-3, 2500);
    p.acceleration.assign(1, {0, 0, -9.81});
    double highest = 0;
    for (int k = 0; k < 40; ++k)
    {
        engine.setWallMotions({{{k < 20 ? 1.0 : -1.0, 0, 0.5}, {}, {}}});
        engine.advance(p, 5e-4);
        highest = std::max(highest, p.position.z[0]);
        if (k == 19) CHECK(p.velocity.x[0] == near(0.4*9.81*0.01, 0.02));
    }
    CHECK(std::abs(p.velocity.x[0]) < 1e-3);               // as long to and fro
    CHECK(highest < 1e-3 + 1e-9);
}

TEST_CASE("the guard lets walls do work")
{
    Settings settings = with(ContactTreatment::soft);
    GuardedEngine guarded(std::make_unique<Engine>(settings, grain(0.5),
                                                   Walls(belt({{3, 0, 0}, {}, {}}))));
    Particles p;
    addSphere(p, {0, 0, 1e-3}, 1e-3, 2500);
    p.acceleration.assign(1, {0, 0, -9.81});
    for (int k = 0; k < 20; ++k) CHECK(guarded.advance(p, 1e-3, 4).warnings.empty());
    CHECK(guarded.engine().settings().stepFraction == settings.stepFraction);
}

TEST_CASE("motions that do not fit the walls are refused")
{
    WallGeometry wrong = belt({{1, 0, 0}, {}, {}});
    wrong.motion = {0};
    CHECK_THROWS_WITH_AS(Walls{wrong}, "walls: 2 triangles but 1 motions", std::invalid_argument);
    wrong.motion = {0, 1};
    CHECK_THROWS_WITH_AS(Walls{wrong}, "walls: a triangle names motion 1, there are 1",
                         std::invalid_argument);
    Walls walls(belt({{1, 0, 0}, {}, {}}));
    CHECK_THROWS_AS(walls.setMotions({}), std::invalid_argument);
    CHECK(walls.largestSpeed() == near(1, 1e-12));
}

TEST_SUITE_END();
