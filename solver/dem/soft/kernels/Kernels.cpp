#include "soft/kernels/Kernels.hpp"

#include <cstdlib>
#include <cstring>

namespace elutria::dem
{

static const Kernels& choose()
{
    const char* asked = std::getenv("ELUTRIA_SIMD");
    if (asked != nullptr && std::strcmp(asked, "baseline") == 0) return baselineKernels;
#if defined(__x86_64__)
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    const bool avx512 = avx2 && __builtin_cpu_supports("avx512f")
                        && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
                        && __builtin_cpu_supports("avx512bw");
    if (avx512 && (asked == nullptr || std::strcmp(asked, "avx2") != 0)) return avx512Kernels;
    if (avx2) return avx2Kernels;
#endif
    return baselineKernels;
}

const Kernels& kernels()
{
    static const Kernels& best = choose();
    return best;
}

} // namespace elutria::dem
