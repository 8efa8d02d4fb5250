#pragma once

#include "core/Particles.hpp"
#include "impacts/ParticleState.hpp"
#include "laws/Settings.hpp"
#include "neighbours/PairSearch.hpp"

#include <vector>

namespace elutria::dem
{

/// Finds the pairs of overlapping bounds.
class BoundPairs
{
public:
    explicit BoundPairs(const Settings& settings) : settings_(settings) {}

    void find(const std::vector<Bound>& bounds);

    /// At least the pairs of the bounds `asked` with each other and all others.
    void findWith(const std::vector<std::uint32_t>& asked, const std::vector<Bound>& bounds);

    std::size_t size() const { return pairs_.size(); }

    /// Calls visit(i, j), i < j, for every pair, ascending.
    template<class Visit>
    void forEach(const Visit& visit) const
    {
        for (std::uint32_t i = 0; i + 1 < pairs_.begin.size(); ++i)
            for (std::uint32_t k = pairs_.begin[i]; k < pairs_.begin[i + 1]; ++k)
                visit(i, pairs_.second[k]);
    }

private:
    Spheres spheres(const std::vector<Bound>& bounds);

    const Settings& settings_;
    PairSearch search_;
    PairList pairs_;
    VectorArray centres_;
    std::vector<double> reach_;
};

} // namespace elutria::dem
