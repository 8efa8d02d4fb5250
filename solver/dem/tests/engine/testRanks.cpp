#include "support/rankScenes.hpp"

#include <stdexcept>

// Particles distributed over ranks: the result is to the bit that of one rank.

using namespace scenes;

TEST_CASE("ranks: chains of impacts as on one rank, to the bit")
{
    for (const bool forced : {true, false})
    {
        Scene scene = box(1e15);
        if (forced) scene.settings.treatment = ContactTreatment::impact;
        const Outcome one = run(scene, 1);
        CHECK(one.impacts > 200);
        CHECK(one.merged > 10);
        for (const int ranks : {2, 3, 8})
        {
            CAPTURE(ranks);
            const Outcome many = run(scene, ranks);
            CHECK(many.shared > 0);
            checkSame(one, many);
        }
    }
}

TEST_CASE("ranks: long steps, with islands over many ranks that grow")
{
    Scene scene = box(1e15);
    scene.duration = 4e-3, scene.steps = 2;
    const Outcome one = run(scene, 1);
    CHECK(one.merged > 50);
    for (const int ranks : {2, 8}) checkSame(one, run(scene, ranks));
}

TEST_CASE("ranks: periodic box")
{
    Scene scene = box(1e15);
    scene.walls = {};
    scene.settings.box = {{0, 0, 0}, {0.03, 0.01, 0.01}, {true, true, true}};
    scene.particles.acceleration = {};
    const Outcome one = run(scene, 1);
    CHECK(one.impacts > 100);
    for (const int ranks : {2, 3, 8}) checkSame(one, run(scene, ranks));
}

TEST_CASE("ranks: contacts that last travel with their particles")
{
    Scene scene = box(1e6);                   // soft: impacts and contact steps side by side
    for (std::size_t i = 0; i < 200; ++i)     // some come to rest below others that float
        scene.particles.acceleration.set(i, {0, 0, i % 5 == 0 ? -60.0 : 0.0});
    scene.particles.dragRate.assign(200, 60);
    PairProperties pair;
    pair.restitution = 0.2, pair.friction = 0.5;
    scene.materials = oneMaterial(pair, 1e6);
    scene.steps = 60, scene.duration = 4e-4;
    const Outcome one = run(scene, 1);
    CHECK(one.subSteps > 1000);
    CHECK(one.contacts.size() > 10);
    for (const int ranks : {2, 3, 8}) checkSame(one, run(scene, ranks));
}

TEST_CASE("ranks: parcels that stand for several particles")
{
    Scene scene = box(1e15);
    scene.particles = chosen(scene.particles, [](std::size_t i) { return i % 2 == 0; });
    const std::size_t n = scene.particles.size();
    for (std::size_t i = 0; i < n; ++i)
        scene.particles.statisticalWeight.push_back(i % 3 == 0 ? 1 : 0.5*double(i % 7 + 1));
    scene.particles.solidFraction.assign(n, 0.1);
    const Outcome one = run(scene, 1);
    CHECK(one.impacts > 100);
    for (const int ranks : {2, 3, 8}) checkSame(one, run(scene, ranks));
}

TEST_CASE("ranks: overlaps that no contact explains")
{
    Scene scene = box(1e15);
    for (std::size_t i = 0; i + 1 < 60; i += 2)
    {
        const Vector3 x = scene.particles.position[i];
        scene.particles.position.set(i + 1, x + Vector3{0.4*scene.particles.radius[i], 0, 1e-5});
    }
    scene.steps = 2;
    const Outcome one = run(scene, 1);
    CHECK(one.separated > 20);
    for (const int ranks : {2, 3, 8}) checkSame(one, run(scene, ranks));
}

TEST_CASE("ranks: a step that takes the soft law for all keeps no drag impulse of the step before")
{
    Scene scene = box(1e6);
    scene.duration = 1e-5;                    // few sub-steps: the soft law from the start
    scene.steps = 1;
    const Outcome clean = run(scene, 1);
    CHECK(clean.subSteps > 0);
    scene.particles.dragImpulse.assign(scene.particles.size(), {1, 1, 1});
    CHECK(run(scene, 1).particles == clean.particles);
}

TEST_CASE("ranks: more of them than particles")
{
    Scene scene = box(1e15);
    scene.particles = chosen(scene.particles, [](std::size_t i) { return i < 3; });
    checkSame(run(scene, 1), run(scene, 8));
    scene.particles = {};
    checkSame(run(scene, 1), run(scene, 3));
}

TEST_CASE("ranks: hits of walls that answer are told where the particle is")
{
    for (const WallAnswer answer : {WallAnswer::told, WallAnswer::takes})
    {
        Scene scene = box(1e15);
        scene.answers = {answer};
        scene.steps = 3;
        const Outcome one = run(scene, 1);
        CHECK(one.hits.size() > 50);
        checkSame(one, run(scene, 3));
    }
}

TEST_CASE("ranks: what one rank refuses is refused by all")
{
    const Particles good = box(1e15).particles;
    ThreadRanks(3).run([&](Exchange& exchange)
    {
        Engine engine({}, oneMaterial({}), {}, exchange);
        Particles mine = chosen(good, [&](std::size_t i) { return int(i % 3) == exchange.rank(); });
        if (exchange.rank() == 1) mine.radius[4] = -1;
        std::string message;
        try { engine.advance(mine, 1e-3); }
        catch (const std::invalid_argument& error) { message = error.what(); }
        CHECK(message.find("radius of particle") == 0);
    });
}
