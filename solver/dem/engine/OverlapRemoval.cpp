#include "engine/OverlapRemoval.hpp"

#include "parallel/Gathered.hpp"
#include "parallel/Message.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

namespace
{

constexpr int mostMoves = 100;
constexpr double clearance = 1e-9;           // of the overlap

/// One move out of every wall, and of every sphere if asked, that `i` overlaps, by half its radius
/// at most out of spheres: not through a wall; false when there was none.
bool moveOut(Particles& p, std::size_t i, const Walls& walls, const PeriodicBox& box, bool spheres)
{
    const Vector3 before = p.position[i];
    Vector3 place = walls.movedOut(before, p.radius[i]);
    Vector3 push;
    for (std::size_t j = 0; spheres && j < p.size(); ++j)
    {
        if (j == i) continue;
        const Vector3 apart = box.shortest(place - p.position[j]);
        const double sum = p.radius[i] + p.radius[j], distance2 = squaredNorm(apart);
        if (distance2 >= sum*sum) continue;
        const double distance = std::sqrt(distance2);
        const Vector3 direction = distance > 0 ? (1/distance)*apart : Vector3{0, 0, 1};
        push += (sum - distance)*(1 + clearance)*direction;
    }
    place += std::min(1.0, 0.5*p.radius[i]/std::max(norm(push), 1e-300))*push;
    p.position.set(i, box.wrapped(place));
    return squaredNorm(place - before) > 0;
}

} // namespace


void OverlapRemoval::place(Particles& particles, const Walls& walls, const PeriodicBox& box,
                           bool spheres, Exchange& exchange)
{
    struct Seen { std::uint64_t latest; bool none; };
    Seen all{latest_, particles.size() == 0};
    for (const std::uint64_t id : particles.id) all.latest = std::max(all.latest, id);
    for (const Seen& ofRank : shareEach(exchange, all))
    {
        all.latest = std::max(all.latest, ofRank.latest);
        all.none = all.none && ofRank.none;
    }
    const auto placeIn = [&](Particles& p)
    {
        for (std::size_t i = 0; i < p.size(); ++i)
            if (p.id[i] > latest_)
                for (int move = 0; move < mostMoves && moveOut(p, i, walls, box, spheres); ++move) {}
    };
    if (!first_ && all.latest > latest_)
    {
        if (spheres)
        {
            Gathered gathered(exchange, particles);
            if (gathered.here()) placeIn(gathered.everyone());
            gathered.giveBack();
        }
        else placeIn(particles);
    }
    latest_ = all.latest;
    first_ = first_ && all.none;
}

} // namespace elutria::dem
