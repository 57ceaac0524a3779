#include "render/compare/difference.h"

#include "render/compare/drift.h"
#include "render/compare/edge_shift.h"
#include "render/compare/rows.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace diff {

namespace {

/// Rows on each side that a pixel of `excess` depends on: two of the weights, one of the neighbours.
constexpr int weight_reach = 2;
/// Rows on each side of a difference in which the smooth pictures are needed to find shifts.
constexpr int shift_reach = 12;

/// Row y of the picture out of focus; the picture's border repeats. sums: memory for width + 4 pixels.
void smooth_row(const Picture& picture, int y, std::vector<std::uint16_t>& sums, std::uint8_t* out) {
    const std::size_t n = row_bytes(picture);
    sums.resize(n + 12);
    Row rows[5];
    for (int k = 0; k < 5; ++k) {
        rows[k] = row_of(picture, y + k - weight_reach);
    }
    std::uint16_t* middle = sums.data() + 6;
    sum_five_rows(rows, n, middle);
    for (std::size_t c = 0; c < 3; ++c) {
        sums[c] = sums[c + 3] = middle[c];
        middle[n + c] = middle[n + 3 + c] = middle[n - 3 + c];
    }
    sum_five_pixels(sums.data(), n, out);
}

/// Least and largest value of each channel over 3 x 3 pixels of one row of a smooth picture.
struct Range {
    Bytes low;
    Bytes high;
    Bytes column_low;  ///< over 1 x 3 pixels, with one pixel more on each side
    Bytes column_high;

    RangeRow row() const { return {low.data(), high.data()}; }

    void compute(const Picture& picture, int y) {
        const std::size_t n = row_bytes(picture);
        low.resize(n);
        high.resize(n);
        column_low.resize(n + 6);
        column_high.resize(n + 6);
        Row up = row_of(picture, y - 1);
        Row at = row_of(picture, y);
        Row down = row_of(picture, y + 1);
        lesser_of(up, at, down, n, column_low.data() + 3);
        greater_of(up, at, down, n, column_high.data() + 3);
        for (std::size_t c = 0; c < 3; ++c) {
            column_low[c] = column_low[c + 3];
            column_high[c] = column_high[c + 3];
            column_low[n + 3 + c] = column_low[n + c];
            column_high[n + 3 + c] = column_high[n + c];
        }
        lesser_of(column_low.data(), column_low.data() + 3, column_low.data() + 6, n, low.data());
        greater_of(column_high.data(), column_high.data() + 3, column_high.data() + 6, n, high.data());
    }
};

/// raw and its sums. Returns for each row whether it holds more than rounding.
std::vector<bool> measure_raw(const Picture& a, const Picture& b, DifferenceMap& map) {
    const auto width = static_cast<std::size_t>(a.width);
    const std::size_t n = row_bytes(a);
    std::vector<bool> has_differences(static_cast<std::size_t>(a.height));
    Bytes channels(n);
    SignedSums sums(n);
    std::int64_t sum = 0;
    for (int y = 0; y < a.height; ++y) {
        std::uint8_t* raw = map.raw.data() + width * static_cast<std::size_t>(y);
        if (std::memcmp(row_of(a, y), row_of(b, y), n) == 0) {
            std::memset(raw, 0, width);
            continue;
        }
        absolute_difference(row_of(a, y), row_of(b, y), n, channels.data());
        sums.add_row(row_of(a, y), row_of(b, y));
        sum += sum_of_differences(row_of(a, y), row_of(b, y), n);
        largest_channel(channels.data(), width, raw);
        const int row_largest = largest_of(raw, width);
        map.largest = std::max(map.largest, row_largest);
        map.differing += count_above(raw, width, 0);
        has_differences[static_cast<std::size_t>(y)] = row_largest > rounding_levels;
    }
    map.mean = static_cast<double>(sum) / (static_cast<double>(n) * a.height);
    sums.enter(width * static_cast<std::size_t>(a.height), map.hidden, map.drift);
    return has_differences;
}

/// Row y of the largest step of a channel from each pixel of a or b to the next one in x or y. largest: memory.
void measure_steps(const Picture& a, const Picture& b, int y, Bytes& largest, std::vector<std::uint8_t>& steps) {
    const std::size_t n = row_bytes(a);
    largest.resize(n);
    std::uint8_t* most = largest.data();
    absolute_difference(row_of(a, y), row_of(a, y + 1), n, most);
    raise_to_difference(row_of(a, y), row_of(a, y) + 3, n - 3, most);
    raise_to_difference(row_of(b, y), row_of(b, y + 1), n, most);
    raise_to_difference(row_of(b, y), row_of(b, y) + 3, n - 3, most);
    const auto width = static_cast<std::size_t>(a.width);
    largest_channel(most, width, steps.data() + width * static_cast<std::size_t>(y));
}

/// For each row whether one within `reach` is set.
std::vector<bool> widened(const std::vector<bool>& rows, int reach) {
    std::vector<bool> wide(rows.size());
    const int count = static_cast<int>(rows.size());
    for (int y = 0; y < count; ++y) {
        if (rows[static_cast<std::size_t>(y)]) {
            const auto begin = wide.begin() + std::max(y - reach, 0);
            std::fill(begin, wide.begin() + std::min(y + reach + 1, count), true);
        }
    }
    return wide;
}

void set_size(Picture& picture, const Picture& like) {
    picture.width = like.width;
    picture.height = like.height;
    picture.rgb.resize(like.rgb.size());
}

/// What a verdict needs, and a picture of the difference does not.
struct Sums {
    DriftSums drift;
    SquareSums squares;
    explicit Sums(const Picture& picture) : drift(picture), squares(picture) {}
};

/// Makes and measures the smooth pictures of a map, row by row.
class RowMeasurer {
public:
    explicit RowMeasurer(DifferenceMap& map) : map_(map), channels_(row_bytes(map.reference)) {}

    void smooth(const Picture& a, const Picture& b, int y) {
        const std::size_t first = channels_.size() * static_cast<std::size_t>(y);
        smooth_row(a, y, columns_, map_.reference.rgb.data() + first);
        smooth_row(b, y, columns_, map_.candidate.rgb.data() + first);
    }

    /// Smooth difference and excess; the rows above and below are smooth already.
    void measure(int y, Sums* sums) {
        const std::size_t n = channels_.size();
        const auto width = static_cast<std::size_t>(map_.width);
        Row pa = row_of(map_.reference, y);
        Row pb = row_of(map_.candidate, y);
        absolute_difference(pa, pb, n, channels_.data());
        largest_channel(channels_.data(), width, map_.smooth.data() + width * static_cast<std::size_t>(y));
        range_a_.compute(map_.reference, y);
        range_b_.compute(map_.candidate, y);
        std::fill(channels_.begin(), channels_.end(), std::uint8_t{0});
        raise_excess(pa, pb, range_a_.row(), n, channels_.data());
        raise_excess(pb, pa, range_b_.row(), n, channels_.data());
        largest_channel(channels_.data(), width, map_.excess.data() + width * static_cast<std::size_t>(y));
        if (sums != nullptr) {
            sums->drift.add_row(pa, pb, range_a_.row(), range_b_.row(), y);
        }
    }

private:
    DifferenceMap& map_;
    std::vector<std::uint16_t> columns_;
    Range range_a_;
    Range range_b_;
    Bytes channels_;
};

/// All of the map but its drift and squares. sums: adds the rows, and has the steps measured; null if neither is wanted.
void measure_maps(const Picture& a, const Picture& b, DifferenceMap& map, Sums* sums) {
    map.width = a.width;
    map.height = a.height;
    const std::size_t pixels = static_cast<std::size_t>(a.width) * static_cast<std::size_t>(a.height);
    map.raw.resize(pixels);
    map.smooth.assign(pixels, 0);
    map.excess.assign(pixels, 0);
    map.differing = 0;
    map.largest = 0;
    map.drift = {};
    const std::vector<bool> has_differences = measure_raw(a, b, map);
    map.steps.assign(pixels, 0);
    map.squares.clear();
    if (map.largest <= rounding_levels) {
        return;
    }
    set_size(map.reference, a);
    set_size(map.candidate, b);
    const std::vector<bool> needs_smooth = widened(has_differences, shift_reach);
    const std::vector<bool> needs_excess = widened(has_differences, weight_reach);
    // Of whole windows, so that the steps of rows without differences count.
    const std::vector<bool> needs_squares = widened(has_differences, shift_window);
    RowMeasurer measurer(map);
    Bytes memory;
    // One row is measured when the next one is smooth, while both are in the processor's caches.
    for (int y = 0; y <= a.height; ++y) {
        if (y < a.height && needs_smooth[static_cast<std::size_t>(y)]) {
            measurer.smooth(a, b, y);
        }
        if (y < a.height && sums != nullptr) {
            measure_steps(a, b, y, memory, map.steps);
        }
        if (y > 0 && needs_excess[static_cast<std::size_t>(y - 1)]) {
            measurer.measure(y - 1, sums);
        }
        if (y > 0 && sums != nullptr && needs_squares[static_cast<std::size_t>(y - 1)]) {
            sums->squares.add_row(map.reference, map.candidate, y - 1);
        }
    }
    if (sums != nullptr) {
        sums->drift.finish_band();
        sums->squares.finish_band();
        map.squares = sums->squares.cells();
    }
}

} // namespace

void measure(const Picture& a, const Picture& b, DifferenceMap& map) {
    Sums sums(a);
    measure_maps(a, b, map, &sums);
    sums.drift.find_block(map.drift);
}

void measure_hidden(const Picture& a, const Picture& b, const Picture& masked, DifferenceMap& map) {
    forget_hidden(map);
    const auto width = static_cast<std::size_t>(a.width);
    map.whole_raw.resize(width * static_cast<std::size_t>(a.height));
    Bytes channels(row_bytes(a));
    for (int y = 0; y < a.height; ++y) {
        absolute_difference(row_of(a, y), row_of(b, y), channels.size(), channels.data());
        largest_channel(channels.data(), width, map.whole_raw.data() + width * static_cast<std::size_t>(y));
    }
    for (std::size_t i = 0; i < b.rgb.size(); ++i) {
        const int d = b.rgb[i] - masked.rgb[i]; // 0 where nothing is hidden
        if (d != 0 && std::abs(d) <= drift_levels) {
            HiddenSigns::Sum& sum = (d > 0 ? map.hidden.up : map.hidden.down)[i % 3];
            sum.levels += std::abs(d);
            ++sum.count;
        }
    }
}

void forget_hidden(DifferenceMap& map) {
    map.whole_raw.clear();
    map.hidden = {};
    map.whole_shift.reset();
}

void measure_excess(const Picture& a, const Picture& b, DifferenceMap& map) {
    measure_maps(a, b, map, nullptr);
}

std::vector<std::int32_t> count_in_cells(const std::vector<std::uint8_t>& values, int width, int height, int level) {
    const auto columns = static_cast<std::size_t>(cell_count(width));
    std::vector<std::int32_t> cells;
    cells.reserve(columns * static_cast<std::size_t>(cell_count(height)));
    Bytes above(columns * cell_size); // in each column of the rows of one cell
    const auto bound = static_cast<std::uint8_t>(level);
    for (int top = 0; top < height; top += cell_size) {
        std::fill(above.begin(), above.end(), std::uint8_t{0});
        for (int y = top; y < std::min(top + cell_size, height); ++y) {
            const auto n = static_cast<std::size_t>(width);
            add_above(values.data() + static_cast<std::size_t>(y) * n, n, bound, above.data());
        }
        for (std::size_t c = 0; c < columns; ++c) {
            const std::uint8_t* sums = above.data() + c * cell_size;
            cells.push_back(sums[0] + sums[1] + sums[2] + sums[3]);
        }
    }
    return cells;
}

} // namespace diff
