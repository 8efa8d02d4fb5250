#define ELUTRIA_KERNELS baselineKernels
#define ELUTRIA_KERNELS_NAME "baseline"
#include "kernels.inl"
