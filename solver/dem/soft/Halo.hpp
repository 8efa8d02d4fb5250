#pragma once

#include "core/ContactRecord.hpp"
#include "parallel/Exchange.hpp"
#include "parallel/Hull.hpp"
#include "soft/Chunks.hpp"
#include "soft/SoftCloud.hpp"

#include <utility>
#include <vector>

namespace elutria::dem
{

/// Ghosts of a rank: the particles of other ranks that could meet own ones before the lists are made
/// anew. Each rank moves its own particles and tells where they are; ghosts carry no forces.
class Halo
{
public:
    explicit Halo(Exchange& exchange) : exchange_(exchange) {}

    /// Chooses the ghosts anew and appends them to the cloud, whose own particles are sorted in
    /// `chunks`. Two particles may meet if the spheres around them touch; a particle's has the reach
    /// reach(i), m. With each ghost come the pairs in `history` (ascending) that it is the first of.
    /// All ranks call it.
    template<class Reach>
    void make(SoftCloud& cloud, const Chunks& chunks, const Reach& reach,
              const std::vector<ContactRecord>& history)
    {
        std::vector<Bound> bounds(cloud.size());
        for (std::size_t i = 0; i < bounds.size(); ++i)
            bounds[i] = {cloud.box.wrapped(cloud.position(i)), reach(i)};
        make(cloud, chunks, bounds, history);
    }
    void forget();

    /// Gets rows that hold what their ranks have now; incoming(k) is that of ghost k. All ranks call it.
    void fetch(const SoftCloud& cloud);
    const Row& incoming(std::size_t ghost) const { return incoming_[ghost]; }
    /// Gives the cloud what it does not keep of the ghosts while it takes its own particles anew.
    void fill(SoftCloud& cloud) const;

    std::size_t size() const { return ghosts_.size(); }
    std::uint64_t id(std::size_t ghost) const { return ghosts_[ghost].id; }
    /// Index among the ghosts, or SoftCloud::none.
    std::uint32_t find(std::uint64_t id) const;
    /// History that came with the ghosts.
    std::vector<ContactRecord> takeRecords() { return std::exchange(records_, {}); }

    /// True if a particle of another rank can be as near to the chunk's as `distance`, m.
    bool isNear(std::size_t chunk, double distance, const PeriodicBox& space) const;
    std::size_t bytes() const;

private:
    struct Ghost
    {
        std::uint64_t id;
        std::uint8_t material, weighted;
    };
    struct Sent
    {
        Row row;
        Ghost ghost;
    };
    void make(SoftCloud& cloud, const Chunks& chunks, const std::vector<Bound>& bounds,
              const std::vector<ContactRecord>& history);
    void announce(const std::vector<Bound>& bounds, const Chunks& chunks);
    void choose(const std::vector<Bound>& bounds, const Chunks& chunks, const PeriodicBox& space);
    void receive(SoftCloud& cloud, const std::vector<Bytes>& messages);

    Exchange& exchange_;
    std::vector<Hull> hulls_;                           // of each rank, around what it may meet
    std::vector<Hull::Box> extents_;                    // of the chunks, around the same
    std::vector<std::vector<std::uint32_t>> sent_;      // to each rank: own particles
    std::vector<Exchange::Partner> partners_;
    std::vector<Ghost> ghosts_;                         // by rank, there in the order sent
    std::vector<std::pair<std::uint64_t, std::uint32_t>> byId_;
    std::vector<ContactRecord> records_;
    Untouched<Row> incoming_;
};

} // namespace elutria::dem
