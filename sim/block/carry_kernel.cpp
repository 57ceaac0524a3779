/// Impulses of batches carried on beyond a sweep, eight blocks at a time: TogetherSweeps::carry_on() is the readable form.
/// Compiled once for each instruction set; KERNEL names it.
#include "sim/base/lanes.h"
#include "sim/block/batch.h"

namespace sim {
namespace {

LANES_INLINE Real3 impulse_of(const BatchPoint& point) {
    return {load(point.p_t[0]), load(point.p_t[1]), load(point.p_n)};
}

/// A batch's share of what Momentum::next() asks for.
LANES_INLINE double along_step(const BatchCarry& carry, const BlockBatch& batch) {
    Real sum = real(0.0);
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        const Real3 now = impulse_of(carry.points[k]);
        const CarriedPoint& carried = carry.carried[k];
        sum += dot(now - load3(carried.begun), now - load3(carried.swept));
    }
    Lanes sums;
    store(sums, sum);
    double total = 0.0;
    for (const double x : sums.x) {
        total += x;
    }
    return total;
}

/// Adds to the activity of bodies what their points of contact move.
LANES_INLINE void add_activity(double* activity, const int* body, unsigned moves, const Push& push, const Real3& r) {
    Lanes moved;
    store(moved, norm(push.dv) + norm(push.dw) * norm(r));
    for (int l = 0; l < lane_count; ++l) {
        if ((moves >> l & 1u) != 0) {
            activity[body[l]] += moved.x[l];
        }
    }
}

/// Repeats a share of what the last sweep did to the impulses of a batch, and gives its bodies the difference.
LANES_INLINE void carry_batch(const BatchCarry& carry, const BlockBatch& batch) {
    const Real zero = real(0.0);
    Real3 force{zero, zero, zero};
    Real3 moment{zero, zero, zero};
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        BatchPoint& point = carry.points[k];
        CarriedPoint& carried = carry.carried[k];
        const Real x = load(point.x);
        const Real y = load(point.y);
        const Real3 now = impulse_of(point);
        const Real3 added = real(carry.momentum) * (now - load3(carried.swept));
        const Real3 next = now + added;
        store3(carried.swept, now);
        store3(carried.begun, next);
        store(point.p_t[0], next.x);
        store(point.p_t[1], next.y);
        store(point.p_n, next.z);
        force = force + added;
        moment = moment + Real3{added.z * y, -(added.z * x), x * added.y - y * added.x};
    }
    const Real3 t1 = load3(batch.frame);
    const Real3 t2 = load3(batch.frame + 3);
    const Real3 n = load3(batch.frame + 6);
    const Real3 p = force.x * t1 + force.y * t2 + force.z * n;
    const Real3 l = moment.x * t1 + moment.y * t2 + moment.z * n;
    const Real3 r_a = load3(batch.r_a);
    const Real3 r_b = load3(batch.r_b);
    const Push push_a(batch.inverse_mass_a, batch.inverse_inertia_a, r_a, p, l);
    const Push push_b(batch.inverse_mass_b, batch.inverse_inertia_b, r_b, -p, -l);
    push_bodies(carry.velocity, batch.a, batch.moves_a, push_a);
    push_bodies(carry.velocity, batch.b, batch.moves_b, push_b);
    add_activity(carry.activity, batch.a, batch.moves_a, push_a, r_a);
    add_activity(carry.activity, batch.b, batch.moves_b, push_b, r_b);
}

} // namespace

void KERNEL(const BatchCarry& carry) {
    for (std::size_t i = 0; i < carry.batch_count; ++i) {
        if (carry.along != nullptr) {
            carry.along[i] = along_step(carry, carry.batches[i]);
        } else {
            carry_batch(carry, carry.batches[i]);
        }
    }
}

} // namespace sim
