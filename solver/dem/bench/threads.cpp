// What threads are worth to contact steps: spheres of 2.5 mm in a box that is periodic sideways, falling
// through it or settled in it, Hertz's law. One line of a csv table for each number of threads, with the
// ratios to the fewest and a checksum of the state, which must not depend on the number.
//   particles=100000,1000000 threads=1,2,4,8,16 (as far as the cores go) scene=settled,falling
//   work=6e7 (particle-steps measured of settled spheres; ten times as many of falling ones)

#include "bench.hpp"
#include "tiledScene.hpp"

#include <cstdio>
#include <stdexcept>

using namespace elutria::dem;

namespace
{

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
    std::printf("scene,particles,threads,steps,wall_us_per_particle_step,speed_up,"
                "processor_us_per_particle_step,processor_ratio,coordination,list_builds,"
                "engine_bytes_per_particle,state\n");
    bool same = true;
    Timing first;
    forRuns(o, "threads", [&](const TiledRun& run)
    {
        const auto spheres = double(run.particles.size());
        const Timing t = measure(run.box, run.particles, run.number, run.steps/5, run.steps);
        if (run.first) first = t;
        same = same && t.state == first.state;
        std::printf("%s,%zu,%u,%zu,%.5g,%.3f,%.5g,%.3f,%.4g,%zu,%.4g,%016llx\n", run.name.c_str(),
                    run.particles.size(), run.number, run.steps, run.each(t.wall),
                    first.wall/t.wall, run.each(t.processor), t.processor/first.processor,
                    2.0*double(t.report.touching)/spheres, t.report.listBuilds,
                    double(t.report.bytes)/spheres, static_cast<unsigned long long>(t.state));
        std::fflush(stdout);
    });
    if (!same) throw std::runtime_error("the state depends on the number of threads");
    return 0;
}
