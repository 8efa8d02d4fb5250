// What ranks are worth to contact steps: the scenes of tiledScene.hpp in blocks of equal size sideways,
// one for each rank. Ranks are threads of this process, with engines and memory of their own, and talk to
// each other in memory. One line of a csv table for each number of ranks, with the ratio to the fewest.
//   particles=100000,1000000 ranks=1,2,4,8,16 (as far as the cores go) scene=settled,falling
//   work=6e7 (particle-steps measured of settled spheres; ten times as many of falling ones)
//   spin=1 (while they wait for each other; 0: where there are fewer cores than ranks)
// States depend on the number of ranks by the order of sums, so that beside the checksum there is the
// energy.

#include "bench.hpp"
#include "parallel/ThreadRanks.hpp"
#include "tiledScene.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>

using namespace elutria::dem;

namespace
{

struct Timing
{
    double wall = 0, processor = 0, exchange = 0;        // s; that of the first rank in exchanges
    double energy = 0;                                   // J, kinetic, without spin
    std::size_t bytes = 0;                               // sent by the first rank
    std::uint64_t state = 0;
    StepReport report;
};

Timing measure(const BoxScene& scene, const Particles& all, unsigned ranks, bool spin,
               std::size_t warmup, std::size_t steps)
{
    std::vector<Particles> parts(ranks);
    Timing t;
    ThreadRanks(int(ranks), spin).run([&](Exchange& exchange)
    {
        const bool first = exchange.rank() == 0;
        Particles& own = parts[exchange.rank()];
        own = scene.ofRank(all, exchange);
        Engine engine(scene.settings(1), grain(1e7, 0.35, 0.9, 0.1), scene.walls(), exchange);
        engine.advance(own, double(warmup)*scene.step);
        exchange.share({});
        const Exchange::Traffic before = exchange.traffic();
        const double wall = seconds(), processor = processorSeconds();
        const StepReport report = engine.advance(own, double(steps)*scene.step);
        const Exchange::Traffic after = exchange.traffic();
        exchange.share({});
        if (!first) return;
        t.wall = seconds() - wall, t.processor = processorSeconds() - processor;
        t.exchange = after.seconds - before.seconds, t.bytes = after.bytes - before.bytes;
        t.report = report;
    });
    std::vector<std::pair<std::uint64_t, std::pair<unsigned, std::size_t>>> byId;
    for (unsigned r = 0; r < ranks; ++r)
        for (std::size_t i = 0; i < parts[r].size(); ++i) byId.push_back({parts[r].id[i], {r, i}});
    std::sort(byId.begin(), byId.end());
    Particles end;
    for (const auto& [id, place] : byId)
    {
        const Particles& p = parts[place.first];
        const std::size_t i = place.second;
        end.position.push_back(p.position[i]);
        end.velocity.push_back(p.velocity[i]);
        end.spin.push_back(p.spin[i]);
        t.energy += 0.5*p.mass[i]*squaredNorm(p.velocity[i]);
    }
    t.state = checksum(end);
    return t;
}

} // namespace

int runRanks(const Options& o)
{
    const bool spin = o.number("spin", 1) != 0;
    std::printf("scene,particles,ranks,steps,wall_us_per_particle_step,speed_up,"
                "processor_us_per_particle_step,processor_ratio,exchange_share,ghosts_per_rank,"
                "sent_bytes_per_step,list_builds,energy_J,state\n");
    Timing first;
    forRuns(o, "ranks", [&](const TiledRun& run)
    {
        const Timing t =
            measure(run.box, run.particles, run.number, spin, run.steps/5, run.steps);
        if (run.first) first = t;
        std::printf("%s,%zu,%u,%zu,%.5g,%.3f,%.5g,%.3f,%.3f,%.0f,%.4g,%zu,%.10g,%016llx\n",
                    run.name.c_str(), run.particles.size(), run.number, run.steps,
                    run.each(t.wall), first.wall/t.wall, run.each(t.processor),
                    t.processor/first.processor, t.exchange/t.wall,
                    double(t.report.ghosts)/run.number, double(t.bytes)/double(run.steps),
                    t.report.listBuilds, t.energy, static_cast<unsigned long long>(t.state));
        std::fflush(stdout);
    });
    return 0;
}
