#include "support/near.hpp"
#include "support/scenes.hpp"

#include <doctest/doctest.h>

using namespace scenes;

namespace
{

Settings soft(const ContactLaw* law)
{
    Settings settings;
    settings.law = law;
    settings.treatment = ContactTreatment::soft;
    return settings;
}

struct Rebound
{
    double tangential;      // over the impact's tangential speed
    double spin;            // rad/s
    double angle;           // tangent of the contact point's rebound angle
};

/// A sphere thrown onto a floor under `angle` from the normal.
Rebound oblique(const ContactLaw* law, double angle, double friction, double restitution)
{
    PairProperties properties;
    properties.restitution = restitution;
    properties.friction = friction;
    properties.normalStiffness = 1e12;      // the closed form is that of hard spheres
    const double radius = 2.5e-3, speed = 3.9;
    Particles p;
    addSphere(p, {0, 0, 1.0002*radius}, radius, 4000);
    p.velocity.set(0, {speed*std::sin(angle), 0, -speed*std::cos(angle)});
    Engine engine(soft(law), oneMaterial(properties, 3e15), Walls(floorAt(0, 1)));
    for (int k = 0; k < 20; ++k) engine.advance(p, 1e-6);
    const Vector3 v = p.velocity[0], w = p.spin[0];
    return {v.x/(speed*std::sin(angle)), w.y, (v.x - radius*w.y)/v.z};
}

/// Largest overlap and force of two spheres (or a sphere and a wall) in an elastic Hertz impact.
struct Peak
{
    double overlap = 0, force = 0, duration = 0;
};

Peak impact(double radius, double density, double young, double poisson, double speed, bool wall)
{
    PairProperties properties;
    properties.restitution = 1;
    properties.friction = 0;
    ContactMaterials materials = oneMaterial(properties, young, poisson);
    const std::uint32_t rigid = materials.add({"rigid", 1e6*young, poisson});
    materials.setPair(0, rigid, properties);
    Settings settings = soft(&contactLaw<HertzMindlin>);
    const double e = wall ? laws::effectiveYoung(young, poisson, 1e6*young, poisson)
                          : laws::effectiveYoung(young, poisson, young, poisson);
    Particles p;
    addSphere(p, {0, 0, radius*(1 + 1e-9)}, radius, density);
    p.velocity.set(0, {0, 0, -speed});
    if (!wall)
    {
        addSphere(p, {0, 0, -radius*(1 + 1e-9)}, radius, density);
        p.velocity.set(1, {0, 0, speed});
    }
    const double mass = wall ? p.mass[0] : p.mass[0]/2, r = wall ? radius : radius/2;
    laws::Coefficients c;
    c.stiffness = e;
    const double time = HertzMindlin::contactTime(c, r, mass, wall ? speed : 2*speed);
    Engine engine(settings, materials, wall ? Walls(floorAt(0, 10, rigid)) : Walls());
    Peak peak;
    const int steps = 400;
    for (int k = 1; k <= 2*steps; ++k)
    {
        const double before = p.velocity.z[0];
        engine.advance(p, time/steps);
        const double gap = wall ? p.position.z[0] - radius
                                : p.position.z[0] - p.position.z[1] - 2*radius;
        peak.overlap = std::max(peak.overlap, -gap);
        peak.force = std::max(peak.force, p.mass[0]*(p.velocity.z[0] - before)*steps/time);
        if (gap < 0) peak.duration = k*time/steps;
    }
    return peak;
}

} // namespace

TEST_SUITE("contact")
{
    TEST_CASE("gross sliding follows Coulomb's law exactly")
    {
        for (const ContactLaw* law : {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>})
        {
            for (double degrees : {40.0, 55.0, 70.0})
            {
                const double friction = 0.092, e = 0.98, angle = degrees*pi/180;
                const Rebound r = oblique(law, angle, friction, e);
                const double speed = 3.9*std::cos(angle), radius = 2.5e-3;
                CAPTURE(degrees);
                CHECK(r.tangential == near(1 - friction*(1 + e)/std::tan(angle), 3e-4));
                CHECK(r.spin == near(2.5*friction*(1 + e)*speed/radius, 3e-4));
            }
        }
    }

    TEST_CASE("a sliding sphere starts to roll after the closed-form time")
    {
        for (double friction : {0.2, 0.5, 1.0})
        {
            PairProperties properties;
            properties.friction = friction;
            properties.normalStiffness = 1e4;
            properties.restitution = 0.5;
            Particles p;
            const double radius = 5e-4, g = 9.81, u0 = 0.1;
            addSphere(p, {0, 0, radius}, radius, 1e4);
            p.position.z[0] -= p.mass[0]*g/1e4;      // rests on its spring
            p.velocity.set(0, {u0, 0, 0});
            p.acceleration.assign(1, {0, 0, -g});
            Engine engine(soft(&contactLaw<LinearSpringDashpot>), oneMaterial(properties), Walls(floorAt(0, 1)));
            const double expected = 2*u0/(7*friction*g), step = expected/200;
            double rolls = 0;
            for (int k = 1; k <= 300 && rolls == 0; ++k)
            {
                engine.advance(p, step);
                if (p.velocity.x[0] <= p.spin.y[0]*radius*(1 + 1e-4)) rolls = k*step;
            }
            CAPTURE(friction);
            CHECK(rolls == near(expected, 0.01));
            for (int k = 0; k < 50; ++k) engine.advance(p, step);
            CHECK(p.velocity.x[0]/u0 == near(5.0/7, 4e-4));
            CHECK(p.spin.y[0]*radius/u0 == near(5.0/7, 4e-4));
        }
    }

    TEST_CASE("Hertz peaks of glass, limestone, aluminium and magnesium alloy")
    {
        const Peak glass = impact(0.01, 2800, 48e9, 0.20, 10, false);
        CHECK(glass.overlap == near(274.11e-6, 1e-3));
        CHECK(glass.force == near(10697, 1e-3));
        CHECK(glass.duration == near(40.34e-6, 4e-3));
        const Peak limestone = impact(0.01, 2500, 20e9, 0.25, 10, false);
        CHECK(limestone.overlap == near(368.30e-6, 1e-3));
        CHECK(limestone.force == near(7108, 1e-3));
        const Peak aluminium = impact(0.1, 2699, 70e9, 0.30, 0.2, true);
        CHECK(aluminium.overlap == near(49.717e-6, 1e-3));
        CHECK(aluminium.force == near(11370, 1e-3));
        const Peak magnesium = impact(0.1, 1800, 40e9, 0.35, 0.2, true);
        CHECK(magnesium.overlap == near(52.123e-6, 1e-3));
        CHECK(magnesium.force == near(7233, 1e-3));
    }

    TEST_CASE("momentum, angular momentum and energy of an oblique collision")
    {
        for (const ContactLaw* law :
             {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>, &contactLaw<SpringSliderDashpot>})
        {
            PairProperties properties;
            properties.restitution = 0.8;
            properties.friction = 0.4;
            Particles p;
            addSphere(p, {0, 0, 0}, 1e-3, 2500);
            addSphere(p, {1.5e-3, 0.4e-3, 0.2e-3}, 0.5e-3, 1200);
            p.velocity.set(0, {1, 0.2, 0});
            p.velocity.set(1, {-1, 0.5, 0.3});
            p.spin.set(0, {100, 300, -200});
            const Vector3 m0 = momentum(p), l0 = angularMomentum(p);
            const double e0 = kineticEnergy(p);
            Engine engine(soft(law), oneMaterial(properties, 1e8));
            for (int k = 0; k < 40; ++k)
            {
                engine.advance(p, 2e-5);
                CHECK(norm(momentum(p) - m0) < 1e-14*norm(m0));
                CHECK(norm(angularMomentum(p) - l0) < 1e-6*norm(l0));
                CHECK(kineticEnergy(p) <= e0*(1 + 1e-9));
            }
            CHECK(kineticEnergy(p) < 0.99*e0);
            CHECK(norm(p.velocity[0] - Vector3{1, 0.2, 0}) > 0.01);
        }
    }

    TEST_CASE("a slope holds a sphere below the friction angle of rolling, and lets it go above")
    {
        for (double slope : {0.05, 0.2})
        {
            PairProperties properties;
            properties.friction = 0.8;
            properties.rollingFriction = 0.1;
            properties.restitution = 0.3;
            Particles p;
            const double radius = 1e-3;
            addSphere(p, {0, 0, radius}, radius, 2500);
            p.acceleration.assign(1, {9.81*std::sin(slope), 0, -9.81*std::cos(slope)});
            Engine engine(soft(&contactLaw<HertzMindlin>), oneMaterial(properties), Walls(floorAt(0, 1)));
            for (int k = 0; k < 50; ++k) engine.advance(p, 2e-3);
            CAPTURE(slope);
            if (slope < 0.1) CHECK(std::abs(p.velocity.x[0]) < 2e-3);
            else
            {
                // rolls with g (sin - rolling friction cos)/(1 + 2/5)
                const double a = 9.81*(std::sin(slope) - 0.1*std::cos(slope))/1.4;
                CHECK(p.velocity.x[0] == near(0.1*a, 0.02));
            }
        }
    }

    TEST_CASE("cohesion holds a slow pair together and lets a fast one go")
    {
        for (double speed : {0.002, 0.5})
        {
            PairProperties properties;
            properties.restitution = 0.5;
            properties.cohesion = 3e4;
            Particles p;
            const double radius = 5e-5;
            addSphere(p, {0, 0, 0}, radius, 2500);
            addSphere(p, {2.01*radius, 0, 0}, radius, 2500);
            p.velocity.set(0, {speed, 0, 0});
            Engine engine(soft(&contactLaw<HertzMindlin>), oneMaterial(properties));
            for (int k = 0; k < 100; ++k) engine.advance(p, 0.1*radius/speed);
            const double apart = p.position.x[1] - p.position.x[0];
            CAPTURE(speed);
            if (speed < 0.1) CHECK(apart < 2*radius);
            else CHECK(apart > 2.1*radius);
        }
    }

    TEST_CASE("linear drag is exact for any relaxation time, and its impulse is accounted for")
    {
        for (double rate : {0.0, 1.0, 1e3, 1e7, 1e12})
        {
            Settings settings = soft(&contactLaw<HertzMindlin>);
            settings.step = 1e-4;
            Engine engine(settings, oneMaterial({}));
            Particles p;
            addSphere(p, {0, 0, 0}, 1e-4, 2500);
            p.velocity.set(0, {1, 0, 0});
            p.dragRate = {rate};
            p.gasVelocity.assign(1, {0, 3, 0});
            p.acceleration.assign(1, {0, 0, -9.81});
            const double time = 0.01;
            engine.advance(p, time);
            const double decay = std::exp(-rate*time);
            const double fall = rate > 0 ? -9.81*-std::expm1(-rate*time)/rate : -9.81*time;
            CAPTURE(rate);
            CHECK(std::abs(p.velocity.x[0] - decay) < 1e-10);      // m/s, of 1
            CHECK(std::abs(p.velocity.y[0] - 3*-std::expm1(-rate*time)) < 1e-10);
            CHECK(p.velocity.z[0] == near(fall, 1e-9));
            const Vector3 gained = p.mass[0]*(p.velocity[0] - Vector3{1, 0, 0})
                                   - p.mass[0]*time*Vector3{0, 0, -9.81};
            if (rate < 1e9) CHECK(norm(gained - p.dragImpulse[0]) < 1e-9*p.mass[0]*3);
        }
    }
}
