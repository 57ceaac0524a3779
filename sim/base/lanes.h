#pragma once
/// Arithmetic on several of eight lanes at a time, as many as a register holds, with the compiler's vector types, for the files
/// *_kernel.cpp only: everything is inlined, so that each instruction set has its own.
#include "sim/base/lane_count.h"

namespace sim {
namespace { // NOLINT: each translation unit has its own, for its instruction set

#define LANES_INLINE inline __attribute__((always_inline))

#if defined(__AVX512F__)
inline constexpr int width = 8; ///< doubles in a register
#elif defined(__AVX2__)
inline constexpr int width = 4;
#else
inline constexpr int width = 2;
#endif

using Real = double __attribute__((vector_size(8 * width)));    ///< one number a lane
using Mask = long long __attribute__((vector_size(8 * width))); ///< one truth value a lane: all its bits are set, or none
using RealInMemory = Real __attribute__((may_alias));
using Short = float __attribute__((vector_size(4 * width)));
using ShortInMemory = Short __attribute__((may_alias));

LANES_INLINE Real load(const double* from) {
    return *reinterpret_cast<const RealInMemory*>(from);
}
LANES_INLINE void store(double* to, const Real& x) {
    *reinterpret_cast<RealInMemory*>(to) = x;
}
LANES_INLINE Real load(const float* from) {
    return __builtin_convertvector(*reinterpret_cast<const ShortInMemory*>(from), Real);
}
LANES_INLINE void store(float* to, const Real& x) {
    *reinterpret_cast<ShortInMemory*>(to) = __builtin_convertvector(x, Short);
}
/// From numbers that are aligned to one only.
LANES_INLINE Real load_anywhere(const double* from) {
    Real x;
    __builtin_memcpy(&x, from, sizeof x);
    return x;
}
LANES_INLINE void store_anywhere(double* to, const Real& x) {
    __builtin_memcpy(to, &x, sizeof x);
}
/// The same in all lanes.
LANES_INLINE Real real(double x) {
    return x - Real{};
}
LANES_INLINE Mask nowhere() {
    return Mask{};
}

/// The lanes whose bits are set.
LANES_INLINE Mask lanes_of(unsigned bits) {
    Mask bit;
    for (int l = 0; l < width; ++l) {
        bit[l] = 1ll << l;
    }
    return (bit & static_cast<long long>(bits)) != 0;
}
LANES_INLINE unsigned bits_of(const Mask& m) {
#if defined(__AVX512DQ__)
    return static_cast<unsigned char>(__builtin_ia32_cvtq2mask512(m));
#elif defined(__AVX2__)
    return static_cast<unsigned>(__builtin_ia32_movmskpd256(reinterpret_cast<Real>(m)));
#elif defined(__SSE2__)
    return static_cast<unsigned>(__builtin_ia32_movmskpd(reinterpret_cast<Real>(m)));
#else
    unsigned bits = 0;
    for (int l = 0; l < width; ++l) {
        bits |= static_cast<unsigned>(m[l] & 1) << l;
    }
    return bits;
#endif
}
LANES_INLINE bool any(const Mask& m) {
    return bits_of(m) != 0;
}
LANES_INLINE Real select(const Mask& m, const Real& yes, const Real& no) {
    return m ? yes : no;
}
LANES_INLINE Real max(const Real& a, const Real& b) {
    return select(a < b, b, a);
}
LANES_INLINE Real min(const Real& a, const Real& b) {
    return select(b < a, b, a);
}
LANES_INLINE Real abs(const Real& x) {
    return reinterpret_cast<Real>(reinterpret_cast<Mask>(x) & 0x7fffffffffffffffll); // all but the sign
}
LANES_INLINE Real sqrt(const Real& x) {
    Real r;
    for (int l = 0; l < width; ++l) {
        r[l] = __builtin_sqrt(x[l]);
    }
    return r;
}

/// Rows become columns.
LANES_INLINE void transpose(Real x[width]) {
#if defined(__AVX512F__)
    Real t[8];
    for (int i = 0; i < 8; i += 2) {
        t[i] = __builtin_shufflevector(x[i], x[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
        t[i + 1] = __builtin_shufflevector(x[i], x[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    }
    Real s[8];
    for (int half = 0; half < 8; half += 4) {
        for (int i = half; i < half + 2; ++i) {
            s[i] = __builtin_shufflevector(t[i], t[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
            s[i + 2] = __builtin_shufflevector(t[i], t[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    }
    for (int i = 0; i < 4; ++i) {
        x[i] = __builtin_shufflevector(s[i], s[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        x[i + 4] = __builtin_shufflevector(s[i], s[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
#elif defined(__AVX2__)
    Real t[4];
    for (int i = 0; i < 4; i += 2) {
        t[i] = __builtin_shufflevector(x[i], x[i + 1], 0, 4, 2, 6);
        t[i + 1] = __builtin_shufflevector(x[i], x[i + 1], 1, 5, 3, 7);
    }
    for (int i = 0; i < 2; ++i) {
        x[i] = __builtin_shufflevector(t[i], t[i + 2], 0, 1, 4, 5);
        x[i + 2] = __builtin_shufflevector(t[i], t[i + 2], 2, 3, 6, 7);
    }
#else
    const Real even = x[0];
    x[0] = __builtin_shufflevector(even, x[1], 0, 2);
    x[1] = __builtin_shufflevector(even, x[1], 1, 3);
#endif
}

/// Row l of eight numbers, at row_of(l), becomes lane l of the columns.
template <typename RowOf>
LANES_INLINE void gather(RowOf&& row_of, Real columns[8]) {
    for (int first = 0; first < 8; first += width) {
        for (int l = 0; l < width; ++l) {
            columns[first + l] = load_anywhere(row_of(l) + first);
        }
        transpose(columns + first);
    }
}
/// The other way round: calls put(l, first, numbers) for those from `first` on of row l.
template <typename Put>
LANES_INLINE void scatter(Real columns[8], Put&& put) {
    for (int first = 0; first < 8; first += width) {
        transpose(columns + first);
        for (int l = 0; l < width; ++l) {
            put(l, first, columns[first + l]);
        }
    }
}
/// Two rows of 64 bytes of the body in each lane.
LANES_INLINE void gather_two(const double* bodies, const int* body, Real rows[16]) {
    gather([&](int l) { return bodies + 16 * body[l]; }, rows);
    gather([&](int l) { return bodies + 16 * body[l] + 8; }, rows + 8);
}
/// 1 in the lanes of the mask, else 0.
LANES_INLINE Real flag(const Mask& m) {
    return select(m, real(1.0), real(0.0));
}

struct Real3 {
    Real x, y, z;
};
LANES_INLINE Real3 operator+(Real3 a, Real3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
LANES_INLINE Real3 operator-(Real3 a, Real3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
LANES_INLINE Real3 operator-(Real3 a) {
    return {-a.x, -a.y, -a.z};
}
LANES_INLINE Real3 operator*(Real s, Real3 a) {
    return {s * a.x, s * a.y, s * a.z};
}
LANES_INLINE Real dot(Real3 a, Real3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
LANES_INLINE Real3 cross(Real3 a, Real3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
LANES_INLINE Real3 select(Mask m, Real3 yes, Real3 no) {
    return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)};
}

/// Of eight lanes those that a register holds: from `first` on.
struct Window {
    int first = 0;

    LANES_INLINE Real load(const Lanes& from) const { return sim::load(from.x + first); }
    LANES_INLINE Real load(const ShortLanes& from) const { return sim::load(from.x + first); }
    LANES_INLINE Real3 load3(const Lanes* from) const { return {load(from[0]), load(from[1]), load(from[2])}; }
    LANES_INLINE void store(Lanes& to, const Real& x) const { sim::store(to.x + first, x); }
    LANES_INLINE void store(ShortLanes& to, const Real& x) const { sim::store(to.x + first, x); }
    LANES_INLINE void store3(Lanes* to, const Real3& v) const {
        store(to[0], v.x);
        store(to[1], v.y);
        store(to[2], v.z);
    }
    LANES_INLINE Mask lanes_of(unsigned bits) const { return sim::lanes_of(bits >> first); }
    LANES_INLINE bool has_any(unsigned bits) const { return (bits >> first & ((1u << width) - 1u)) != 0; }
    /// Sets the bits of these lanes.
    LANES_INLINE void set(unsigned& bits, const Mask& m) const {
        bits = (bits & ~(((1u << width) - 1u) << first)) | bits_of(m) << first;
    }
};

/// A symmetric 3x3 matrix.
struct Sym3 {
    Real xx, xy, xz, yy, yz, zz;
};
LANES_INLINE Real3 operator*(const Sym3& m, Real3 a) {
    return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z,
            m.xz * a.x + m.yz * a.y + m.zz * a.z};
}
LANES_INLINE Sym3 operator*(Real s, const Sym3& m) {
    return {s * m.xx, s * m.xy, s * m.xz, s * m.yy, s * m.yz, s * m.zz};
}
/// x with m x = b, by cofactors.
LANES_INLINE Real3 solve(const Sym3& m, Real3 b) {
    const Real c_xx = m.yy * m.zz - m.yz * m.yz;
    const Real c_xy = m.xz * m.yz - m.xy * m.zz;
    const Real c_xz = m.xy * m.yz - m.xz * m.yy;
    const Real c_yy = m.xx * m.zz - m.xz * m.xz;
    const Real c_yz = m.xy * m.xz - m.xx * m.yz;
    const Real c_zz = m.xx * m.yy - m.xy * m.xy;
    const Real r = 1.0 / (m.xx * c_xx + m.xy * c_xy + m.xz * c_xz);
    return r * (Sym3{c_xx, c_xy, c_xz, c_yy, c_yz, c_zz} * b);
}

} // namespace
} // namespace sim
