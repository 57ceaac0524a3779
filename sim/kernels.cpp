#include "sim/block_batch.h"
#include "sim/box_axes.h"

namespace sim {

// block_kernel.cpp and axes_kernel.cpp, compiled for each instruction set.
double block_kernel_baseline(const BatchSweep& sweep);
void axes_kernel_baseline(const AxesSearch& search);
#if defined(TUMBLE_X86_KERNELS)
double block_kernel_avx2(const BatchSweep& sweep);
double block_kernel_avx512(const BatchSweep& sweep);
void axes_kernel_avx2(const AxesSearch& search);
void axes_kernel_avx512(const AxesSearch& search);
#endif

namespace {

/// The widest of a kernel's forms that this processor can run.
template <typename Kernel>
Kernel* widest([[maybe_unused]] Kernel* avx512, [[maybe_unused]] Kernel* avx2, Kernel* baseline) {
#if defined(TUMBLE_X86_KERNELS)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
        return avx512;
    }
    if (__builtin_cpu_supports("avx2")) {
        return avx2;
    }
#endif
    return baseline;
}

#if !defined(TUMBLE_X86_KERNELS)
constexpr auto block_kernel_avx512 = block_kernel_baseline;
constexpr auto block_kernel_avx2 = block_kernel_baseline;
constexpr auto axes_kernel_avx512 = axes_kernel_baseline;
constexpr auto axes_kernel_avx2 = axes_kernel_baseline;
#endif

} // namespace

double sweep_batches(const BatchSweep& sweep) {
    static const auto kernel = widest(block_kernel_avx512, block_kernel_avx2, block_kernel_baseline);
    return kernel(sweep);
}

void find_axes(const AxesSearch& search) {
    static const auto kernel = widest(axes_kernel_avx512, axes_kernel_avx2, axes_kernel_baseline);
    kernel(search);
}

} // namespace sim
