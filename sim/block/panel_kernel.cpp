/// Products of blocks of 6 x 6, as many rows at a time as a register holds. Compiled once for each instruction set; KERNEL names it.
#include "sim/base/lanes.h"
#include "sim/block/panel.h"

#include <cstddef>

namespace sim {
namespace {

/// The first `count` of these.
LANES_INLINE Mask first_lanes(int count) {
    Mask lane;
    for (int l = 0; l < width; ++l) {
        lane[l] = l;
    }
    return lane < static_cast<long long>(count);
}

/// Rows that follow each other in both panels.
LANES_INLINE void subtract_rows(const PanelProduct& work, const double* from, double* to, int rows) {
    for (int row = 0; row < rows; row += width) {
        Real left[6];
        for (int k = 0; k < 6; ++k) {
            left[k] = load_anywhere(from + row + static_cast<std::ptrdiff_t>(k) * work.from_rows);
        }
        const Mask inside = first_lanes(rows - row);
        for (int column = 0; column < 6; ++column) {
            Real sum = left[0] * work.factor[column];
            for (int k = 1; k < 6; ++k) {
                sum += left[k] * work.factor[6 * k + column];
            }
            double* const at = to + row + static_cast<std::ptrdiff_t>(column) * work.to_rows;
            const Real before = load_anywhere(at);
            store_anywhere(at, select(inside, before - sum, before));
        }
    }
}

} // namespace

void KERNEL(const PanelProduct& work) {
    for (int first = 0; first < work.count;) {
        int last = first + 1;
        while (last < work.count && work.places[last] == work.places[last - 1] + 1) {
            ++last;
        }
        subtract_rows(work, work.from + 6 * first, work.to + 6 * work.places[first], 6 * (last - first));
        first = last;
    }
}

} // namespace sim
