#pragma once
/// Random numbers that are the same on every platform, for ever: std's distributions are not.
#include "sim/base/math.h"

#include <cmath>
#include <cstdint>

namespace sim {

/// SplitMix64 (Steele, Lea, Flood 2014).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    /// Uniform in [0, 1), 53 bits.
    double uniform() {
        state_ += 0x9E3779B97F4A7C15u;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }

    /// Uniform on the unit sphere: points of the cube until one lies in the ball, but not next to its centre.
    Vec3 direction() {
        constexpr double least_square = 1e-4;
        for (;;) {
            const double x = 2.0 * uniform() - 1.0;
            const double y = 2.0 * uniform() - 1.0;
            const double z = 2.0 * uniform() - 1.0;
            const double square = x * x + y * y + z * z;
            if (square <= 1.0 && square >= least_square) {
                return Vec3(x, y, z) / std::sqrt(square);
            }
        }
    }

private:
    std::uint64_t state_;
};

} // namespace sim
