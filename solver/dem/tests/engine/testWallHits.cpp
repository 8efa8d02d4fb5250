#include "engine/GuardedEngine.hpp"
#include "support/near.hpp"
#include "support/scenes.hpp"
#include "support/wallShapes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

// Walls that answer: hits are reported, and particles taken.

using namespace scenes;

namespace
{

constexpr ContactTreatment treatments[] = {ContactTreatment::automatic, ContactTreatment::impact,
                                           ContactTreatment::soft};

GuardedEngine engine(ContactTreatment treatment, WallGeometry walls, WallAnswer answer,
                     double restitution = 0.8, unsigned threads = 1)
{
    Settings settings;
    settings.treatment = treatment, settings.threads = threads;
    PairProperties pair;
    pair.restitution = restitution, pair.friction = 0;
    GuardedEngine made(std::make_unique<Engine>(settings, oneMaterial(pair, 1e8),
                                                Walls(std::move(walls))), 0.2);
    made.engine().setWallAnswers({answer});
    return made;
}

/// Spheres in a row of layers above the floor, thrown downwards and askew.
Particles thrown(std::size_t count)
{
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> any(-1, 1);
    Particles p;
    for (std::size_t i = 0; i < count; ++i)
    {
        addSphere(p, {4e-3*double(i % 5), 4e-3*double(i/5 % 5), 2e-3 + 4e-3*double(i/25)}, 1e-3, 2500);
        p.velocity.set(i, {0.2*any(random), 0.2*any(random), -1});
    }
    return p;
}

} // namespace

TEST_SUITE_BEGIN("wall hits");

TEST_CASE("a ball that bounces is told as often, as fast and when the closed form says")
{
    // Falls from h: hits at t1 = sqrt(2 h/g), then after 2 e^n v1/g each, with e^n v1
    const double h = 0.1, g = 9.81, e = 0.8, radius = 1e-3, first = std::sqrt(2*h/g);
    for (const ContactTreatment treatment : treatments)
    {
        GuardedEngine dem = engine(treatment, floorAt(0, 1), WallAnswer::told, e);
        Particles p;
        addSphere(p, {0, 0, radius + h}, radius, 2500);
        p.acceleration.assign(1, {0, 0, -g});
        std::vector<WallHit> hits;
        for (int step = 0; step < 120; ++step)
            for (WallHit hit : dem.advance(p, 5e-3, 2).hits)
            {
                hit.time += step*5e-3;
                hits.push_back(hit);
            }
        REQUIRE(hits.size() == 3);               // to 0.6 s: at 0.143, 0.371, 0.554 s
        double time = first, speed = g*first;
        for (const WallHit& hit : hits)
        {
            CHECK(hit.time == near(time, 1e-3));
            CHECK(hit.velocity.z == near(-speed, 2e-3));
            CHECK(hit.normal.z == near(1, 1e-12));
            CHECK(hit.position.z == near(radius, 2e-3));   // found at the end of a sub-step
            CHECK(hit.id == 1);
            time += 2*e*speed/g, speed *= e;
        }
    }
}

TEST_CASE("walls that are not asked tell nothing")
{
    for (const ContactTreatment treatment : treatments)
    {
        GuardedEngine dem = engine(treatment, floorAt(0, 1), WallAnswer::silent);
        Particles p = thrown(25);
        for (int step = 0; step < 10; ++step) CHECK(dem.advance(p, 1e-3, 2).hits.empty());
        CHECK(p.velocity.z[0] > 0.7);
    }
}

TEST_CASE("a wall takes what hits it, and what comes behind passes to it")
{
    for (const ContactTreatment treatment : treatments)
    {
        CAPTURE(int(treatment));
        GuardedEngine dem = engine(treatment, floorAt(0, 1), WallAnswer::takes);
        Particles p;                             // the second follows the first straight down
        addSphere(p, {0, 0, 2e-3}, 1e-3, 2500);
        addSphere(p, {0, 0, 5e-3}, 1e-3, 2500);
        for (std::size_t i = 0; i < 2; ++i) p.velocity.set(i, {0, 0, -1});
        const double before = p.position.z[1];
        const StepReport report = dem.advance(p, 2e-3, 2);
        REQUIRE(report.hits.size() == 1);
        CHECK(report.hits[0].id == 1);
        CHECK(report.hits[0].time == near(1e-3, 1e-3));
        CHECK(p.position.z[0] == near(1e-3, 1e-3));
        CHECK(norm(p.velocity[0]) == 0);
        CHECK(p.position.z[1] == near(before - 2e-3, 1e-9));
        const StepReport rest = dem.advance(p, 0.1, 2);
        std::set<std::uint64_t> taken;
        for (const WallHit& hit : rest.hits) taken.insert(hit.id);
        CHECK(taken.count(2) == 1);
        CHECK(norm(p.velocity[1]) == 0);
    }
}

TEST_CASE("all that is thrown at a wall is taken once, in one long step or in many")
{
    for (const ContactTreatment treatment : treatments)
        for (const int steps : {1, 60})
        {
            CAPTURE(int(treatment));
            CAPTURE(steps);
            GuardedEngine dem = engine(treatment, floorAt(0, 10), WallAnswer::takes);
            Particles p = thrown(200);
            const std::size_t count = p.size();
            std::map<std::uint64_t, WallHit> taken;
            std::size_t hits = 0;
            for (int step = 0; step < steps; ++step)
            {
                for (const WallHit& hit : dem.advance(p, 0.12/steps, 2).hits)
                {
                    taken[hit.id] = hit;
                    ++hits;
                }
                Particles left;                  // the caller lays down what rests
                for (std::size_t i = 0; i < p.size(); ++i)
                {
                    if (taken.count(p.id[i]))
                    {
                        CHECK(norm(p.velocity[i]) == 0);
                        CHECK(norm(p.position[i] - taken[p.id[i]].position) < 1e-12);
                        continue;
                    }
                    const std::size_t k = addSphere(left, p.position[i], p.radius[i], 2500);
                    left.id[k] = p.id[i];
                    left.velocity.set(k, p.velocity[i]), left.spin.set(k, p.spin[i]);
                }
                p = left;
            }
            CHECK(hits == count);
            CHECK(taken.size() == count);
            for (const auto& [id, hit] : taken) CHECK(hit.position.z == near(1e-3, 2e-2));
        }
}

TEST_CASE("hits are the same on any number of threads")
{
    std::vector<std::vector<WallHit>> found;
    for (const unsigned threads : {1u, 4u})
    {
        found.emplace_back();
        GuardedEngine dem = engine(ContactTreatment::automatic, shapes::box({-2e-3, -2e-3, 0},
            {0.02, 0.02, 0.05}), WallAnswer::told, 0.8, threads);
        Particles p = thrown(200);
        for (int step = 0; step < 40; ++step)
            for (const WallHit& hit : dem.advance(p, 1e-3, 2).hits) found.back().push_back(hit);
    }
    REQUIRE(found[0].size() > 200);
    REQUIRE(found[1].size() == found[0].size());
    for (std::size_t k = 0; k < found[0].size(); ++k)
    {
        CHECK(found[1][k].id == found[0][k].id);
        CHECK(found[1][k].time == found[0][k].time);
        CHECK(norm(found[1][k].velocity - found[0][k].velocity) == 0);
    }
}

TEST_SUITE_END();
