#include "engine/GuardedEngine.hpp"
#include "impacts/StochasticCollisions.hpp"
#include "support/ThreadExchange.hpp"
#include "support/near.hpp"
#include "support/scenes.hpp"
#include "support/wallShapes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <random>
#include <stdexcept>

// Particles distributed over ranks: the result is to the bit that of one rank.

using namespace scenes;

namespace
{

struct Scene
{
    Settings settings;
    ContactMaterials materials = oneMaterial({});
    WallGeometry walls;
    Particles particles;
    double duration = 1e-3;
    int steps = 6;
    bool guarded = true;
    std::vector<WallAnswer> answers = {};
};

struct Outcome
{
    std::map<std::uint64_t, std::vector<double>> particles;      // by id, all that moves
    std::vector<ContactRecord> contacts;
    std::vector<std::vector<double>> hits;                       // of walls, in no order
    std::size_t impacts = 0, subSteps = 0, merged = 0, shared = 0, separated = 0, free = 0;
};

/// The same, with every column, of particles for which `take` says so.
Particles chosen(const Particles& p, const std::function<bool(std::size_t)>& take)
{
    Particles q;
    q.stepIndex = p.stepIndex;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        if (!take(i)) continue;
        q.id.push_back(p.id[i]), q.material.push_back(p.material[i]);
        q.radius.push_back(p.radius[i]), q.mass.push_back(p.mass[i]);
        q.position.push_back(p.position[i]), q.velocity.push_back(p.velocity[i]);
        q.spin.push_back(p.spin[i]);
        if (!p.statisticalWeight.empty()) q.statisticalWeight.push_back(p.statisticalWeight[i]);
        if (!p.solidFraction.empty()) q.solidFraction.push_back(p.solidFraction[i]);
        if (!p.dragRate.empty()) q.dragRate.push_back(p.dragRate[i]);
        if (!p.gasVelocity.empty()) q.gasVelocity.push_back(p.gasVelocity[i]);
        if (!p.acceleration.empty()) q.acceleration.push_back(p.acceleration[i]);
        if (!p.dragImpulse.empty()) q.dragImpulse.push_back(p.dragImpulse[i]);
    }
    return q;
}

void append(Particles& to, const Particles& p)
{
    const auto add = [](auto& a, const auto& b) { a.insert(a.end(), b.begin(), b.end()); };
    const auto addVectors = [&](VectorArray& a, const VectorArray& b)
    {
        add(a.x, b.x), add(a.y, b.y), add(a.z, b.z);
    };
    add(to.id, p.id), add(to.material, p.material), add(to.radius, p.radius), add(to.mass, p.mass);
    add(to.statisticalWeight, p.statisticalWeight), add(to.solidFraction, p.solidFraction);
    add(to.dragRate, p.dragRate);
    addVectors(to.position, p.position), addVectors(to.velocity, p.velocity);
    addVectors(to.spin, p.spin), addVectors(to.gasVelocity, p.gasVelocity);
    addVectors(to.acceleration, p.acceleration);
}

/// Rank of a particle: slabs of x that change places and widths with the step, so that particles and
/// their contacts go from rank to rank.
int rankOf(const Vector3& x, double from, double to, int step, int ranks)
{
    const double share = std::fmod((x.x - from)/(to - from) + 0.13*step + 1, 1.0);
    return std::min(ranks - 1, int(share*share*ranks));
}

Outcome run(const Scene& scene, int ranks)
{
    Outcome outcome;
    std::mutex mutex;
    double from = 1e300, to = -1e300;
    for (const double x : scene.particles.position.x) from = std::min(from, x), to = std::max(to, x);
    Particles all = scene.particles;         // gathered after each step, as a mesh would hand them on
    ThreadRanks threads(ranks);
    std::vector<std::unique_ptr<GuardedEngine>> engines(ranks);
    std::vector<Particles> parts(ranks);
    std::vector<StepReport> reports(ranks);
    threads.run([&](Exchange& exchange)
    {
        GuardedEngine engine(std::make_unique<Engine>(scene.settings, scene.materials,
            Walls(scene.walls, scene.settings.box), exchange));
        engine.engine().setWallAnswers(scene.answers);
        const int me = exchange.rank();
        std::vector<std::vector<double>> hits;
        for (int step = 0; step < scene.steps; ++step)
        {
            parts[me] = chosen(all, [&](std::size_t i)
                               { return rankOf(all.position[i], from, to, step, ranks) == me; });
            parts[me].stepIndex = step;
            exchange.share({});
            const StepReport report = scene.guarded
                ? engine.advance(parts[me], scene.duration, 2)
                : engine.engine().advance(parts[me], scene.duration);
            for (const WallHit& hit : report.hits)
                hits.push_back({double(step), hit.time, double(hit.id), double(hit.triangle),
                                double(hit.answer), hit.position.x, hit.velocity.x, hit.normal.x});
            exchange.share({});
            if (me == 0)
            {
                Particles next;
                for (const Particles& part : parts) append(next, part);
                all = next;
                outcome.impacts += report.impacts, outcome.subSteps += report.subSteps;
                outcome.merged += report.mergedIslands, outcome.shared += report.sharedIslands;
                outcome.separated += report.separated, outcome.free += report.freeParticles;
            }
            exchange.share({});
        }
        const std::lock_guard<std::mutex> lock(mutex);
        outcome.hits.insert(outcome.hits.end(), hits.begin(), hits.end());
        for (const ContactRecord& record : engine.engine().exportContacts())
            outcome.contacts.push_back(record);
        const Particles& p = parts[me];
        for (std::size_t i = 0; i < p.size(); ++i)
        {
            std::vector<double>& values = outcome.particles[p.id[i]];
            for (const Vector3& v : {p.position[i], p.velocity[i], p.spin[i],
                                     p.dragImpulse.empty() ? Vector3{} : p.dragImpulse[i]})
                values.insert(values.end(), {v.x, v.y, v.z});
        }
    });
    std::sort(outcome.contacts.begin(), outcome.contacts.end(),
              [](const ContactRecord& a, const ContactRecord& b)
              {
                  if (a.first != b.first) return a.first < b.first;
                  return a.second != b.second ? a.second < b.second : a.wall < b.wall;
              });
    std::sort(outcome.hits.begin(), outcome.hits.end());
    return outcome;
}

void checkSame(const Outcome& one, const Outcome& many)
{
    CHECK(one.shared == 0);
    CHECK(many.particles == one.particles);
    CHECK(many.impacts == one.impacts);
    CHECK(many.subSteps == one.subSteps);
    CHECK(many.merged == one.merged);
    CHECK(many.separated == one.separated);
    CHECK(many.free == one.free);
    CHECK(many.hits == one.hits);
    REQUIRE(many.contacts.size() == one.contacts.size());
    for (std::size_t k = 0; k < one.contacts.size(); ++k)
    {
        CHECK(many.contacts[k].first == one.contacts[k].first);
        CHECK(many.contacts[k].second == one.contacts[k].second);
        CHECK(norm(many.contacts[k].tangential - one.contacts[k].tangential) == 0);
    }
}

Particles cloud(std::size_t count, const Vector3& size, double smallest, double largest, double speed,
                unsigned seed = 3)
{
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    Particles p;
    while (p.size() < count)
    {
        const double r = smallest*std::pow(largest/smallest, uniform(0, 1));
        const Vector3 x{uniform(r, size.x - r), uniform(r, size.y - r), uniform(r, size.z - r)};
        bool clear = true;
        for (std::size_t j = 0; clear && j < p.size(); ++j)
            clear = norm(x - p.position[j]) > r + p.radius[j];
        if (!clear) continue;
        const std::size_t i = addSphere(p, x, r, 2500);
        p.id[i] = 1 + (i*7919) % 100003;          // ids do not follow places or ranks
        p.velocity.set(i, {uniform(-speed, speed), uniform(-speed, speed), uniform(-speed, speed)});
    }
    return p;
}

Scene box(double young)
{
    Scene scene;
    const Vector3 size{0.03, 0.01, 0.01};
    scene.walls = shapes::box({0, 0, 0}, size, 2);
    scene.particles = cloud(200, size, 0.2e-3, 0.7e-3, 1);
    scene.particles.acceleration.assign(200, {0, 0, -9.81});
    scene.particles.gasVelocity.assign(200, {0.3, 0, 0});
    for (std::size_t i = 0; i < 200; ++i) scene.particles.dragRate.push_back(0.1*double(i % 97));
    PairProperties pair;
    pair.restitution = 0.9, pair.friction = 0.3, pair.normalStiffness = young*1e-3;
    scene.materials = oneMaterial(pair, young);
    return scene;
}

} // namespace


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

TEST_CASE("ranks: the soft law for all, on the first rank")
{
    Scene scene = box(1e6);
    scene.settings.treatment = ContactTreatment::soft;
    scene.steps = 4;
    const Outcome one = run(scene, 1);
    const Outcome many = run(scene, 3);
    REQUIRE(many.particles.size() == one.particles.size());
    for (const auto& [id, values] : one.particles)      // sums over all depend on their order
        for (std::size_t k = 0; k < values.size(); ++k)
            CHECK(std::abs(many.particles.at(id)[k] - values[k]) < 1e-12*(1 + std::abs(values[k])));
    CHECK(many.contacts.size() == one.contacts.size());
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
