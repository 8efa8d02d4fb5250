#pragma once

#include "laws/ContactLaw.hpp"
#include "laws/HertzMindlin.hpp"
#include "laws/LinearSpringDashpot.hpp"
#include "laws/SpringSliderDashpot.hpp"

#include <cstddef>
#include <string_view>

namespace elutria::dem
{

template<class... Laws>
struct LawList
{
    static constexpr std::size_t size = sizeof...(Laws);
    static constexpr const ContactLaw* laws[size] = {&contactLaw<Laws>...};

    /// The place of the law with this name; `size` if there is none.
    static constexpr std::size_t find(std::string_view name)
    {
        std::size_t place = 0;
        while (place < size && name != laws[place]->name) ++place;
        return place;
    }
};

/// The laws that dictionaries may name and for which the soft integrator has vector kernels. Any
/// other law that Settings hold works too, one contact at a time.
using ContactLaws = LawList<HertzMindlin, LinearSpringDashpot, SpringSliderDashpot,
                            SpringSliderDashpotOfAnyExponent>;

} // namespace elutria::dem
