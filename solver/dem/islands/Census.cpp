#include "islands/Census.hpp"

#include "parallel/Message.hpp"

#include <algorithm>

namespace elutria::dem
{

namespace
{

struct Extreme
{
    std::uint32_t material;
    double radius, mass;
    Vector3 velocity;
};

std::vector<Extreme> extremes(const Particles& p)
{
    std::vector<Extreme> found;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        const std::uint32_t material = p.material[i];
        if (material >= found.size()) found.resize(material + 1, {0, 0, 0, {}});
        Extreme& e = found[material];
        if (e.radius == 0) e = {material, p.radius[i], p.mass[i], p.velocity[i]};
        e.radius = std::min(e.radius, p.radius[i]);
        e.mass = std::min(e.mass, p.mass[i]);
        if (norm(p.velocity[i]) > norm(e.velocity)) e.velocity = p.velocity[i];
    }
    found.erase(std::remove_if(found.begin(), found.end(),
                               [](const Extreme& e) { return e.radius == 0; }), found.end());
    return found;
}

void add(Particles& to, const std::vector<Extreme>& spheres)
{
    for (const Extreme& e : spheres)
    {
        to.id.push_back(to.size());
        to.material.push_back(e.material);
        to.radius.push_back(e.radius), to.mass.push_back(e.mass);
        to.position.push_back({}), to.velocity.push_back(e.velocity), to.spin.push_back({});
    }
}

} // namespace


Particles extremesOf(const Particles& particles)
{
    Particles made;
    add(made, extremes(particles));
    return made;
}


Census takeCensus(Exchange& exchange, const Particles& particles, std::size_t contactEnds)
{
    Census all;
    if (exchange.alone())
    {
        all.particles = particles.size(), all.contactEnds = contactEnds;
        return all;
    }
    Vector3 velocity;
    for (std::size_t i = 0; i < particles.size(); ++i) velocity += particles.velocity[i];
    const std::vector<double>& weights = particles.statisticalWeight;
    const bool weighted =
        std::any_of(weights.begin(), weights.end(), [](double w) { return w != 1; });
    Outgoing out;
    out << particles.size() << contactEnds << weighted << velocity << extremes(particles);
    for (const Bytes& bytes : exchange.share(out.take()))
    {
        Incoming in(bytes);
        all.particles += in.get<std::size_t>();
        all.contactEnds += in.get<std::size_t>();
        all.weighted = in.get<bool>() || all.weighted;
        all.velocity += in.get<Vector3>();
        add(all.extremes, in.get<std::vector<Extreme>>());
    }
    if (all.particles > 0) all.velocity *= 1/double(all.particles);
    return all;
}

} // namespace elutria::dem
