#include "islands/OverlapSeparation.hpp"

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

} // namespace elutria::dem
