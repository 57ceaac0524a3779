/// Impulses of batches extrapolated beyond a sweep, eight blocks at a time; see extrapolation.h.
/// Compiled once for each instruction set; KERNEL names it.
#include "sim/block/lane_twist.h"

namespace sim {
namespace {

LANES_INLINE Real3 impulse_of(const BatchPoint& point) {
    return {load(point.p_t[0]), load(point.p_t[1]), load(point.p_n)};
}

/// A batch's share of what Extrapolation::next() asks for.
LANES_INLINE double along_step(const BatchExtrapolation& work, const BlockBatch& batch) {
    Real sum = real(0.0);
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        const Real3 now = impulse_of(work.points[k]);
        const ExtrapolatedPoint& before = work.before[k];
        sum += dot(now - load3(before.begun), now - load3(before.swept));
    }
    Lanes sums;
    store(sums, sum);
    double total = 0.0;
    for (const double x : sums.x) {
        total += x;
    }
    return total;
}

/// Repeats a share of what the last sweep did to the impulses of a batch, and gives its bodies the difference.
LANES_INLINE void extrapolate_batch(const BatchExtrapolation& work, BlockBatch& batch) {
    const Real zero = real(0.0);
    Mask pulls = zero < zero; // until the next visit: eq. 3 holds there, and none passes it over
    Real3 force{zero, zero, zero};
    Real3 moment{zero, zero, zero};
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        BatchPoint& point = work.points[k];
        ExtrapolatedPoint& before = work.before[k];
        const Real x = load(point.x);
        const Real y = load(point.y);
        const Real3 now = impulse_of(point);
        const Real3 added = real(work.share) * (now - load3(before.swept));
        const Real3 next = now + added;
        pulls |= next.z < 0.0;
        store3(before.swept, now);
        store3(before.begun, next);
        store(point.p_t[0], next.x);
        store(point.p_t[1], next.y);
        store(point.p_n, next.z);
        force = force + added;
        moment = moment + Real3{added.z * y, -(added.z * x), x * added.y - y * added.x};
    }
    store(batch.seen[2], select(pulls, real(no_point), load(batch.seen[2])));
    const Frame f = frame_of(batch);
    push_bodies(work.rows, work.velocity, batch, f.world(force), f.world(moment));
}

} // namespace

void KERNEL(const BatchExtrapolation& work) {
    for (std::size_t i = 0; i < work.batch_count; ++i) {
        if (work.along != nullptr) {
            work.along[i] = along_step(work, work.batches[i]);
        } else {
            extrapolate_batch(work, work.batches[i]);
        }
    }
}

} // namespace sim
