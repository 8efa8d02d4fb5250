#pragma once

#include "engine/GuardedEngine.hpp"
#include "parallel/ThreadRanks.hpp"
#include "support/scenes.hpp"
#include "support/wallShapes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <random>

// Scenes whose particles are distributed over ranks.

namespace scenes
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
    int retakes = 2;
    double hands = 0.13;           // of the extent, by which slabs of ranks move from step to step
};

struct Outcome
{
    std::map<std::uint64_t, std::vector<double>> particles;      // by id, all that moves
    std::vector<ContactRecord> contacts;
    std::vector<std::vector<double>> hits;                       // of walls, in no order
    std::size_t impacts = 0, subSteps = 0, merged = 0, shared = 0, separated = 0, free = 0;
};

/// The same, with every column, of particles for which `take` says so.
inline Particles chosen(const Particles& p, const std::function<bool(std::size_t)>& take)
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

inline void append(Particles& to, const Particles& p)
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

/// Rank of a particle: slabs of x of different widths; where they move with the steps, particles and
/// their contacts go from rank to rank.
inline int rankOf(const Vector3& x, double from, double to, double shift, int ranks)
{
    const double share = std::fmod((x.x - from)/(to - from) + shift + 1, 1.0);
    return std::min(ranks - 1, int(share*share*ranks));
}

inline Outcome run(const Scene& scene, int ranks)
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
                               { return rankOf(all.position[i], from, to, scene.hands*step, ranks) == me; });
            parts[me].stepIndex = step;
            exchange.share({});
            const StepReport report = scene.guarded
                ? engine.advance(parts[me], scene.duration, scene.retakes)
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

inline void checkSame(const Outcome& one, const Outcome& many)
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

inline Particles cloud(std::size_t count, const Vector3& size, double smallest, double largest, double speed,
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

inline Scene box(double young)
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

} // namespace scenes
