// Particles of many sizes in a gas stream up a column 50 x 50 x 500 mm, periodic along it: few touch.
//   particles=5000 step=1e-3 steps=200 warmup=20 treatment=auto|soft|impact threads=1
//   smallest=1e-4 largest=1.5e-3 young=1e7 restitution=0.9 friction=0.3 gas=5 seed=1
// Diameters: Rosin-Rammler by mass, d63 0.6 of the largest, n 2, truncated.

#include "bench.hpp"
#include "laws/LawList.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

using namespace elutria::dem;

namespace
{

constexpr double pi = 3.14159265358979323846;
constexpr double width = 0.05, height = 0.5, density = 2650, gasDensity = 1.2, viscosity = 1.8e-5,
                 gravity = 9.81;

/// The four sides, meshed as a column of 5 mm cells would be.
WallGeometry sides()
{
    WallGeometry g;
    const int across = 10, along = 100;
    const Vector3 corners[5] = {{0, 0, 0}, {width, 0, 0}, {width, width, 0}, {0, width, 0},
                                {0, 0, 0}};
    for (int side = 0; side < 4; ++side)
    {
        const auto base = std::uint32_t(g.points.size());
        for (int j = 0; j <= along; ++j)
            for (int i = 0; i <= across; ++i)
                g.points.push_back(corners[side]
                                   + (double(i)/across)*(corners[side + 1] - corners[side])
                                   + Vector3{0, 0, height*j/along});
        for (std::uint32_t j = 0; j < along; ++j)
            for (std::uint32_t i = 0; i < across; ++i)
            {
                const std::uint32_t a = base + j*(across + 1) + i, b = a + across + 1;
                g.triangles.push_back({a, a + 1, b});
                g.triangles.push_back({a + 1, b + 1, b});
            }
    }
    g.material.assign(g.triangles.size(), 0);
    return g;
}

/// Drag rate at the terminal velocity, 1/s, and that velocity, m/s (Schiller and Naumann 1935).
void terminal(double diameter, double& rate, double& velocity)
{
    const double stokes = 18*viscosity/(density*diameter*diameter);
    velocity = gravity/stokes;
    for (int k = 0; k < 200; ++k)
    {
        const double reynolds = gasDensity*velocity*diameter/viscosity;
        rate = stokes*(reynolds < 1000 ? 1 + 0.15*std::pow(reynolds, 0.687)
                                       : 0.44/24*reynolds);
        velocity = 0.5*(velocity + gravity/rate);
    }
}

Particles feed(const Options& options)
{
    const auto count = std::size_t(options.number("particles", 5000));
    const double smallest = options.number("smallest", 1e-4);
    const double largest = options.number("largest", 1.5e-3), d63 = 0.6*largest;
    const double gas = options.number("gas", 5);
    std::mt19937_64 random(std::uint64_t(options.number("seed", 1)));
    std::uniform_real_distribution<double> uniform(0, 1);
    // the mass law turned into one by number, on a grid of diameters
    std::vector<double> diameters, cumulative;
    for (int k = 0; k <= 400; ++k)
    {
        const double d = smallest*std::pow(largest/smallest, k/400.0), z = d/d63;
        diameters.push_back(d);
        cumulative.push_back((k ? cumulative.back() : 0) + z*z*std::exp(-z*z)/(d*d*d));
    }
    const std::size_t across = 14, along = 2*count/(across*across) + 1;
    std::vector<std::size_t> places(across*across*along);
    for (std::size_t k = 0; k < places.size(); ++k) places[k] = k;
    std::shuffle(places.begin(), places.end(), random);
    Particles p;
    for (std::size_t k = 0; k < count; ++k)
    {
        const auto at = std::lower_bound(cumulative.begin(), cumulative.end(),
                                         uniform(random)*cumulative.back());
        const double d = diameters[std::size_t(at - cumulative.begin())];
        double rate, velocity;
        terminal(d, rate, velocity);
        const std::size_t i = places[k] % across, j = places[k]/across % across,
                          l = places[k]/(across*across);
        p.id.push_back(k + 1);
        p.material.push_back(0);
        p.radius.push_back(d/2);
        p.mass.push_back(pi/6*d*d*d*density);
        p.position.push_back({(double(i) + 0.5)*width/across, (double(j) + 0.5)*width/across,
                              (double(l) + 0.5)*height/double(along)});
        p.velocity.push_back({0.2*(uniform(random) - 0.5), 0.2*(uniform(random) - 0.5),
                              gas - velocity});
        p.spin.push_back({});
        p.dragRate.push_back(rate);
        p.gasVelocity.push_back({0, 0, gas});
        p.acceleration.push_back({0, 0, -gravity});
    }
    return p;
}

} // namespace

int runColumn(const Options& options)
{
    Settings settings;
    settings.law = &contactLaw<HertzMindlin>;
    const std::string treatment = options.text("treatment", "auto");
    if (treatment != "auto" && treatment != "soft" && treatment != "impact")
        throw std::invalid_argument("treatment is '" + treatment + "'; allowed: auto soft impact");
    settings.treatment = treatment == "auto" ? ContactTreatment::automatic
        : treatment == "soft" ? ContactTreatment::soft : ContactTreatment::impact;
    settings.threads = unsigned(options.number("threads", 1));
    settings.box = {{0, 0, 0}, {width, width, height}, {false, false, true}};
    ContactMaterials materials;
    materials.add({"grain", options.number("young", 1e7), 0.3});
    PairProperties pair;
    pair.restitution = options.number("restitution", 0.9);
    pair.friction = options.number("friction", 0.3);
    materials.setPair(0, 0, pair);

    Particles p = feed(options);
    Engine engine(settings, materials, Walls(sides(), settings.box));
    const double step = options.number("step", 1e-3);
    const int steps = int(options.number("steps", 200)), warmup = int(options.number("warmup", 20));
    StepReport sum;
    double free = 0, wall = 0, processor = 0;
    for (int k = -warmup; k < steps; ++k)
    {
        if (k == 0) wall = seconds(), processor = processorSeconds();
        const StepReport r = engine.advance(p, step);
        if (k < 0) continue;
        free += double(r.freeParticles);
        sum.impacts += r.impacts, sum.subSteps += r.subSteps, sum.pieces += r.pieces;
        sum.softIslands += r.softIslands, sum.mergedIslands += r.mergedIslands;
        sum.islands += r.islands, sum.candidates += r.candidates;
        sum.searchSeconds += r.searchSeconds, sum.impactSeconds += r.impactSeconds;
        sum.softSeconds += r.softSeconds;
    }
    wall = seconds() - wall, processor = processorSeconds() - processor;
    const double particleSteps = double(p.size())*steps;
    double energy = 0;
    for (std::size_t i = 0; i < p.size(); ++i) energy += 0.5*p.mass[i]*squaredNorm(p.velocity[i]);
    std::printf("{\"mode\": \"column\", \"treatment\": \"%s\", \"particles\": %zu, \"step_s\": %g, "
                "\"steps\": %d, \"young_Pa\": %g, \"smallest_m\": %g, "
                "\"us_per_particle_step\": %.4f, \"processor_us_per_particle_step\": %.4f, "
                "\"free_share\": %.4f, \"impacts\": %zu, \"islands\": %zu, \"merged\": %zu, "
                "\"soft_islands\": %zu, \"sub_steps\": %zu, \"pieces\": %zu, \"candidates\": %zu, "
                "\"search_s\": %.4f, \"impact_s\": %.4f, \"soft_s\": %.4f, "
                "\"kinetic_energy_J\": %.9g}\n",
                treatment.c_str(), p.size(), step, steps, options.number("young", 1e7),
                options.number("smallest", 1e-4), 1e6*wall/particleSteps,
                1e6*processor/particleSteps, free/particleSteps, sum.impacts, sum.islands,
                sum.mergedIslands, sum.softIslands, sum.subSteps, sum.pieces, sum.candidates,
                sum.searchSeconds, sum.impactSeconds, sum.softSeconds, energy);
    return 0;
}
