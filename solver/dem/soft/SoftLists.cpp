// The soft integrator's neighbour list and near pairs: when they are made anew, and how wide.

#include "core/forEach.hpp"
#include "core/text.hpp"
#include "soft/SoftIntegrator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace elutria::dem
{

namespace
{

// Costs on an ordinary processor, ns; only their ratios matter.
constexpr double searchCost = 300;       // per particle and neighbour list
constexpr double lookCost = 4;           // per pair looked at for the near ones
constexpr double refreshCost = 15;       // per particle and choice of near pairs, besides
constexpr double pairCost = 6;           // per near pair and sub-step

} // namespace

/// Time between choices of near pairs, s: minimises their cost plus that of near pairs that do not
/// touch.
double SoftIntegrator::nearInterval() const
{
    const double each = double(candidates())/double(std::max<std::size_t>(1, cloud_.size()));
    const double way = step_*nearBuffer_.meanRate()/cloud_.mean;
    const double steps = std::sqrt((refreshCost + lookCost*each)
                                   /(2*pairCost*density_*std::max(way, 1e-9)));
    return step_*std::clamp(steps, 2.0, 2000.0);
}

/// Time between neighbour lists, s: minimises their cost plus that of listed pairs that are not near.
double SoftIntegrator::listInterval() const
{
    const double near = nearInterval();
    const double way = step_*listBuffer_.meanRate()/cloud_.mean;
    const double steps = std::sqrt(searchCost*near/step_
                                   /(2*lookCost*density_*std::max(way, 1e-9)));
    return std::clamp(step_*steps, 2*near, 1e5*step_);
}

/// Largest buffer of a particle in the list, m.
double SoftIntegrator::widestBuffer() const
{
    if (settings_.skin > 0) return 0.5*settings_.skin;
    if (searchesEveryStep()) return 0.025*cloud_.smallest;
    double most = 0.8*cloud_.mean;
    for (int a = 0; a < 3; ++a)
    {
        if (!settings_.box.periodic[a]) continue;
        const double length = settings_.box.high[a] - settings_.box.low[a];
        most = std::min(most, std::max(0.24*length - cloud_.largest, 0.01*cloud_.smallest));
    }
    return most;
}

/// The reference methods keep no list.
bool SoftIntegrator::searchesEveryStep() const
{
    return settings_.search == NeighbourSearch::bruteForce
           || settings_.search == NeighbourSearch::cells;
}

/// The shortest image must be the only one in reach.
void SoftIntegrator::checkBox() const
{
    const double reach = 2*(cloud_.largest + widestBuffer());
    for (int a = 0; a < 3; ++a)
    {
        const double length = settings_.box.high[a] - settings_.box.low[a];
        if (settings_.box.periodic[a] && length < 2*reach)
        {
            throw std::invalid_argument("periodic box is " + text(length) + " m wide in "
                + "xyz"[a] + "; allowed: at least " + text(2*reach)
                + " m, twice the reach of its largest particle");
        }
    }
}

/// Speeds and frames of the chunks as the particles are now.
void SoftIntegrator::measureMotion()
{
    motion_.resize(contacts_.chunks().all());
    forEach(settings_.threads, motion_.size(), [&](std::size_t c) { measureMotion(c); });
}

void SoftIntegrator::measureMotion(std::size_t chunk)
{
    const std::size_t begin = contacts_.chunks().begin(chunk), end = contacts_.chunks().end(chunk);
    ChunkMotion& m = motion_[chunk];
    Vector3 mean;
    double fastest2 = 0, inFrame2 = 0;
    for (std::size_t i = begin; i < end; ++i) mean += cloud_.velocity(i);
    m.frame = (1/double(end - begin))*mean;
    for (std::size_t i = begin; i < end; ++i)
    {
        fastest2 = std::max(fastest2, squaredNorm(cloud_.velocity(i)));
        inFrame2 = std::max(inFrame2, squaredNorm(cloud_.velocity(i) - m.frame));
    }
    m.speed = std::sqrt(inFrame2), m.wallSpeed = std::sqrt(fastest2);
}

void SoftIntegrator::rebuild()
{
    std::vector<LastingPair> pairs;
    std::vector<LastingWall> walls;
    if (valid_) pairs = contacts_.lasting(), walls = atWalls_.lasting();
    checkBox();
    std::vector<std::uint64_t> ghosts;
    for (std::size_t g = 0; g < halo_.size(); ++g) ghosts.push_back(halo_.id(g));
    cloud_.resizeGhosts(0);
    const Untouched<std::uint32_t> now = cloud_.sort(2*cloud_.mean);
    if (!exchange_.alone()) makeHalo();
    if (valid_)
    {
        rename(pairs, now, ghosts);
        for (LastingWall& w : walls) w.particle = now[w.particle];
        install(pairs, walls);
    }
    else
    {
        install();
    }
    valid_ = true;
    ++rebuilds_;
    measureMotion();
    grantBuffers(exchange_.alone() ? 0 : contacts_.chunks().count(), contacts_.chunks().all());
    neighbours_ = chunkNeighbours(cloud_, contacts_.chunks(), 6*widestBuffer());
    if (!exchange_.alone()) measureHalo(true);
    findNeighbours();
    selectNear();
    wallMargin_.resize(contacts_.chunks().count());
    forEach(settings_.threads, contacts_.chunks().count(), [&](std::size_t c) { refreshWalls(c); });
}

/// Buffers of these chunks for a new list.
void SoftIntegrator::grantBuffers(std::size_t from, std::size_t to)
{
    const Chunks& chunks = contacts_.chunks();
    const bool first = listBuffer_.chunks() != chunks.count();
    for (VerletBuffer* buffer : {&listBuffer_, &nearBuffer_})
    {
        buffer->resize(chunks);
        for (std::size_t c = from; c < to; ++c)
        {
            if (first || c >= chunks.count())
                buffer->expect(c, 0.5*motion_[c].speed
                                  + std::sqrt(0.2*cloud_.strongestPush*cloud_.mean));
        }
    }
    grantNear(from, to);
    const double most = widestBuffer(), interval = listInterval();
    const bool equal = settings_.skin > 0 || searchesEveryStep();
    forEach(settings_.threads, to - from, [&](std::size_t k)
    {
        const std::size_t c = from + k;
        if (equal) listBuffer_.grant(c, cloud_, most);
        else listBuffer_.grant(c, cloud_, motion_[c].frame, interval, 0, most, &nearBuffer_);
    });
    sinceList_ = 0;
}

void SoftIntegrator::grantNear(std::size_t from, std::size_t to)
{
    constexpr double least = 8;      // sub-steps of the fastest particle
    const double interval = nearInterval(), most = 0.5*widestBuffer();
    forEach(settings_.threads, to - from, [&](std::size_t k)
    {
        const std::size_t c = from + k;
        const ChunkMotion& m = motion_[c];
        nearBuffer_.grant(c, cloud_, m.frame, interval, least*m.speed*step_, most);
    });
    sinceNear_ = 0;
}

void SoftIntegrator::findNeighbours()
{
    if (cloud_.rows.empty())             // on this rank
    {
        list_.begin.assign(1, 0);
        list_.second.clear();
        return;
    }
    Untouched<double> reach(cloud_.rows.size());
    const auto sums = forBlocks(settings_.threads, reach.size(),
                                [&](std::size_t begin, std::size_t end)
    {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i)
        {
            reach[i] = cloud_.rows[i].radius + listBuffer_.of(i);
            sum += listBuffer_.of(i);
        }
        return sum;
    });
    const double widest = std::accumulate(sums.begin(), sums.end(), 0.0)/double(reach.size());
    const Row* rows = cloud_.rows.data();
    const Spheres spheres{reach.size(), &rows->x, &rows->y, &rows->z, reach.data(), 0,
                          sizeof(Row)/sizeof(double)};
    // not kept: most of the time its memory would lie idle
    PairSearch().find(spheres, cloud_.box, settings_.search, settings_.cellLayers,
                      settings_.threads, list_);
    density_ = std::max(0.2, double(candidates())/double(cloud_.size())
                             /(1 + 2*widest/cloud_.mean));
}

void SoftIntegrator::selectNear()
{
    forEach(settings_.threads, contacts_.chunks().count(), [&](std::size_t c)
    {
        contacts_.refresh(c, cloud_, list_, nearBuffer_);
    });
    contacts_.connect();
}

/// New near pairs; false if the list leaves no room for them.
bool SoftIntegrator::refresh()
{
    const std::size_t chunks = contacts_.chunks().all();
    forEach(settings_.threads, chunks, [&](std::size_t c) { nearBuffer_.measure(c, cloud_); });
    forEach(settings_.threads, chunks,
            [&](std::size_t c) { nearBuffer_.learn(c, sinceNear_, neighbours_); });
    measureMotion();
    grantNear(0, chunks);
    forEach(settings_.threads, chunks,
            [&](std::size_t c) { listBuffer_.measure(c, cloud_, &nearBuffer_); });
    if (!exchange_.alone()) measureHalo(false);
    if (listBuffer_.suffices(neighbours_, 2*widestBuffer()) && haloHasRoom())
    {
        selectNear();
        return true;
    }
    forEach(settings_.threads, chunks,
            [&](std::size_t c) { listBuffer_.learn(c, sinceList_, neighbours_); });
    return false;
}

void SoftIntegrator::refreshWalls(std::size_t chunk)
{
    const double margin = std::max(0.25*cloud_.mean, 8*motion_[chunk].wallSpeed*step_);
    wallMargin_[chunk] = atWalls_.refresh(chunk, cloud_, contacts_.chunks().begin(chunk),
                                          contacts_.chunks().end(chunk), margin);
    motion_[chunk].wallWay = 0;
}

/// The chunks whose near buffers may be consumed, or may be in the next step with `reserve`.
std::vector<std::uint32_t> SoftIntegrator::nearFailing(const std::vector<std::uint32_t>& among,
                                                       bool reserve) const
{
    std::vector<std::uint32_t> failing;
    for (const std::uint32_t c : among)
    {
        if (!nearBuffer_.suffices(c, neighbours_, reserve ? motion_[c].speed*step_ : 0))
            failing.push_back(c);
    }
    return failing;
}

/// True if the near pairs hold every pair that can touch; measures where the bounds do not suffice.
bool SoftIntegrator::nearSuffices()
{
    const double most = 2*widestBuffer();
    if (nearBuffer_.suffices(neighbours_, most)) return true;
    if (nearBuffer_.farthest() > most) return false;
    std::vector<std::uint32_t> chunks(motion_.size());
    std::iota(chunks.begin(), chunks.end(), 0u);
    const auto measure = [&](const std::vector<std::uint32_t>& which)
    {
        forEach(settings_.threads, which.size(),
                [&](std::size_t k) { nearBuffer_.measure(which[k], cloud_); });
    };
    chunks = nearFailing(chunks, false);
    measure(chunks);
    chunks = nearFailing(chunks, true);
    std::vector<std::uint32_t> around;
    for (const std::uint32_t c : chunks)
        around.insert(around.end(), neighbours_[c].begin(), neighbours_[c].end());
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    measure(around);
    return nearFailing(chunks, true).empty();
}

/// Refreshes or rebuilds lists that could miss a pair after the displacements so far.
void SoftIntegrator::ensureLists()
{
    bool wanted = !valid_ || searchesEveryStep();
    if (!wanted && !(nearSuffices() && haloSuffices())) wanted = !refresh();
    if (exchange_.alone() ? wanted : agreeOnList(wanted)) return rebuild();
    std::vector<std::uint32_t> nearWalls;
    for (std::uint32_t c = 0; c < contacts_.chunks().count(); ++c)
    {
        if (!(motion_[c].wallWay < wallMargin_[c])) nearWalls.push_back(c);
    }
    forEach(settings_.threads, nearWalls.size(), [&](std::size_t k) { refreshWalls(nearWalls[k]); });
}

} // namespace elutria::dem
