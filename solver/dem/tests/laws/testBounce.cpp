#include "support/scenes.hpp"

#include <doctest/doctest.h>

#include <vector>

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

double pairRestitution(const ContactLaw* law, double asked, double speed)
{
    PairProperties properties;
    properties.restitution = asked;
    properties.normalStiffness = 1e4;
    Particles p;
    const double a = 1e-3, b = 0.6e-3;
    addSphere(p, {0, 0, 0}, a, 2500);
    addSphere(p, {1.2345*a + b, 0, 0}, b, 2500);
    p.velocity.set(1, {-speed, 0, 0});
    Engine engine(soft(law), oneMaterial(properties, 1e8));
    for (int i = 0; i < 40; ++i)
    {
        engine.advance(p, 1e-3*a/speed*50);
    }
    return (p.velocity.x[1] - p.velocity.x[0])/speed;
}

double wallRestitution(const ContactLaw* law, double asked, double speed)
{
    PairProperties properties;
    properties.restitution = asked;
    properties.normalStiffness = 1e4;
    Particles p;
    const double r = 1e-3;
    addSphere(p, {0.1*r, 0.2*r, 1.317*r}, r, 2500);
    p.velocity.set(0, {0, 0, -speed});
    Engine engine(soft(law), oneMaterial(properties, 1e8), Walls(floorAt(0, 1)));
    for (int i = 0; i < 40; ++i) engine.advance(p, 0.05*r/speed);
    return p.velocity.z[0]/speed;
}

/// Speed and time after the bounce of MFiX DEM01 (Garg et al. 2012): a sphere of d 0.2 m, density
/// 2600 kg/m^3 falls from a height of 0.5 m; heights sampled every `every` seconds.
struct Fall
{
    double stiffness, restitution, gravity = 9.81;
    double radius = 0.1, start = 0.5, density = 2600;

    double mass() const { return 4.0/3*pi*radius*radius*radius*density; }
    /// Height in free fall, damped oscillation with gravity, and free flight again.
    double height(double t) const
    {
        const double tc = std::sqrt(2*(start - radius)/gravity);
        if (t < tc) return start - 0.5*gravity*t*t;
        const double w = std::sqrt(stiffness/mass()), l = std::log(restitution);
        const double zeta = -l/std::sqrt(pi*pi + l*l), wd = w*std::sqrt(1 - zeta*zeta);
        const double y0 = gravity/(w*w), v0 = -gravity*tc;
        const double c1 = y0, c2 = (v0 + zeta*w*y0)/wd;
        const auto overlapHeight = [&](double s)
        {
            return std::exp(-zeta*w*s)*(c1*std::cos(wd*s) + c2*std::sin(wd*s)) - y0;
        };
        double low = 0.5*pi/wd, high = 1.5*pi/wd;      // where the sphere leaves again
        for (int i = 0; i < 200; ++i)
        {
            const double mid = 0.5*(low + high);
            (overlapHeight(mid) < 0 ? low : high) = mid;
        }
        if (t - tc < low) return radius + overlapHeight(t - tc);
        const double h = 1e-7;
        const double speed = (overlapHeight(low + h) - overlapHeight(low - h))/(2*h);
        const double s = t - tc - low;
        return radius + speed*s - 0.5*gravity*s*s;
    }
    double largestError(double step) const
    {
        PairProperties properties;
        properties.restitution = restitution;
        properties.normalStiffness = stiffness;
        Settings settings = soft(&contactLaw<LinearSpringDashpot>);
        settings.step = step;
        Engine engine(settings, oneMaterial(properties), Walls(floorAt(0, 10)));
        Particles p;
        addSphere(p, {0, 0, start}, radius, density);
        p.acceleration.assign(1, {0, 0, -gravity});
        double worst = 0;
        const double every = 1e-2;
        for (int i = 1; i <= 60; ++i)      // the second fall ends later than this
        {
            engine.advance(p, every);
            worst = std::max(worst, std::abs(p.position.z[0] - height(i*every)));
        }
        return worst;
    }
};

} // namespace

TEST_SUITE("bounce")
{
    TEST_CASE("restitution comes out as asked at the default step")
    {
        for (const ContactLaw* law : {&contactLaw<LinearSpringDashpot>, &contactLaw<HertzMindlin>})
        {
            for (double asked : {0.05, 0.2, 0.5, 0.8, 0.9, 0.97, 1.0})
            {
                for (double speed : {0.1, 0.3, 1.0, 3.0})
                {
                    CAPTURE(law->name);
                    CAPTURE(asked);
                    CAPTURE(speed);
                    // shares of the approaching speed, and of its change
                    const double allowed = std::min(6e-4, 5e-4*(1 + asked));
                    CHECK(std::abs(pairRestitution(law, asked, speed) - asked) < allowed);
                    CHECK(std::abs(wallRestitution(law, asked, speed) - asked) < allowed);
                }
            }
        }
    }

    TEST_CASE("fall and bounce follows the closed form to second order")
    {
        // the peers' largest error, 1.4e-4 m, belongs to stiffness 1e4 N/m and restitution 0.9
        CHECK(Fall{1e4, 0.9}.largestError(1e-3) < 1.4e-4);
        for (double stiffness : {5e4, 1e5})
        {
            for (double e : {0.6, 0.9, 1.0})
            {
                const Fall fall{stiffness, e};
                // the moment of first touch falls anywhere in a step: compare means over steps
                double coarse = 0, fine = 0;
                for (double stretch : {1.0, 0.93, 0.87, 0.81})
                {
                    coarse += std::log(fall.largestError(stretch*1e-3))/4;
                    fine += std::log(fall.largestError(stretch*1.25e-4))/4;
                }
                const double order = (coarse - fine)/std::log(8.0);
                CAPTURE(stiffness);
                CAPTURE(e);
                CAPTURE(order);
                CAPTURE(std::exp(fine));
                CHECK(order > 1.8);
                CHECK(std::exp(fine) < 3e-5);
            }
        }
    }
}
