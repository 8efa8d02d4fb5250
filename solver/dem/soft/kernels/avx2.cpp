#if defined(__x86_64__)
#define ELUTRIA_KERNELS avx2Kernels
#define ELUTRIA_KERNELS_NAME "avx2"
#include "soft/kernels/kernels.inl"
#endif
