/// Resting contacts, eight blocks at a time: what they start from, their gaps at the predicted poses (eq. 8), what they
/// store for the next interval. Compiled once for each instruction set; KERNEL names it.
#include "sim/block/lane_twist.h"
#include "sim/solve/rest_batch.h"

namespace sim {
namespace {

constexpr double infinity = __builtin_inf();

LANES_INLINE void gather_rows(double* const* from, Real rows[8]) {
    for (int l = 0; l < lane_count; ++l) {
        rows[l] = load_anywhere(from[l]);
    }
    transpose(rows);
}

LANES_INLINE Mask nowhere() {
    return real(0.0) < 0.0;
}

/// Time [s] that the impulses of the interval stand for.
LANES_INLINE Real impulse_interval(const Real& node_weight, double h) {
    const Mask part = node_weight < 1.0;
    return select(part, 0.5 * h / select(part, 1.0 - node_weight, real(1.0)), real(h));
}

/// Acceleration into the contact, of a relative to b.
LANES_INLINE Real fall_of(const RestRules& rules, const BlockBatch& batch, const Real3& n) {
    const Real3 gravity{real(rules.gravity[0]), real(rules.gravity[1]), real(rules.gravity[2])};
    return (flag(lanes_of(batch.moves_b)) - flag(lanes_of(batch.moves_a))) * dot(gravity, n);
}

/// What the last interval left of a contact; see ContactMemory.
struct Memory {
    Real p_n, interval, force_share, last_interval, approach_speed;
    Mask sticks;
    Real3 p_t;
    LANES_INLINE Memory() {}
    LANES_INLINE explicit Memory(double* const* from) {
        Real row[8];
        gather_rows(from, row);
        p_n = row[0];
        p_t = {row[1], row[2], row[3]};
        sticks = row[4] < 0.0;
        interval = abs(row[4]);
        force_share = row[5];
        last_interval = row[6];
        approach_speed = row[7];
    }
};

/// Share [-] of the impulses at t0 that acts before it (see node_weight()); all of it where none touches. memory: of the points.
LANES_INLINE Real node_weight_of(const RestWork& work, const BlockBatch& batch, const BatchPoint* points, const Memory* memory) {
    Real last = real(0.0);
    Mask touches = nowhere();
    for (int k = 0; k < batch.count; ++k) {
        const Mask here = lanes_of(points[k].there);
        last = max(last, select(here, memory[k].last_interval, real(0.0)));
        touches |= here & (load(points[k].gap) <= work.rules->tolerance);
    }
    return select(touches, last / (last + real(work.rules->h)), real(1.0));
}

/// Sum of the block's normal impulses.
LANES_INLINE Real load_on(const BlockBatch& batch, const BatchPoint* points) {
    Real sum = load(points[0].p_n);
    for (int k = 1; k < batch.count; ++k) {
        sum += load(points[k].p_n);
    }
    return sum;
}

/// Share [-] of the block's load that is no force.
LANES_INLINE Real share_beyond(const Real& force, const Real& sum) {
    const Mask loaded = sum > 0.0;
    return select(loaded, 1.0 - force / select(loaded, sum, real(1.0)), real(0.0));
}

/// Of the impulses that a solve starts from, the share [-] that is uncertain: see ContactSolver::take_uncertain().
LANES_INLINE Real uncertain_share(const RestRules& rules, const BlockBatch& batch, const RestBlock& block,
                                  const BatchPoint* points) {
    return share_beyond(rules.is_stretched ? real(0.0) : load(block.load), load_on(batch, points));
}

/// Targets, marks and impulses of the points.
LANES_INLINE void start(const RestWork& work, BlockBatch& batch, RestBlock& block, BatchPoint* points, RestPoint* rest) {
    const RestRules& rules = *work.rules;
    const double h = rules.h;
    const Real zero = real(0.0);
    const Real one = real(1.0);
    const Frame f = frame_of(batch);
    Memory memories[block_size];
    for (int k = 0; k < batch.count; ++k) {
        memories[k] = Memory(work.memory + lane_count * k);
    }
    const Real node_weight = node_weight_of(work, batch, points, memories);
    store(batch.node_weight, node_weight);
    const Real interval = impulse_interval(node_weight, h);
    const Real fall = fall_of(rules, batch, f.n);
    const Twist twist = twist_of(work.before, batch, f);
    Mask sticks = nowhere();
    Mask bore = nowhere();
    Mask approaches = nowhere();
    Real force = zero;
    for (int k = 0; k < batch.count; ++k) {
        const Mask here = lanes_of(points[k].there);
        const Real x = load(points[k].x);
        const Real y = load(points[k].y);
        const Real gap = load(points[k].gap);
        const Memory& memory = memories[k];
        const Mask ahead = gap > rules.tolerance; // a speculative contact
        const Real u_n = twist.normal(x, y);
        points[k].ahead = bits_of(ahead);
        points[k].closing = bits_of(here & ahead & (gap + h * (u_n - (0.5 * h) * fall) <= 0.0));
        // What overlaps by more than the tolerance is pushed apart no faster than a fall by as much: it would be thrown.
        const Real kept = max(gap, real(-rules.band));
        const Real begun = min(max(gap, load(block.least_gap)), kept);
        const Real push = max(h * sqrt(max(-(2.0 * rules.weight * begun), zero)), real(rules.tolerance));
        store(rest[k].gap_target, select(gap <= rules.band, begun + rules.step_share * (min(kept, begun + push) - begun), zero));
        const Mask loaded = here & (memory.p_n > 0.0);
        const Real stretch = select(loaded, interval / select(loaded, memory.interval, one), zero);
        force += stretch * memory.force_share * memory.p_n;
        const Mask warm = rules.warm_start ? loaded : nowhere();
        const Real started = select(warm, stretch, zero);
        const Real p_n = started * memory.p_n;
        store(points[k].p_n, p_n);
        store(points[k].p_t[0], started * dot(memory.p_t, f.t1));
        store(points[k].p_t[1], started * dot(memory.p_t, f.t2));
        const Real slow1 = twist.tangential1(y);
        const Real slow2 = twist.tangential2(x);
        const Mask slow = slow1 * slow1 + slow2 * slow2 <= rules.velocity_tolerance * rules.velocity_tolerance;
        const Mask is_new = (memory.p_n == 0.0) & (memory.last_interval == 0.0);
        bore |= loaded;
        approaches |= here & (u_n < 0.0);
        sticks |= (warm & memory.sticks) | (here & is_new & ~ahead & slow);
    }
    batch.sticking = bits_of(sticks);
    block.fresh = bits_of((approaches | lanes_of(block.fresh)) & ~bore);
    store(block.load, force);
    block.is_certain = !any(uncertain_share(rules, batch, block, points) > 0.0);
}

/// Gives the bodies share_of(k) [-] of the impulses of each point k.
template <typename Share>
LANES_INLINE void apply(const BodyRows* rows, double* velocity, const BlockBatch& batch, const BatchPoint* points,
                        Share&& share_of) {
    const Real zero = real(0.0);
    Real3 force{zero, zero, zero};
    Real3 turning{zero, zero, zero};
    for (int k = 0; k < batch.count; ++k) {
        const Real x = load(points[k].x);
        const Real y = load(points[k].y);
        const Real share = share_of(k);
        const Real p_n = share * load(points[k].p_n);
        const Real p_1 = share * load(points[k].p_t[0]);
        const Real p_2 = share * load(points[k].p_t[1]);
        force = force + Real3{p_1, p_2, p_n};
        turning = turning + Real3{p_n * y, -(p_n * x), x * p_2 - y * p_1};
    }
    const Frame f = frame_of(batch);
    push_bodies(rows, velocity, batch, f.world(force), f.world(turning));
}

/// Of the uncertain share of the impulses with what the points part faster by than their targets [J].
LANES_INLINE double uncertain_work(const RestWork& work, const BlockBatch& batch, const RestBlock& block,
                                   const BatchPoint* points) {
    const Twist twist = twist_of(work.before, batch, frame_of(batch));
    Real sum = real(0.0);
    for (int k = 0; k < batch.count; ++k) {
        const Real p_n = load(points[k].p_n);
        const Real x = load(points[k].x);
        const Real y = load(points[k].y);
        sum += p_n * (twist.normal(x, y) - load(points[k].u_n_target)) +
               load(points[k].p_t[0]) * (twist.tangential1(y) - load(points[k].u_t_target[0])) +
               load(points[k].p_t[1]) * (twist.tangential2(x) - load(points[k].u_t_target[1]));
    }
    Lanes of_lanes;
    store(of_lanes, uncertain_share(*work.rules, batch, block, points) * sum);
    double all = 0.0;
    for (const double of_lane : of_lanes.x) {
        all += of_lane;
    }
    return all;
}

/// Keeps a part of the uncertain share of the impulses.
LANES_INLINE void scale(const RestWork& work, const BlockBatch& batch, const RestBlock& block, BatchPoint* points) {
    const Real left = 1.0 - (1.0 - work.kept) * uncertain_share(*work.rules, batch, block, points);
    for (int k = 0; k < batch.count; ++k) {
        store(points[k].p_n, left * load(points[k].p_n));
        store(points[k].p_t[0], left * load(points[k].p_t[0]));
        store(points[k].p_t[1], left * load(points[k].p_t[1]));
    }
}

/// What overlaps is asked to part no further than to the tolerance; within it, it stays as it is.
LANES_INLINE void yield(const RestWork& work, BlockBatch& batch, BatchPoint* points, RestPoint* rest) {
    const double per_h = 1.0 / work.rules->h;
    Mask yields = nowhere();
    for (int k = 0; k < batch.count; ++k) {
        const Real asked = load(rest[k].gap_target);
        const Real left = min(asked, max(load(points[k].gap), real(-work.rules->tolerance)));
        const Mask changes = lanes_of(points[k].there) & (left < asked);
        const Real target = load(points[k].u_n_target);
        store(points[k].u_n_target, select(changes, target + (left - asked) * per_h, target));
        store(rest[k].gap_target, left);
        yields |= changes;
    }
    store(batch.seen[2], select(yields, real(no_point), load(batch.seen[2])));
}

/// A body's predicted motion since the interval began.
struct Motion {
    Real row[16];
    LANES_INLINE Motion(const BodyRows* end, const int* body) { gather_two(end->x, body, row); }
    LANES_INLINE Real3 turn(const Real3& v) const {
        return {row[0] * v.x + row[1] * v.y + row[2] * v.z, row[3] * v.x + row[4] * v.y + row[5] * v.z,
                row[6] * v.x + row[7] * v.y + row[8] * v.z};
    }
    LANES_INLINE Real3 position() const { return {row[9], row[10], row[11]}; }
};

/// Normal of crossing edges.
LANES_INLINE Real3 edge_normal(const Real3& edge_a, const Real3& edge_b) {
    const Real one = real(1.0);
    const Real zero = real(0.0);
    const Real3 across = cross(edge_a, edge_b);
    const Real square = dot(across, across);
    const Mask crosses = square > 0.0;
    return (1.0 / select(crosses, sqrt(square), one)) * select(crosses, across, Real3{zero, zero, one});
}

/// The crossing edges of the blocks at the predicted poses.
struct Edges {
    Real3 a, b, n;
    Real3 lean; ///< where impulses act along another normal: how much their points differ from the edges', per gap
    LANES_INLINE Edges() {}
    LANES_INLINE Edges(const RestBlock& block, const Motion& move_a, const Motion& move_b, const Real3& n_b) {
        const Real3 a_before = load3(block.edge_a);
        const Real3 b_before = load3(block.edge_b);
        a = move_a.turn(a_before);
        b = move_b.turn(b_before);
        n = edge_normal(a, b);
        lean = n_b - move_b.turn(edge_normal(a_before, b_before));
    }
    /// Has the touch wandered too far along them? d: of points on them that touched as the interval began. The lines of
    /// edges that are parallel are nowhere near.
    LANES_INLINE Mask wander(const RestBlock& block, const Real3& d) const {
        const Real cosine = dot(a, b);
        const Real sine_square = 1.0 - cosine * cosine;
        return abs(cosine * dot(d, b) - dot(d, a)) > load(block.reach) * abs(sine_square);
    }
};

/// Gaps and slips of the plain blocks at the predicted poses, and the targets that close them. Returns the largest error
/// of a gap in each lane.
LANES_INLINE Real measure(const RestWork& work, BlockBatch& batch, const RestBlock& block, BatchPoint* points,
                          const RestPoint* rest) {
    const double per_h = 1.0 / work.rules->h;
    const Frame f = frame_of(batch);
    const Twist twist = twist_of(work.velocity, batch, f);
    const Motion a(work.end, batch.a);
    const Motion b(work.end, batch.b);
    // d of a point is linear in where it lies in the block.
    const Real3 n_a = a.turn(f.n);
    const Real3 n_b = b.turn(f.n);
    const Real3 by_x = a.turn(f.t1) - b.turn(f.t1);
    const Real3 by_y = a.turn(f.t2) - b.turn(f.t2);
    const Real3 middle = (a.position() - b.position()) + (a.turn(load3(batch.r_a)) - b.turn(load3(batch.r_b)));
    const Real nearest_gap = load(batch.nearest_gap);
    const Real3 n_face = select(lanes_of(batch.face_of_a), n_a, n_b);
    Edges edges;
    if (block.edges != 0) {
        edges = Edges(block, a, b, n_b);
    }
    Real worst = real(-infinity);
    for (int k = 0; k < batch.count; ++k) {
        const RestPoint& r = rest[k];
        const Mask measured = lanes_of(points[k].there & block.plain);
        const Real x = load(points[k].x);
        const Real y = load(points[k].y);
        const Real height = load(points[k].height);
        const Real3 d = middle + x * by_x + y * by_y + height * n_a - (height + nearest_gap - load(points[k].gap)) * n_b;
        Real3 n = n_face;
        Real gap = dot(n, d);
        Real3 across = d - gap * n;
        if (points[k].edges != 0) {
            const Mask at_edges = lanes_of(points[k].edges);
            const Real3 between = d - load(points[k].gap) * edges.lean;
            const Mask wanders = edges.wander(block, between);
            n = select(wanders, f.n, edges.n);
            across = select(at_edges, d - dot(n, d) * n, across);
            gap = select(at_edges, dot(n, select(wanders, d, between)), gap);
        }
        const Real missing = load(r.gap_target) - gap;
        const Real error = select(load(points[k].p_n) > 0.0, abs(missing), missing);
        worst = select(measured, max(worst, error), worst);
        const auto set = [&](Lanes& target, const Real& value) { store(target, select(measured, value, load(target))); };
        set(points[k].u_n_target, twist.normal(x, y) + missing * per_h);
        set(points[k].u_t_target[0], twist.tangential1(y) - dot(f.t1, across) * per_h);
        set(points[k].u_t_target[1], twist.tangential2(x) - dot(f.t2, across) * per_h);
    }
    return worst;
}

/// What the last step's force gives in the interval, or a weight, that of the lighter body.
LANES_INLINE Real expected_load(const RestWork& work, const BlockBatch& batch, const RestBlock& block) {
    Lanes inverse_mass;
    for (int l = 0; l < lane_count; ++l) {
        const double a = work.begin[batch.a[l]].x[0];
        const double b = work.begin[batch.b[l]].x[0];
        inverse_mass.x[l] = a > b ? a : b;
    }
    const Real interval = impulse_interval(load(batch.node_weight), work.rules->h);
    return max(load(block.load), work.rules->weight * interval / load(inverse_mass));
}

/// Which blocks does an impact load? A speculative one that is held ahead, at its own point or at another one of the block; or
/// one too slow to collide, or what a collision leaves, which wedges bodies: it bore no load, and now bears far more than a weight.
LANES_INLINE void find_hits(const RestWork& work, const BlockBatch& batch, RestBlock& block, const BatchPoint* points) {
    block.grows = bits_of(load_on(batch, points) > work.rules->largest_growth * expected_load(work, batch, block));
    unsigned closing = 0;
    block.hit = 0;
    for (int k = 0; k < batch.count; ++k) {
        closing |= points[k].closing;
        block.hit |= points[k].closing & bits_of(load(points[k].p_n) > 0.0);
    }
    block.hit |= (block.fresh | closing) & block.grows;
}

/// Where has friction reached its limit, and the points slip? at_limit: where it has.
LANES_INLINE Mask loses_mark(const RestRules& rules, const BlockBatch& batch, const BatchPoint* points, const Twist& twist,
                             Mask& at_limit) {
    Mask slips = nowhere();
    at_limit = nowhere();
    const Real mu = load(batch.mu);
    for (int k = 0; k < batch.count; ++k) {
        const Real p_n = load(points[k].p_n);
        const Real p_1 = load(points[k].p_t[0]);
        const Real p_2 = load(points[k].p_t[1]);
        const Mask loaded = p_n > 0.0;
        at_limit |= loaded & (sqrt(p_1 * p_1 + p_2 * p_2) >= rules.limit * mu * p_n);
        const Real s_1 = twist.tangential1(load(points[k].y)) - load(points[k].u_t_target[0]);
        const Real s_2 = twist.tangential2(load(points[k].x)) - load(points[k].u_t_target[1]);
        slips |= loaded & (rules.h * sqrt(s_1 * s_1 + s_2 * s_2) > rules.slip_tolerance);
    }
    return at_limit & slips;
}

/// Writes eight columns as rows, those of `lanes`.
LANES_INLINE void scatter_rows(double* const* to, unsigned lanes, Real rows[8]) {
    transpose(rows);
    for (int l = 0; l < lane_count; ++l) {
        if ((lanes >> l & 1u) != 0) {
            store_anywhere(to[l], rows[l]);
        }
    }
}

/// What the contacts of the batch hand to the next interval.
LANES_INLINE void store_impulses(const RestWork& work, const BlockBatch& batch, RestBlock& block, const BatchPoint* points,
                                 const RestPoint* rest) {
    const RestRules& rules = *work.rules;
    const double h = rules.h;
    const Real zero = real(0.0);
    const Frame f = frame_of(batch);
    const Twist twist = twist_of(work.velocity, batch, f);
    Mask at_limit;
    const Mask lost = loses_mark(rules, batch, points, twist, at_limit);
    const Mask has_friction = load(batch.mu) > 0.0;
    const Mask keeps = has_friction & (((lanes_of(batch.sticking)) & ~lost) | ~at_limit);
    const Real interval = impulse_interval(load(batch.node_weight), h);
    const Real sum = load_on(batch, points);
    const Real force = select(lanes_of(block.hit), min(sum, expected_load(work, batch, block)), sum);
    store(block.load, force);
    const Real force_share = 1.0 - share_beyond(force, sum);
    const Twist before = twist_of(work.before, batch, f);
    const Real fall = fall_of(rules, batch, f.n);
    for (int k = 0; k < batch.count; ++k) {
        const Real x = load(points[k].x);
        const Real y = load(points[k].y);
        const Real p_n = load(points[k].p_n);
        const Real p_1 = load(points[k].p_t[0]);
        const Real p_2 = load(points[k].p_t[1]);
        const Mask loaded = p_n > 0.0;
        const Mask ahead = lanes_of(points[k].ahead);
        const Real u_n = twist.normal(x, y);
        const Real u_1 = twist.tangential1(y);
        const Real u_2 = twist.tangential2(x);
        const Real gap = load(rest[k].gap_target) - h * (load(points[k].u_n_target) - u_n);
        const Mask impact = lanes_of(points[k].closing) & (gap <= rules.tolerance);
        const Real u_n_before = before.normal(x, y);
        const Real taken = -(0.5 * p_n * (u_n_before + u_n)) -
                           0.5 * (p_1 * (before.tangential1(y) + u_1) + p_2 * (before.tangential2(x) + u_2));
        const Real3 p_t = f.world(p_1, p_2);
        const Mask sticks = loaded & keeps;
        const Memory memory(work.memory + lane_count * k);
        // That it would touch with, without impulses [m/s].
        const Real approach = max(-u_n_before, zero);
        const Real touch_speed =
            max(sqrt(max(approach * approach + 2.0 * fall * load(points[k].gap), zero)), memory.approach_speed);
        Real first[8] = {select(ahead, zero, p_n),
                         select(ahead, zero, p_t.x),
                         select(ahead, zero, p_t.y),
                         select(ahead, zero, p_t.z),
                         select(ahead, zero, select(sticks, -interval, interval)),
                         force_share,
                         select(loaded & ~ahead, real(h), zero),
                         select(impact, touch_speed, zero)};
        scatter_rows(work.memory + lane_count * k, points[k].there, first);
        Lanes energy_taken;
        store(energy_taken, select(impact, taken, zero));
        for (int l = 0; l < lane_count; ++l) {
            if ((points[k].there >> l & 1u) != 0) {
                work.memory[lane_count * k + l][8] = energy_taken.x[l];
            }
        }
    }
}

} // namespace

double KERNEL(const RestWork& work) {
    double worst = 0.0;
    for (std::size_t i = 0; i < work.batch_count; ++i) {
        BlockBatch& batch = work.batches[i];
        RestBlock& block = work.blocks[i];
        BatchPoint* points = work.points + batch.first;
        RestPoint* rest = work.rest + batch.first;
        if (work.phase == RestPhase::start) {
            start(work, batch, block, points, rest);
            apply(work.begin, work.velocity, batch, points, [](int) { return real(1.0); });
        } else if (work.phase == RestPhase::uncertain) {
            if (!block.is_certain) {
                const Real share = uncertain_share(*work.rules, batch, block, points);
                apply(work.begin, work.velocity, batch, points, [&](int) { return share; });
            }
        } else if (work.phase == RestPhase::uncertain_work) {
            work.parts[i] = block.is_certain ? 0.0 : uncertain_work(work, batch, block, points);
        } else if (work.phase == RestPhase::scale) {
            if (!block.is_certain) {
                scale(work, batch, block, points);
            }
        } else if (work.phase == RestPhase::yield) {
            yield(work, batch, points, rest);
        } else if (work.phase == RestPhase::hits) {
            find_hits(work, batch, block, points);
        } else if (work.phase == RestPhase::store) {
            store_impulses(work, batch, block, points, rest);
            const Real before = load(batch.node_weight) * (1.0 - share_beyond(load(block.load), load_on(batch, points)));
            apply(work.begin, work.at_node, batch, points,
                  [&](int k) { return select(lanes_of(points[k].ahead), real(0.0), before); });
        } else {
            Lanes errors;
            store(errors, measure(work, batch, block, points, rest));
            for (const double error : errors.x) {
                worst = worst < error ? error : worst;
            }
        }
    }
    return worst;
}

} // namespace sim
