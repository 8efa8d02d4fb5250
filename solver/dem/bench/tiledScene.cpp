#include "tiledScene.hpp"

#include "engine/Engine.hpp"

#include <algorithm>
#include <cmath>
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

/// Makes settled beds from one that has settled once.
class Scenes
{
public:
    Particles make(const std::string& name, std::size_t particles)
    {
        if (name == "falling") return sceneOf(particles).fill(particles, diameter, 0.1);
        if (name != "settled")
            throw std::invalid_argument("scene is '" + name + "'; allowed: settled falling");
        if (tile_.size() == 0) tile_ = settledTile();
        return repeated(tile_, particles);
    }

private:
    Particles tile_;
};

std::vector<std::string> listed(const std::string& text)
{
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
    return parts;
}

std::vector<unsigned> numbersListed(const std::string& text)
{
    std::vector<unsigned> numbers;
    for (const std::string& part : listed(text)) numbers.push_back(unsigned(std::stoul(part)));
    if (!numbers.empty()) return numbers;
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    for (unsigned n = 1; n <= std::min(cores, 16u); n *= 2) numbers.push_back(n);
    return numbers;
}

std::size_t stepsFor(const std::string& scene, double work, std::size_t particles)
{
    return std::max<std::size_t>(
        10, std::size_t((scene == "settled" ? 1 : 10)*work/double(particles)));
}

} // namespace

void forRuns(const Options& o, const std::string& numbers,
             const std::function<void(const TiledRun&)>& measure)
{
    const double work = o.number("work", 6e7);
    const std::vector<unsigned> all = numbersListed(o.text(numbers, ""));
    Scenes scenes;
    for (const std::string& size : listed(o.text("particles", "100000,1000000")))
    {
        const auto particles = std::size_t(std::stod(size));
        const BoxScene box = sceneOf(particles);
        for (const std::string& name : listed(o.text("scene", "settled,falling")))
        {
            const Particles p = scenes.make(name, particles);
            const std::size_t steps = stepsFor(name, work, p.size());
            for (const unsigned number : all)
                measure({box, name, p, steps, number, number == all.front()});
        }
    }
}

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
