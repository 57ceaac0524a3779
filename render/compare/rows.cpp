#include "render/compare/rows.h"

#include <cstdlib>

// Loops that compilers turn into vector instructions: no branches, no wider numbers, three arguments two by two. Each is
// compiled for all processors, and once more for those with vectors of 32 bytes, with the same results.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ROW_LOOP __attribute__((target_clones("avx2", "default")))
#else
#define ROW_LOOP
#endif

namespace diff {

namespace {

inline std::uint8_t lesser(std::uint8_t a, std::uint8_t b) {
    return a < b ? a : b;
}
inline std::uint8_t greater(std::uint8_t a, std::uint8_t b) {
    return a > b ? a : b;
}
inline std::uint8_t apart(std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(greater(a, b) - lesser(a, b));
}

} // namespace

ROW_LOOP void lesser_of(Row a, Row b, Row c, std::size_t n, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < n; ++i) {
        out[i] = lesser(a[i], lesser(b[i], c[i]));
    }
}

ROW_LOOP void greater_of(Row a, Row b, Row c, std::size_t n, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < n; ++i) {
        out[i] = greater(a[i], greater(b[i], c[i]));
    }
}

ROW_LOOP void subtract(Row a, Row b, std::size_t n, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < n; ++i) {
        out[i] = static_cast<std::uint8_t>(a[i] - b[i]);
    }
}

ROW_LOOP void absolute_difference(Row a, Row b, std::size_t n, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < n; ++i) {
        out[i] = apart(a[i], b[i]);
    }
}

ROW_LOOP void raise_to_difference(Row a, Row b, std::size_t n, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < n; ++i) {
        out[i] = greater(out[i], apart(a[i], b[i]));
    }
}

ROW_LOOP void raise_to(Row a, std::size_t n, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < n; ++i) {
        out[i] = greater(out[i], a[i]);
    }
}

ROW_LOOP void largest_channel(Row channels, std::size_t pixels, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < pixels; ++i) {
        out[i] = greater(channels[3 * i], greater(channels[3 * i + 1], channels[3 * i + 2]));
    }
}

ROW_LOOP void raise_excess(Row p, Row q, RangeRow range, std::size_t n, std::uint8_t* __restrict excess) {
    Row low = range.low, high = range.high;
    for (std::size_t i = 0; i < n; ++i) {
        const auto most = static_cast<std::uint8_t>((p[i] + high[i] + 1) >> 1);
        // The mean rounded down, from the one rounded up, which processors have.
        const auto least = static_cast<std::uint8_t>(((p[i] + low[i] + 1) >> 1) - ((p[i] ^ low[i]) & 1));
        const auto above = static_cast<std::uint8_t>(greater(q[i], most) - most);
        const auto below = static_cast<std::uint8_t>(greater(q[i], least) - q[i]);
        excess[i] = greater(excess[i], greater(above, below));
    }
}

ROW_LOOP void sum_five_rows(const Row* rows, std::size_t n, std::uint16_t* __restrict sums) {
    Row a = rows[0], b = rows[1], c = rows[2], d = rows[3], e = rows[4];
    for (std::size_t i = 0; i < n; ++i) {
        sums[i] = static_cast<std::uint16_t>(a[i] + e[i] + 4 * (b[i] + d[i]) + 6 * c[i]);
    }
}

ROW_LOOP void sum_five_pixels(const std::uint16_t* s, std::size_t n, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < n; ++i) {
        const auto sum = static_cast<std::uint16_t>(s[i] + s[i + 12] + 4 * (s[i + 3] + s[i + 9]) + 6 * s[i + 6] + 128);
        out[i] = static_cast<std::uint8_t>(sum >> 8);
    }
}

ROW_LOOP std::uint32_t sum_of_differences(Row a, Row b, std::size_t n) {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
        sum += static_cast<std::uint32_t>(std::abs(a[i] - b[i]));
    }
    return sum;
}

ROW_LOOP std::uint8_t largest_of(Row values, std::size_t n) {
    std::uint8_t largest = 0;
    for (std::size_t i = 0; i < n; ++i) {
        largest = greater(largest, values[i]);
    }
    return largest;
}

ROW_LOOP int count_above(Row values, std::size_t n, std::uint8_t bound) {
    int count = 0;
    for (std::size_t i = 0; i < n; ++i) {
        count += values[i] > bound;
    }
    return count;
}

ROW_LOOP void add_above(Row values, std::size_t n, std::uint8_t bound, std::uint8_t* __restrict counts) {
    for (std::size_t i = 0; i < n; ++i) {
        counts[i] = static_cast<std::uint8_t>(counts[i] + (values[i] > bound));
    }
}

ROW_LOOP void add_signed(Row a, Row b, std::size_t n, SignedColumns columns) {
    std::int16_t* __restrict sums = columns.sums;
    std::int16_t* __restrict balances = columns.balances;
    std::int16_t* __restrict counts = columns.counts;
    for (std::size_t i = 0; i < n; ++i) {
        const auto whole = static_cast<std::int16_t>(b[i] - a[i]);
        const auto d = apart(a[i], b[i]) > columns.most ? std::int16_t{0} : whole;
        const auto sign = static_cast<std::int16_t>((d > 0) - (d < 0));
        sums[i] = static_cast<std::int16_t>(sums[i] + d);
        balances[i] = static_cast<std::int16_t>(balances[i] + sign);
        counts[i] = static_cast<std::int16_t>(counts[i] + (d != 0));
    }
}

ROW_LOOP void add_where_flat(Row a, Row b, Spread spread, std::size_t n, std::int16_t* __restrict sums) {
    Row of = spread.of;
    const std::uint8_t most = spread.most, least = spread.least;
    for (std::size_t i = 0; i < n; ++i) {
        const auto d = static_cast<std::int16_t>(b[i] - a[i]);
        const bool counts = (of[i] <= most) & (apart(a[i], b[i]) > least);
        sums[i] = static_cast<std::int16_t>(sums[i] + (counts ? d : std::int16_t{0}));
    }
}

ROW_LOOP void add_squares(Row values, std::size_t n, std::uint32_t* __restrict sums) {
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t v = values[i];
        sums[i] += v * v;
    }
}

ROW_LOOP void quarter_grey(Row channels, std::size_t pixels, std::uint8_t* __restrict out) {
    for (std::size_t i = 0; i < pixels; ++i) {
        const auto sum = static_cast<std::uint16_t>(channels[3 * i] * 77 + channels[3 * i + 1] * 150 + channels[3 * i + 2] * 29);
        out[i] = static_cast<std::uint8_t>(sum >> 10);
    }
}

ROW_LOOP void replace_above(Row values, Ramp ramp, std::size_t n, std::uint8_t* __restrict out) {
    Row shown = ramp.shown;
    const std::uint8_t above = ramp.above, first = ramp.first;
    for (std::size_t i = 0; i < n; ++i) {
        const auto index = static_cast<std::uint8_t>(first + (shown[i] >> 2));
        out[i] = values[i] > above ? index : out[i];
    }
}

ROW_LOOP void add_row(Row row, std::size_t n, std::uint16_t* __restrict sums) {
    for (std::size_t i = 0; i < n; ++i) {
        sums[i] = static_cast<std::uint16_t>(sums[i] + row[i]);
    }
}

ROW_LOOP void add_sums(const std::uint16_t* __restrict row, std::size_t n, std::uint16_t* __restrict sums) {
    for (std::size_t i = 0; i < n; ++i) {
        sums[i] = static_cast<std::uint16_t>(sums[i] + row[i]);
    }
}

ROW_LOOP void divide(const std::uint16_t* __restrict sums, std::size_t n, std::uint32_t count, std::uint8_t* __restrict out) {
    // Exact for sums of up to 255 times count.
    const std::uint32_t inverse = ((1u << 24) + count - 1) / count;
    for (std::size_t i = 0; i < n; ++i) {
        out[i] = static_cast<std::uint8_t>((sums[i] + count / 2) * inverse >> 24);
    }
}

} // namespace diff
