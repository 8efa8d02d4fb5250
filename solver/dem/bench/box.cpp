// Spheres fall and settle in a box that is periodic sideways.
//   particles=25000 width=0.075 height=0.25 diameter=0.0025 step=1e-5 steps=20000 report=1000
//   law=hertz|linear young=1e7 poisson=0.35 restitution=0.9 friction=0.1 threads=1

#include "bench.hpp"
#include "laws/LawList.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

using namespace elutria::dem;

namespace
{

constexpr double pi = 3.14159265358979323846;

WallGeometry floorAndLid(double width, double height)
{
    WallGeometry g;
    for (double z : {0.0, height})
    {
        const auto k = std::uint32_t(g.points.size());
        g.points.insert(g.points.end(), {{0, 0, z}, {width, 0, z}, {width, width, z},
                                         {0, width, z}});
        g.triangles.push_back({k, k + 1, k + 2});
        g.triangles.push_back({k, k + 2, k + 3});
        g.material.insert(g.material.end(), 2, 0);
    }
    return g;
}

/// Spheres at random places of a jittered lattice that fills the box, falling at `speed`.
Particles fill(std::size_t count, double width, double height, double diameter, double speed)
{
    Particles p;
    std::mt19937_64 random(15485863);
    std::uniform_real_distribution<double> uniform(-0.5, 0.5);
    std::size_t across = 1, along = 1;
    while (across*across*along < count)
    {
        if (width/double(across + 1) < height/double(along)) ++along;
        else ++across;
    }
    const double dx = width/double(across), dz = (height - diameter)/double(along);
    std::vector<std::size_t> places(across*across*along);
    for (std::size_t k = 0; k < places.size(); ++k) places[k] = k;
    std::shuffle(places.begin(), places.end(), random);
    const double room = 0.98*(std::min(dx, dz) - diameter);
    if (room < 0) throw std::invalid_argument("the box is too small for its particles");
    for (std::size_t k = 0; k < count; ++k)
    {
        const std::size_t i = places[k] % across, j = places[k]/across % across,
                          l = places[k]/(across*across);
        p.id.push_back(k + 1);
        p.material.push_back(0);
        p.radius.push_back(diameter/2);
        p.mass.push_back(pi/6*diameter*diameter*diameter*2526);
        p.position.push_back({(double(i) + 0.5)*dx + room*uniform(random),
                              (double(j) + 0.5)*dx + room*uniform(random),
                              diameter/2 + (double(l) + 0.5)*dz + room*uniform(random)});
        p.velocity.push_back({0, 0, -speed});
        p.spin.push_back({});
    }
    p.acceleration.assign(count, {0, 0, -9.81});
    return p;
}

struct State
{
    double energy = 0, mean = 0, bed = 0;

    explicit State(const Particles& p)
    {
        std::vector<double> z(p.position.z);
        std::sort(z.begin(), z.end());
        bed = z[std::size_t(0.95*double(p.size()))];
        for (std::size_t i = 0; i < p.size(); ++i)
        {
            energy += 0.5*p.mass[i]*squaredNorm(p.velocity[i]);      // without spin
            mean += z[i]/double(p.size());
        }
    }
};

} // namespace

int runBox(const Options& o)
{
    const auto count = std::size_t(o.number("particles", 25000));
    const double width = o.number("width", 0.075*std::sqrt(double(count)/25000));
    const double height = o.number("height", 0.25), diameter = o.number("diameter", 0.0025);
    const double step = o.number("step", 1e-5);
    Settings settings;
    settings.law = o.text("law", "hertz") == "linear" ? &contactLaw<LinearSpringDashpot> : &contactLaw<HertzMindlin>;
    settings.treatment = ContactTreatment::soft;
    settings.search = searchNamed(o.text("search", "automatic"));
    settings.threads = unsigned(o.number("threads", 1));
    settings.step = step;
    settings.skin = o.number("skin", 0);
    settings.box = {{0, 0, 0}, {width, width, height}, {true, true, false}};
    ContactMaterials materials;
    materials.add({"grain", o.number("young", 1e7), o.number("poisson", 0.35)});
    PairProperties pair;
    pair.restitution = o.number("restitution", 0.9);
    pair.friction = o.number("friction", 0.1);
    materials.setPair(0, 0, pair);
    Engine engine(settings, materials, Walls(floorAndLid(width, height), settings.box));

    const double before = residentBytes();
    Particles p = fill(count, width, height, diameter, 0.1);
    const auto steps = std::size_t(o.number("steps", 20000));
    const auto report = std::size_t(o.number("report", 1000));
    for (std::size_t done = 0; done < steps;)
    {
        const std::size_t now = std::min(report, steps - done);
        const double start = seconds(), startProcessor = processorSeconds();
        const StepReport r = engine.advance(p, double(now)*step);
        const double took = seconds() - start, used = processorSeconds() - startProcessor;
        done += now;
        const State state(p);
        std::printf("{\"step\": %zu, \"time_s\": %.6g, \"wall_s\": %.6g, \"cpu_s\": %.6g, "
                    "\"us_per_particle_step\": %.5g, "
                    "\"cpu_us_per_particle_step\": %.5g, \"kinetic_energy_J\": %.17g, "
                    "\"mean_height_m\": %.17g, \"bed_height_m\": %.6g, \"coordination\": %.4g, "
                    "\"candidates_per_particle\": %.4g, \"list_builds\": %zu, "
                    "\"engine_bytes_per_particle\": %.4g, \"process_bytes_per_particle\": %.4g}\n",
                    done, double(done)*step, took, used, 1e6*took/double(now*count),
                    1e6*used/double(now*count), state.energy,
                    state.mean, state.bed + diameter/2, 2.0*double(r.touching)/double(count),
                    double(r.candidates)/double(count), r.listBuilds,
                    double(r.bytes)/double(count), (residentBytes() - before)/double(count));
        std::fflush(stdout);
    }
    return 0;
}
