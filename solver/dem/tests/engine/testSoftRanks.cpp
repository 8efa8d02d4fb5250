#include "support/rankScenes.hpp"

#include <stdexcept>

// The soft law for all where particles are distributed over ranks: the result is that of one rank but
// for the order of sums.

using namespace scenes;

namespace
{

Scene softBox()
{
    Scene scene = box(1e6);
    scene.settings.treatment = ContactTreatment::soft;
    scene.steps = 4;
    return scene;
}

/// Largest difference, of values below one in this measure.
double apart(const Outcome& a, const Outcome& b)
{
    REQUIRE(a.particles.size() == b.particles.size());
    double most = 0;
    for (const auto& [id, values] : a.particles)
        for (std::size_t k = 0; k < values.size(); ++k)
            most = std::max(most, std::abs(b.particles.at(id)[k] - values[k])/(1 + std::abs(values[k])));
    return most;
}

void checkAlike(const Outcome& one, const Outcome& many, double rounding = 1e-12)
{
    CHECK(apart(one, many) < rounding);
    CHECK(many.subSteps == one.subSteps);
    REQUIRE(many.contacts.size() == one.contacts.size());
    for (std::size_t k = 0; k < one.contacts.size(); ++k)
    {
        CHECK(many.contacts[k].first == one.contacts[k].first);
        CHECK(many.contacts[k].second == one.contacts[k].second);
        CHECK(norm(many.contacts[k].tangential - one.contacts[k].tangential) < rounding);
    }
    REQUIRE(many.hits.size() == one.hits.size());
    for (std::size_t k = 0; k < one.hits.size(); ++k)
        for (std::size_t v = 0; v < one.hits[k].size(); ++v)
            CHECK(many.hits[k][v] == doctest::Approx(one.hits[k][v]).epsilon(rounding));
}

/// Grains in layers that touch each other and the floor, with sideways speeds.
Scene bed(bool periodic)
{
    Scene scene;
    scene.settings.treatment = ContactTreatment::soft;
    const double r = 1e-3;
    const int across = 14, deep = 4, high = 5;
    const Vector3 size{2*r*across, 2*r*deep, 0.02};
    scene.walls = periodic ? WallGeometry{} : shapes::box({0, 0, 0}, size);
    if (periodic) scene.settings.box = {{0, 0, 0}, size, {true, true, true}};
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int k = 0; k < across*deep*high; ++k)
    {
        const int i = k % across, j = k/across % deep, l = k/(across*deep);
        const std::size_t n = addSphere(scene.particles, {r*(2*i + 1), r*(2*j + 1), r*(1.99*l + 0.995)},
                                        r*(1 - 0.05*std::abs(uniform(random))), 2500);
        scene.particles.id[n] = 1 + (n*7919) % 100003;
        scene.particles.velocity.set(n, {0.2*uniform(random), 0.2*uniform(random),
                                         0.2*uniform(random)});
        scene.particles.spin.set(n, {50*uniform(random), 50*uniform(random), 0});
    }
    if (!periodic) scene.particles.acceleration.assign(scene.particles.size(), {0, 0, -9.81});
    PairProperties pair;
    pair.restitution = 0.6, pair.friction = 0.4;
    scene.materials = oneMaterial(pair, 1e6);
    return scene;
}

Particles particlesOf(const Outcome& outcome, const Particles& like)
{
    Particles p = like;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        const std::vector<double>& v = outcome.particles.at(p.id[i]);
        p.position.set(i, {v[0], v[1], v[2]});
        p.velocity.set(i, {v[3], v[4], v[5]});
        p.spin.set(i, {v[6], v[7], v[8]});
    }
    return p;
}

} // namespace


TEST_CASE("soft ranks: spheres that go from rank to rank")
{
    const Scene scene = softBox();
    const Outcome one = run(scene, 1);
    CHECK(one.contacts.size() > 5);
    for (const int ranks : {2, 3, 8}) checkAlike(one, run(scene, ranks));
}

TEST_CASE("soft ranks: a bed that settles in a box")
{
    for (const double hands : {0.0, 0.13})           // fixed ranks, and some that give grains away
    {
        Scene scene = bed(false);
        scene.hands = hands;
        scene.duration = 2e-3, scene.steps = 3;
        const Outcome one = run(scene, 1);
        CHECK(one.contacts.size() > 200);
        CHECK(one.subSteps > 150);
        for (const int ranks : {2, 3, 4}) checkAlike(one, run(scene, ranks), 1e-9);
    }
}

TEST_CASE("soft ranks: pairs over ranks give both the same, to the bit of the total momentum")
{
    Scene scene = bed(true);
    scene.hands = 0;
    scene.duration = 2e-2, scene.steps = 1;
    const Vector3 before = momentum(scene.particles);
    const Outcome one = run(scene, 1), many = run(scene, 3);
    const Particles after = particlesOf(many, scene.particles);
    const double each = scene.particles.mass[0]*0.2;
    CHECK(norm(momentum(after) - before) < 1e-12*each*double(after.size()));
    const double energy = kineticEnergy(scene.particles);
    CHECK(kineticEnergy(after) < 0.5*energy);
    CHECK(kineticEnergy(after) == doctest::Approx(kineticEnergy(particlesOf(one, after))).epsilon(0.05));
}

TEST_CASE("soft ranks: a pair that slides over each other, to the bit")
{
    Scene scene;
    scene.settings.treatment = ContactTreatment::soft;
    addSphere(scene.particles, {0, 0, 0}, 1e-3, 2500);
    addSphere(scene.particles, {1.6e-3, 1.3e-3, 0}, 1e-3, 2500);
    scene.particles.velocity.set(0, {0.2, 0.05, 0.01});
    scene.particles.spin.set(1, {10, -20, 100});
    PairProperties pair;
    pair.restitution = 0.5, pair.friction = 0.3, pair.rollingFriction = 0.02;
    scene.materials = oneMaterial(pair, 1e6);
    scene.duration = 4e-4;
    scene.hands = 0;
    for (const int steps : {1, 2, 40})       // while they touch, and after
    {
        scene.steps = steps;
        const Outcome one = run(scene, 1), two = run(scene, 2);
        CHECK(one.contacts.size() == (steps < 40 ? 1 : 0));
        checkSame(one, two);
        scene.particles.id = {2, 1};
        checkSame(run(scene, 1), run(scene, 2));
        scene.particles.id = {1, 2};
    }
}

TEST_CASE("soft ranks: a sphere shot through those of another rank in one call")
{
    Scene scene = bed(false);
    scene.hands = 0;
    const std::size_t shot = addSphere(scene.particles, {0.5e-3, 4e-3, 0.0135}, 0.4e-3, 20000);
    scene.particles.velocity.set(shot, {6, 0, -1.6});
    scene.particles.acceleration.push_back({0, 0, -9.81});
    scene.duration = 4e-3, scene.steps = 1;
    const Outcome one = run(scene, 1);
    const std::vector<double>& end = one.particles.at(scene.particles.id[shot]);
    CHECK(end[0] > 0.015);
    CHECK(end[3] < 5.9);
    for (const int ranks : {2, 4}) checkAlike(one, run(scene, ranks), 1e-8);
}

TEST_CASE("soft ranks: streams that pass each other in a periodic box")
{
    Scene scene = bed(true);
    scene.hands = 0;
    for (std::size_t i = 0; i < scene.particles.size(); ++i)
        scene.particles.velocity.set(i, {0, 0, scene.particles.position.x[i] < 0.014 ? 1.0 : -1.0});
    scene.duration = 5e-3, scene.steps = 1;
    const Outcome one = run(scene, 1);
    for (const int ranks : {2, 3}) checkAlike(one, run(scene, ranks), 1e-7);
}

TEST_CASE("soft ranks: heaps that fly at each other from beyond each other's reach")
{
    // neither has ghosts, and in neither does anything move against anything else
    Scene scene = bed(true);
    scene.hands = 0;
    scene.settings.box = {};
    for (std::size_t i = 0; i < scene.particles.size(); ++i)
    {
        const Vector3 x = scene.particles.position[i];
        const double side = x.x < 0.014 ? -1 : 1;
        scene.particles.position.set(i, 1.06*x + Vector3{0.006*side, 0, 0});    // none touches another
        scene.particles.velocity.set(i, {-2*side, 0, 0});
        scene.particles.spin.set(i, {});
    }
    // at the ends, so that the ranks' slabs meet between the heaps: both are the first rank's
    for (const Vector3& x : {Vector3{-0.0357, 0.05, 0}, Vector3{0.038, 0.05, 0}})
        scene.particles.velocity.set(addSphere(scene.particles, x, 1e-3, 2500), {2, 0, 0});
    scene.duration = 5e-3, scene.steps = 1;
    Scene parting = scene;
    for (double& x : parting.particles.velocity.x) x = -x;
    const Outcome one = run(scene, 1), two = run(scene, 2);
    CHECK(kineticEnergy(particlesOf(one, scene.particles)) < 0.9*kineticEnergy(scene.particles));
    checkAlike(one, two, 1e-9);
    checkAlike(run(parting, 1), run(parting, 2), 1e-9);
}

TEST_CASE("soft ranks: what is asked of the search, of materials and of weights")
{
    Scene scene = bed(false);
    scene.duration = 3e-4, scene.steps = 2;
    PairProperties soft = {}, sticky = {};
    soft.restitution = 0.5, soft.friction = 0.2;
    sticky.restitution = 0.3, sticky.friction = 0.6, sticky.cohesion = 1e3, sticky.rollingFriction = 0.1;
    scene.materials.add({"wax", 4e5, 0.3});
    scene.materials.setPair(0, 1, soft);
    scene.materials.setPair(1, 1, sticky);
    for (std::size_t i = 0; i < scene.particles.size(); ++i)     // on some ranks only
        scene.particles.material[i] = scene.particles.position.x[i] > 0.02;
    for (const NeighbourSearch search : {NeighbourSearch::automatic, NeighbourSearch::bruteForce,
                                         NeighbourSearch::verlet})
    {
        scene.settings.search = search;
        checkAlike(run(scene, 1), run(scene, 3), 1e-11);
    }
    scene.settings.search = NeighbourSearch::automatic;
    scene.settings.skin = 2e-4;
    checkAlike(run(scene, 1), run(scene, 3), 1e-11);
    scene.settings.skin = 0;
    for (std::size_t i = 0; i < scene.particles.size(); ++i)
    {
        scene.particles.statisticalWeight.push_back(scene.particles.position.x[i] < 5e-3 ? 3 : 1);
        const Vector3 x = scene.particles.position[i];
        scene.particles.position.set(i, {x.x, x.y, 0.99*x.z});   // overlaps that they pass
    }
    scene.guarded = false;
    checkAlike(run(scene, 1), run(scene, 3), 1e-11);
}

TEST_CASE("soft ranks: steps in which contacts rule, between others")
{
    Scene scene = bed(false);
    scene.settings.treatment = ContactTreatment::automatic;
    scene.duration = 3e-4, scene.steps = 8;            // most touch at first, and fewer later
    const std::size_t n = scene.particles.size();
    for (std::size_t i = 0; i < n; ++i) scene.particles.acceleration.set(i, {0, 0, 200});
    scene.particles.dragRate.assign(n, 5);
    const Outcome one = run(scene, 1);
    CHECK(one.subSteps > 50);
    CHECK(one.impacts > 20);
    for (const int ranks : {2, 3})
    {
        const Outcome many = run(scene, ranks);
        CHECK(apart(one, many) < 1e-9);
        CHECK(many.subSteps == one.subSteps);
        CHECK(many.impacts == one.impacts);
        CHECK(many.contacts.size() == one.contacts.size());
    }
}

TEST_CASE("soft ranks: more of them than particles")
{
    Scene scene = softBox();
    scene.particles = chosen(scene.particles, [](std::size_t i) { return i < 3; });
    checkAlike(run(scene, 1), run(scene, 8));
    scene.particles = {};
    checkAlike(run(scene, 1), run(scene, 3));
}

TEST_CASE("soft ranks: hits of walls that answer are told where the particle is")
{
    for (const WallAnswer answer : {WallAnswer::told, WallAnswer::takes})
    {
        Scene scene = softBox();
        scene.answers = {answer};
        scene.steps = 2;
        const Outcome one = run(scene, 1);
        CHECK(one.hits.size() > 20);
        checkAlike(one, run(scene, 3), 1e-10);
    }
}

TEST_CASE("soft ranks: a step that is not sound is repeated by all")
{
    Scene scene;                                   // spheres thrown together in a periodic box
    scene.settings.treatment = ContactTreatment::soft;
    scene.settings.step = 1e-4;                    // a contact takes about 6e-5 s
    scene.settings.box = {{0, 0, 0}, {0.01, 0.01, 0.01}, {true, true, true}};
    PairProperties hard;
    hard.restitution = 1, hard.friction = 0;
    scene.materials = oneMaterial(hard);
    std::mt19937 random(3);
    std::normal_distribution<double> speed(0, 0.3);
    for (int i = 0; i < 6*6*6; ++i)
    {
        const Vector3 corner{i % 6 + 0.5, i/6 % 6 + 0.5, i/36 + 0.5};
        const std::size_t k = addSphere(scene.particles, (0.01/6)*corner, 5e-4, 2650);
        scene.particles.velocity.set(k, {speed(random), speed(random), speed(random)});
    }
    scene.duration = 2e-4, scene.steps = 50, scene.retakes = 8, scene.hands = 0;
    const Outcome one = run(scene, 1), many = run(scene, 3);
    CHECK(one.subSteps > 2*50);                    // that many if none had been repeated
    CHECK(many.subSteps == one.subSteps);
    CHECK(kineticEnergy(particlesOf(many, scene.particles)) < 10*kineticEnergy(scene.particles));
}

TEST_CASE("soft ranks: motion that diverges on one rank ends the step on all")
{
    Particles good = bed(false).particles;
    good.acceleration.assign(good.size(), {});
    ThreadRanks(3).run([&](Exchange& exchange)
    {
        Settings settings;
        settings.treatment = ContactTreatment::soft;
        settings.step = 1e-5;
        Engine engine(settings, oneMaterial({}), {}, exchange);
        Particles mine = chosen(good, [&](std::size_t i) { return int(i % 3) == exchange.rank(); });
        if (exchange.rank() == 1) mine.acceleration.x[4] = 1e300;
        std::string message;
        try { engine.advance(mine, 1e-3); }
        catch (const std::runtime_error& error) { message = error.what(); }
        CHECK(message.find("particle motion diverged") == 0);
    });
}

TEST_CASE("soft ranks: forces as one rank finds them, and on with other ranks from a record")
{
    Scene scene = bed(false);
    scene.duration = 3e-4, scene.steps = 2, scene.hands = 0;
    const Outcome half = run(scene, 3);
    REQUIRE(half.contacts.size() > 100);
    const Particles all = particlesOf(half, scene.particles);
    std::map<std::uint64_t, Vector3> serial;
    std::mutex mutex;
    double most = 0, largest = 0;
    for (const int ranks : {1, 2, 4})
        ThreadRanks(ranks).run([&](Exchange& exchange)
        {
            Engine engine(scene.settings, scene.materials, Walls(scene.walls), exchange);
            const Particles mine = chosen(all, [&](std::size_t i)
            { return rankOf(all.position[i], 0, 0.028, 0, ranks) == exchange.rank(); });
            // on any rank: records are handed to where their particles are
            if (exchange.rank() == ranks - 1) engine.importContacts(half.contacts);
            VectorArray force, torque;
            engine.contactForces(mine, 1e-6, force, torque);
            const std::lock_guard<std::mutex> lock(mutex);
            for (std::size_t i = 0; i < mine.size(); ++i)
            {
                if (ranks == 1) serial[mine.id[i]] = force[i] + 1e3*torque[i];
                largest = std::max(largest, norm(force[i]));
                most = std::max(most, norm(force[i] + 1e3*torque[i] - serial[mine.id[i]]));
            }
        });
    CHECK(largest > 1e-4);
    CHECK(most < 1e-12*largest);
}
