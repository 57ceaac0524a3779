/// Resting contacts, eight blocks at a time: what they start from, their gaps at the predicted poses (eq. 8), what they
/// store for the next interval. Compiled once for each instruction set; KERNEL names it.
#include "sim/solve/rest_motion.h"

namespace sim {
namespace {

constexpr double infinity = __builtin_inf();

/// Time [s] that the impulses of the interval stand for.
LANES_INLINE Real impulse_interval(const Real& node_weight, double h) {
    const Mask part = node_weight < 1.0;
    return select(part, 0.5 * h / select(part, 1.0 - node_weight, real(1.0)), real(h));
}

/// What the last interval left of a contact; see ContactMemory.
struct Memory {
    Real p_n, interval, force_share, last_interval, approach_speed;
    Mask sticks;
    Real3 p_t;
    LANES_INLINE Memory() {}
    LANES_INLINE explicit Memory(double* const* from) {
        Real row[8];
        gather([&](int l) { return from[l]; }, row);
        p_n = row[0];
        p_t = {row[1], row[2], row[3]};
        sticks = row[4] < 0.0;
        interval = abs(row[4]);
        force_share = row[5];
        last_interval = row[6];
        approach_speed = row[7];
    }
};

/// Share [-] of the block's load that is no force.
LANES_INLINE Real share_beyond(const Real& force, const Real& sum) {
    const Mask loaded = sum > 0.0;
    return select(loaded, 1.0 - force / select(loaded, sum, real(1.0)), real(0.0));
}

/// These lanes of a batch.
struct Rest : Window {
    const RestWork& work;
    const RestRules& rules;
    BlockBatch& batch;
    RestBlock& block;
    BatchPoint* points;
    RestPoint* rest;

    LANES_INLINE Rest(const RestWork& of, std::size_t i, int first_lane)
        : Window{first_lane}, work(of), rules(*of.rules), batch(of.batches[i]), block(of.blocks[i]),
          points(of.points + batch.first), rest(of.rest + batch.first) {}

    /// Rows of point k.
    LANES_INLINE double* const* memory_of(int k) const { return work.memory + lane_count * k + first; }
    /// Acceleration into the contact, of a relative to b.
    LANES_INLINE Real fall_along(const Real3& n) const {
        const Real3 gravity{real(rules.gravity[0]), real(rules.gravity[1]), real(rules.gravity[2])};
        return (flag(lanes_of(batch.moves_b)) - flag(lanes_of(batch.moves_a))) * dot(gravity, n);
    }

    /// Share [-] of the impulses at t0 that acts before it (see node_weight()); all of it where none touches. memory: of the points.
    LANES_INLINE Real node_weight_of(const Memory* memory) const {
        Real last = real(0.0);
        Mask touches = nowhere();
        for (int k = 0; k < batch.count; ++k) {
            const Mask here = lanes_of(points[k].there);
            last = max(last, select(here, memory[k].last_interval, real(0.0)));
            touches |= here & (load(points[k].gap) <= rules.tolerance);
        }
        return select(touches, last / (last + real(rules.h)), real(1.0));
    }

    /// Sum of the block's normal impulses.
    LANES_INLINE Real load_on_block() const {
        Real sum = load(points[0].p_n);
        for (int k = 1; k < batch.count; ++k) {
            sum += load(points[k].p_n);
        }
        return sum;
    }

    /// Of the impulses that a solve starts from, the share [-] that is uncertain: see ContactSolver::begin_group().
    LANES_INLINE Real uncertain_share() const {
        return share_beyond(rules.is_stretched ? real(0.0) : load(block.load), load_on_block());
    }

    /// Targets, marks and impulses of the points.
    LANES_INLINE void start() const {
        const double h = rules.h;
        const Real zero = real(0.0);
        const Real one = real(1.0);
        const Frame f = frame_of(batch, *this);
        Memory memories[block_size];
        Mask touches = nowhere();
        for (int k = 0; k < batch.count; ++k) {
            memories[k] = Memory(memory_of(k));
            touches |= lanes_of(points[k].there) & (load(points[k].gap) <= rules.tolerance);
        }
        const Real node_weight = node_weight_of(memories);
        store(batch.node_weight, node_weight);
        const Real interval = impulse_interval(node_weight, h);
        const Real fall = fall_along(f.n);
        const Real free_fall = select(touches, zero, fall); // what touches elsewhere is held, as the upper face of a thin plate
        const Twist twist = twist_of(work.before, batch, f, *this);
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
            set(points[k].ahead, ahead);
            set(points[k].closing, here & ahead & (gap + h * (u_n - (0.5 * h) * free_fall) <= 0.0));
            // What overlaps by more than the tolerance is pushed apart no faster than a fall by as much: it would be thrown. A
            // feature that overlaps by more than its pair did parts to that within a step.
            const Real kept = max(gap, real(-rules.band));
            const Real begun = min(max(gap, load(block.least_gap)), kept);
            const Real push = max(h * sqrt(max(-(2.0 * rules.weight * begun), zero)), real(rules.tolerance));
            store(rest[k].gap_target, select(gap <= rules.band, gap + rules.step_share * (min(kept, begun + push) - gap), zero));
            const Mask loaded = here & (memory.p_n > 0.0);
            const Real stretch = select(loaded, interval / select(loaded, memory.interval, one), zero);
            force += stretch * memory.force_share * memory.p_n;
            const Mask warm = rules.warm_start ? loaded : nowhere();
            const Mask overlaps = gap < -rules.band;
            const Mask halved = rules.is_wedged ? overlaps : nowhere();
            const Real started = select(warm, select(halved, 0.5 * stretch, stretch), zero);
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
        set(batch.sticking, sticks);
        set(block.fresh, (approaches | lanes_of(block.fresh)) & ~bore);
        store(block.load, force);
        block.is_certain = (first == 0 || block.is_certain) && !any(uncertain_share() > 0.0);
    }

    /// Gives the bodies share_of(k) [-] of the impulses of each point k.
    template <typename Share>
    LANES_INLINE void apply(double* velocity, Share&& share_of) const {
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
        const Frame f = frame_of(batch, *this);
        push_bodies(work.begin, velocity, batch, *this, {f.world(force), f.world(turning)});
    }

    /// Work [J] of the impulses, where the points move by the twist faster than less(k) [m/s]: along n, t_1, t_2.
    template <typename Less>
    LANES_INLINE Real work_at(const Twist& twist, Less&& less) const {
        Real sum = real(0.0);
        for (int k = 0; k < batch.count; ++k) {
            const Real x = load(points[k].x);
            const Real y = load(points[k].y);
            const Real3 u{twist.normal(x, y), twist.tangential1(y), twist.tangential2(x)};
            sum += dot({load(points[k].p_n), load(points[k].p_t[0]), load(points[k].p_t[1])}, u - less(k));
        }
        return sum;
    }

    /// Work [J] of the uncertain share of the impulses with what the points part faster by than their targets.
    LANES_INLINE Real uncertain_work() const {
        const Twist twist = twist_of(work.before, batch, frame_of(batch, *this), *this);
        return uncertain_share() * work_at(twist, [&](int k) {
                   const BatchPoint& p = points[k];
                   return Real3{load(p.u_n_target), load(p.u_t_target[0]), load(p.u_t_target[1])};
               });
    }

    /// Work [J] of all impulses, but for what pushes overlaps apart.
    LANES_INLINE Real impulse_work() const {
        const Real zero = real(0.0);
        const Frame f = frame_of(batch, *this);
        const Twist before = twist_of(work.before, batch, f, *this);
        const Twist after = twist_of(work.velocity, batch, f, *this);
        return 0.5 * work_at({before.u + after.u, before.w + after.w}, [&](int k) {
                   return Real3{max((1.0 / rules.h) * (load(rest[k].gap_target) - load(points[k].gap)), zero), zero, zero};
               });
    }

    /// Keeps a part of the uncertain share of the impulses.
    LANES_INLINE void scale() const {
        const Real left = 1.0 - (1.0 - work.kept) * uncertain_share();
        for (int k = 0; k < batch.count; ++k) {
            store(points[k].p_n, left * load(points[k].p_n));
            store(points[k].p_t[0], left * load(points[k].p_t[0]));
            store(points[k].p_t[1], left * load(points[k].p_t[1]));
        }
    }

    /// What overlaps is asked to part no further than to the tolerance. Within it, it stays as it is, or, where it is nearer to the
    /// tolerance than to the band, parts at the pace given. Returns the most [m] that loaded contacts are asked for less.
    LANES_INLINE Real hold_overlaps() const {
        const double per_h = 1.0 / rules.h;
        const Real halfway = real(-0.5 * (rules.band + rules.tolerance));
        Real most = real(0.0);
        Mask held = nowhere();
        for (int k = 0; k < batch.count; ++k) {
            const Real asked = load(rest[k].gap_target);
            const Real gap = load(points[k].gap);
            const Real left = min(asked, max(min(gap + rules.h * work.pace, max(gap, halfway)), real(-rules.tolerance)));
            const Mask changes = lanes_of(points[k].there) & (left < asked);
            const Real target = load(points[k].u_n_target);
            store(points[k].u_n_target, select(changes, target + (left - asked) * per_h, target));
            store(rest[k].gap_target, left);
            held |= changes;
            most = max(most, select(changes & (load(points[k].p_n) > 0.0), asked - left, real(0.0)));
        }
        store(batch.seen[2], select(held, real(no_point), load(batch.seen[2])));
        return most;
    }

    /// Of the gaps is asked no more what the bodies miss by the softness of their impulses. Returns the most of it [m] in each lane.
    LANES_INLINE Real give_way() const {
        const Twist twist = twist_of(work.velocity, batch, frame_of(batch, *this), *this);
        Real3 wrench{real(0.0), real(0.0), real(0.0)};
        for (int k = 0; k < batch.count; ++k) {
            const Real p_n = load(points[k].p_n);
            wrench = wrench + Real3{p_n, p_n * load(points[k].y), -(p_n * load(points[k].x))};
        }
        const Real softness = select(lanes_of(batch.led), real(work.softness), real(0.0));
        const Real3 change = softness * (normal_response(batch, *this) * wrench);
        Real most = real(0.0);
        for (int k = 0; k < batch.count; ++k) {
            const Real x = load(points[k].x);
            const Real y = load(points[k].y);
            const Real target = load(points[k].u_n_target);
            const Real missing = min(target - twist.normal(x, y), change.x + change.y * y - change.z * x);
            const Real given = max(missing, real(0.0));
            store(points[k].u_n_target, target - given);
            store(rest[k].gap_target, load(rest[k].gap_target) - rules.h * given);
            most = max(most, rules.h * given);
        }
        return most;
    }

    /// Gaps and slips of the plain blocks at the predicted poses, and the targets that close them. Returns the largest error
    /// of a gap in each lane.
    LANES_INLINE Real measure() const {
        const double per_h = 1.0 / rules.h;
        const Frame f = frame_of(batch, *this);
        const Twist twist = twist_of(work.velocity, batch, f, *this);
        const Motion a(work.end, batch.a + first);
        const Motion b(work.end, batch.b + first);
        // d of a point is linear in where it lies in the block.
        const Real3 n_a = a.turn(f.n);
        const Real3 n_b = b.turn(f.n);
        const Real3 by_x = a.turn(f.t1) - b.turn(f.t1);
        const Real3 by_y = a.turn(f.t2) - b.turn(f.t2);
        const Real3 middle = (a.position() - b.position()) + (a.turn(load3(batch.r_a)) - b.turn(load3(batch.r_b)));
        const Real nearest_gap = load(batch.nearest_gap);
        const Real3 n_face = select(lanes_of(batch.face_of_a), n_a, n_b);
        Edges edges;
        if (has_any(block.edges)) {
            const Placed on_a(work.begin, batch.a + first);
            const Placed on_b(work.begin, batch.b + first);
            edges = Edges(block.crossing + first, {on_a, a}, {on_b, b}, n_b);
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
            if (has_any(points[k].edges)) {
                const Mask at_edges = lanes_of(points[k].edges);
                const Real3 between = d - load(points[k].gap) * edges.lean;
                const Mask wanders = lanes_of(points[k].wandered) | (at_edges & edges.wander(between));
                Window::set(points[k].wandered, wanders);
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
    LANES_INLINE Real expected_load() const {
        Real inverse_mass;
        for (int l = 0; l < width; ++l) {
            const double a = work.begin[batch.a[first + l]].x[0];
            const double b = work.begin[batch.b[first + l]].x[0];
            inverse_mass[l] = a > b ? a : b;
        }
        const Real interval = impulse_interval(load(batch.node_weight), rules.h);
        return max(load(block.load), rules.weight * interval / inverse_mass);
    }

    /// Which blocks does an impact load? A speculative one that is held ahead, at its own point or at another one of the block; or
    /// one too slow to collide, or what a collision leaves, which wedges bodies: it bore no load, and now bears far more than a weight.
    LANES_INLINE void find_hits() const {
        const Mask grows = load_on_block() > rules.largest_growth * expected_load();
        Mask closes = nowhere();
        Mask hit = nowhere();
        for (int k = 0; k < batch.count; ++k) {
            const Mask closing = lanes_of(points[k].closing);
            closes |= closing;
            hit |= closing & (load(points[k].p_n) > 0.0);
        }
        set(block.grows, grows);
        set(block.hit, hit | ((lanes_of(block.fresh) | closes) & grows));
    }

    /// Where has friction reached its limit, and the points slip? at_limit: where it has.
    LANES_INLINE Mask loses_mark(const Twist& twist, Mask& at_limit) const {
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

    /// What the contacts of the batch hand to the next interval.
    LANES_INLINE void store_impulses() const {
        const double h = rules.h;
        const Real zero = real(0.0);
        const Frame f = frame_of(batch, *this);
        const Twist twist = twist_of(work.velocity, batch, f, *this);
        Mask at_limit;
        const Mask lost = loses_mark(twist, at_limit);
        const Mask has_friction = load(batch.mu) > 0.0;
        const Mask keeps = has_friction & ((lanes_of(batch.sticking) & ~lost) | ~at_limit);
        const Real interval = impulse_interval(load(batch.node_weight), h);
        const Real sum = load_on_block();
        const Real force = select(lanes_of(block.hit), min(sum, expected_load()), sum);
        store(block.load, force);
        const Real force_share = 1.0 - share_beyond(force, sum);
        const Twist before = twist_of(work.before, batch, f, *this);
        const Real fall = fall_along(f.n);
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
            const Memory memory(memory_of(k));
            // That it would touch with, without impulses [m/s].
            const Real approach = max(-u_n_before, zero);
            const Real touch_speed =
                max(sqrt(max(approach * approach + 2.0 * fall * load(points[k].gap), zero)), memory.approach_speed);
            Real row[8] = {select(ahead, zero, p_n),
                           select(ahead, select(impact, taken, zero), p_t.x),
                           select(ahead, zero, p_t.y),
                           select(ahead, zero, p_t.z),
                           select(ahead, zero, select(sticks, -interval, interval)),
                           force_share,
                           select(loaded & ~ahead, real(h), zero),
                           select(impact, touch_speed, zero)};
            double* const* to = memory_of(k);
            scatter(row, [&](int l, int place, const Real& numbers) { store_anywhere(to[l] + place, numbers); });
        }
    }
};

/// A phase of one batch; returns the largest error of a gap where it is to measure, and adds to `sum` what is to be summed up.
LANES_INLINE Real work_on_lanes(const Rest& lanes, double& sum) {
    const RestWork& work = lanes.work;
    Real worst = real(0.0);
    const auto add = [&](const Real& of_lanes) {
        for (int l = 0; l < width; ++l) {
            sum += of_lanes[l];
        }
    };
    switch (work.phase) {
    case RestPhase::start:
        lanes.start();
        lanes.apply(work.velocity, [](int) { return real(1.0); });
        break;
    case RestPhase::uncertain:
        if (!lanes.block.is_certain) {
            const Real share = lanes.uncertain_share();
            lanes.apply(work.velocity, [&](int) { return share; });
        }
        break;
    case RestPhase::uncertain_work:
        if (!lanes.block.is_certain) {
            add(lanes.uncertain_work());
        }
        break;
    case RestPhase::impulse_work:
        add(lanes.impulse_work());
        break;
    case RestPhase::scale:
        if (!lanes.block.is_certain) {
            lanes.scale();
        }
        break;
    case RestPhase::hold_overlaps:
        worst = lanes.hold_overlaps();
        break;
    case RestPhase::give_way:
        worst = lanes.give_way();
        break;
    case RestPhase::measure:
        worst = lanes.measure();
        lanes.find_hits();
        break;
    case RestPhase::store:
        lanes.store_impulses();
        const Real before =
            lanes.load(lanes.batch.node_weight) * (1.0 - share_beyond(lanes.load(lanes.block.load), lanes.load_on_block()));
        lanes.apply(work.at_node, [&](int k) { return select(lanes.lanes_of(lanes.points[k].ahead), real(0.0), before); });
        break;
    }
    return worst;
}

} // namespace

double KERNEL(const RestWork& work) {
    Real worst = real(0.0);
    for (std::size_t i = 0; i < work.batch_count; ++i) {
        double sum = 0.0;
        for (int first = 0; first < lane_count; first += width) {
            worst = max(worst, work_on_lanes(Rest(work, i, first), sum));
        }
        if (work.sums != nullptr) {
            work.sums[i] = sum;
        }
    }
    double largest = 0.0;
    for (int l = 0; l < width; ++l) {
        largest = largest < worst[l] ? worst[l] : largest;
    }
    return largest;
}

} // namespace sim
