#pragma once
/// Exact fractions for the time axis: the step and the frame rate never meet in floating point.
#include <cstdint>
#include <numeric>
#include <optional>
#include <string_view>

namespace sim {

/// num / den in lowest terms, den > 0.
struct Rational {
    std::int64_t num = 0;
    std::int64_t den = 1;

    double value() const noexcept { return static_cast<double>(num) / static_cast<double>(den); }
    friend bool operator==(const Rational&, const Rational&) = default;
};

/// num / den in lowest terms; den != 0.
constexpr Rational make_rational(std::int64_t num, std::int64_t den) {
    const std::int64_t d = std::gcd(num, den) * (den < 0 ? -1 : 1);
    return {num / d, den / d};
}

/// Reads "24000/1001", "60", "0.001" or "1e-3" exactly; nothing if it is none of these or does not fit.
std::optional<Rational> parse_rational(std::string_view text);

/// The exact fraction of the shortest decimal text of x (0.001 gives 1/1000); nothing if it does not fit.
std::optional<Rational> rational_from_decimal(double x);

/// Step shown by frame k: round(k / (fps h)), halves up. h [s] > 0, fps [1/s] > 0, k >= 0.
/// CHECKs that the product fits in 128 bits: it does up to k = 2^40 with numerators and denominators to
/// 10^12.
std::int64_t step_of_frame(std::int64_t k, Rational fps, Rational h);

/// Number of frames of a film: round(duration fps), halves up. duration [s] >= 0.
std::int64_t frame_count(Rational duration, Rational fps);

/// Steps of a whole film: round(duration / h), halves up; its last frame is not later. duration, h [s].
std::int64_t step_count(Rational duration, Rational h);

} // namespace sim
