#include "neighbours/PairSearch.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

using namespace elutria::dem;

namespace
{

struct RandomCloud
{
    std::vector<double> x, y, z, radius;
    std::mt19937_64 random;

    RandomCloud(std::size_t n, double ratio, unsigned seed) : random(seed)
    {
        std::uniform_real_distribution<double> place(0, 1), size(0, 1);
        for (std::size_t i = 0; i < n; ++i)
        {
            x.push_back(place(random)), y.push_back(place(random)), z.push_back(place(random));
            radius.push_back(0.1*std::pow(ratio, -size(random)));
        }
    }
    void move(double most)
    {
        std::uniform_real_distribution<double> step(-most, most);
        for (auto* c : {&x, &y, &z})
        {
            for (double& value : *c) value += step(random);
        }
    }
    /// About one of ten, in no order
    std::vector<std::uint32_t> some()
    {
        std::vector<std::uint32_t> found(x.size());
        std::iota(found.begin(), found.end(), 0u);
        std::shuffle(found.begin(), found.end(), random);
        found.resize(x.size()/10 + 1);
        return found;
    }
    Spheres spheres(double skin) const
    {
        return {x.size(), x.data(), y.data(), z.data(), radius.data(), skin, 1};
    }
};

} // namespace

TEST_SUITE("search")
{
    TEST_CASE("every method finds the pairs of brute force, after building and after moving")
    {
        PeriodicBox open, box{{0, 0, 0}, {1, 1, 1}, {true, true, false}},
            all{{0, 0, 0}, {1, 1, 1}, {true, true, true}};
        PairSearch kept;
        for (double ratio : {1.0, 3.0, 20.0, 200.0})
        {
            for (std::size_t n : {2u, 17u, 700u})
            {
                RandomCloud cloud(n, ratio, unsigned(7*n) + unsigned(ratio));
                for (int round = 0; round < 3; ++round)
                {
                    for (const PeriodicBox& b : {open, box, all})
                    {
                        const Spheres spheres = cloud.spheres(0.02*round);
                        const std::vector<Pair> expected =
                            findPairs(spheres, b, NeighbourSearch::bruteForce);
                        const auto agrees = [&](NeighbourSearch method, int layers)
                        {
                            const std::vector<Pair> found = findPairs(spheres, b, method, layers);
                            CAPTURE(n);
                            CAPTURE(ratio);
                            CAPTURE(int(method));
                            CAPTURE(layers);
                            CHECK(found == expected);
                        };
                        for (int layers : {1, 2, 3}) agrees(NeighbourSearch::cells, layers);
                        agrees(NeighbourSearch::verlet, 1);
                        agrees(NeighbourSearch::hierarchical, 1);
                        PairList list;
                        kept.find(spheres, b, NeighbourSearch::hierarchical, 1, 3, list);
                        CHECK(list.pairs() == expected);

                        const std::vector<std::uint32_t> asked = cloud.some();
                        const auto isAsked = [&](std::uint32_t i)
                        { return std::find(asked.begin(), asked.end(), i) != asked.end(); };
                        std::vector<Pair> withAsked;
                        for (const Pair& pair : expected)
                            if (isAsked(pair.first) || isAsked(pair.second)) withAsked.push_back(pair);
                        for (unsigned threads : {1u, 3u})
                        {
                            kept.findWith(asked, spheres, b, threads, list);
                            CHECK(list.pairs() == withAsked);
                        }
                    }
                    cloud.move(0.3);
                }
            }
        }
    }

    TEST_CASE("threads share the search of many spheres of two sizes and find the pairs of brute force")
    {
        RandomCloud cloud(9000, 1, 5);
        for (std::size_t i = 0; i < cloud.radius.size(); ++i) cloud.radius[i] = i % 9 ? 0.005 : 0.02;
        const PeriodicBox box{{0, 0, 0}, {1, 1, 1}, {true, false, true}};
        const Spheres spheres = cloud.spheres(0.004);
        const std::vector<Pair> expected = findPairs(spheres, box, NeighbourSearch::bruteForce);
        CHECK(expected.size() > 1000);
        for (unsigned threads : {1u, 2u, 4u})
        {
            PairList list;
            PairSearch().find(spheres, box, NeighbourSearch::hierarchical, 1, threads, list);
            CHECK(list.pairs() == expected);
        }
    }

    TEST_CASE("spheres in one place, on cell faces, in a plane and on a line")
    {
        const std::size_t n = 60;
        for (int kind = 0; kind < 4; ++kind)
        {
            std::vector<double> x(n), y(n), z(n), radius(n, 0.5);
            for (std::size_t i = 0; i < n; ++i)
            {
                if (kind >= 1) x[i] = double(i % 10);
                if (kind >= 2) y[i] = double(i/10);
                if (kind >= 3) z[i] = 1e3*double(i);
            }
            for (double skin : {0.0, 1e-3})
            {
                const Spheres s{n, x.data(), y.data(), z.data(), radius.data(), skin, 1};
                const std::vector<Pair> expected =
                    findPairs(s, {}, NeighbourSearch::bruteForce);
                for (NeighbourSearch method : {NeighbourSearch::cells, NeighbourSearch::hierarchical})
                {
                    CHECK(findPairs(s, {}, method, 2) == expected);
                }
            }
        }
    }
}
