// Single grains in air at rest and rising.
#include "Settling.hpp"

#include "near.hpp"

using namespace elutria::laws;

namespace
{

constexpr Gas air{1.2, 1.8e-5};
constexpr double g = 9.81;
const Drag spheres = SchillerNaumann::CdRe;

} // namespace

TEST_SUITE("settling")
{

TEST_CASE("the sphere of MFiX' verification settles at 0.4574017 m/s")
{
    CHECK(terminalVelocity(spheres, {2000, {}}, 100e-6, air, 9.80665)
          == near(0.4574017, 1e-6));
}

TEST_CASE("a small sphere settles as Stokes says")
{
    const double d = 1e-6, stokes = (2650 - 1.2)*g*d*d/(18*1.8e-5);
    CHECK(terminalVelocity(spheres, {2650, {}}, d, air, g) == near(stokes, 1e-3));
}

TEST_CASE("the size that settles at a speed settles at that speed")
{
    for (const DragLaw& law : dragLaws())
        for (const double speed : {0.3, 2.0, 8.0})
        {
            const Grain grain{2650, {0.8, 0.7, 0.7}};
            const double size = settlingSize(law.CdRe, grain, speed, air, g, 1e-6, 0.05);
            CAPTURE(law.name);
            CHECK(terminalVelocity(law.CdRe, grain, size, air, g)
                  == near(speed, 1e-9));
        }
}

TEST_CASE("no size settles where all rise or all fall, and none that is lighter than the gas")
{
    CHECK(settlingSize(spheres, {2650, {}}, 100, air, g, 1e-4, 1e-3) == 0);
    CHECK(settlingSize(spheres, {2650, {}}, 0.01, air, g, 1e-4, 1e-3) == 0);
    CHECK(settlingSize(spheres, {1.1, {}}, 1, air, g, 1e-6, 0.1) == 0);
    CHECK(terminalVelocity(spheres, {1.1, {}}, 1e-3, air, g) == 0);
}

TEST_CASE("relaxation: a slow slip decays in Stokes' time, a fast one sooner")
{
    const double d = 50e-6, stokes = 2650*d*d/(18*1.8e-5);
    CHECK(relaxationTime(spheres, {2650, {}}, d, 1e-9, air) == near(stokes, 1e-3));
    CHECK(relaxationTime(spheres, {2650, {}}, d, 5, air) < 0.6*stokes);
}

TEST_CASE("relaxation at the terminal velocity is that velocity over gravity, less buoyancy")
{
    const Grain grain{2650, {}};
    const double v = terminalVelocity(spheres, grain, 4e-4, air, g);
    CHECK(relaxationTime(spheres, grain, 4e-4, v, air)
          == near(v/(g*(1 - 1.2/2650)), 1e-9));
}

}
