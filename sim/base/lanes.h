#pragma once
/// Arithmetic on eight lanes with the compiler's vector types, for the files *_kernel.cpp only: everything is inlined, so
/// that each instruction set has its own.
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
inline constexpr int parts = lane_count / width;

using Part = double __attribute__((vector_size(8 * width)));
using PartMask = long long __attribute__((vector_size(8 * width))); ///< all bits of a lane set: true
using PartInMemory = Part __attribute__((may_alias));
using PartAnywhere = Part __attribute__((may_alias, aligned(8))); ///< aligned to one number only

/// One number a lane.
struct Real {
    Part p[parts];
};
/// One truth value a lane.
struct Mask {
    PartMask p[parts];
};

LANES_INLINE Real load(const double* from) {
    Real r;
    for (int i = 0; i < parts; ++i) {
        r.p[i] = *reinterpret_cast<const PartInMemory*>(from + width * i);
    }
    return r;
}
LANES_INLINE Real load_anywhere(const double* from) {
    Real r;
    for (int i = 0; i < parts; ++i) {
        r.p[i] = *reinterpret_cast<const PartAnywhere*>(from + width * i);
    }
    return r;
}
LANES_INLINE void store(double* to, const Real& x) {
    for (int i = 0; i < parts; ++i) {
        *reinterpret_cast<PartInMemory*>(to + width * i) = x.p[i];
    }
}
LANES_INLINE void store_anywhere(double* to, const Real& x) {
    for (int i = 0; i < parts; ++i) {
        *reinterpret_cast<PartAnywhere*>(to + width * i) = x.p[i];
    }
}
LANES_INLINE Real load(const Lanes& from) {
    return load(from.x);
}
LANES_INLINE void store(Lanes& to, const Real& x) {
    store(to.x, x);
}
LANES_INLINE Real real(double x) {
    Real r;
    for (int i = 0; i < parts; ++i) {
        r.p[i] = x - Part{}; // all lanes
    }
    return r;
}

#define LANES_OPERATOR(op)                                                                                   \
    LANES_INLINE Real operator op(const Real& a, const Real& b) {                                            \
        Real r;                                                                                              \
        for (int i = 0; i < parts; ++i) {                                                                    \
            r.p[i] = a.p[i] op b.p[i];                                                                       \
        }                                                                                                    \
        return r;                                                                                            \
    }                                                                                                        \
    LANES_INLINE Real operator op(double a, const Real& b) { return real(a) op b; }                          \
    LANES_INLINE Real operator op(const Real& a, double b) { return a op real(b); }                          \
    LANES_INLINE Real& operator op##=(Real& a, const Real& b) { return a = a op b; }
LANES_OPERATOR(+)
LANES_OPERATOR(-)
LANES_OPERATOR(*)
LANES_OPERATOR(/)
#undef LANES_OPERATOR

#define LANES_COMPARISON(op)                                                                                 \
    LANES_INLINE Mask operator op(const Real& a, const Real& b) {                                            \
        Mask r;                                                                                              \
        for (int i = 0; i < parts; ++i) {                                                                    \
            r.p[i] = a.p[i] op b.p[i];                                                                       \
        }                                                                                                    \
        return r;                                                                                            \
    }                                                                                                        \
    LANES_INLINE Mask operator op(const Real& a, double b) { return a op real(b); }
LANES_COMPARISON(<)
LANES_COMPARISON(>)
LANES_COMPARISON(<=)
LANES_COMPARISON(>=)
LANES_COMPARISON(==)
#undef LANES_COMPARISON

LANES_INLINE Mask operator&(const Mask& a, const Mask& b) {
    Mask r;
    for (int i = 0; i < parts; ++i) {
        r.p[i] = a.p[i] & b.p[i];
    }
    return r;
}
LANES_INLINE Mask operator|(const Mask& a, const Mask& b) {
    Mask r;
    for (int i = 0; i < parts; ++i) {
        r.p[i] = a.p[i] | b.p[i];
    }
    return r;
}
LANES_INLINE Mask operator~(const Mask& a) {
    Mask r;
    for (int i = 0; i < parts; ++i) {
        r.p[i] = ~a.p[i];
    }
    return r;
}
LANES_INLINE Mask& operator&=(Mask& a, const Mask& b) {
    return a = a & b;
}
LANES_INLINE Mask& operator|=(Mask& a, const Mask& b) {
    return a = a | b;
}
LANES_INLINE bool any(const Mask& m) {
    PartMask bits = m.p[0];
    for (int i = 1; i < parts; ++i) {
        bits |= m.p[i];
    }
    long long all = 0;
    for (int l = 0; l < width; ++l) {
        all |= bits[l];
    }
    return all != 0;
}
/// The lanes whose bits are set.
LANES_INLINE Mask lanes_of(unsigned bits) {
    Mask m;
    for (int i = 0; i < parts; ++i) {
        PartMask bit;
        for (int l = 0; l < width; ++l) {
            bit[l] = 1ll << (i * width + l);
        }
        m.p[i] = (bit & static_cast<long long>(bits)) != 0;
    }
    return m;
}
LANES_INLINE unsigned bits_of(const Mask& m) {
#if defined(__AVX512DQ__)
    return static_cast<unsigned char>(__builtin_ia32_cvtq2mask512(m.p[0]));
#else
    unsigned bits = 0;
    for (int i = 0; i < parts; ++i) {
        for (int l = 0; l < width; ++l) {
            bits |= static_cast<unsigned>(m.p[i][l] & 1) << (i * width + l);
        }
    }
    return bits;
#endif
}
LANES_INLINE Real select(const Mask& m, const Real& yes, const Real& no) {
    Real r;
    for (int i = 0; i < parts; ++i) {
        r.p[i] = m.p[i] ? yes.p[i] : no.p[i];
    }
    return r;
}
LANES_INLINE Real max(const Real& a, const Real& b) {
    return select(a < b, b, a);
}
LANES_INLINE Real min(const Real& a, const Real& b) {
    return select(b < a, b, a);
}
LANES_INLINE Real operator-(const Real& a) {
    return 0.0 - a;
}
LANES_INLINE Real abs(const Real& x) {
    Real r;
    for (int i = 0; i < parts; ++i) {
        r.p[i] = reinterpret_cast<Part>(reinterpret_cast<PartMask>(x.p[i]) & 0x7fffffffffffffffll); // all but the sign
    }
    return r;
}
LANES_INLINE Real sqrt(const Real& x) {
    Real r;
    for (int i = 0; i < parts; ++i) {
        for (int l = 0; l < width; ++l) {
            r.p[i][l] = __builtin_sqrt(x.p[i][l]);
        }
    }
    return r;
}

/// Rows become columns: lane l of x[i] was lane i of x[l].
LANES_INLINE void transpose(Real x[8]) {
#if defined(__AVX512F__)
    Part t[8];
    for (int i = 0; i < 8; i += 2) {
        t[i] = __builtin_shufflevector(x[i].p[0], x[i + 1].p[0], 0, 8, 2, 10, 4, 12, 6, 14);
        t[i + 1] = __builtin_shufflevector(x[i].p[0], x[i + 1].p[0], 1, 9, 3, 11, 5, 13, 7, 15);
    }
    Part s[8];
    for (int half = 0; half < 8; half += 4) {
        for (int i = half; i < half + 2; ++i) {
            s[i] = __builtin_shufflevector(t[i], t[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
            s[i + 2] = __builtin_shufflevector(t[i], t[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    }
    for (int i = 0; i < 4; ++i) {
        x[i].p[0] = __builtin_shufflevector(s[i], s[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        x[i + 4].p[0] = __builtin_shufflevector(s[i], s[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
#else
    Lanes rows[8];
    for (int i = 0; i < 8; ++i) {
        store(rows[i], x[i]);
    }
    for (int i = 0; i < 8; ++i) {
        Lanes column;
        for (int l = 0; l < 8; ++l) {
            column.x[l] = rows[l].x[i];
        }
        x[i] = load(column);
    }
#endif
}

/// The first 8 of `stride` numbers of the body in each lane.
template <int stride>
LANES_INLINE void gather(const double* bodies, const int* body, Real rows[8]) {
    for (int l = 0; l < lane_count; ++l) {
        rows[l] = load(bodies + stride * body[l]);
    }
    transpose(rows);
}

/// Two rows of 64 bytes of the body in each lane.
LANES_INLINE void gather_two(const double* bodies, const int* body, Real rows[16]) {
    gather<16>(bodies, body, rows);
    gather<16>(bodies + 8, body, rows + 8);
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
LANES_INLINE Real norm(Real3 a) {
    return sqrt(dot(a, a));
}
LANES_INLINE Real3 load3(const Lanes* from) {
    return {load(from[0]), load(from[1]), load(from[2])};
}
LANES_INLINE void store3(Lanes* to, Real3 v) {
    store(to[0], v.x);
    store(to[1], v.y);
    store(to[2], v.z);
}
LANES_INLINE Real3 select(Mask m, Real3 yes, Real3 no) {
    return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)};
}

/// A symmetric 3x3 matrix.
struct Sym3 {
    Real xx, xy, xz, yy, yz, zz;
};
LANES_INLINE Real3 operator*(const Sym3& m, Real3 a) {
    return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z,
            m.xz * a.x + m.yz * a.y + m.zz * a.z};
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
