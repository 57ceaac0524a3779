/// One sweep over batches of blocks. Compiled once for each instruction set; KERNEL names it.
#include "sim/block/friction.h"
#include "sim/block/normals.h"

namespace sim {
namespace {

/// Solves the blocks of the lanes that are due with all others held. Returns the largest change of each lane.
template <int N>
LANES_INLINE Real visit_lanes(const BatchSweep& sweep, BlockBatch& batch, Visit<N>& v) {
    const Real zero = real(0.0);
    v.force = v.moment = {zero, zero, zero};
    v.change = v.left = zero;
    v.share = real(1.0);
    for (int k = 0; k < N; ++k) {
        const BatchPoint& point = v.points[k];
        v.p_n[k] = v.load(point.p_n);
        v.p_1[k] = v.load(point.p_t[0]);
        v.p_2[k] = v.load(point.p_t[1]);
    }
    v.solve_normals(real(sweep.tolerance), select(v.lanes_of(batch.led), real(sweep.softness), zero));
    if (batch.has_friction) {
        v.solve_friction();
    }
    const auto put = [&](Lanes& to, const Real& x) { v.store(to, select(v.due, x, v.load(to))); };
    const auto put3 = [&](Lanes* to, const Real3& x) { v.store3(to, select(v.due, x, v.load3(to))); };
    const Real share = sweep.by_half ? min(v.share, real(0.5)) : v.share;
    const Mask part = share < 1.0;
    if (any(part)) {
        Mask pulls = nowhere(); // extrapolation left it so, and a share of it would
        for (int k = 0; k < N; ++k) {
            pulls |= v.load(v.points[k].p_n) < 0.0;
        }
        const Real taken = select(pulls, real(1.0), share);
        const auto take = [&](Real& found, const Lanes& before) {
            found = select(part, taken * found + (1.0 - taken) * v.load(before), found);
        };
        for (int k = 0; k < N; ++k) {
            const BatchPoint& point = v.points[k];
            take(v.p_n[k], point.p_n);
            take(v.p_1[k], point.p_t[0]);
            take(v.p_2[k], point.p_t[1]);
        }
        v.force = taken * v.force;
        v.moment = taken * v.moment;
        v.left = select(part, real(infinity), v.left);
    }
    for (int k = 0; k < N; ++k) {
        BatchPoint& point = v.points[k];
        put(point.p_n, v.p_n[k]);
        put(point.p_t[0], v.p_1[k]);
        put(point.p_t[1], v.p_2[k]);
    }
    const Frame f = frame_of(batch, v);
    const Real3 none{zero, zero, zero};
    push_bodies(sweep.rows, sweep.velocity, batch, v, {f.world(select(v.due, v.force, none)), f.world(select(v.due, v.moment, none))});
    put3(batch.seen, {v.twist.u.x, v.twist.u.y, select(v.left > sweep.skip, real(no_point), v.twist.u.z)});
    put3(batch.seen + 3, v.twist.w);
    return select(v.due, v.change, zero);
}

/// The same for the lanes at whose points velocities changed by more than `skip` since they were visited last.
template <int N>
Real visit_batch(const BatchSweep& sweep, BlockBatch& batch) {
    BatchPoint* points = sweep.points + batch.first;
    Real largest = real(0.0);
    for (int first = 0; first < lane_count; first += width) {
        Visit<N> v(batch, points, first);
        v.twist = twist_of(sweep.velocity, batch, frame_of(batch, v), v);
        const Twist since{v.twist.u - v.load3(batch.seen), v.twist.w - v.load3(batch.seen + 3)};
        v.due = v.lanes_of(points[0].there) & (v.largest_square(since) > sweep.skip * sweep.skip);
        const Real change = any(v.due) ? visit_lanes(sweep, batch, v) : real(0.0);
        v.store(batch.change, change);
        largest = max(largest, change);
    }
    return largest;
}

Real visit_batch(const BatchSweep& sweep, BlockBatch& batch) {
    switch (batch.count) {
    case 1:
        return visit_batch<1>(sweep, batch);
    case 2:
        return visit_batch<2>(sweep, batch);
    case 4:
        return visit_batch<4>(sweep, batch);
    case 6:
        return visit_batch<6>(sweep, batch);
    default:
        return visit_batch<9>(sweep, batch);
    }
}

} // namespace

double KERNEL(const BatchSweep& sweep) {
    Real worst = real(0.0);
    for (std::size_t i = 0; i < sweep.batch_count; ++i) {
        worst = max(worst, visit_batch(sweep, sweep.batches[i]));
    }
    double largest = 0.0;
    for (int l = 0; l < width; ++l) {
        largest = largest < worst[l] ? worst[l] : largest;
    }
    return largest;
}

} // namespace sim
