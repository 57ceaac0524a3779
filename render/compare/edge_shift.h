#pragma once
/// By how far the edges of a small part would have to be moved to differ as much as they do.
///
/// Where a picture moves by u px, it differs by u times its slope: the sum of its squared differences is u^2 times that of
/// its squared slopes. Other samples, grain and lossy encoders change an edge less than a shift by a pixel does, wherever
/// it is and however steep; a body that moves, comes or goes changes it more.
#include "render/compare/difference.h"
#include "render/compare/rows.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace diff {

/// Every second row tells enough of pictures out of focus.
inline constexpr int square_rows = 2;

/// Squares of two pictures, by cell.
class SquareSums {
public:
    explicit SquareSums(const Picture& picture) : columns_(static_cast<std::size_t>(cell_count(picture.width))) {
        cells_.resize(columns_ * static_cast<std::size_t>(cell_count(picture.height)));
        for (std::vector<std::uint32_t>& sums : sums_) {
            sums.resize(columns_ * cell_bytes);
        }
        values_.resize(row_bytes(picture));
    }

    /// Rows ascend.
    void add_row(const Picture& a, const Picture& b, int y) {
        if (y % square_rows != 0) {
            return;
        }
        if (y / cell_size != band_) {
            finish_band();
            band_ = y / cell_size;
        }
        const std::size_t n = values_.size();
        absolute_difference(row_of(a, y), row_of(b, y), n, values_.data());
        add_squares(values_.data(), n, sums_[0].data());
        for (int side = 0; side < 2; ++side) {
            const Picture& picture = side == 0 ? a : b;
            absolute_difference(row_of(picture, y), row_of(picture, y + 1), n, values_.data());
            raise_to_difference(row_of(picture, y), row_of(picture, y) + 3, n - 3, values_.data());
            add_squares(values_.data(), n, sums_[side + 1].data());
        }
    }

    /// After the last row.
    void finish_band() {
        SquareCell* cells = cells_.data() + static_cast<std::size_t>(band_) * columns_;
        const auto sum_of = [](const std::vector<std::uint32_t>& sums, std::size_t column) {
            const auto first = sums.begin() + static_cast<std::ptrdiff_t>(column * cell_bytes);
            return std::accumulate(first, first + cell_bytes, 0u);
        };
        for (std::size_t column = 0; column < columns_; ++column) {
            cells[column].differences += sum_of(sums_[0], column);
            cells[column].steps[0] += sum_of(sums_[1], column);
            cells[column].steps[1] += sum_of(sums_[2], column);
        }
        for (std::vector<std::uint32_t>& sums : sums_) {
            std::fill(sums.begin(), sums.end(), 0u);
        }
    }

    const std::vector<SquareCell>& cells() const { return cells_; }

private:
    static constexpr std::size_t cell_bytes = std::size_t{cell_size} * 3; ///< of a row

    std::size_t columns_;
    std::vector<SquareCell> cells_;
    int band_ = 0;
    // Of the rows of one cell under way, by column and channel: of differences and of both pictures' steps [levels^2].
    std::vector<std::uint32_t> sums_[3];
    Bytes values_; ///< of one row
};

/// Shifts of all windows, wherever they lie.
struct EdgeShift {
    double pixels = 0.0; ///< [px] of the farthest window
    int x = 0;           ///< [px] its upper left corner
    int y = 0;           ///< [px]
    double usual = 0.0;  ///< [px] that nine of ten edges stay below, each as heavy as it is steep
};
inline constexpr int shift_window = 8; ///< [px] its side

EdgeShift find_edge_shift(const DifferenceMap& map);

} // namespace diff
