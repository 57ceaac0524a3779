#pragma once
/// A curve through values at some times: of a camera, and of a body that is moved by keys.
#include "sim/base/math.h"

#include <algorithm>
#include <span>

namespace sim {

/// How it goes on from a key to the next.
enum class Easing {
    smooth,  ///< through both, without a stop
    stop,    ///< at rest at both
    linear,  ///< at one rate
    cut,     ///< not at all: the next key begins anew
};

template <int n>
struct CurveKey {
    double time = 0.0;                         ///< [s] later than that of the key before
    Easing easing = Easing::smooth;            ///< to the next key
    Eigen::Matrix<double, n, 1> value;
};

/// A value and how fast it changes [1/s].
template <int n>
struct CurvePoint {
    Eigen::Matrix<double, n, 1> value;
    Eigen::Matrix<double, n, 1> rate;
};

/// Rate at key i: the slope between its neighbours (Catmull & Rom 1974, uneven times); zero at the ends and beside a
/// piece that is not smooth.
template <int n>
Eigen::Matrix<double, n, 1> key_rate(std::span<const CurveKey<n>> keys, std::size_t i) {
    const bool is_passed =
        i > 0 && i + 1 < keys.size() && keys[i - 1].easing == Easing::smooth && keys[i].easing == Easing::smooth;
    if (!is_passed) {
        return Eigen::Matrix<double, n, 1>::Zero();
    }
    const double share = 1.0 / (keys[i + 1].time - keys[i - 1].time);
    return keys[i + 1].value * share - keys[i - 1].value * share;
}

/// At t [s]; at least one key. Before the first and from the last on their values stand. At a key where the rate jumps it is
/// that of the piece that begins.
template <int n>
CurvePoint<n> curve_at(std::span<const CurveKey<n>> keys, double t) {
    const auto next = std::ranges::upper_bound(keys, t, {}, &CurveKey<n>::time);
    if (next == keys.begin() || next == keys.end()) {
        return {(next == keys.end() ? keys.back() : keys.front()).value, Eigen::Matrix<double, n, 1>::Zero()};
    }
    const CurveKey<n>& from = *(next - 1);
    const CurveKey<n>& to = *next;
    const double span = to.time - from.time;
    const double s = (t - from.time) / span;
    if (from.easing == Easing::cut) {
        return {from.value, Eigen::Matrix<double, n, 1>::Zero()};
    }
    if (from.easing == Easing::linear) {
        return {from.value * (1.0 - s) + to.value * s, (to.value - from.value) / span};
    }
    // A cubic Hermite curve.
    const auto i = static_cast<std::size_t>(next - keys.begin());
    const Eigen::Matrix<double, n, 1> rate_from = key_rate(keys, i - 1), rate_to = key_rate(keys, i);
    const double s2 = s * s;
    const double s3 = s2 * s;
    const double slope = (6 * s2 - 6 * s) / span;
    return {(from.value * (2 * s3 - 3 * s2 + 1) + to.value * (3 * s2 - 2 * s3)) +
                (rate_from * (span * (s3 - 2 * s2 + s)) + rate_to * (span * (s3 - s2))),
            (from.value - to.value) * slope + rate_from * (3 * s2 - 4 * s + 1) + rate_to * (3 * s2 - 2 * s)};
}

} // namespace sim
