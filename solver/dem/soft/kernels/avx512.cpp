#if defined(__x86_64__)
#define ELUTRIA_KERNELS avx512Kernels
#define ELUTRIA_KERNELS_NAME "avx512"
#include "soft/kernels/kernels.inl"
#endif
