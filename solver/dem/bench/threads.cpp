// What threads are worth to contact steps: spheres of 2.5 mm in a box that is periodic sideways, falling
// through it or settled in it, Hertz's law. One line of a csv table for each number of threads, with the
// ratios to the fewest and a checksum of the state, which must not depend on the number.
//   particles=100000,1000000 threads=1,2,4,8,16 (as far as the cores go) scene=settled,falling
//   work=6e7 (particle-steps measured of settled spheres; ten times as many of falling ones)
// The settled bed is a narrow one, repeated sideways: 6250 spheres each.

#include "bench.hpp"
#include "boxScene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <thread>

using namespace elutria::dem;

namespace
{

constexpr double diameter = 0.0025;
constexpr std::size_t tileSize = 6250;
constexpr double tileWidth = 0.0375;       // m

std::vector<std::string> listed(const std::string& text)
{
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
    return parts;
}

std::vector<unsigned> threadsListed(const std::string& text)
{
    std::vector<unsigned> numbers;
    for (const std::string& part : listed(text)) numbers.push_back(unsigned(std::stoul(part)));
    if (!numbers.empty()) return numbers;
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    for (unsigned n = 1; n <= std::min(cores, 16u); n *= 2) numbers.push_back(n);
    return numbers;
}

/// Tiles sideways and backwards, as square as they get.
std::pair<std::size_t, std::size_t> tiles(std::size_t particles)
{
    const std::size_t count = std::max<std::size_t>(1, (particles + tileSize/2)/tileSize);
    auto deep = std::size_t(std::sqrt(double(count)));
    while (count % deep != 0) --deep;
    return {count/deep, deep};
}

BoxScene sceneOf(std::size_t particles)
{
    const auto [across, deep] = tiles(particles);
    BoxScene scene;
    scene.width = double(across)*tileWidth, scene.depth = double(deep)*tileWidth;
    return scene;
}

/// 6250 spheres at rest on the floor.
Particles settledTile()
{
    BoxScene scene = sceneOf(tileSize);
    Particles p;
    {
        BoxScene crowded = scene;
        crowded.height = 0.09;
        p = crowded.fill(tileSize, diameter, 0.1);
    }
    scene.step = 2e-5;
    Engine engine(scene.settings(1), grain(1e7, 0.35, 0.3, 0.1), scene.walls());
    engine.advance(p, 0.25);
    return p;
}

Particles repeated(const Particles& tile, std::size_t particles)
{
    const auto [across, deep] = tiles(particles);
    Particles p;
    for (std::size_t k = 0; k < across*deep; ++k)
    {
        const Vector3 shift{double(k % across)*tileWidth, double(k/across)*tileWidth, 0};
        for (std::size_t i = 0; i < tile.size(); ++i)
        {
            p.id.push_back(p.size() + 1);
            p.material.push_back(0);
            p.radius.push_back(tile.radius[i]);
            p.mass.push_back(tile.mass[i]);
            p.position.push_back(tile.position[i] + shift);
            p.velocity.push_back(tile.velocity[i]);
            p.spin.push_back(tile.spin[i]);
            p.acceleration.push_back(tile.acceleration[i]);
        }
    }
    return p;
}

/// FNV-1a of the bits of positions, velocities and spins.
std::uint64_t checksum(const Particles& p)
{
    std::uint64_t hash = 14695981039346656037ull;
    for (const VectorArray* array : {&p.position, &p.velocity, &p.spin})
    {
        for (const std::vector<double>* values : {&array->x, &array->y, &array->z})
        {
            for (double value : *values)
            {
                std::uint64_t bits;
                std::memcpy(&bits, &value, sizeof(bits));
                hash = (hash ^ bits)*1099511628211ull;
            }
        }
    }
    return hash;
}

struct Timing
{
    double wall = 0, processor = 0;        // s
    std::uint64_t state = 0;
    StepReport report;
};

Timing measure(const BoxScene& scene, Particles p, unsigned threads, std::size_t warmup,
               std::size_t steps)
{
    Engine engine(scene.settings(threads), grain(1e7, 0.35, 0.9, 0.1), scene.walls());
    engine.advance(p, double(warmup)*scene.step);
    Timing t;
    const double wall = seconds(), processor = processorSeconds();
    t.report = engine.advance(p, double(steps)*scene.step);
    t.wall = seconds() - wall, t.processor = processorSeconds() - processor;
    t.state = checksum(p);
    return t;
}

} // namespace

int runThreads(const Options& o)
{
    const std::vector<unsigned> numbers = threadsListed(o.text("threads", ""));
    const double work = o.number("work", 6e7);
    Particles tile;
    std::printf("scene,particles,threads,steps,wall_us_per_particle_step,speed_up,"
                "processor_us_per_particle_step,processor_ratio,coordination,list_builds,"
                "engine_bytes_per_particle,state\n");
    bool same = true;
    for (const std::string& size : listed(o.text("particles", "100000,1000000")))
    {
        const auto particles = std::size_t(std::stod(size));
        const BoxScene scene = sceneOf(particles);
        for (const std::string& name : listed(o.text("scene", "settled,falling")))
        {
            const bool settled = name == "settled";
            if (!settled && name != "falling")
                throw std::invalid_argument("scene is '" + name + "'; allowed: settled falling");
            if (settled && tile.size() == 0) tile = settledTile();
            const Particles p = settled ? repeated(tile, particles)
                                        : scene.fill(particles, diameter, 0.1);
            const auto steps =
                std::max<std::size_t>(10, std::size_t((settled ? 1 : 10)*work/double(p.size())));
            Timing first;
            for (const unsigned threads : numbers)
            {
                const Timing t = measure(scene, p, threads, steps/5, steps);
                if (threads == numbers.front()) first = t;
                same = same && t.state == first.state;
                const double each = 1e6/(double(steps)*double(p.size()));
                std::printf("%s,%zu,%u,%zu,%.5g,%.3f,%.5g,%.3f,%.4g,%zu,%.4g,%016llx\n",
                            name.c_str(), p.size(), threads, steps, each*t.wall,
                            first.wall/t.wall, each*t.processor, t.processor/first.processor,
                            2.0*double(t.report.touching)/double(p.size()), t.report.listBuilds,
                            double(t.report.bytes)/double(p.size()),
                            static_cast<unsigned long long>(t.state));
                std::fflush(stdout);
            }
        }
    }
    if (!same) throw std::runtime_error("the state depends on the number of threads");
    return 0;
}
