#define ELUTRIA_KERNELS baselineKernels
#define ELUTRIA_KERNELS_NAME "baseline"
#include "soft/kernels/kernels.inl"
