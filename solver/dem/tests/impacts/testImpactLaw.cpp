#include "impacts/ImpactLaw.hpp"
#include "laws/LawList.hpp"
#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

using namespace elutria::dem;

namespace
{

struct Uniform
{
    std::mt19937_64 generator;
    explicit Uniform(std::uint64_t seed = 11) : generator(seed) {}
    double operator()(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(generator);
    }
    Vector3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size),
                                          (*this)(-size, size)}; }
};

ContactMaterials grains(double restitution, double friction)
{
    PairProperties p;
    p.restitution = restitution;
    p.friction = friction;
    p.normalStiffness = 1e12;      // so stiff that nothing turns while they touch
    return scenes::oneMaterial(p, 1e16);
}

ImpactLaw impactLaw(const ContactLaw& law, const ContactMaterials& materials)
{
    return ImpactLaw(LawTable(law, materials), materials, 0, 0);
}

/// Two spheres that touch, as bodies and as particles for the soft engine.
struct Encounter2
{
    Particles particles;
    ImpactBody a, b;
    Vector3 normal;

    Encounter2(Uniform& random, double sliding)
    {
        normal = random.vector(1);
        normal *= 1/norm(normal);
        Vector3 along = cross(normal, random.vector(1));
        along *= 1/norm(along);
        scenes::addSphere(particles, {0, 0, 0}, 1e-3, 2500);
        scenes::addSphere(particles, {0, 0, 0}, random(0.5e-3, 2e-3), 1000);
        particles.position.set(0, (particles.radius[0] + particles.radius[1])*normal);
        particles.velocity.set(0, random(-2, 2)*Vector3{1, 1, 0});
        particles.velocity.set(1, particles.velocity[0] + normal + sliding*along);
        particles.spin.set(0, random(-1, 1)*normal);
        body(a, 0), body(b, 1);
    }
    void body(ImpactBody& to, std::size_t i) const
    {
        to = {particles.radius[i], 1/particles.mass[i], particles.velocity[i], particles.spin[i]};
    }
};

} // namespace


TEST_CASE("impact: momentum and angular momentum exact, energy never grows, restitution as asked")
{
    Uniform random;
    for (const ContactLaw* law : {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>})
        for (int trial = 0; trial < 300; ++trial)
        {
            const double e = random(0.05, 1), friction = random(0, 1);
            static const double fixed[4][2] = {{1, 0}, {1, 1}, {0.05, 2}, {0.5, 0.01}};
            const auto materials = trial < 4 ? grains(fixed[trial][0], fixed[trial][1])
                : trial % 30 == 0 ? grains(e, friction) : grains(0.8, 0.3);
            const double asked = materials.pair(0, 0).restitution;
            static ImpactLaw impact;
            if (trial < 5 || trial % 30 < 2) impact = impactLaw(*law, materials);
            REQUIRE(impact.applies());

            Encounter2 pair(random, random(0, 4));
            pair.particles.spin.set(0, random.vector(2000));
            pair.particles.spin.set(1, random.vector(2000));
            pair.body(pair.a, 0), pair.body(pair.b, 1);
            Particles& p = pair.particles;
            const Vector3 momentum = scenes::momentum(p), spin = scenes::angularMomentum(p);
            const double energy = scenes::kineticEnergy(p);
            const double closing = dot(p.velocity[1] - p.velocity[0], pair.normal);
            REQUIRE(collide(pair.a, pair.b, pair.normal, impact));
            p.velocity.set(0, pair.a.velocity), p.velocity.set(1, pair.b.velocity);
            p.spin.set(0, pair.a.spin), p.spin.set(1, pair.b.spin);

            CHECK(norm(scenes::momentum(p) - momentum) < 1e-15*norm(momentum) + 1e-20);
            CHECK(norm(scenes::angularMomentum(p) - spin) < 1e-13*norm(spin));
            CHECK(scenes::kineticEnergy(p) <= energy*(1 + 1e-14));
            CHECK(dot(p.velocity[0] - p.velocity[1], pair.normal)
                  == near(asked*closing, 1e-12));
            CHECK_FALSE(collide(pair.a, pair.b, pair.normal, impact));   // they part now
        }
}

TEST_CASE("impact: gross sliding as in the closed form")
{
    const double e = 0.8, friction = 0.2;
    const auto materials = grains(e, friction);
    for (const ContactLaw* law : {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>})
    {
        const ImpactLaw impact = impactLaw(*law, materials);
        ImpactBody ball{0.01, 1/0.02, {3, 0, -1}, {}}, wall;
        collide(ball, wall, {0, 0, 1}, impact);
        CHECK(ball.velocity.x == near(3 - friction*(1 + e), 1e-12));
        CHECK(ball.velocity.z == near(e, 1e-12));
        CHECK(ball.spin.y == near(2.5*friction*(1 + e)/0.01, 1e-12));
    }
}

TEST_CASE("impact: sticking with k_t = 2/7 k_n turns the sliding round with the same restitution")
{
    const ImpactLaw impact = impactLaw(contactLaw<LinearSpringDashpot>, grains(0.9, 1));
    const double sliding = 0.05;
    const double after = sliding - 3.5*impact.tangentialImpulse(sliding);
    CHECK(std::abs(after + 0.9*sliding) < 2e-3*sliding);
}

TEST_CASE("impact: the same outcome as the soft contact, from sticking to gross sliding")
{
    Uniform random;
    for (const ContactLaw* law :
         {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>, &contactLaw<SpringSliderDashpot>})
        for (const double e : {0.3, 0.7, 0.95})
        {
            const auto materials =
                grains(e, law == &contactLaw<SpringSliderDashpot> ? 0 : 0.3);
            const ImpactLaw impact = impactLaw(*law, materials);
            REQUIRE(impact.applies());
            Settings settings;
            settings.law = law;
            settings.treatment = ContactTreatment::soft;
            settings.stepFraction = 0.002;
            for (const double sliding : {0.0, 0.05, 0.3, 0.8, 1.2, 1.6, 1.9, 2.5, 5.0})
            {
                CAPTURE(law->name);
                CAPTURE(e);
                CAPTURE(sliding);
                Encounter2 pair(random, sliding);
                Particles soft = pair.particles;
                const Vector3 before0 = soft.velocity[0];
                Engine engine(settings, materials);
                engine.advance(soft, 3*impact.duration(1e-5, 1e-3, 1));
                REQUIRE(engine.exportContacts().empty());
                REQUIRE(collide(pair.a, pair.b, pair.normal, impact));
                CHECK(norm(pair.a.velocity - soft.velocity[0])
                      < 2e-3*norm(soft.velocity[0] - before0));
                CHECK(norm(pair.a.spin - soft.spin[0])
                      < 0.01*norm(soft.spin[0]) + 3e-3*sliding/soft.radius[0]);
            }
        }
}

TEST_CASE("impact: rolling resistance as the soft contact has it")
{
    Uniform random(0);
    for (const double rolling : {0.002, 0.005, 0.01})
    {
        auto materials = grains(0.9, 0.3);
        PairProperties p = materials.pair(0, 0);
        p.rollingFriction = rolling;
        materials.setPair(0, 0, p);
        const ImpactLaw impact = impactLaw(contactLaw<HertzMindlin>, materials);
        Settings settings;
        settings.treatment = ContactTreatment::soft;
        settings.stepFraction = 0.002;
        Encounter2 pair(random, 0.3);
        pair.particles.spin.set(0, 300.0*pair.normal);
        pair.body(pair.a, 0);
        Particles soft = pair.particles;
        const Vector3 turning = scenes::angularMomentum(soft);
        Engine engine(settings, materials);
        engine.advance(soft, 3*impact.duration(1e-5, 1e-3, 1));
        const double energy = scenes::kineticEnergy(pair.particles);
        REQUIRE(collide(pair.a, pair.b, pair.normal, impact));
        Particles& hard = pair.particles;
        hard.velocity.set(0, pair.a.velocity), hard.velocity.set(1, pair.b.velocity);
        hard.spin.set(0, pair.a.spin), hard.spin.set(1, pair.b.spin);
        CHECK(scenes::kineticEnergy(hard) < energy);
        CHECK(norm(scenes::angularMomentum(hard) - turning) < 1e-12*norm(turning));
        CAPTURE(rolling);
        for (const std::size_t i : {0, 1})
            CHECK(norm(hard.spin[i] - soft.spin[i]) < 15);        // of 300 rad/s
    }
}

TEST_CASE("impact: rolling friction r costs r of the speed and 4.5 r of the surface's against the soft contact")
{
    double worstVelocity = 0, worstSpin = 0;
    for (const double rolling : {0.001, 0.01})
        for (const double other : {0.5e-3, 3e-3})           // radius of the second sphere, m
            for (const double spin : {0.0, -300.0, 300.0, -1000.0})
                for (const double sliding : {0.1, 0.3, 0.8, 2.0})
                {
                    auto materials = grains(0.9, 0.3);
                    PairProperties p = materials.pair(0, 0);
                    p.rollingFriction = rolling;
                    materials.setPair(0, 0, p);
                    const ImpactLaw impact = impactLaw(contactLaw<HertzMindlin>, materials);
                    Particles soft;
                    scenes::addSphere(soft, {0, 0, 0}, 1e-3, 2500);
                    scenes::addSphere(soft, {1e-3 + other, 0, 0}, other, 1000);
                    soft.velocity.set(0, {1, 0, 0});
                    soft.velocity.set(1, {0, sliding, 0});
                    soft.spin.set(0, {0, 0, spin});
                    ImpactBody a{1e-3, 1/soft.mass[0], soft.velocity[0], soft.spin[0]},
                        b{other, 1/soft.mass[1], soft.velocity[1], soft.spin[1]};
                    const double mass = 1/(a.inverseMass + b.inverseMass);
                    Settings settings;
                    settings.treatment = ContactTreatment::soft;
                    settings.stepFraction = 0.005;
                    Engine(settings, materials)
                        .advance(soft, 3*impact.duration(mass, 1e-3*other/(1e-3 + other), 1));
                    REQUIRE(collide(a, b, {-1, 0, 0}, impact));
                    const double scale = rolling*std::hypot(1.0, sliding);
                    for (const auto& [body, i] : {std::pair(a, 0), std::pair(b, 1)})
                    {
                        worstVelocity = std::max(worstVelocity,
                                                 norm(body.velocity - soft.velocity[i])/scale);
                        worstSpin = std::max(worstSpin,
                                             body.radius*norm(body.spin - soft.spin[i])/scale);
                    }
                }
    CHECK(worstVelocity < 1.1);
    CHECK(worstSpin < 4.6);
    CHECK(worstSpin > 1);       // the manual names it
}

TEST_CASE("impact: contact duration as that of the soft law")
{
    for (const ContactLaw* law : {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>})
    {
        const auto materials = grains(0.9, 0.3);
        const ImpactLaw impact = impactLaw(*law, materials);
        const laws::Coefficients c = LawTable(*law, materials)(0, 0);
        const double expected = law->contactTime(c, 1e-3, 1e-5, 2);
        CHECK(impact.duration(1e-5, 1e-3, 2) == near(expected, 0.03));
    }
}

TEST_CASE("impact: what one impulse cannot stand for is left to the soft law")
{
    auto materials = grains(0.9, 0.3);
    PairProperties sticky = materials.pair(0, 0);
    sticky.cohesion = 1e4;
    materials.setPair(0, 0, sticky);
    CHECK_FALSE(impactLaw(contactLaw<HertzMindlin>, materials).applies());
    sticky.cohesion = 0;
    materials.setPair(0, 0, sticky);
    CHECK_FALSE(impactLaw(contactLaw<SpringSliderDashpot>, materials).applies());
    sticky.friction = 0, sticky.exponent = 1;
    materials.setPair(0, 0, sticky);
    CHECK_FALSE(impactLaw(contactLaw<SpringSliderDashpot>, materials).applies());
    CHECK(impactLaw(contactLaw<HertzMindlin>, materials).applies());
}
