#include "sim/block_batch.h"

namespace sim {

// block_kernel.cpp, compiled for each instruction set.
double sweep_batches_baseline(const BatchSweep& sweep);
#if defined(TUMBLE_X86_KERNELS)
double sweep_batches_avx2(const BatchSweep& sweep);
double sweep_batches_avx512(const BatchSweep& sweep);
#endif

double sweep_batches(const BatchSweep& sweep) {
#if defined(TUMBLE_X86_KERNELS)
    static const auto kernel = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")
                                   ? sweep_batches_avx512
                               : __builtin_cpu_supports("avx2") ? sweep_batches_avx2
                                                                : sweep_batches_baseline;
    return kernel(sweep);
#else
    return sweep_batches_baseline(sweep);
#endif
}

} // namespace sim
