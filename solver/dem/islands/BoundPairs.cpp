#include "islands/BoundPairs.hpp"

#include "core/forEach.hpp"

namespace elutria::dem
{

Spheres BoundPairs::spheres(const std::vector<Bound>& bounds)
{
    const std::size_t n = bounds.size();
    centres_.resize(n), reach_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
    {
        centres_.set(i, settings_.box.wrapped(bounds[i].centre));
        reach_[i] = bounds[i].reach;
    }
    return {n, centres_.x.data(), centres_.y.data(), centres_.z.data(), reach_.data()};
}


void BoundPairs::find(const std::vector<Bound>& bounds)
{
    search_.find(spheres(bounds), settings_.box, NeighbourSearch::automatic, 1,
                 threadsFor(bounds.size(), settings_.threads), pairs_);
}


void BoundPairs::findWith(const std::vector<std::uint32_t>& asked,
                          const std::vector<Bound>& bounds)
{
    // a bound that is asked looks all around, one of all looks half around
    if (3*asked.size() > bounds.size()) return find(bounds);
    search_.findWith(asked, spheres(bounds), settings_.box,
                     threadsFor(bounds.size(), settings_.threads), pairs_);
}

} // namespace elutria::dem
