#pragma once

#include <algorithm>
#include <cstddef>

namespace elutria::dem
{

/// Equal runs of particles in the cloud's order, each worked on by one thread at a time. How many there
/// are follows from the number of particles alone, so that results do not depend on threads; where
/// particles are many, numbers of threads that divide 16 get equally many chunks. Behind them, in chunks
/// of their own, are the ghosts: particles of other ranks.
class Chunks
{
public:
    explicit Chunks(std::size_t particles = 0, std::size_t ghosts = 0)
      : particles_(particles), ghosts_(ghosts)
    {
        std::size_t wanted = (particles + most - 1)/most;
        for (const std::size_t equal : {16, 4})
        {
            if (particles < equal*least) continue;
            wanted = (wanted + equal - 1)/equal*equal;
            break;
        }
        size_ = std::max<std::size_t>(1, wanted == 0 ? 1 : (particles + wanted - 1)/wanted);
        count_ = (particles + size_ - 1)/size_;
    }

    /// Chunks of particles; those of ghosts follow up to all().
    std::size_t count() const { return count_; }
    std::size_t all() const { return count_ + (ghosts_ + ofGhosts - 1)/ofGhosts; }
    std::size_t begin(std::size_t chunk) const
    {
        return chunk < count_ ? chunk*size_ : particles_ + (chunk - count_)*ofGhosts;
    }
    std::size_t end(std::size_t chunk) const
    {
        return chunk < count_ ? std::min(particles_, (chunk + 1)*size_)
                              : particles_ + std::min(ghosts_, (chunk + 1 - count_)*ofGhosts);
    }
    /// Of a particle that is no ghost.
    std::size_t of(std::size_t particle) const { return particle/size_; }
    std::size_t particles() const { return particles_; }
    std::size_t ghosts() const { return ghosts_; }

private:
    static constexpr std::size_t least = 1024, most = 2048;      // particles of a chunk
    static constexpr std::size_t ofGhosts = 256;                 // in a chunk of them

    std::size_t particles_, ghosts_, size_, count_;
};

} // namespace elutria::dem
