#include "boxScene.hpp"

#include "laws/LawList.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

using namespace elutria::dem;

namespace
{

constexpr double pi = 3.14159265358979323846, density = 2526, gravity = 9.81;

} // namespace

Walls BoxScene::walls() const
{
    WallGeometry g;
    for (double z : {0.0, height})
    {
        const auto k = std::uint32_t(g.points.size());
        g.points.insert(g.points.end(), {{0, 0, z}, {width, 0, z}, {width, depth, z},
                                         {0, depth, z}});
        g.triangles.push_back({k, k + 1, k + 2});
        g.triangles.push_back({k, k + 2, k + 3});
        g.material.insert(g.material.end(), 2, 0);
    }
    return Walls(g, settings(1).box);
}

Settings BoxScene::settings(unsigned threads) const
{
    Settings s;
    s.law = &contactLaw<HertzMindlin>;
    s.treatment = ContactTreatment::soft;
    s.threads = threads;
    s.step = step;
    s.box = {{0, 0, 0}, {width, depth, height}, {true, true, false}};
    return s;
}

Particles BoxScene::fill(std::size_t count, double diameter, double speed) const
{
    Particles p;
    std::mt19937_64 random(15485863);
    std::uniform_real_distribution<double> uniform(-0.5, 0.5);
    // cells of equal width sideways, as many as `count` needs
    std::size_t across = 1, along = 1, deep = 1;
    const auto cells = [&] { return across*deep*along; };
    while (cells() < count)
    {
        if (width/double(across + 1) < height/double(along)) ++along;
        else ++across;
        deep = std::max<std::size_t>(1, std::size_t(double(across)*depth/width + 0.5));
    }
    const double dx = width/double(across), dy = depth/double(deep);
    const double dz = (height - diameter)/double(along);
    std::vector<std::size_t> places(cells());
    for (std::size_t k = 0; k < places.size(); ++k) places[k] = k;
    std::shuffle(places.begin(), places.end(), random);
    const double room = 0.98*(std::min({dx, dy, dz}) - diameter);
    if (room < 0) throw std::invalid_argument("the box is too small for its particles");
    for (std::size_t k = 0; k < count; ++k)
    {
        const std::size_t i = places[k] % across, j = places[k]/across % deep,
                          l = places[k]/(across*deep);
        p.id.push_back(k + 1);
        p.material.push_back(0);
        p.radius.push_back(diameter/2);
        p.mass.push_back(pi/6*diameter*diameter*diameter*density);
        p.position.push_back({(double(i) + 0.5)*dx + room*uniform(random),
                              (double(j) + 0.5)*dy + room*uniform(random),
                              diameter/2 + (double(l) + 0.5)*dz + room*uniform(random)});
        p.velocity.push_back({0, 0, -speed});
        p.spin.push_back({});
    }
    p.acceleration.assign(count, {0, 0, -gravity});
    return p;
}

Particles BoxScene::ofRank(const Particles& all, const Exchange& exchange) const
{
    const auto ranks = unsigned(exchange.ranks());
    auto deep = unsigned(std::sqrt(double(ranks)));
    while (ranks % deep != 0) --deep;
    const unsigned across = ranks/deep;
    const auto along = [](double x, double length, unsigned count)
    {
        return std::min(count - 1, unsigned(std::max(0.0, x/length*count)));
    };
    Particles own = all;
    keepOnly(own, [&](std::size_t i)
    {
        const Vector3 x = all.position[i];
        return along(x.y, depth, deep)*across + along(x.x, width, across) == unsigned(exchange.rank());
    });
    return own;
}

ContactMaterials grain(double young, double poisson, double restitution, double friction)
{
    ContactMaterials materials;
    materials.add({"grain", young, poisson});
    PairProperties pair;
    pair.restitution = restitution;
    pair.friction = friction;
    materials.setPair(0, 0, pair);
    return materials;
}
