/// Each kernel is compiled for each instruction set (NAME_kernel.cpp -> NAME_kernel_SET); the widest that this processor
/// can run is taken, or the one that the environment's TUMBLE_KERNELS names: baseline, avx2. All give the same bits.
#include "sim/block/batch.h"
#include "sim/collide/box_pairs.h"
#include "sim/solve/rest_batch.h"

#include <cstdlib>
#include <string_view>

#if defined(TUMBLE_X86_KERNELS)
#define CHOOSE_KERNEL(result, name, argument)                                                                          \
    result name##_kernel_baseline(const argument&);                                                                    \
    result name##_kernel_avx2(const argument&);                                                                        \
    result name##_kernel_avx512(const argument&);                                                                      \
    namespace {                                                                                                        \
    result (*name##_kernel())(const argument&) {                                                                       \
        static const auto chosen = has_avx512() ? name##_kernel_avx512                                                 \
                                   : has_avx2() ? name##_kernel_avx2                                                   \
                                                : name##_kernel_baseline;                                              \
        return chosen;                                                                                                 \
    }                                                                                                                  \
    }
#else
#define CHOOSE_KERNEL(result, name, argument)                                                                          \
    result name##_kernel_baseline(const argument&);                                                                    \
    namespace {                                                                                                        \
    result (*name##_kernel())(const argument&) {                                                                       \
        return name##_kernel_baseline;                                                                                 \
    }                                                                                                                  \
    }
#endif

namespace sim {

#if defined(TUMBLE_X86_KERNELS)
namespace {

bool is_asked_for(std::string_view set) {
    const char* asked = std::getenv("TUMBLE_KERNELS");
    return asked != nullptr && set == asked;
}
bool has_avx512() {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && !is_asked_for("avx2") &&
           !is_asked_for("baseline");
}
bool has_avx2() {
    return __builtin_cpu_supports("avx2") && !is_asked_for("baseline");
}

} // namespace
#endif

CHOOSE_KERNEL(double, block, BatchSweep)
CHOOSE_KERNEL(void, extrapolate, BatchExtrapolation)
CHOOSE_KERNEL(void, prepare, BatchPreparation)
CHOOSE_KERNEL(void, axes, AxesSearch)
CHOOSE_KERNEL(void, faces, FaceClip)
CHOOSE_KERNEL(double, rest, RestWork)

double sweep_batches(const BatchSweep& sweep) {
    return block_kernel()(sweep);
}

void extrapolate_batches(const BatchExtrapolation& work) {
    extrapolate_kernel()(work);
}

void prepare_batches(const BatchPreparation& preparation) {
    prepare_kernel()(preparation);
}

double work_on_rest(const RestWork& work) {
    return rest_kernel()(work);
}

void find_axes(const AxesSearch& search) {
    axes_kernel()(search);
}

void clip_faces(const FaceClip& clip) {
    faces_kernel()(clip);
}

} // namespace sim
