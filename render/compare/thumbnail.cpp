#include "render/compare/thumbnail.h"

#include "render/compare/rows.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace diff {

namespace {

/// Rows of a part that are looked at: about so many, evenly spread.
constexpr int rows_of_part = 8;

/// First row or column of a picture in part k.
int part_start(int k, int size) {
    return static_cast<int>((std::int64_t{k} * size + thumbnail_side - 1) / thumbnail_side);
}

} // namespace

Thumbnail thumbnail_of(const Picture& picture) {
    Thumbnail means{};
    std::vector<std::uint16_t> sums;
    for (int row = 0; row < thumbnail_side; ++row) {
        const int top = part_start(row, picture.height);
        const int bottom = part_start(row + 1, picture.height);
        const int step = std::max(1, (bottom - top) / rows_of_part);
        sums.assign(row_bytes(picture), 0);
        for (int y = top; y < bottom; y += step) {
            add_row(row_of(picture, y), sums.size(), sums.data());
        }
        for (int column = 0; column < thumbnail_side; ++column) {
            const int left = part_start(column, picture.width);
            const int right = part_start(column + 1, picture.width);
            const int count = std::max((bottom - top + step - 1) / step * (right - left), 1);
            for (int c = 0; c < 3; ++c) {
                std::uint64_t sum = 0;
                for (int x = left; x < right; ++x) {
                    sum += sums[static_cast<std::size_t>(3 * x + c)];
                }
                means[static_cast<std::size_t>((row * thumbnail_side + column) * 3 + c)] =
                    static_cast<float>(sum) / static_cast<float>(count);
            }
        }
    }
    return means;
}

} // namespace diff
