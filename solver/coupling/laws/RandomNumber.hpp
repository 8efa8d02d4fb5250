// Random numbers of a key: any one is known without those before it.
#pragma once

#include <cstdint>

namespace elutria::laws
{

/// Scrambles 64 bits: Stafford's variant 13 of the MurmurHash3 finaliser,
/// http://zimbry.blogspot.com/2011/09/better-bit-mixing-improving-on.html
inline std::uint64_t scrambled(std::uint64_t z)
{
    z = (z ^ (z >> 30))*0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27))*0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

/// In [0, 1), with the 53 bits of a double.
inline double uniform(std::uint64_t seed, std::uint64_t key)
{
    return double(scrambled(seed + scrambled(key)) >> 11)*0x1.0p-53;
}

} // namespace elutria::laws
