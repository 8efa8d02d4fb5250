#include "Drift.hpp"

#include <algorithm>
#include <cmath>

namespace elutria::dem
{

void Drift::reset(const PairList& list, std::size_t particles, std::size_t chunkSize)
{
    const std::size_t count = (particles + chunkSize - 1)/chunkSize;
    chunks_.resize(count);
    std::vector<std::uint32_t> seenBy(count, 0xffffffffu);
    for (std::uint32_t c = 0; c < count; ++c)
    {
        Chunk& chunk = chunks_[c];
        chunk.shift = {};
        chunk.way = chunk.wallWay = 0;
        chunk.neighbours.clear();
        const std::size_t end = std::min(particles, (c + 1)*chunkSize);
        for (std::uint32_t k = list.begin[c*chunkSize]; k < list.begin[end]; ++k)
        {
            const auto other = std::uint32_t(list.second[k]/chunkSize);
            if (other == c || seenBy[other] == c) continue;
            seenBy[other] = c;
            chunk.neighbours.push_back(other);
        }
    }
    for (std::size_t c = 0; c < count; ++c) mark(c);
}

void Drift::add(std::size_t c, const MoveWork& work)
{
    Chunk& chunk = chunks_[c];
    chunk.speed = std::sqrt(work.fastestInFrame);
    chunk.wallSpeed = std::sqrt(work.fastest);
    chunk.way += chunk.speed*work.step;
    chunk.wallWay += chunk.wallSpeed*work.step;
    chunk.shift += work.step*chunk.frame;
    chunk.frame = (1/double(work.end - work.begin))*Vector3{work.sum[0], work.sum[1], work.sum[2]};
}

void Drift::add(double way)
{
    for (Chunk& chunk : chunks_) chunk.way += way, chunk.wallWay += way;
}

double Drift::sinceReset(std::size_t c) const
{
    const Chunk& chunk = chunks_[c];
    double most = 2*chunk.way;
    for (std::uint32_t n : chunk.neighbours)
    {
        const Chunk& other = chunks_[n];
        most = std::max(most, chunk.way + other.way + norm(chunk.shift - other.shift));
    }
    return most;
}

double Drift::sinceMark(std::size_t c) const
{
    const Chunk& chunk = chunks_[c];
    const double way = chunk.way - chunk.marks[0].way;
    const Vector3 shift = chunk.shift - chunk.marks[0].shift;
    double most = 2*way;
    for (std::size_t k = 0; k < chunk.neighbours.size(); ++k)
    {
        const Chunk& other = chunks_[chunk.neighbours[k]];
        const Mark& mark = chunk.marks[k + 1];
        most = std::max(most, way + other.way - mark.way
                              + norm(shift - (other.shift - mark.shift)));
    }
    return most;
}

void Drift::mark(std::size_t c)
{
    Chunk& chunk = chunks_[c];
    chunk.marks.clear();
    chunk.marks.push_back({chunk.way, chunk.shift});
    for (std::uint32_t n : chunk.neighbours) chunk.marks.push_back({chunks_[n].way, chunks_[n].shift});
}

double Drift::speed() const
{
    double fastest = 0;
    for (const Chunk& chunk : chunks_) fastest = std::max(fastest, chunk.speed);
    return fastest;
}

std::size_t Drift::bytes() const
{
    std::size_t sum = chunks_.capacity()*sizeof(Chunk);
    for (const Chunk& c : chunks_)
    {
        sum += 4*c.neighbours.capacity() + c.marks.capacity()*sizeof(Mark);
    }
    return sum;
}

} // namespace elutria::dem
