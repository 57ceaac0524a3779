#include "render/compare/edge_shift.h"

#include <cmath>

namespace diff {

namespace {

/// Slopes of a window are no less than if each channel of each pixel had this one [levels/px]: what is faint, grain and the
/// rings that encoders draw, is not made an edge of.
constexpr double least_slope = 16.0;

} // namespace

EdgeShift farthest_shift(const DifferenceMap& map) {
    constexpr int side = shift_window / cell_size;
    const int columns = cell_count(map.width);
    const int rows = cell_count(map.height);
    EdgeShift farthest;
    double largest = 0.0; // squared
    if (map.squares.empty()) {
        return farthest;
    }
    for (int row = 0; row == 0 || row + side <= rows; ++row) {
        for (int column = 0; column == 0 || column + side <= columns; ++column) {
            double differences = 0.0;
            double slopes = least_slope * least_slope * 3 * shift_window * shift_window / square_rows;
            for (int y = row; y < std::min(row + side, rows); ++y) {
                for (int x = column; x < std::min(column + side, columns); ++x) {
                    const SquareCell& cell = map.squares[static_cast<std::size_t>(y * columns + x)];
                    differences += cell.differences;
                    slopes += 0.5 * (cell.steps[0] + cell.steps[1]);
                }
            }
            if (differences > largest * slopes) {
                largest = differences / slopes;
                farthest = {0.0, column * cell_size, row * cell_size};
            }
        }
    }
    farthest.pixels = std::sqrt(largest);
    return farthest;
}

double mean_shift(const DifferenceMap& map) {
    double differences = 0.0;
    double slopes = 0.0;
    for (const SquareCell& cell : map.squares) {
        differences += cell.differences;
        slopes += 0.5 * (cell.steps[0] + cell.steps[1]);
    }
    return slopes > 0.0 ? std::sqrt(differences / slopes) : 0.0;
}

} // namespace diff
