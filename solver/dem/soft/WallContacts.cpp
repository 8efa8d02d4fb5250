#include "soft/WallContacts.hpp"

#include <algorithm>

namespace elutria::dem
{

WallContacts::WallContacts(const LawTable& laws, const Walls& walls) : laws_(laws), walls_(walls) {}

void WallContacts::reset(const Chunks& chunks, const std::vector<LastingWall>& lasting)
{
    chunks_.resize(chunks.count());
    for (Chunk& chunk : chunks_) chunk.count = 0;
    for (const LastingWall& l : lasting)
    {
        Chunk& chunk = chunks_[chunks.of(l.particle)];
        if (chunk.count == 0 || chunk.current[chunk.count - 1].particle != l.particle)
        {
            if (chunk.current.size() <= chunk.count) chunk.current.emplace_back();
            Candidate& added = chunk.current[chunk.count++];
            added.particle = l.particle;
            added.memories.clear();
        }
        chunk.current[chunk.count - 1].memories.push_back({l.feature, {l.displacement, true}});
    }
}

double WallContacts::refresh(std::size_t index, const SoftCloud& cloud, std::size_t begin,
                          std::size_t end, double margin)
{
    if (walls_.empty()) return 1e300;
    Chunk& chunk = chunks_[index];
    double nearest = 1e300;
    std::size_t made = 0, old = 0;
    for (std::size_t i = begin; i < end; ++i)
    {
        const double reach = cloud.rows[i].radius + margin;
        const Vector3 position = cloud.position(i);
        const double bound = walls_.distanceBound(position);
        if (bound > reach)
        {
            nearest = std::min(nearest, bound - cloud.rows[i].radius);
            continue;
        }
        if (chunk.next.size() <= made) chunk.next.emplace_back();
        Candidate& candidate = chunk.next[made];
        walls_.collect(position, reach, candidate.images);
        nearest = margin;
        if (candidate.images.empty()) continue;
        candidate.particle = std::uint32_t(i);
        candidate.flat = walls_.isFlat(position, margin, candidate.images);
        candidate.below = 0;
        candidate.memories.clear();
        while (old < chunk.count && chunk.current[old].particle < i) ++old;
        if (old < chunk.count && chunk.current[old].particle == i)
        {
            candidate.memories.swap(chunk.current[old].memories);
        }
        ++made;
    }
    chunk.current.swap(chunk.next);
    chunk.count = made;
    chunk.margin = margin;
    return std::max(margin, nearest);
}

void WallContacts::evaluate(std::size_t index, SoftCloud& cloud, StepWeights weights, double time)
{
    if (walls_.empty()) return;
    Chunk& chunk = chunks_[index];
    const ContactLaw& law = laws_.law();
    for (std::size_t k = 0; k < chunk.count; ++k)
    {
        Candidate& candidate = chunk.current[k];
        const std::uint32_t i = candidate.particle;
        const Row& row = cloud.rows[i];
        const double reach = candidate.memories.empty() ? 0 : chunk.margin;
        const Vector3 position = cloud.position(i);
        if (candidate.flat)
        {
            walls_.contactsOnFlat(position, row.radius, reach, candidate.images,
                                  candidate.below, chunk.found);
        }
        else
        {
            walls_.contacts(position, row.radius, reach, candidate.images, chunk.found);
        }
        if (chunk.found.empty() && candidate.memories.empty()) continue;
        Load& load = cloud.loads[i];
        chunk.kept.clear();
        for (const WallContact& wall : chunk.found)
        {
            ContactHistory history;
            for (const Memory& memory : candidate.memories)
            {
                if (memory.first == wall.feature) history = memory.second;
            }
            if (wall.gap >= 0 && !history.touching) continue;
            const bool begins = !history.touching;
            const double share = (row.radius + wall.gap)/row.radius;
            const Vector3 velocity =
                cloud.frame + Vector3{row.vx, row.vy, row.vz} - wall.velocity;
            Encounter e;
            e.normal = wall.normal;
            e.overlap = -wall.gap;
            e.slip = velocity - share*cross(Vector3{row.sx, row.sy, row.sz}, e.normal);
            e.radius = row.radius;
            e.mass = 1/cloud.bases[i].inverseMass;
            const laws::Coefficients& c = laws_(cloud.material(i), wall.material);
            const ContactForce f = law.force(c, e, history, weights);
            const Vector3 force = f.normal*e.normal + f.tangential;
            Vector3 moment = -share*cross(e.normal, f.tangential);
            if (c.rolling > 0)
            {
                const Vector3 spin = (1/row.radius)*Vector3{row.sx, row.sy, row.sz};
                moment += (1/row.radius)*rollingTorque(c, f.elastic, e.radius,
                    0.4*e.mass*row.radius*row.radius, spin, weights);
            }
            load.fx += force.x, load.fy += force.y, load.fz += force.z;
            load.mx += moment.x, load.my += moment.y, load.mz += moment.z;
            if (history.touching) chunk.kept.push_back({wall.feature, history});
            if (begins && walls_.answer(wall.triangle) != WallAnswer::silent)
                chunk.hits.push_back({cloud.id(i), wall.triangle, walls_.answer(wall.triangle), time,
                                      position, velocity + wall.velocity, wall.normal});
            chunk.largestOverlap = std::max(chunk.largestOverlap, e.overlap/row.radius);
        }
        candidate.memories.assign(chunk.kept.begin(), chunk.kept.end());
    }
}

double WallContacts::takeLargestOverlap()
{
    double largest = 0;
    for (Chunk& chunk : chunks_)
    {
        largest = std::max(largest, chunk.largestOverlap);
        chunk.largestOverlap = 0;
    }
    return largest;
}

std::vector<WallHit> WallContacts::takeHits()
{
    std::vector<WallHit> all;
    for (Chunk& chunk : chunks_)
    {
        all.insert(all.end(), chunk.hits.begin(), chunk.hits.end());
        chunk.hits.clear();
    }
    sortHits(all);
    return all;
}

std::vector<LastingWall> WallContacts::lasting() const
{
    std::vector<LastingWall> all;
    for (const Chunk& chunk : chunks_)
    {
        for (std::size_t k = 0; k < chunk.count; ++k)
        {
            for (const auto& [feature, history] : chunk.current[k].memories)
            {
                all.push_back({chunk.current[k].particle, feature, history.displacement});
            }
        }
    }
    return all;
}

std::size_t WallContacts::touching() const
{
    std::size_t count = 0;
    for (const Chunk& chunk : chunks_)
    {
        for (std::size_t k = 0; k < chunk.count; ++k) count += chunk.current[k].memories.size();
    }
    return count;
}

std::size_t WallContacts::bytes() const
{
    std::size_t sum = 0;
    for (const Chunk& chunk : chunks_)
    {
        for (const auto* list : {&chunk.current, &chunk.next})
        {
            sum += list->capacity()*sizeof(Candidate);
            for (const Candidate& c : *list)
            {
                sum += c.images.capacity()*sizeof(Walls::Image)
                       + c.memories.capacity()*sizeof(Memory);
            }
        }
    }
    return sum;
}

} // namespace elutria::dem
