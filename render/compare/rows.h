#pragma once
/// Rows of pictures, and loops over their bytes.
#include "render/compare/picture.h"

#include <algorithm>
#include <cstdint>

namespace diff {

using Row = const std::uint8_t*;

inline std::size_t row_bytes(const Picture& picture) {
    return static_cast<std::size_t>(picture.width) * 3;
}

inline Row row_of(const Picture& picture, int y) {
    return picture.rgb.data() + row_bytes(picture) * static_cast<std::size_t>(std::clamp(y, 0, picture.height - 1));
}

// n: bytes. What is written lies apart from what is read.

void lesser_of(Row a, Row b, Row c, std::size_t n, std::uint8_t* out);
void greater_of(Row a, Row b, Row c, std::size_t n, std::uint8_t* out);
void subtract(Row a, Row b, std::size_t n, std::uint8_t* out);
void absolute_difference(Row a, Row b, std::size_t n, std::uint8_t* out);
/// `out` becomes no less than the difference of a and b.
void raise_to_difference(Row a, Row b, std::size_t n, std::uint8_t* out);
/// `out` becomes no less than a.
void raise_to(Row a, std::size_t n, std::uint8_t* out);
/// Of each pixel's three channels the largest.
void largest_channel(Row channels, std::size_t pixels, std::uint8_t* out);

/// Least and largest value about each pixel and channel of a row.
struct RangeRow {
    Row low;
    Row high;
};

/// By how much q leaves the half of p's range about p, added to `excess` by maximum.
void raise_excess(Row p, Row q, RangeRow range, std::size_t n, std::uint8_t* excess);

// Weights 1 4 6 4 1: of five rows, and of five neighbouring pixels of such sums, divided by 256.
void sum_five_rows(const Row* rows, std::size_t n, std::uint16_t* sums);
void sum_five_pixels(const std::uint16_t* sums, std::size_t n, std::uint8_t* out);

/// Sum of |a - b| for n < 2^24.
std::uint32_t sum_of_differences(Row a, Row b, std::size_t n);
std::uint8_t largest_of(Row values, std::size_t n);
/// Number of values above `bound`, n < 2^31; and for each value, added to `counts`.
int count_above(Row values, std::size_t n, std::uint8_t bound);
void add_above(Row values, std::size_t n, std::uint8_t bound, std::uint8_t* counts);

/// Columns of signed differences b - a of at most `most` levels, of the signs of those, and of how many are not 0.
struct SignedColumns {
    std::uint8_t most;
    std::int16_t* sums;
    std::int16_t* balances;
    std::int16_t* counts;
};
void add_signed(Row a, Row b, std::size_t n, SignedColumns columns);
/// Adds to `sums` the differences b - a of more than `least` where `spread` is no more than `most_spread`.
struct Spread {
    Row of;
    std::uint8_t most;
    std::uint8_t least;
};
void add_where_flat(Row a, Row b, Spread spread, std::size_t n, std::int16_t* sums);

/// Adds the square of each value.
void add_squares(Row values, std::size_t n, std::uint32_t* sums);

/// A quarter of each pixel's brightness, 0 to 63.
void quarter_grey(Row channels, std::size_t pixels, std::uint8_t* out);

/// Where a value is above `above`, `out` becomes `first` and a quarter of `shown`.
struct Ramp {
    Row shown;
    std::uint8_t above;
    std::uint8_t first;
};
void replace_above(Row values, Ramp ramp, std::size_t n, std::uint8_t* out);

/// Sums of columns of bytes, of up to 257 rows.
void add_row(Row row, std::size_t n, std::uint16_t* sums);
void add_sums(const std::uint16_t* row, std::size_t n, std::uint16_t* sums);

/// Means, rounded, of sums of up to 256 bytes.
void divide(const std::uint16_t* sums, std::size_t n, std::uint32_t count, std::uint8_t* out);

} // namespace diff
