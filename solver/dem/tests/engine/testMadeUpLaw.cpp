#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

// A contact law is one struct: here is one that the engine has never seen, in an engine's scene.

using namespace scenes;

namespace
{

/// Elastic cones: the force grows with the square of the overlap, F = K overlap^2, K in N/m^2 given
/// as normalStiffness; no friction, no damping.
struct ElasticCone
{
    using Coefficients = laws::Coefficients;

    static constexpr const char* name = "elasticCone";
    static constexpr bool givenStiffness = true, givenDamping = true, dashpotJumps = true;

    static Coefficients coefficients(const ContactMaterial&, const ContactMaterial&,
                                     const PairProperties& p)
    {
        Coefficients c;
        c.stiffness = p.normalStiffness;
        return c;
    }
    template<class Real>
    static Real stiffness(const laws::CoefficientsOf<Real>& c, Real, Real overlap)
    {
        return c.stiffness*overlap;
    }
    template<class Real>
    static laws::Force<Real> force(const laws::CoefficientsOf<Real>& c,
                                   const laws::Kinematics<Real>& k)
    {
        const Real s = stiffness(c, k.radius, k.overlap);
        return laws::normalForce(c, k, s*k.overlap, laws::root(s*k.mass), laws::split(k).approach);
    }
    // From energy, K overlap^3/3 = m v^2/2; the time is 2.8044 overlap/v (Beta functions)
    static double timeScale(const Coefficients& c, double, double mass, double speed)
    {
        return std::cbrt(mass/(c.stiffness*speed));
    }
    static double largestOverlap(const Coefficients& c, double, double mass, double speed)
    {
        return std::cbrt(1.5*mass*speed*speed/c.stiffness);
    }
    static constexpr double wayOverOverlap = 2.8044;
    static double contactTime(const Coefficients& c, double radius, double mass, double speed)
    {
        return wayOverOverlap*largestOverlap(c, radius, mass, speed)/speed;
    }
    static double storedEnergy(const Coefficients& c, double, double overlap)
    {
        return c.stiffness*overlap*overlap*overlap/3;
    }
    static bool impactSuffices(const Coefficients&) { return true; }
};

/// A law of the list under a name that is not there: without vector kernels.
struct Unlisted : HertzMindlin
{
    static constexpr const char* name = "unlisted";
};

struct Collision
{
    Particles particles;
    StepReport report;
};

Collision headOn(ContactTreatment treatment, double duration)
{
    PairProperties cone;
    cone.normalStiffness = 1e9;
    Settings settings;
    settings.law = &contactLaw<ElasticCone>;
    settings.treatment = treatment;
    Collision c;
    addSphere(c.particles, {0, 0, 0}, 1e-3, 2500);
    addSphere(c.particles, {2.01e-3, 0, 0}, 1e-3, 2500);
    c.particles.velocity.set(0, {0.5, 0, 0});
    c.particles.velocity.set(1, {-0.5, 0, 0});
    Engine engine(settings, oneMaterial(cone));
    c.report = engine.advance(c.particles, duration);
    return c;
}

} // namespace

TEST_SUITE_BEGIN("made-up law");

TEST_CASE("soft spheres under a law from this file rebound with their energy and its overlap")
{
    const Collision c = headOn(ContactTreatment::soft, 1e-3);
    CHECK(c.particles.velocity.x[0] == near(-0.5, 1e-4));
    CHECK(c.particles.velocity.x[1] == near(0.5, 1e-4));
    const double deepest = std::cbrt(1.5*0.5*c.particles.mass[0]/1e9);     // at 1 m/s
    CHECK(c.report.largestOverlap == near(deepest/1e-3, 2e-3));
}

TEST_CASE("the engine makes an impact of it, as deep and as long as the law says")
{
    const Collision c = headOn(ContactTreatment::automatic, 1e-3);
    CHECK(c.report.impacts == 1);
    CHECK(c.report.subSteps == 0);
    CHECK(c.particles.velocity.x[0] == near(-0.5, 1e-4));
    const double deepest = std::cbrt(1.5*0.5*c.particles.mass[0]/1e9);
    CHECK(c.report.largestOverlap == near(deepest/1e-3, 2e-3));
}

TEST_CASE("particles and walls under different laws")
{
    // Soft springs at the walls, elastic cones between the particles
    PairProperties p;
    p.normalStiffness = 1e3, p.restitution = 1, p.friction = 0;
    Settings settings;
    settings.treatment = ContactTreatment::soft;
    settings.law = &contactLaw<ElasticCone>;
    settings.wallLaw = &contactLaw<LinearSpringDashpot>;
    Particles all;
    addSphere(all, {0, 0, 1.005e-3}, 1e-3, 2500);
    all.velocity.set(0, {0, 0, -0.3});
    Engine engine(settings, oneMaterial(p), Walls(floorAt(0, 1)));
    const StepReport report = engine.advance(all, 2e-3);
    CHECK(all.velocity.z[0] == near(0.3, 1e-3));
    CHECK(report.largestOverlap == near(0.3*std::sqrt(all.mass[0]/1e3)/1e-3, 2e-3));

    PairProperties cone = p;
    cone.normalStiffness = 1e9;
    settings.treatment = ContactTreatment::automatic;
    addSphere(all, {0, 0, 3.3e-3}, 1e-3, 2500);
    all.position.set(0, {0, 0, 1.2e-3});
    all.velocity.set(0, {0, 0, 0});
    all.velocity.set(1, {0, 0, -1});
    Engine both(settings, oneMaterial(cone), Walls(floorAt(0, 1)));
    CHECK(both.advance(all, 4e-4).impacts == 2);           // the pair, then the floor
}

TEST_CASE("one contact at a time or in vector registers: the same forces")
{
    PairProperties properties;
    properties.rollingFriction = 0.01;
    const ContactMaterials materials = oneMaterial(properties);
    Settings listed, single;
    listed.treatment = single.treatment = ContactTreatment::soft;
    single.law = &contactLaw<Unlisted>;
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> place(0, 0.016), component(-1, 1);
    Particles p;
    for (int i = 0; i < 5000; ++i)                         // more than one chunk of particles
    {
        const std::size_t k =
            addSphere(p, {place(random), place(random), place(random)}, 5e-4, 2500);
        p.velocity.set(k, {component(random), component(random), component(random)});
    }
    Engine a(listed, materials), b(single, materials);
    VectorArray forceA, forceB, torqueA, torqueB;
    for (int step = 0; step < 2; ++step)                   // contacts that begin; that last
    {
        a.contactForces(p, 1e-6, forceA, torqueA);
        b.contactForces(p, 1e-6, forceB, torqueB);
        double largest = 0, twist = 0;
        for (std::size_t i = 0; i < p.size(); ++i)
            largest = std::max(largest, norm(forceA[i])), twist = std::max(twist, norm(torqueA[i]));
        REQUIRE(largest > 0);
        for (std::size_t i = 0; i < p.size(); ++i)
        {
            CHECK(norm(forceA[i] - forceB[i]) < 1e-5*largest);
            CHECK(norm(torqueA[i] - torqueB[i]) < 1e-5*twist);
        }
    }
}

TEST_CASE("the words of the laws")
{
    CHECK(ContactLaws::find("hertzMindlin") == 0);
    CHECK(ContactLaws::find("elasticCone") == ContactLaws::size);
    for (const ContactLaw* law : ContactLaws::laws)
        CHECK(law == ContactLaws::laws[ContactLaws::find(law->name)]);
}

TEST_SUITE_END();
