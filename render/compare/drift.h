#pragma once
/// Signed differences of two pictures, row by row: a light or a gain that moves all pixels the same way.
#include "render/compare/difference.h"
#include "render/compare/rows.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace diff {

/// A pixel is flat if its neighbours in the smooth picture differ by no more than this [levels].
inline constexpr int flat_levels = 12;

/// Sums of drift are kept for squares of this side [px]; a block is two by two of them.
inline constexpr int drift_cell = drift_block / 2;

/// Sums of signed differences on flat pixels.
class DriftSums {
public:
    explicit DriftSums(const Picture& picture)
        : width_(picture.width), height_(picture.height), columns_((picture.width + drift_cell - 1) / drift_cell),
          rows_((picture.height + drift_cell - 1) / drift_cell) {
        for (std::vector<std::int32_t>& channel : cells_) {
            channel.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
        }
        sums_.resize(row_bytes(picture));
    }

    /// Rows ascend.
    void add_row(Row a, Row b, const RangeRow& range_a, const RangeRow& range_b, int y) {
        if (y / drift_cell != band_) {
            finish_band();
            band_ = y / drift_cell;
        }
        const std::size_t n = sums_.size();
        spread_.resize(n);
        std::uint8_t* spread = spread_.data();
        subtract(range_a.high, range_a.low, n, spread);
        raise_to_difference(range_b.high, range_b.low, n, spread);
        add_where_flat(a, b, {spread, flat_levels, rounding_levels}, n, sums_.data());
    }

    /// After the last row.
    void finish_band() {
        for (std::size_t i = 0; i < sums_.size(); ++i) {
            const std::size_t column = i / (std::size_t{drift_cell} * 3);
            cells_[i % 3][static_cast<std::size_t>(band_ * columns_) + column] += sums_[i];
        }
        std::fill(sums_.begin(), sums_.end(), std::int16_t{0});
    }

    /// The largest mean of a block.
    void find_block(Drift& drift) const {
        const double block_pixels =
            static_cast<double>(std::min(drift_block, width_)) * static_cast<double>(std::min(drift_block, height_));
        for (std::size_t c = 0; c < 3; ++c) {
            for (int y = 0; y == 0 || y + 1 < rows_; ++y) {
                for (int x = 0; x == 0 || x + 1 < columns_; ++x) {
                    const double block = block_sum(cells_[c], x, y) / block_pixels;
                    if (std::abs(block) > std::abs(drift.block)) {
                        drift.block = block;
                        drift.x = x * drift_cell;
                        drift.y = y * drift_cell;
                    }
                }
            }
        }
    }

private:
    double block_sum(const std::vector<std::int32_t>& cells, int x, int y) const {
        double sum = 0.0;
        for (int row = y; row < std::min(y + 2, rows_); ++row) {
            for (int column = x; column < std::min(x + 2, columns_); ++column) {
                sum += cells[static_cast<std::size_t>(row * columns_ + column)];
            }
        }
        return sum;
    }

    int width_;
    int height_;
    int columns_;
    int rows_;
    std::array<std::vector<std::int32_t>, 3> cells_; ///< [levels px]
    // Of the band of drift_cell rows under way, by column and channel: at most 32 * 255.
    int band_ = 0;
    std::vector<std::int16_t> sums_; ///< [levels px]
    Bytes spread_;                   ///< of one row
};

/// Larger differences [levels] are no drift, but of edges, or something that has come or gone.
inline constexpr std::uint8_t drift_levels = 16;

/// Signed differences of each channel, added up by column first: so their sums are vector instructions.
class SignedSums {
public:
    explicit SignedSums(std::size_t n) : sums_(n), balances_(n), counts_(n) {}

    void add_row(Row a, Row b) {
        add_signed(a, b, sums_.size(), {drift_levels, sums_.data(), balances_.data(), counts_.data()});
        constexpr int most_rows = 128; // of differences of up to 255
        if (++rows_ == most_rows) {
            flush();
        }
    }

    /// hidden: none of these may be drift, all may speak against it, so that more masked is never more drift.
    void enter(std::size_t pixels, const HiddenSigns& hidden, Drift& drift) {
        constexpr double by_chance = 3.0; // standard deviations of the balance of signs that are tossed
        flush();
        double largest = -1.0;
        for (std::size_t c = 0; c < 3; ++c) {
            const auto n = static_cast<double>(std::max<std::int64_t>(count_[c] + hidden.up[c].count + hidden.down[c].count, 1));
            for (const int sign : {1, -1}) {
                const HiddenSigns::Sum& against = sign > 0 ? hidden.down[c] : hidden.up[c];
                const auto balance = static_cast<double>(sign * balance_[c] - against.count);
                const double mean = static_cast<double>(sign * sum_[c] - against.levels) / static_cast<double>(pixels);
                const double one_sided = std::max(0.0, balance / n - by_chance / std::sqrt(n));
                if (mean >= 0.0 && mean * one_sided > largest) {
                    largest = mean * one_sided;
                    drift.mean = sign * mean;
                    drift.one_sided = one_sided;
                }
            }
        }
    }

private:
    void flush() {
        for (std::size_t i = 0; i < sums_.size(); ++i) {
            sum_[i % 3] += sums_[i];
            balance_[i % 3] += balances_[i];
            count_[i % 3] += counts_[i];
        }
        for (std::vector<std::int16_t>* columns : {&sums_, &balances_, &counts_}) {
            std::fill(columns->begin(), columns->end(), std::int16_t{0});
        }
        rows_ = 0;
    }

    std::vector<std::int16_t> sums_;     ///< [levels]
    std::vector<std::int16_t> balances_; ///< rows in which b is larger, less those in which it is smaller
    std::vector<std::int16_t> counts_;   ///< rows in which they differ
    int rows_ = 0;
    // Of each channel.
    std::array<std::int64_t, 3> sum_{};
    std::array<std::int64_t, 3> balance_{};
    std::array<std::int64_t, 3> count_{};
};

} // namespace diff
