#include "soft/VerletBuffer.hpp"

#include "core/forEach.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

ChunkNeighbours chunkNeighbours(const SoftCloud& cloud, const Chunks& chunks, double reach)
{
    struct Extent
    {
        Vector3 middle, half;
    };
    std::vector<Extent> extents(chunks.all());
    forEach(cloud.threads, chunks.all(), [&](std::size_t c)
    {
        Vector3 low{1e300, 1e300, 1e300}, high = -low;
        for (std::size_t i = chunks.begin(c); i < chunks.end(c); ++i)
        {
            const Vector3 x = cloud.position(i);
            const double r = cloud.rows[i].radius;
            for (int a = 0; a < 3; ++a)
            {
                low[a] = std::min(low[a], x[a] - r), high[a] = std::max(high[a], x[a] + r);
            }
        }
        extents[c] = {0.5*(low + high), 0.5*(high - low)};
    });
    ChunkNeighbours neighbours(chunks.all());
    forEach(cloud.threads, chunks.all(), [&](std::size_t c)
    {
        for (std::uint32_t d = 0; d < chunks.all(); ++d)
        {
            const Vector3 apart = cloud.box.shortest(extents[c].middle - extents[d].middle);
            bool near = d != c;
            for (int a = 0; a < 3; ++a)
            {
                near = near && std::abs(apart[a]) < extents[c].half[a] + extents[d].half[a] + reach;
            }
            if (near) neighbours[c].push_back(d);
        }
    });
    return neighbours;
}

void VerletBuffer::resize(const Chunks& chunks)
{
    runs_ = chunks;
    chunks_.resize(chunks.all());
    anchors_.resize(chunks.particles() + chunks.ghosts());
}

void VerletBuffer::expect(std::size_t c, double rate)
{
    chunks_[c].rate = chunks_[c].meanRate = rate;
}

void VerletBuffer::learn(std::size_t c, double elapsed, const ChunkNeighbours& neighbours)
{
    if (!(elapsed > 0)) return;
    Chunk& chunk = chunks_[c];
    double apart = 0;
    for (std::uint32_t n : neighbours[c]) apart = std::max(apart, norm(chunk.shift - chunks_[n].shift));
    const double used = std::max(0.0, chunk.share - chunk.left) + 0.5*apart;
    chunk.rate = std::max(0.8*chunk.rate, used/elapsed);
    chunk.meanRate = chunk.rate + chunk.meanWay/elapsed;
}

double VerletBuffer::meanRate() const
{
    double sum = 0;
    for (const Chunk& chunk : chunks_) sum += chunk.meanRate;
    return chunks_.empty() ? 0 : sum/double(chunks_.size());
}

/// Remembers where the particles are.
void VerletBuffer::anchor(std::size_t c, const SoftCloud& cloud)
{
    Chunk& chunk = chunks_[c];
    chunk.origin = cloud.position(begin(c));
    chunk.shift = {};
    chunk.way = chunk.meanWay = 0;
    float largest = 0;
    for (std::size_t i = begin(c); i < end(c); ++i)
    {
        const Vector3 x = cloud.position(i) - chunk.origin;
        Anchor& a = anchors_[i];
        a.x = float(x.x), a.y = float(x.y), a.z = float(x.z);
        largest = std::max({largest, std::abs(a.x), std::abs(a.y), std::abs(a.z)});
    }
    chunk.rounding = 1.2e-7*largest;
}

void VerletBuffer::grant(std::size_t c, const SoftCloud& cloud, const Vector3& frame, double interval,
                   double least, double most, const VerletBuffer* others)
{
    anchor(c, cloud);
    Chunk& chunk = chunks_[c];
    chunk.share = 1.2*chunk.rate*interval + least + 2e-3*cloud.smallest + chunk.rounding;
    chunk.share = std::min(chunk.share, 0.7*most);
    chunk.left = 1e300;
    for (std::size_t i = begin(c); i < end(c); ++i)
    {
        const double own = interval*norm(cloud.velocity(i) - frame);
        const float least = others ? 2*others->anchors_[i].buffer : 0;
        anchors_[i].buffer = std::max(float(std::min(chunk.share + own, most)), least);
        chunk.left = std::min(chunk.left, double(anchors_[i].buffer));
    }
}

void VerletBuffer::grant(std::size_t c, const SoftCloud& cloud, double equal)
{
    anchor(c, cloud);
    chunks_[c].share = chunks_[c].left = equal;
    for (std::size_t i = begin(c); i < end(c); ++i) anchors_[i].buffer = float(equal);
}

void VerletBuffer::use(std::size_t c, double way, const Vector3& shift)
{
    Chunk& chunk = chunks_[c];
    chunk.way += way;
    chunk.left -= way;
    chunk.shift += shift;
}

void VerletBuffer::measure(std::size_t c, const SoftCloud& cloud, const VerletBuffer* others)
{
    Chunk& chunk = chunks_[c];
    const bool wraps = cloud.box.any();
    const auto gone = [&](std::size_t i)
    {
        const Anchor& a = anchors_[i];
        const Vector3 way = cloud.position(i) - chunk.origin - Vector3{a.x, a.y, a.z};
        return wraps ? cloud.box.shortest(way) : way;
    };
    Vector3 mean;
    for (std::size_t i = begin(c); i < end(c); ++i) mean += gone(i);
    mean *= 1/double(end(c) - begin(c));
    chunk.left = 1e300;
    chunk.way = chunk.meanWay = 0;
    for (std::size_t i = begin(c); i < end(c); ++i)
    {
        const double way = norm(gone(i) - mean);
        const double aside = others ? others->anchors_[i].buffer : 0;
        chunk.left = std::min(chunk.left, anchors_[i].buffer - way - aside);
        chunk.way = std::max(chunk.way, way);
        chunk.meanWay += way;
    }
    chunk.left -= chunk.rounding;
    chunk.meanWay /= double(end(c) - begin(c));
    chunk.shift = mean;
}

bool VerletBuffer::suffices(std::size_t c, const ChunkNeighbours& neighbours, double reserve) const
{
    const Chunk& chunk = chunks_[c];
    bool enough = 2*chunk.left >= reserve;
    for (std::uint32_t n : neighbours[c])
    {
        enough = enough && chunk.left + chunks_[n].left
                           >= reserve + norm(chunk.shift - chunks_[n].shift);
    }
    return enough;
}

double VerletBuffer::farthest() const
{
    double most = 0;
    for (const Chunk& chunk : chunks_)
    {
        most = std::max(most, chunk.way + norm(chunk.shift - chunks_[0].shift));
    }
    return 2*most;
}

/// True only if all suffice: without a look at pairs of chunks.
bool VerletBuffer::surelySuffices(double most) const
{
    Vector3 middle;
    for (const Chunk& chunk : chunks_) middle += chunk.shift;
    middle *= 1/double(chunks_.size());
    const double first = norm(chunks_[0].shift - middle);
    bool enough = true;
    for (const Chunk& chunk : chunks_)
    {
        const double apart = norm(chunk.shift - middle);
        enough = enough && chunk.left >= apart && 2*(chunk.way + apart + first) < most;
    }
    return enough;
}

bool VerletBuffer::suffices(const ChunkNeighbours& neighbours, double most) const
{
    if (chunks_.empty() || surelySuffices(most)) return true;
    bool enough = farthest() < most;
    for (std::size_t c = 0; enough && c < chunks_.size(); ++c) enough = suffices(c, neighbours);
    return enough;
}

std::size_t VerletBuffer::bytes() const
{
    return chunks_.capacity()*sizeof(Chunk) + anchors_.capacity()*sizeof(Anchor);
}

} // namespace elutria::dem
