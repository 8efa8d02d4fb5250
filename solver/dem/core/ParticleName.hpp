#pragma once

#include <cstdint>

namespace elutria::dem
{

/// What a particle is called in the whole run: where it is from (a processor, or the feed) and its
/// number there. As 64 bits it is the particle's id.
struct ParticleName
{
    std::uint32_t origin, number;

    constexpr ParticleName(std::uint32_t from, std::uint32_t numbered)
        : origin(from), number(numbered)
    {}

    explicit constexpr ParticleName(std::uint64_t id)
        : origin(std::uint32_t(id >> 32)), number(std::uint32_t(id))
    {}

    constexpr std::uint64_t id() const { return std::uint64_t(origin) << 32 | number; }
};

} // namespace elutria::dem
