#include "sim/base/rational.h"

#include "sim/base/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace sim {

namespace {

__extension__ using Int128 = __int128;

/// Digits of a decimal text without its point, and the power of ten that belongs to them.
struct Decimal {
    std::int64_t digits = 0;
    int exponent = 0;
};

/// factor * 10^power, or nothing if it does not fit.
std::optional<std::int64_t> times_power_of_ten(std::int64_t factor, int power) {
    for (int i = 0; i < power; ++i) {
        if (__builtin_mul_overflow(factor, 10, &factor)) {
            return std::nullopt;
        }
    }
    return factor;
}

/// Reads an integer and nothing else; a leading '+' is allowed.
std::optional<std::int64_t> parse_integer(std::string_view text) {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
        text.remove_prefix(1);
    }
    std::int64_t value = 0;
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (status != std::errc() || end != text.data() + text.size()) {
        return std::nullopt;
    }
    return value;
}

/// Splits "-12.34e5" into digits -1234 and exponent 3; trailing zeros behind the point are dropped.
std::optional<Decimal> parse_decimal(std::string_view text) {
    Decimal result;
    // The exponent, if there is one.
    if (const std::size_t e = text.find_first_of("eE"); e != std::string_view::npos) {
        const std::optional<std::int64_t> exponent = parse_integer(text.substr(e + 1));
        if (!exponent || std::abs(*exponent) > 400) {
            return std::nullopt;
        }
        result.exponent = static_cast<int>(*exponent);
        text = text.substr(0, e);
    }
    const bool is_negative = !text.empty() && text[0] == '-';
    if (!text.empty() && (text[0] == '-' || text[0] == '+')) {
        text.remove_prefix(1);
    }
    // The digits before and behind the point.
    const std::size_t point = text.find('.');
    const std::string_view whole = text.substr(0, point);
    std::string_view fraction = point == std::string_view::npos ? std::string_view() : text.substr(point + 1);
    if (whole.empty() || (point != std::string_view::npos && fraction.empty())) {
        return std::nullopt;
    }
    while (!fraction.empty() && fraction.back() == '0') {
        fraction.remove_suffix(1);
    }
    for (const std::string_view part : {whole, fraction}) {
        for (const char c : part) {
            if (c < '0' || c > '9' || __builtin_mul_overflow(result.digits, 10, &result.digits) ||
                __builtin_add_overflow(result.digits, c - '0', &result.digits)) {
                return std::nullopt;
            }
        }
    }
    result.exponent -= static_cast<int>(fraction.size());
    result.digits = is_negative ? -result.digits : result.digits;
    return result;
}

} // namespace

std::optional<Rational> parse_rational(std::string_view text) {
    // Numerator and denominator.
    if (const std::size_t slash = text.find('/'); slash != std::string_view::npos) {
        const std::optional<std::int64_t> num = parse_integer(text.substr(0, slash));
        const std::optional<std::int64_t> den = parse_integer(text.substr(slash + 1));
        constexpr std::int64_t lowest =
            std::numeric_limits<std::int64_t>::min(); // has no negative counterpart
        if (!num || !den || *den == 0 || *num == lowest || *den == lowest) {
            return std::nullopt;
        }
        return make_rational(*num, *den);
    }
    // A decimal number.
    const std::optional<Decimal> decimal = parse_decimal(text);
    if (!decimal) {
        return std::nullopt;
    }
    if (decimal->digits == 0) {
        return Rational{0, 1};
    }
    const bool is_whole = decimal->exponent >= 0;
    const std::optional<std::int64_t> scaled =
        times_power_of_ten(is_whole ? decimal->digits : 1, std::abs(decimal->exponent));
    if (!scaled) {
        return std::nullopt;
    }
    return is_whole ? Rational{*scaled, 1} : make_rational(decimal->digits, *scaled);
}

std::optional<Rational> rational_from_decimal(double x) {
    if (!std::isfinite(x)) {
        return std::nullopt;
    }
    char text[32];
    const auto [end, status] = std::to_chars(text, text + sizeof text, x);
    CHECK(status == std::errc());
    return parse_rational(std::string_view(text, static_cast<std::size_t>(end - text)));
}

namespace {

/// floor(factor * num / den + 1/2), exactly. factor >= 0, num >= 0, den > 0.
std::int64_t rounded_product(std::int64_t factor, Int128 num, Int128 den) {
    // floor((2 f n + d) / (2 d))
    Int128 top = 0;
    Int128 bottom = 0;
    CHECK(factor >= 0 && num >= 0 && den > 0);
    CHECK(!__builtin_mul_overflow(num, 2 * static_cast<Int128>(factor), &top));
    CHECK(!__builtin_add_overflow(top, den, &top));
    CHECK(!__builtin_mul_overflow(den, 2, &bottom));
    const Int128 quotient = top / bottom;
    CHECK(quotient <= std::numeric_limits<std::int64_t>::max());
    return static_cast<std::int64_t>(quotient);
}

} // namespace

std::int64_t step_of_frame(std::int64_t k, Rational fps, Rational h) {
    return rounded_product(k, static_cast<Int128>(fps.den) * h.den, static_cast<Int128>(fps.num) * h.num);
}

std::int64_t frame_count(Rational duration, Rational fps) {
    return rounded_product(1, static_cast<Int128>(duration.num) * fps.num,
                           static_cast<Int128>(duration.den) * fps.den);
}

std::int64_t step_count(Rational duration, Rational h) {
    return rounded_product(1, static_cast<Int128>(duration.num) * h.den,
                           static_cast<Int128>(duration.den) * h.num);
}

} // namespace sim
