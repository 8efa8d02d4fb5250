// Spheres fall and settle in a box that is periodic sideways.
//   particles=25000 width=0.075 height=0.25 diameter=0.0025 step=1e-5 steps=20000 report=1000
//   law=hertz|linear young=1e7 poisson=0.35 restitution=0.9 friction=0.1 threads=1
//   ranks=1 (threads that talk to each other in memory, as in ranks.cpp)

#include "bench.hpp"
#include "boxScene.hpp"
#include "laws/LawList.hpp"
#include "parallel/Message.hpp"
#include "parallel/ThreadRanks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

using namespace elutria::dem;

namespace
{

/// Of the particles of all ranks.
struct State
{
    double energy = 0, mean = 0, bed = 0;

    State(const Particles& own, Exchange& exchange)
    {
        for (std::size_t i = 0; i < own.size(); ++i)
            energy += 0.5*own.mass[i]*squaredNorm(own.velocity[i]);      // without spin
        double all = 0;
        for (const double ofRank : shareEach(exchange, energy)) all += ofRank;
        energy = all;
        std::vector<double> z = joined(shareEach(exchange, std::vector<double>(own.position.z)));
        std::sort(z.begin(), z.end());
        bed = z[std::size_t(0.95*double(z.size()))];
        for (const double height : z) mean += height/double(z.size());
    }
};

} // namespace

int runBox(const Options& o)
{
    const auto count = std::size_t(o.number("particles", 25000));
    BoxScene scene;
    scene.width = scene.depth = o.number("width", 0.075*std::sqrt(double(count)/25000));
    scene.height = o.number("height", 0.25);
    const double diameter = o.number("diameter", 0.0025), step = o.number("step", 1e-5);
    scene.step = step;
    Settings settings = scene.settings(unsigned(o.number("threads", 1)));
    if (o.text("law", "hertz") == "linear") settings.law = &contactLaw<LinearSpringDashpot>;
    settings.search = searchNamed(o.text("search", "automatic"));
    settings.skin = o.number("skin", 0);
    const auto steps = std::size_t(o.number("steps", 20000));
    const auto report = std::size_t(o.number("report", 1000));
    const Particles all = scene.fill(count, diameter, 0.1);
    const double before = residentBytes();
    ThreadRanks(int(o.number("ranks", 1)), true).run([&](Exchange& exchange)
    {
        Engine engine(settings,
                      grain(o.number("young", 1e7), o.number("poisson", 0.35),
                            o.number("restitution", 0.9), o.number("friction", 0.1)),
                      scene.walls(), exchange);
        Particles own = scene.ofRank(all, exchange);
        for (std::size_t done = 0; done < steps;)
        {
            const std::size_t now = std::min(report, steps - done);
            const double start = seconds(), startProcessor = processorSeconds();
            const StepReport r = engine.advance(own, double(now)*step);
            const double took = seconds() - start, used = processorSeconds() - startProcessor;
            done += now;
            const State state(own, exchange);
            if (exchange.rank() > 0) continue;
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
    });
    return 0;
}
