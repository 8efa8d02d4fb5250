// Time of the neighbour search per step while particles move.
//   scene=walk (two-dimensional random walk, area fraction 0.1)
//         column (three-dimensional, ten times as high as wide, volume fraction 0.02)
//   method=bruteForce|cells|verlet|hierarchical layers=1 particles=1000 steps=0 (as many as fit
//   in `seconds`=0.5) ratio=1 (largest over smallest diameter, equal mass per size decade)
// bruteForce and cells search in every step; verlet and hierarchical keep a list with a skin and
// search when the largest displacement asks for it.

#include "bench.hpp"
#include "neighbours/PairSearch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

using namespace elutria::dem;

namespace
{

constexpr double pi = 3.14159265358979323846;

struct Scene
{
    std::vector<double> x, y, z, radius;
    PeriodicBox box;
    double smallest = 1;
    std::mt19937_64 random{7};

    Scene(bool flat, std::size_t n, double ratio)
    {
        std::uniform_real_distribution<double> uniform(0, 1);
        double volume = 0;
        for (std::size_t i = 0; i < n; ++i)
        {
            // equal mass per size decade: number density ~ r^-4
            const double u = uniform(random), a = std::pow(ratio, -3.0);
            const double r = ratio > 1 ? std::pow(1 - u*(1 - a), -1.0/3) : 1;
            radius.push_back(r);
            volume += flat ? pi*r*r : 4.0/3*pi*r*r*r;
        }
        const double width = flat ? std::sqrt(volume/0.1) : std::cbrt(volume/0.02/10);
        box = {{0, 0, 0}, {width, width, flat ? 0 : 10*width}, {true, true, !flat}};
        for (std::size_t i = 0; i < n; ++i)
        {
            x.push_back(width*uniform(random)), y.push_back(width*uniform(random));
            z.push_back(box.high.z*uniform(random));
        }
        sortBySpace();
        const double least = 4*(*std::max_element(radius.begin(), radius.end())) + 4;
        for (int a = 0; a < 3; ++a)
        {
            if (box.high[a] < least) box.periodic[a] = false;
        }
    }
    /// Neighbours in space close in memory, as the engine keeps its particles.
    void sortBySpace()
    {
        constexpr double width = 8;
        const auto key = [&](std::size_t i)
        {
            return std::array<int, 3>{int(z[i]/width), int(y[i]/width), int(x[i]/width)};
        };
        std::vector<std::size_t> order(x.size());
        std::iota(order.begin(), order.end(), 0);
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
        for (std::vector<double>* values : {&x, &y, &z, &radius})
        {
            const std::vector<double> before = *values;
            for (std::size_t k = 0; k < order.size(); ++k) (*values)[k] = before[order[k]];
        }
    }

    /// One random step of every particle, up to `most` in each direction.
    void move(double most)
    {
        std::uint64_t state = random();
        const double scale = 2*most/4294967296.0;
        const auto step = [&](std::vector<double>& c)
        {
            for (double& value : c)
            {
                state = state*6364136223846793005u + 1442695040888963407u;
                value += scale*double(state >> 32) - most;
            }
        };
        step(x), step(y);
        if (box.high.z > 0) step(z);
    }
};

} // namespace

int runNeighbours(const Options& o)
{
    const bool flat = o.text("scene", "column") == "walk";
    const auto n = std::size_t(o.number("particles", 1000));
    const auto layers = int(o.number("layers", 1));
    const NeighbourSearch method = searchNamed(o.text("method", "hierarchical"));
    const double most = 0.02, skin = 0.6, enough = o.number("seconds", 0.5);
    const auto asked = std::size_t(o.number("steps", 0));
    const bool lists =
        method == NeighbourSearch::verlet || method == NeighbourSearch::hierarchical;
    const double before = residentBytes();
    Scene scene(flat, n, o.number("ratio", 1));
    PairSearch finder;
    PairList list;
    double way = 0, spent = 0, used = 0;
    std::size_t steps = 0, searches = 0;
    const auto search = [&]
    {
        const Spheres spheres{n, scene.x.data(), scene.y.data(), scene.z.data(),
                              scene.radius.data(), lists ? skin : 0};
        finder.find(spheres, scene.box, method, layers, 1, list);
        way = 0;
    };
    search();
    // ends after a search, so that each counts with all the steps it serves
    while (asked > 0 ? steps < asked : spent < enough || steps < 2 || way > 0)
    {
        const double start = seconds(), startProcessor = processorSeconds();
        scene.move(most);
        way += most*std::sqrt(flat ? 2 : 3);
        if (!lists || 2*way >= skin)
        {
            search();
            ++searches;
        }
        spent += seconds() - start;
        used += processorSeconds() - startProcessor;
        ++steps;
    }
    std::printf("{\"scene\": \"%s\", \"method\": \"%s\", \"layers\": %d, \"particles\": %zu, "
                "\"steps\": %zu, \"searches\": %zu, \"pairs_per_particle\": %.4g, "
                "\"wall_s_per_step\": %.6g, \"cpu_s_per_step\": %.6g, "
                "\"process_bytes_per_particle\": %.4g}\n",
                flat ? "walk" : "column", o.text("method", "hierarchical").c_str(), layers, n,
                steps, searches, double(list.size())/double(n), spent/double(steps),
                used/double(steps), (residentBytes() - before)/double(n));
    return 0;
}
