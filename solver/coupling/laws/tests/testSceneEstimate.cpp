// The estimate of a scene, against sums by hand for a column of one size.
#include "SceneEstimate.hpp"

#include "near.hpp"

using namespace elutria::laws;

namespace
{

// 1 g/s of 1 mm spheres of 2000 kg/m3 in 2 litres of air that rises in half a second at 1 m/s
constexpr double pi6 = 0.5235987755982988;
const Solids solids{1e-3, 2000*pi6*1e-9, {{2000, 1, 1, 1e-3}}};
const GasStream air{1.25, 1, 2e-3, 0.5};

} // namespace

TEST_SUITE("scene")
{

TEST_CASE("loading, and what is inside")
{
    const SceneEstimate e = estimate(solids, air, 10);
    CHECK(e.loading == near(1e-3/(1.25*2e-3/0.5), 1e-9));     // over 5 g/s of air
    CHECK(e.inside == near(0.5e-3, 1e-9));
    CHECK(e.solidFraction == near(0.5e-3/2000/2e-3, 1e-9));
}

TEST_CASE("the gas changes by the weight inside over the momentum that the stream carries in")
{
    // 0.5 g weigh 5 mN; 2.5 g of air at 1 m/s come in every half second: 5 mN
    CHECK(estimate(solids, air, 10).gasChange == near(1, 1e-9));
}

TEST_CASE("collisions: what a sphere's tube of twice its radius holds")
{
    // 477 spheres in 2 litres; a tube of pi mm2 and 0.25 m (half the gas' way) holds 0.1875 of them
    CHECK(estimate(solids, air, 10).collisions == near(0.1875, 1e-3));
}

TEST_CASE("a step has as many collisions as it may")
{
    const SceneEstimate e = estimate(solids, air, 10);
    const double step = collisionStep(e, air, 0.05);
    CHECK(step/air.throughTime*e.collisions == near(0.05, 1e-9));
}

TEST_CASE("materials add up by their shares")
{
    Solids two = solids;
    two.materials = {{2000, 0.5, 0.5, 1e-3}, {2000, 0.5, 0.5, 1e-3}};
    const SceneEstimate a = estimate(solids, air, 10), b = estimate(two, air, 10);
    CHECK(b.collisions == near(a.collisions, 1e-9));
    CHECK(b.solidFraction == near(a.solidFraction, 1e-9));
}

}
