#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <new>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>

using namespace scenes;

namespace
{
std::atomic<std::size_t> allocations{0};
}

// Counted for the whole test program: the engine's library resolves to these.
[[gnu::noinline]] void* operator new(std::size_t size)
{
    ++allocations;
    if (void* p = std::malloc(size)) return p;
    throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment)
{
    ++allocations;
    const std::size_t a = static_cast<std::size_t>(alignment);
    if (void* p = std::aligned_alloc(a, (size + a - 1)/a*a)) return p;
    throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
    ++allocations;
    return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace
{

Settings soft(const ContactLaw* law = &contactLaw<HertzMindlin>)
{
    Settings settings;
    settings.law = law;
    settings.treatment = ContactTreatment::soft;
    return settings;
}

/// A loose heap of spheres of two materials over a floor, periodic sideways.
struct Heap
{
    Settings settings = soft();
    ContactMaterials materials;
    Particles particles;
    double width = 0.02;

    explicit Heap(std::size_t count, double ratio = 3)
    {
        materials.add({"sand", 1e7, 0.3});
        materials.add({"wax", 5e6, 0.4});
        PairProperties pair;
        pair.restitution = 0.6;
        pair.friction = 0.4;
        materials.setPair(0, 0, pair);
        pair.restitution = 0.5;
        materials.setPair(0, 1, pair);
        pair.friction = 0.1;
        materials.setPair(1, 1, pair);
        settings.box = {{0, 0, 0}, {width, width, 0}, {true, true, false}};
        std::mt19937_64 random(42);
        std::uniform_real_distribution<double> uniform(0, 1);
        const double largest = 0.45*width/10;
        for (std::size_t k = 0; k < count; ++k)
        {
            const std::size_t i = k % 10, j = k/10 % 10, l = k/100;
            const double radius = largest*std::pow(ratio, -uniform(random));
            const double cell = width/10, room = cell - 2*radius;
            addSphere(particles,
                      {(double(i) + 0.5)*cell + room*(uniform(random) - 0.5),
                       (double(j) + 0.5)*cell + room*(uniform(random) - 0.5),
                       (double(l) + 0.5)*cell + room*(uniform(random) - 0.5)},
                      radius, 2500, std::uint32_t(k % 2));
            particles.velocity.set(k, {uniform(random) - 0.5, uniform(random) - 0.5, -0.5});
        }
        particles.acceleration.assign(count, {0, 0, -9.81});
    }
    Engine engine() const
    {
        WallGeometry floor{{{0, 0, 0}, {width, 0, 0}, {width, width, 0}, {0, width, 0}},
                           {{0, 1, 2}, {0, 2, 3}}, {0, 0}};
        return Engine(settings, materials, Walls(floor, settings.box));
    }
};

bool same(const VectorArray& a, const VectorArray& b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

std::string message(const std::function<void()>& work)
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

} // namespace

TEST_SUITE("engine")
{
    TEST_CASE("the same bits for any number of threads")
    {
        // enough for every loop to be shared; a narrow buffer, so that lists are made anew
        const auto heapOn = [](unsigned threads)
        {
            Heap heap(9000);
            heap.settings.threads = threads;
            heap.settings.skin = 0.02*heap.particles.radius[0];
            return heap;
        };
        Heap reference = heapOn(1);
        Engine one = reference.engine();
        std::size_t lists = 0;
        for (int k = 0; k < 2; ++k) lists += one.advance(reference.particles, 5e-4).listBuilds;
        CHECK(lists > 2);
        const std::vector<ContactRecord> contacts = one.exportContacts();
        CHECK(contacts.size() > 100);
        for (unsigned threads : {2u, 3u, 4u})
        {
            Heap heap = heapOn(threads);
            Engine engine = heap.engine();
            for (int k = 0; k < 2; ++k) engine.advance(heap.particles, 5e-4);
            CHECK(same(heap.particles.position, reference.particles.position));
            CHECK(same(heap.particles.velocity, reference.particles.velocity));
            CHECK(same(heap.particles.spin, reference.particles.spin));
            const std::vector<ContactRecord> theirs = engine.exportContacts();
            REQUIRE(theirs.size() == contacts.size());
            bool equal = true;
            for (std::size_t k = 0; k < contacts.size(); ++k)
            {
                const Vector3 apart = theirs[k].tangential - contacts[k].tangential;
                equal = equal && theirs[k].first == contacts[k].first
                        && theirs[k].second == contacts[k].second && squaredNorm(apart) == 0;
            }
            CHECK(equal);
        }
    }

    TEST_CASE("the same bits for any order of the caller's particles")
    {
        Heap reference(3000), shuffled(3000);
        const std::size_t n = 3000;
        std::vector<std::size_t> order(n);
        std::iota(order.begin(), order.end(), 0u);
        std::shuffle(order.begin(), order.end(), std::mt19937(3));
        const Particles& p = reference.particles;
        Particles& q = shuffled.particles;
        for (std::size_t k = 0; k < n; ++k)
        {
            const std::size_t i = order[k];
            q.id[k] = p.id[i], q.material[k] = p.material[i];
            q.radius[k] = p.radius[i], q.mass[k] = p.mass[i];
            q.position.set(k, p.position[i]), q.velocity.set(k, p.velocity[i]);
            q.spin.set(k, p.spin[i]);
        }
        Engine a = reference.engine(), b = shuffled.engine();
        for (int k = 0; k < 5; ++k)
        {
            a.advance(reference.particles, 2e-3);
            b.advance(shuffled.particles, 2e-3);
        }
        double largest = 0;
        for (std::size_t k = 0; k < n; ++k)
        {
            largest = std::max(largest, norm(q.velocity[k] - p.velocity[order[k]]));
        }
        CHECK(largest == 0);
    }

    TEST_CASE("momentum of a periodic cloud of spheres that collide is kept to rounding")
    {
        Heap heap(2000);
        heap.settings.box.high.z = 0.05;
        heap.settings.box.periodic = {true, true, true};
        heap.particles.acceleration = {};
        Engine engine(heap.settings, heap.materials);
        double scale = 0;
        for (std::size_t i = 0; i < 2000; ++i)
        {
            scale += heap.particles.mass[i]*norm(heap.particles.velocity[i]);
        }
        const Vector3 before = momentum(heap.particles);
        double energy = kineticEnergy(heap.particles);
        for (int k = 0; k < 10; ++k)
        {
            engine.advance(heap.particles, 2e-3);
            CHECK(norm(momentum(heap.particles) - before) < 1e-13*scale);
        }
        CHECK(kineticEnergy(heap.particles) < energy);
        for (std::size_t i = 0; i < 2000; ++i)
        {
            const Vector3 x = heap.particles.position[i];
            for (int a = 0; a < 3; ++a)
            {
                CHECK(x[a] >= 0);
                CHECK(x[a] < heap.settings.box.high[a]);
            }
        }
    }

    TEST_CASE("a periodic box gives the forces of its images")
    {
        PairProperties pair;
        pair.friction = 0.5;
        Settings settings = soft();
        settings.box = {{0, 0, 0}, {0.01, 0.01, 0.01}, {true, true, true}};
        Engine periodic(settings, oneMaterial(pair)), open(soft(), oneMaterial(pair));
        const Vector3 a{0.0001, 0.005, 0.0099}, b{0.0098, 0.0052, 0.0004};
        Particles p, q;
        addSphere(p, a, 5e-4, 2500), addSphere(p, b, 5e-4, 2500);
        addSphere(q, a, 5e-4, 2500), addSphere(q, b + Vector3{-0.01, 0, 0.01}, 5e-4, 2500);
        for (Particles* s : {&p, &q}) s->velocity.set(0, {-0.1, 0.2, 0.3});
        VectorArray fp, tp, fq, tq;
        periodic.contactForces(p, 1e-6, fp, tp);
        open.contactForces(q, 1e-6, fq, tq);
        CHECK(norm(fq[0]) > 0);
        CHECK(norm(fp[0] - fq[0]) < 1e-5*norm(fq[0]));
        CHECK(norm(fp[0] + fp[1]) == 0);
        CHECK(norm(tp[1] - tq[1]) < 1e-5*norm(tq[1]));
    }

    TEST_CASE("history survives list rebuilds, refreshes, a reordering caller and a restart")
    {
        // the same heap with a skin so small that lists are made all the time
        Heap calm(1000), busy(1000);
        calm.settings.skin = 1e-3;
        busy.settings.skin = 2e-5;
        Engine a = calm.engine(), b = busy.engine();
        std::size_t buildsCalm = 0, buildsBusy = 0;
        for (int k = 0; k < 5; ++k)
        {
            buildsCalm += a.advance(calm.particles, 1e-3).listBuilds;
            buildsBusy += b.advance(busy.particles, 1e-3).listBuilds;
        }
        CHECK(buildsBusy > 5*buildsCalm);
        CHECK(norm(calm.particles.position[500] - busy.particles.position[500]) < 1e-7);

        // to rest, then pushed sideways below the friction limit: only history holds it
        PairProperties pair;
        pair.friction = 0.5;
        pair.restitution = 0.3;
        Particles p;
        addSphere(p, {0, 0, 1e-3}, 1e-3, 2500);
        p.spin.set(0, {0, 0, 0});
        p.acceleration.assign(1, {1.0, 0, -9.81});
        Engine first(soft(), oneMaterial(pair), Walls(floorAt(0, 1)));
        first.advance(p, 5e-3);
        const std::vector<ContactRecord> records = first.exportContacts();
        REQUIRE(records.size() == 1);
        CHECK(records[0].wall);
        Engine second(soft(), oneMaterial(pair), Walls(floorAt(0, 1)));
        second.importContacts(records);
        Particles q = p;
        first.advance(p, 5e-3);
        second.advance(q, 5e-3);
        CHECK(p.velocity.x[0] == q.velocity.x[0]);
        CHECK(p.spin.y[0] == q.spin.y[0]);
    }

    TEST_CASE("a restart from exported contacts goes on with the same bits")
    {
        Heap heap(800);
        Engine first = heap.engine();
        first.advance(heap.particles, 0.03);
        const auto records = first.exportContacts();
        CHECK(records.size() > 100);
        first.importContacts(records);      // what a run does when it writes a restart
        Engine second = heap.engine();
        second.importContacts(records);
        Particles copy = heap.particles;
        first.advance(heap.particles, 0.01);
        second.advance(copy, 0.01);
        CHECK(same(copy.position, heap.particles.position));
        CHECK(same(copy.velocity, heap.particles.velocity));
    }

    TEST_CASE("a block that falls as one meets the block below")
    {
        // nothing moves within its block, and at first the blocks are out of each other's reach
        Settings settings = soft();
        settings.step = 1e-5;
        const double d = 1e-3, pitch = 1.1*d, gap = 8e-3, speed = 1;
        Particles p;
        for (int k = 0; k < 2*16*16*8; ++k)
        {
            const int above = k/2048, layer = k % 2048/256;
            addSphere(p, {pitch*(k % 16), pitch*(k/16 % 16), pitch*(layer + 8*above) + gap*above},
                      d/2, 2500);
            p.velocity.set(k, {0, 0, -speed*above});
        }
        Engine engine(settings, oneMaterial({}));
        engine.advance(p, 1.5*gap/speed);
        double fastestBelow = 0;
        for (std::size_t i = 0; i < p.size()/2; ++i)
            fastestBelow = std::max(fastestBelow, -p.velocity.z[i]);
        CHECK(fastestBelow > 0.5*speed);
    }

    TEST_CASE("sub-steps allocate nothing while the lists hold")
    {
        Heap heap(2000);
        heap.settings.step = 1e-7;
        Engine engine = heap.engine();
        engine.advance(heap.particles, 200e-7);      // some way into what the lists hold for
        std::size_t before = allocations;
        engine.advance(heap.particles, 10e-7);
        const std::size_t few = allocations - before;
        before = allocations;
        engine.advance(heap.particles, 40e-7);
        CHECK(allocations - before <= few);
    }

    TEST_CASE("all instruction sets agree")
    {
        const char* old = std::getenv("ELUTRIA_SIMD");
        CHECK((old == nullptr || std::strlen(old) > 0));
        Heap heap(1500);
        heap.settings.search = NeighbourSearch::cells;      // other lists, too
        Heap other(1500);
        Engine a = heap.engine(), b = other.engine();
        a.advance(heap.particles, 1e-3);
        b.advance(other.particles, 1e-3);
        for (std::size_t i = 0; i < 1500; i += 100)
        {
            CHECK(norm(heap.particles.position[i] - other.particles.position[i]) < 1e-9);
        }
    }

    TEST_CASE("bad input is refused in one line with the value and what is allowed")
    {
        const auto build = [](const std::function<void(Settings&, PairProperties&)>& spoil)
        {
            return message([&]
            {
                Settings settings = soft();
                PairProperties pair;
                spoil(settings, pair);
                Engine engine(settings, oneMaterial(pair));
            });
        };
        CHECK(build([](Settings&, PairProperties&) {}).empty());
        CHECK(build([](Settings&, PairProperties& p) { p.restitution = 0; })
                  .find("restitution") == 0);
        CHECK(build([](Settings&, PairProperties& p) { p.restitution = 1.2; })
                  .find("allowed: above 0, up to 1") != std::string::npos);
        CHECK(build([](Settings&, PairProperties& p) { p.friction = -1; }).find("friction") == 0);
        CHECK(build([](Settings& s, PairProperties&) { s.stepFraction = NAN; })
                  .find("stepFraction") == 0);
        CHECK(build([](Settings& s, PairProperties&) { s.cellLayers = 0; }).find("cellLayers") == 0);

        Engine engine(soft(), oneMaterial({}));
        const auto spoilt = [&](const std::function<void(Particles&)>& spoil)
        {
            Particles p;
            addSphere(p, {0, 0, 0}, 1e-3, 2500);
            addSphere(p, {1, 0, 0}, 1e-3, 2500);
            spoil(p);
            return message([&] { engine.advance(p, 1e-3); });
        };
        CHECK(spoilt([](Particles&) {}).empty());
        CHECK(spoilt([](Particles& p) { p.radius[1] = -1; }).find("radius of particle 2") == 0);
        CHECK(spoilt([](Particles& p) { p.mass[0] = NAN; }).find("mass of particle 1") == 0);
        CHECK(spoilt([](Particles& p) { p.material[0] = 7; }).find("material") == 0);
        CHECK(spoilt([](Particles& p) { p.velocity.x[0] = INFINITY; }) != "");
        CHECK(spoilt([](Particles& p) { p.mass.pop_back(); }).find("particle array mass") == 0);
        CHECK(spoilt([](Particles& p) { p.id[1] = p.id[0]; }).find("particle id 1") == 0);
        CHECK(message([&] { Particles p; engine.advance(p, -1); }).find("duration") == 0);
        Particles none;
        CHECK(engine.advance(none, 1e-3).subSteps == 0);

        Settings narrow = soft();
        narrow.box = {{0, 0, 0}, {0.003, 1, 1}, {true, false, false}};
        Engine small(narrow, oneMaterial({}));
        Particles p;
        addSphere(p, {0, 0, 0}, 1e-3, 2500);
        CHECK(message([&] { small.advance(p, 1e-3); }).find("periodic box") == 0);
    }

    TEST_CASE("the sub-step is of pairs that can meet: two walls do not")
    {
        ContactMaterials materials;
        for (int k = 0; k < 3; ++k) materials.add({});
        PairProperties soft;
        soft.normalStiffness = 1;
        for (std::uint32_t b = 0; b < 3; ++b) materials.setPair(0, b, soft);
        Settings settings;
        settings.law = &contactLaw<LinearSpringDashpot>;
        Particles p;
        addSphere(p, {}, 1e-3, 2500);
        const double expected = settings.stepFraction
            *scenes::pi*std::sqrt(0.5*p.mass[0]/soft.normalStiffness)
            /std::sqrt(1 - std::pow(laws::dampingRatio(soft.restitution), 2));
        CHECK(Engine(settings, materials).stepLimit(p) == near(expected, 1e-5));
    }

    TEST_CASE("deep overlaps are reported with the number, and expected before")
    {
        PairProperties pair;
        pair.restitution = 1, pair.friction = 0, pair.normalStiffness = 1e3;
        for (const ContactLaw* law : {&contactLaw<HertzMindlin>, &contactLaw<LinearSpringDashpot>})
        {
            for (const auto treatment : {ContactTreatment::soft, ContactTreatment::automatic})
            {
                Particles p;
                addSphere(p, {0, 0, 0}, 1e-3, 2500);
                addSphere(p, {2.1e-3, 0, 0}, 1e-3, 2500);
                p.velocity.set(1, {-5, 0, 0});
                Settings settings = soft(law);
                settings.treatment = treatment;
                Engine engine(settings, oneMaterial(pair, 1e6));
                const StepReport r = engine.advance(p, 3e-3);
                REQUIRE(r.warnings.size() == 1);
                CHECK(r.warnings[0].name == "overlap");
                CHECK(r.largestOverlap
                      == near(engine.expectedOverlap(1e-3, 2500, 5), 0.01));
            }
        }
    }

    TEST_CASE("spheres put into each other are moved apart and told; sizes too far apart refused")
    {
        Settings settings;
        Engine engine(settings, oneMaterial({}));
        Particles p;
        addSphere(p, {0, 0, 0}, 1e-3, 2500);
        addSphere(p, {1.5e-3, 0, 0}, 1e-3, 2500);
        const StepReport r = engine.advance(p, 1e-3);
        CHECK(r.separated == 1);
        REQUIRE(r.warnings.size() == 1);
        CHECK(r.warnings[0].howMuch == "1 of them in a step");
        addSphere(p, {1, 0, 0}, 1e-10, 2500);
        CHECK_THROWS_AS(engine.advance(p, 1e-3), std::invalid_argument);
    }
}
