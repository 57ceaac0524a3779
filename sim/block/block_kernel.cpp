/// One sweep over batches of blocks. Compiled once for each instruction set; KERNEL names it.
#include "sim/block/solve.h"

namespace sim {
namespace {

/// Solves the blocks of a batch with all others held. change: largest velocity change at a point of each lane.
template <int N>
void visit_batch(const BatchSweep& sweep, const BlockBatch& batch, Lanes& change) {
    Visit<N> v(batch, sweep.points + batch.first);
    const Frame f = frame_of(batch);
    v.twist = twist_of(sweep.velocity, batch, f);
    const Real zero = real(0.0);
    v.force = v.moment = {zero, zero, zero};
    v.change = zero;
    for (int k = 0; k < N; ++k) {
        const BatchPoint& point = v.points[k];
        v.x[k] = load(point.x);
        v.y[k] = load(point.y);
        v.p_n[k] = load(point.p_n);
        v.p_1[k] = load(point.p_t[0]);
        v.p_2[k] = load(point.p_t[1]);
    }
    v.solve_normals(real(sweep.slack));
    if (batch.has_friction) {
        v.solve_friction();
    }
    for (int k = 0; k < N; ++k) {
        store(v.points[k].p_n, v.p_n[k]);
        store(v.points[k].p_t[0], v.p_1[k]);
        store(v.points[k].p_t[1], v.p_2[k]);
    }
    push_bodies(sweep.rows, sweep.velocity, batch, f.world(v.force), f.world(v.moment));
    store(change, v.change);
}

void visit_batch(const BatchSweep& sweep, const BlockBatch& batch, Lanes& change) {
    switch (batch.count) {
    case 1:
        return visit_batch<1>(sweep, batch, change);
    case 2:
        return visit_batch<2>(sweep, batch, change);
    case 4:
        return visit_batch<4>(sweep, batch, change);
    case 6:
        return visit_batch<6>(sweep, batch, change);
    default:
        return visit_batch<9>(sweep, batch, change);
    }
}

/// Did the bodies of any lane change by more than `skip` since it was last solved?
LANES_INLINE bool is_awake(const BlockBatch& batch, const double* activity, double skip) {
    bool awake = false;
    for (int l = 0; l < lane_count; ++l) {
        const double since = activity[batch.a[l]] - batch.seen_a.x[l] + activity[batch.b[l]] - batch.seen_b.x[l];
        awake |= batch.block[l] >= 0 && (batch.seen_a.x[l] < 0.0 || since > skip);
    }
    return awake;
}

} // namespace

double KERNEL(const BatchSweep& sweep) {
    double worst = 0.0;
    for (std::size_t i = 0; i < sweep.batch_count; ++i) {
        BlockBatch& batch = sweep.batches[i];
        if (!is_awake(batch, sweep.activity, sweep.skip)) {
            continue;
        }
        visit_batch(sweep, batch, batch.change);
        for (int l = 0; l < lane_count; ++l) {
            if (batch.block[l] < 0) {
                continue;
            }
            const double change = batch.change.x[l];
            double& active_a = sweep.activity[batch.a[l]];
            double& active_b = sweep.activity[batch.b[l]];
            if ((batch.moves_a >> l & 1u) != 0) {
                active_a += change;
            }
            if ((batch.moves_b >> l & 1u) != 0) {
                active_b += change;
            }
            // One visit leaves a rest where friction and normal impulses depend on each other.
            batch.seen_a.x[l] = change > sweep.skip ? -1.0 : active_a;
            batch.seen_b.x[l] = active_b;
            worst = worst < change ? change : worst;
        }
    }
    return worst;
}

} // namespace sim
