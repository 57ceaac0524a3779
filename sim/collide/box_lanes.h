#pragma once
/// A box in each lane. Included by kernels only.
#include "sim/base/lanes.h"
#include "sim/collide/box_pairs.h"

namespace sim {
namespace { // NOLINT: see lanes.h

struct Boxes {
    Real3 axes[3]; ///< in the world
    Real3 centre;
    Real half[3];
};

LANES_INLINE Boxes gather_boxes(const PlacedBoxRow* boxes, const int* index) {
    Real low[8];
    Real high[8];
    gather([&](int l) { return boxes[index[l]].axes; }, low);
    gather([&](int l) { return boxes[index[l]].axes + 8; }, high);
    return {{{low[0], low[1], low[2]}, {low[3], low[4], low[5]}, {low[6], low[7], high[0]}},
            {high[1], high[2], high[3]},
            {high[4], high[5], high[6]}};
}

} // namespace
} // namespace sim
