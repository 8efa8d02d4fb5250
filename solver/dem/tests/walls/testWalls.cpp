#include "support/near.hpp"
#include "support/wallShapes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <stdexcept>

using namespace elutria::dem;

namespace
{

std::vector<WallContact> touching(const Walls& walls, const Vector3& centre, double radius,
                                  double reach = 0)
{
    std::vector<WallContact> found;
    walls.contacts(centre, radius, reach, found);
    return found;
}

struct Uniform
{
    std::mt19937_64 generator{42};
    double operator()(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(generator);
    }
};

/// Smallest distance to any triangle, by sampling none: all triangles, no look-up.
double nearestOfAll(const Walls& walls, const Vector3& position)
{
    double nearest = 1e300;
    for (std::uint32_t t = 0; t < walls.size(); ++t)
        nearest = std::min(nearest, norm(position - walls.nearestPoint({t, {}}, position)));
    return nearest;
}

} // namespace


TEST_CASE("walls: a sphere in a box touches each side it reaches, once")
{
    for (const int n : {1, 7})
    {
        const Walls walls(shapes::box({-1, 0, 2}, {1, 1, 5}, n));
        Uniform random;
        for (int trial = 0; trial < 3000; ++trial)
        {
            const Vector3 c{random(-1, 1), random(0, 1), random(2, 5)};
            const double radius = random(0.01, 0.4);
            const double gaps[6] = {c.x + 1 - radius, 1 - c.x - radius, c.y - radius,
                                    1 - c.y - radius, c.z - 2 - radius, 5 - c.z - radius};
            const auto found = touching(walls, c, radius);
            const auto expected = std::count_if(gaps, gaps + 6, [](double g) { return g <= 0; });
            REQUIRE(found.size() == std::size_t(expected));
            for (const WallContact& contact : found)
            {
                CHECK(std::any_of(gaps, gaps + 6, [&](double g)
                                  { return std::abs(g - contact.gap) < 1e-12; }));
                CHECK(norm(c - (radius + contact.gap)*contact.normal - contact.point) < 1e-12);
                CHECK(dot(contact.normal, c - contact.point) > 0);
            }
        }
    }
}

TEST_CASE("walls: a convex edge gives one contact, at the edge")
{
    // A step: floor at z = 0 for x > 0, riser at x = 0 from z = -1 to 0, lower floor at z = -1.
    WallGeometry g;
    shapes::addSheet(g, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 5, 5);
    shapes::addSheet(g, {0, 0, -1}, {0, 0, 1}, {0, 1, 0}, 5, 5);
    shapes::addSheet(g, {-1, 0, -1}, {1, 0, 0}, {0, 1, 0}, 5, 5);
    const Walls walls(g);
    Uniform random;
    for (int trial = 0; trial < 3000; ++trial)
    {
        const Vector3 c{random(-0.4, 0.4), random(0.2, 0.8), random(-0.9, 0.3)};
        if (c.x > 0 && c.z < 0) continue;
        const double radius = random(0.01, 0.2);
        std::size_t expected = 0;
        if (c.x > 0) expected = c.z <= radius;
        else if (c.z > 0) expected = std::hypot(c.x, c.z) <= radius;
        else expected = std::size_t(-c.x <= radius) + std::size_t(c.z + 1 <= radius);
        const auto found = touching(walls, c, radius);
        REQUIRE(found.size() == expected);
        if (c.x < 0 && c.z > 0 && expected == 1)
        {
            CHECK(std::abs(found[0].gap + radius - std::hypot(c.x, c.z)) < 1e-12);
            CHECK(std::abs(found[0].normal.y) < 1e-9);
        }
    }
}

TEST_CASE("walls: a free corner, a free edge and both faces of a baffle")
{
    WallGeometry g;
    shapes::addSheet(g, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 3, 2);
    const Walls walls(g);
    Uniform random;
    for (int trial = 0; trial < 5000; ++trial)
    {
        const Vector3 c{random(-0.3, 1.3), random(-0.3, 1.3), random(-0.3, 0.3)};
        const double radius = random(0.01, 0.3);
        const Vector3 nearest{std::clamp(c.x, 0.0, 1.0), std::clamp(c.y, 0.0, 1.0), 0};
        const double gap = norm(c - nearest) - radius;
        const auto found = touching(walls, c, radius);
        REQUIRE(found.size() == std::size_t(gap <= 0));
        if (gap <= 0)
        {
            CHECK(std::abs(found[0].gap - gap) < 1e-12);
            CHECK(norm(found[0].point - nearest) < 1e-9);
        }
    }
    // On the edge that the sheet's triangles share, and in the plane itself.
    CHECK(touching(walls, {1.0/3, 0.5, 0.05}, 0.1).size() == 1);
    CHECK(touching(walls, {0.5, 0.5, 0}, 0.1).size() == 1);
}

TEST_CASE("walls: rolling over a triangulated floor feels one plane")
{
    WallGeometry fine, plane;
    shapes::addSheet(fine, {0, 0, 0}, {1, 0, 0.1}, {0, 1, 0}, 37, 23);
    shapes::addSheet(plane, {0, 0, 0}, {1, 0, 0.1}, {0, 1, 0});
    const Walls many(fine), one(plane);
    const Vector3 up = (1/std::hypot(1, 0.1))*Vector3{-0.1, 0, 1};
    for (int step = 0; step <= 1000; ++step)
    {
        const double s = 0.1 + 0.8*step/1000;
        const Vector3 c = Vector3{s, s, 0.1*s} + 0.0195*up;
        const auto a = touching(many, c, 0.02), b = touching(one, c, 0.02);
        REQUIRE(a.size() == 1);
        REQUIRE(b.size() == 1);
        CHECK(std::abs(a[0].gap - b[0].gap) < 1e-13);
        CHECK(norm(a[0].normal - b[0].normal) < 1e-9);
        CHECK(a[0].feature == touching(many, {0.5, 0.5, 0.06}, 0.02)[0].feature);
    }
}

TEST_CASE("walls: inside and outside a tube of facets one contact, with one key all around")
{
    const Walls walls(shapes::tube(1, 3, 48, 5));
    Uniform random;
    std::uint64_t key = 0;
    bool first = true;
    for (int trial = 0; trial < 3000; ++trial)
    {
        const double angle = random(0, 6.2831853), radius = random(0.05, 0.3);
        const double overlap = random(0.003, 0.02);
        for (const double distance : {1 - radius + overlap, 1 + radius - overlap})
        {
            const Vector3 c{distance*std::cos(angle), distance*std::sin(angle), random(0.5, 2.5)};
            const auto found = touching(walls, c, radius);
            REQUIRE(found.size() == 1);
            CHECK(std::abs(found[0].gap + overlap) < 1 - std::cos(3.1415927/48) + 1e-9);
            if (first) key = found[0].feature, first = false;
            CHECK(found[0].feature == key);
        }
    }
}

TEST_CASE("walls: the nearest contact is the nearest of all triangles, on a rubble of triangles")
{
    Uniform random;
    WallGeometry g;
    for (std::uint32_t t = 0; t < 400; ++t)
    {
        const Vector3 a{random(0, 1), random(0, 1), random(0, 1)};
        for (int k = 0; k < 3; ++k)
            g.points.push_back(a + Vector3{random(-.1, .1), random(-.1, .1), random(-.1, .1)});
        g.triangles.push_back({3*t, 3*t + 1, 3*t + 2});
        g.material.push_back(t % 3);
    }
    const Walls walls(g);
    for (int trial = 0; trial < 2000; ++trial)
    {
        const Vector3 c{random(-.5, 1.5), random(-.5, 1.5), random(-.5, 1.5)};
        const double nearest = nearestOfAll(walls, c);
        CHECK(walls.distanceBound(c) <= nearest);
        const auto found = touching(walls, c, 0.1, 0.05);
        REQUIRE(found.empty() == (nearest > 0.15));
        if (!found.empty())
        {
            CHECK(std::abs(found[0].gap + 0.1 - nearest) < 1e-12);
            CHECK(found[0].material == g.material[found[0].triangle]);
        }
    }
}

TEST_CASE("walls: where they are flat the triangle below is all there is to touch")
{
    // A box on an open-ended sheet that is bent once, with a step in its material
    WallGeometry shape = shapes::box({-1, 0, 2}, {1, 1, 5}, 6);
    shapes::addSheet(shape, {-3, -3, 0}, {3, 0, 0}, {0, 6, 0}, 5, 8, 1);
    shapes::addSheet(shape, {0, -3, 0}, {3, 0, 0}, {0, 6, 0}, 5, 8, 2);
    shapes::addSheet(shape, {-3, -3, 0}, {0, 0, 2}, {0, 6, 0}, 3, 8);
    const Walls walls(shape);
    Uniform random;
    int flats = 0;
    for (int trial = 0; trial < 5000; ++trial)
    {
        const Vector3 centre{random(-3.1, 3.1), random(-3.1, 3.1), random(-0.3, 5.3)};
        const double radius = random(0.02, 0.3), margin = random(0.01, 0.3);
        std::vector<Walls::Image> among;
        walls.collect(centre, radius + margin, among);
        if (!walls.isFlat(centre, margin, among)) continue;

        ++flats;
        std::uint32_t below = 0;
        std::vector<WallContact> all, found;
        for (int move = 0; move < 10; ++move)
        {
            Vector3 way{random(-1, 1), random(-1, 1), random(-1, 1)};
            way *= margin*random(0, 1)/norm(way);
            const double reach = move % 2 ? 0 : margin - norm(way);
            walls.contacts(centre + way, radius, reach, all);
            walls.contactsOnFlat(centre + way, radius, reach, among, below, found);
            REQUIRE(found.size() == all.size());
            if (found.empty()) continue;
            CHECK(found[0].gap == near(all[0].gap, 1e-12));
            CHECK(norm(found[0].normal - all[0].normal) < 1e-12);
            CHECK(found[0].feature == all[0].feature);
            CHECK(found[0].material == all[0].material);
        }
    }
    CHECK(flats > 500);

    // Beside a rim, and where two walls are in reach, it is not
    std::vector<Walls::Image> among;
    walls.collect({-2.5, 2.95, 0.05}, 0.15, among);
    CHECK_FALSE(walls.isFlat({-2.5, 2.95, 0.05}, 0.1, among));
    CHECK(walls.isFlat({-2.5, 2.95, 0.05}, 0.04, among));
    walls.collect({-2.95, 1, 0.05}, 0.15, among);
    CHECK_FALSE(walls.isFlat({-2.95, 1, 0.05}, 0.1, among));
}


TEST_CASE("walls: a periodic floor has no end")
{
    for (const int n : {1, 3})
    {
        WallGeometry g;
        shapes::addSheet(g, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, n, n);
        PeriodicBox box{{0, 0, 0}, {1, 1, 1}, {true, true, false}};
        const Walls walls(g, box);
        Uniform random;
        const auto key = touching(walls, {0.4, 0.4, 0.1}, 0.15)[0].feature;
        for (int trial = 0; trial < 3000; ++trial)
        {
            const Vector3 c{random(-3, 4), random(-3, 4), random(-0.3, 0.3)};
            const auto found = touching(walls, c, 0.2, 0.2);
            CHECK(walls.distanceBound(c) <= std::abs(c.z));
            REQUIRE(found.size() == 1);
            CHECK(std::abs(found[0].gap - (std::abs(c.z) - 0.2)) < 1e-12);
            CHECK(found[0].feature == key);
        }
        for (const double edge : {0.0, 1.0})
            CHECK(touching(walls, {edge, edge, 0.1}, 0.2).size() == 1);
    }
}

TEST_CASE("walls: keys follow edges and tell corners apart")
{
    const Walls walls(shapes::box({0, 0, 0}, {1, 1, 1}, 4));
    const double out = 0.05;
    const auto edgeA = touching(walls, {0.1, -out, -out}, 0.1);
    const auto edgeB = touching(walls, {0.9, -out, -out}, 0.1);
    const auto edgeC = touching(walls, {0.9, 1 + out, -out}, 0.1);
    const auto corner = touching(walls, {-out, -out, -out}, 0.1);
    for (const auto& found : {edgeA, edgeB, edgeC, corner}) REQUIRE(found.size() == 1);
    CHECK(edgeA[0].feature == edgeB[0].feature);
    CHECK(edgeA[0].feature != edgeC[0].feature);
    CHECK(edgeA[0].feature != corner[0].feature);
}

TEST_CASE("walls: distance bound is sharp enough to spare particles away from walls")
{
    const Walls walls(shapes::box({0, 0, 0}, {0.05, 0.05, 0.5}, 10));
    Uniform random;
    for (int trial = 0; trial < 1000; ++trial)
    {
        const Vector3 c{random(0, 0.05), random(0, 0.05), random(0, 0.5)};
        const double exact = std::min({c.x, c.y, c.z, 0.05 - c.x, 0.05 - c.y, 0.5 - c.z});
        CHECK(walls.distanceBound(c) <= exact);
        CHECK(walls.distanceBound(c) >= exact - 0.007);
    }
    CHECK(walls.distanceBound({1, 0, 0}) <= 0.95);
    CHECK(walls.distanceBound({1, 0, 0}) > 0.9);
}

TEST_CASE("walls: what is refused, and what is harmless")
{
    WallGeometry g;
    shapes::addSheet(g, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    WallGeometry bad = g;
    bad.points[0].x = std::nan("");
    CHECK_THROWS_AS(Walls{bad}, std::invalid_argument);
    bad = g, bad.triangles[0][1] = 99;
    CHECK_THROWS_AS(Walls{bad}, std::invalid_argument);
    bad = g, bad.material.pop_back();
    CHECK_THROWS_AS(Walls{bad}, std::invalid_argument);
    CHECK_THROWS_AS(Walls(g, PeriodicBox{{0, 0, 0}, {0, 1, 1}, {true, false, false}}),
                    std::invalid_argument);

    CHECK(touching(Walls{}, {0, 0, 0}, 1).empty());
    WallGeometry sliver = g;                           // without area
    sliver.triangles.push_back({0, 1, 1});
    sliver.material.push_back(0);
    CHECK(touching(Walls{sliver}, {0.5, 0, 0.05}, 0.1).size() == 1);
    WallGeometry onlySliver;
    onlySliver.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    onlySliver.triangles = {{0, 1, 2}};
    onlySliver.material = {0};
    CHECK(touching(Walls{onlySliver}, {0.5, 0, 0.05}, 0.1).empty());
}
