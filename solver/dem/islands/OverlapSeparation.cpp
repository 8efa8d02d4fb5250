#include "islands/OverlapSeparation.hpp"

#include "parallel/Message.hpp"

#include <algorithm>

namespace elutria::dem
{

void separate(std::vector<ParticleState>& particles, const std::vector<Overlap>& overlaps,
              const Walls& walls, const PeriodicBox& box)
{
    constexpr int sweeps = 20;
    const auto moveOutOfWalls = [&](ParticleState& p)
    {
        p.flight.position = walls.movedOut(p.flight.position, p.radius);
    };
    for (int sweep = 0; sweep < sweeps; ++sweep)
        for (const Overlap& overlap : overlaps)
        {
            ParticleState& a = particles[overlap.first];
            moveOutOfWalls(a);
            if (overlap.second == Overlap::wall) continue;
            ParticleState& b = particles[overlap.second];
            moveOutOfWalls(b);
            Vector3 apart = box.shortest(a.flight.position - b.flight.position);
            const double distance = norm(apart), sum = a.radius + b.radius;
            if (distance >= sum) continue;
            apart = distance > 0 ? (1/distance)*apart : Vector3{0, 0, 1};
            const double move = 0.5*(sum - distance)*(1 + 1e-9);
            a.flight.position += std::min(move, 0.5*a.radius)*apart;
            b.flight.position -= std::min(move, 0.5*b.radius)*apart;
        }
    for (const Overlap& overlap : overlaps)
    {
        moveOutOfWalls(particles[overlap.first]);
        if (overlap.second != Overlap::wall) moveOutOfWalls(particles[overlap.second]);
    }
}


OverlapsOfAll overlapsOfAll(Exchange& exchange, const std::vector<ParticleState>& states,
                            std::size_t own, const std::vector<Overlap>& overlaps)
{
    struct Found { std::uint64_t first, second; bool wall; };
    const auto before = [](const Found& a, const Found& b)
    {
        if (a.wall != b.wall) return b.wall;
        return a.first != b.first ? a.first < b.first : a.second < b.second;
    };
    std::vector<Found> found;
    std::vector<ParticleState> mine;
    for (const Overlap& overlap : overlaps)
    {
        const bool wall = overlap.second == Overlap::wall;
        found.push_back({states[overlap.first].id, wall ? 0 : states[overlap.second].id, wall});
        for (const std::uint32_t i : {overlap.first, overlap.second})
            if (i < own) mine.push_back(states[i]);
    }
    found = joined(shareEach(exchange, found));
    OverlapsOfAll all;
    if (found.empty()) return all;
    std::sort(found.begin(), found.end(), before);
    found.erase(std::unique(found.begin(), found.end(), [&](const Found& a, const Found& b)
                            { return !before(a, b) && !before(b, a); }), found.end());

    all.particles = joined(shareEach(exchange, mine));
    std::sort(all.particles.begin(), all.particles.end(),
              [](const ParticleState& a, const ParticleState& b) { return a.id < b.id; });
    all.particles.erase(std::unique(all.particles.begin(), all.particles.end(),
                                    [](const ParticleState& a, const ParticleState& b)
                                    { return a.id == b.id; }), all.particles.end());
    const auto place = [&](std::uint64_t id)
    {
        return std::uint32_t(std::lower_bound(all.particles.begin(), all.particles.end(), id,
            [](const ParticleState& s, std::uint64_t i) { return s.id < i; })
            - all.particles.begin());
    };
    for (const Found& f : found)
        all.overlaps.push_back({place(f.first), f.wall ? Overlap::wall : place(f.second)});
    return all;
}

} // namespace elutria::dem
