/// Impulses of batches extrapolated beyond a sweep, eight blocks at a time; see extrapolation.h.
/// Compiled once for each instruction set; KERNEL names it.
#include "sim/block/lane_twist.h"

namespace sim {
namespace {

LANES_INLINE Real3 impulse_of(const BatchPoint& point, Window lanes) {
    return {lanes.load(point.p_t[0]), lanes.load(point.p_t[1]), lanes.load(point.p_n)};
}

LANES_INLINE StepParts parts_of_step(const BatchExtrapolation& work, const BlockBatch& batch) {
    StepParts parts;
    for (Window lanes; lanes.first < lane_count; lanes.first += width) {
        Real extrapolated = real(0.0);
        Real swept = real(0.0);
        for (int k = batch.first; k < batch.first + batch.count; ++k) {
            const Real3 now = impulse_of(work.points[k], lanes);
            const Real3 begun = lanes.load3(work.before[k].begun);
            const Real3 before = lanes.load3(work.before[k].swept);
            extrapolated += dot(begun - before, now - before);
            swept += dot(now - begun, now - before);
        }
        for (int l = 0; l < width; ++l) {
            parts.extrapolated += extrapolated[l];
            parts.swept += swept[l];
        }
    }
    return parts;
}

/// Repeats a share of what the last sweep did to the impulses of these lanes, and gives their bodies the difference.
LANES_INLINE void extrapolate_lanes(const BatchExtrapolation& work, BlockBatch& batch, Window lanes) {
    const Real zero = real(0.0);
    Mask breaks = nowhere(); // eq. 3 or 4, until the next visit, and none passes it over
    Real3 force{zero, zero, zero};
    Real3 moment{zero, zero, zero};
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        BatchPoint& point = work.points[k];
        ExtrapolatedPoint& before = work.before[k];
        const Real x = lanes.load(point.x);
        const Real y = lanes.load(point.y);
        const Real3 now = impulse_of(point, lanes);
        const Real3 added = real(work.share) * (now - lanes.load3(before.swept));
        const Real3 next = now + added;
        const Real limit = lanes.load(batch.mu) * next.z;
        breaks |= (next.z < 0.0) | (next.x * next.x + next.y * next.y > limit * limit);
        lanes.store3(before.swept, now);
        lanes.store3(before.begun, next);
        lanes.store(point.p_t[0], next.x);
        lanes.store(point.p_t[1], next.y);
        lanes.store(point.p_n, next.z);
        force = force + added;
        moment = moment + Real3{added.z * y, -(added.z * x), x * added.y - y * added.x};
    }
    lanes.store(batch.seen[2], select(breaks, real(no_point), lanes.load(batch.seen[2])));
    const Frame f = frame_of(batch, lanes);
    push_bodies(work.rows, work.velocity, batch, lanes, {f.world(force), f.world(moment)});
}

} // namespace

void KERNEL(const BatchExtrapolation& work) {
    for (std::size_t i = 0; i < work.batch_count; ++i) {
        if (work.parts != nullptr) {
            work.parts[i] = parts_of_step(work, work.batches[i]);
            continue;
        }
        for (Window lanes; lanes.first < lane_count; lanes.first += width) {
            extrapolate_lanes(work, work.batches[i], lanes);
        }
    }
}

} // namespace sim
