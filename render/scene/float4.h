#pragma once
/// Four numbers at a time: vectors as g++ and clang++ have them on every processor.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

/// By g++ compiled twice, chosen when the program starts: the same numbers, sooner where there is AVX2. With
/// [[gnu::flatten]] also what the function calls.
#if defined(__x86_64__) && defined(__linux__) && !defined(__clang__)
#define FOR_ALL_AND_AVX2 __attribute__((target_clones("default", "avx2")))
#else
#define FOR_ALL_AND_AVX2
#endif

namespace render {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

inline Float4 all(float x) {
    return Float4{x, x, x, x};
}
inline Int4 all(std::int32_t x) {
    return Int4{x, x, x, x};
}
/// a where all bits of the mask are set, b where none is.
inline Int4 chosen(Int4 mask, Int4 a, Int4 b) {
    return (mask & a) | (~mask & b);
}
inline Float4 chosen(Int4 mask, Float4 a, Float4 b) {
    return std::bit_cast<Float4>(chosen(mask, std::bit_cast<Int4>(a), std::bit_cast<Int4>(b)));
}
/// Whether a bit of the mask is set.
inline bool any(Int4 mask) {
    const auto halves = std::bit_cast<std::array<std::uint64_t, 2>>(mask);
    return (halves[0] | halves[1]) != 0;
}
/// Square roots. Of std::sqrt g++ makes four instructions and four branches, for errno.
inline Float4 root(Float4 x) {
#ifdef __SSE__
    return _mm_sqrt_ps(x);
#else
    return Float4{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
#endif
}

} // namespace render
