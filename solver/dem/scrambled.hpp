#pragma once

#include <cstdint>

namespace elutria::dem
{

/// Another number for every number, with no pattern left: Stafford's variant 13 of the
/// MurmurHash3 finaliser, http://zimbry.blogspot.com/2011/09/better-bit-mixing-improving-on.html
inline std::uint64_t scrambled(std::uint64_t z)
{
    z = (z ^ (z >> 30))*0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27))*0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

} // namespace elutria::dem
