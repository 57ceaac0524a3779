#include "render/compare/stray.h"

#include "render/compare/rows.h"

#include <algorithm>

namespace diff {

namespace {

constexpr int stray_levels = 40;      ///< by which a stray pixel differs
constexpr int stray_flat_levels = 24; ///< range of a channel within flat_reach of it
constexpr int flat_reach = 2;         ///< [px]

bool is_flat_around(const Picture& picture, int x, int y) {
    const int left = std::max(x - flat_reach, 0);
    const int right = std::min(x + flat_reach, picture.width - 1);
    for (std::size_t c = 0; c < 3; ++c) {
        int low = 255;
        int high = 0;
        for (int row = std::max(y - flat_reach, 0); row <= std::min(y + flat_reach, picture.height - 1); ++row) {
            for (int column = left; column <= right; ++column) {
                const int value = picture.rgb[(static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.width) +
                                               static_cast<std::size_t>(column)) * 3 + c];
                low = std::min(low, value);
                high = std::max(high, value);
            }
        }
        if (high - low > stray_flat_levels) {
            return false;
        }
    }
    return true;
}

} // namespace

Peak count_strays(const Picture& a, const Picture& b, const std::vector<std::uint8_t>& raw, int most) {
    Peak found;
    const auto width = static_cast<std::size_t>(a.width);
    for (int y = 0; y < a.height; ++y) {
        Row row = raw.data() + width * static_cast<std::size_t>(y);
        if (largest_of(row, width) <= stray_levels) {
            continue;
        }
        for (int x = 0; x < a.width && found.value < most; ++x) {
            if (row[x] > stray_levels && (is_flat_around(a, x, y) || is_flat_around(b, x, y))) {
                found = found.value == 0 ? Peak{1, x, y} : Peak{found.value + 1, found.x, found.y};
            }
        }
    }
    return found;
}

} // namespace diff
