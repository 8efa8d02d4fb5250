#include "islands/BoundPairs.hpp"

#include "core/forEach.hpp"

namespace elutria::dem
{

void BoundPairs::find(const std::vector<Bound>& bounds)
{
    const std::size_t n = bounds.size();
    centres_.resize(n), reach_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
    {
        centres_.set(i, settings_.box.wrapped(bounds[i].centre));
        reach_[i] = bounds[i].reach;
    }
    search_.find({n, centres_.x.data(), centres_.y.data(), centres_.z.data(), reach_.data()},
                 settings_.box, NeighbourSearch::automatic, 1,
                 threadsFor(n, settings_.threads), pairs_);
}

} // namespace elutria::dem
