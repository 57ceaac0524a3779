#include "render/compare/edge_shift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace diff {

namespace {

/// Slopes of a window are no less than if each channel of each pixel had this one [levels/px]: what is faint, grain and the
/// rings that encoders draw, is not made an edge of.
constexpr double least_slope = 16.0;

/// Slopes by shift: how many of the edges stay below one.
class Shifts {
public:
    void add(double pixels, double slopes) {
        bins_[std::min(static_cast<std::size_t>(pixels / bin), bins_.size() - 1)] += slopes;
        sum_ += slopes;
    }

    double usual() const {
        constexpr double share = 0.9; // [-] of the edges
        double below = 0.0;
        std::size_t i = 0;
        while (i < bins_.size() && below + bins_[i] <= share * sum_) {
            below += bins_[i++];
        }
        return bin * static_cast<double>(i);
    }

private:
    static constexpr double bin = 0.01; ///< [px]
    std::array<double, 500> bins_{};
    double sum_ = 0.0;
};

} // namespace

EdgeShift find_edge_shift(const DifferenceMap& map) {
    constexpr int side = shift_window / cell_size;
    constexpr double least_slopes = least_slope * least_slope * 3 * shift_window * shift_window / square_rows;
    const int columns = cell_count(map.width);
    const int rows = cell_count(map.height);
    EdgeShift farthest;
    if (map.squares.empty()) {
        return farthest;
    }
    Shifts shifts;
    for (int row = 0; row == 0 || row + side <= rows; ++row) {
        for (int column = 0; column == 0 || column + side <= columns; ++column) {
            std::uint32_t differences = 0;
            std::uint32_t steps = 0; // of both pictures
            for (int y = row; y < std::min(row + side, rows); ++y) {
                for (int x = column; x < std::min(column + side, columns); ++x) {
                    const SquareCell& cell = map.squares[static_cast<std::size_t>(y * columns + x)];
                    differences += cell.differences;
                    steps += cell.steps[0] + cell.steps[1];
                }
            }
            const double slopes = 0.5 * steps;
            const double shift = std::sqrt(differences / (slopes + least_slopes));
            shifts.add(shift, slopes);
            if (shift > farthest.pixels) {
                farthest = {shift, column * cell_size, row * cell_size};
            }
        }
    }
    farthest.usual = shifts.usual();
    return farthest;
}

} // namespace diff
