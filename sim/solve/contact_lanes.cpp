#include "sim/solve/contact_solver.h"

#include "sim/model/integrate.h"

#include <algorithm>
#include <cstddef>

namespace sim {
namespace {

static_assert(most_points == block_size);
static_assert(offsetof(ContactGeometry, n) == sizeof(double) && offsetof(ContactGeometry, a) == 4 * sizeof(double) &&
                  sizeof(ContactGeometry) >= 8 * sizeof(double),
              "rest_kernel.cpp reads gap, n and a");
static_assert(offsetof(ContactMemory, slip) - offsetof(ContactMemory, p_n) == 8 * sizeof(double) &&
                  offsetof(ContactMemory, mark) - offsetof(ContactMemory, p_n) == 15 * sizeof(double),
              "rest_kernel.cpp reads and writes two rows");

/// Batches for whose contacts is asked ahead of their turn.
constexpr std::size_t ahead_batches = 2;

ContactPoint point_in_lane(const BatchPoint& from, std::size_t lane) {
    ContactPoint point;
    point.x = from.x.x[lane];
    point.y = from.y.x[lane];
    point.p_n = from.p_n.x[lane];
    point.p_t = {from.p_t[0].x[lane], from.p_t[1].x[lane]};
    return point;
}

} // namespace

/// Are all contacts solved in batches, as they are when the interval begins? Marks of sticking do not change within a
/// solve where mu_s = mu_d.
bool ContactSolver::fits_lanes(std::span<const PairContacts> pairs) const {
    return !stop_at_impacts_ && !settings_.shock_propagation && !TogetherSweeps::fits(loop_) &&
           std::ranges::all_of(pairs, [](const PairContacts& pair) { return pair.material.mu_s == pair.material.mu_d; });
}

/// What the lanes need to know of the blocks of a pair.
void ContactSolver::head_blocks(const Bodies& bodies, PairContacts& pair, int pair_index, Place place) {
    const std::span<const Contact> all = pair.manifold.contacts;
    for (std::size_t first = 0; first < all.size(); ++place.block) {
        const std::span<const Contact> own = pair.blocks == 1 ? all : all.subspan(first, block_length(all.subspan(first)));
        const ContactFeature& feature = own[0].feature;
        ContactBlock& block = loop_.blocks[place.block];
        block.a = pair.manifold.body_a;
        block.b = pair.manifold.body_b;
        block.first = static_cast<int>(place.point + first);
        block.count = static_cast<int>(own.size());
        block.mu_s = pair.material.mu_s;
        block.mu_d = pair.material.mu_d;
        block.set_surface(feature);
        BlockHead& head = heads_[place.block];
        head = {.contacts = own.data(),
                .memory = pair.memory.data() + first,
                .pair = pair_index,
                .index = static_cast<int>(first),
                .is_plain = block.is_flat || own.size() == 1};
        const ContactFeature& edges = own.back().feature; // the last by its id, if there are any
        const bool has_edges = edges.kind == FeatureKind::edges;
        for (const Contact& contact : own.first(own.size() - (has_edges ? 1 : 0))) {
            head.is_plain = head.is_plain && block.is_flat && contact.feature.kind == feature.kind && !is_curved(contact.feature);
        }
        head.has_edges = head.is_plain && has_edges;
        if (head.has_edges) {
            head.edge_a = bodies.pose[static_cast<std::size_t>(block.a)].orientation * (edges.side * edges.direction_a);
            head.edge_b = bodies.pose[static_cast<std::size_t>(block.b)].orientation * edges.direction_b;
        }
        first += own.size();
    }
}

/// Blocks, points and contacts of all pairs, straight into the batches: what place_contacts() and apply_impulses() do.
void ContactSolver::start_lanes(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const Place> places) {
    heads_.resize(loop_.blocks.size());
    loop_.share(pairs.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t pair = first; pair < last; ++pair) {
            head_blocks(bodies, pairs[pair], static_cast<int>(pair), places[pair]);
        }
    });
    loop_.plan(bodies);
    rest_points_.resize(loop_.batch_points.size());
    rest_blocks_.resize(loop_.batches.size());
    begin_.resize(bodies.props.size());
    end_.resize(bodies.props.size());
    for (const std::size_t i : solved_bodies_) {
        const Vec3& position = bodies.pose[i].position;
        const Mat3& inertia = bodies.inverse_inertia[i];
        begin_[i] = {{position.x(), position.y(), position.z(), bodies.props[i].inverse_mass, inertia(0, 0), inertia(0, 1),
                      inertia(0, 2), inertia(1, 1), inertia(1, 2), inertia(2, 2)}};
    }
    before_ = bodies.velocity.front().v.data();
    const Vec3& gravity = settings_.gravity;
    rules_ = {.h = h_,
              .tolerance = settings_.tolerance,
              .band = soft_band * settings_.tolerance,
              .relaxation = relaxation_,
              .step_share = step_share_,
              .velocity_tolerance = settings_.velocity_tolerance,
              .largest_stretch = largest_stretch,
              .largest_growth = largest_growth,
              .limit = 1.0 - limit_rounding,
              .slip_tolerance = iteration_share * settings_.tolerance,
              .gravity = {gravity.x(), gravity.y(), gravity.z()},
              .warm_start = settings_.warm_start};
    loop_.share(loop_.batches.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < std::min(first + ahead_batches, last); ++i) {
            head_batch(bodies, i);
        }
        for (std::size_t i = first; i < last; ++i) {
            if (i + ahead_batches < last) {
                head_batch(bodies, i + ahead_batches);
            }
            work_on_batches(RestPhase::start, i, i + 1);
            prepare_batches({&loop_.batches[i], 1, loop_.batch_points.data()});
        }
    });
    loop_.share_colours([&](std::size_t first, std::size_t last) { work_on_batches(RestPhase::apply, first, last); });
}

/// Whose contacts the lanes of batch i hold; asks for their memory.
void ContactSolver::head_batch(const Bodies& bodies, std::size_t i) {
    BlockBatch& batch = loop_.batches[i];
    RestBlock& rest = rest_blocks_[i];
    batch.moves_a = batch.moves_b = batch.flat = batch.face_of_a = 0;
    batch.has_friction = false;
    rest.plain = rest.edges = rest.hit = 0;
    const std::span<RestPoint> points = std::span(rest_points_).subspan(static_cast<std::size_t>(batch.first),
                                                                        static_cast<std::size_t>(batch.count));
    for (RestPoint& point : points) {
        point.there = point.edges = 0;
    }
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
        const bool is_empty = batch.block[lane] < 0; // such a lane has a sound one's numbers, and none is written
        const auto index = static_cast<std::size_t>(batch.block[is_empty ? 0 : lane]);
        const ContactBlock& block = loop_.blocks[index];
        const BlockHead& head = heads_[index];
        const auto bit = static_cast<unsigned>(!is_empty) << lane;
        batch.a[lane] = block.a;
        batch.b[lane] = block.b;
        batch.moves_a |= bodies.props[static_cast<std::size_t>(block.a)].is_static() ? 0u : bit;
        batch.moves_b |= bodies.props[static_cast<std::size_t>(block.b)].is_static() ? 0u : bit;
        batch.flat |= block.is_flat ? bit : 0u;
        batch.face_of_a |= block.is_face_of_a ? bit : 0u;
        batch.has_friction = batch.has_friction || block.has_friction();
        batch.mu.x[lane] = block.mu_d;
        rest.plain |= head.is_plain ? bit : 0u;
        for (std::size_t k = 0; k < points.size(); ++k) {
            const bool is_there = k < static_cast<std::size_t>(block.count);
            points[k].at[lane] = &head.contacts[is_there ? k : 0].at.gap;
            points[k].memory[lane] = &head.memory[is_there ? k : 0].p_n;
            points[k].there |= is_there ? bit : 0u;
            __builtin_prefetch(points[k].at[lane]);
            __builtin_prefetch(points[k].at[lane] + 7);
        }
        if (head.has_edges) {
            rest.edges |= bit;
            points[static_cast<std::size_t>(block.count - 1)].edges |= bit;
            const double size = std::min(bodies.props[static_cast<std::size_t>(block.a)].bounding_radius,
                                         bodies.props[static_cast<std::size_t>(block.b)].bounding_radius);
            rest.reach.x[lane] = wander_share * size;
            for (int axis = 0; axis < 3; ++axis) {
                rest.edge_a[axis].x[lane] = head.edge_a[axis];
                rest.edge_b[axis].x[lane] = head.edge_b[axis];
            }
        }
    }
    fetch_batch(i);
}

/// Asks for what the contacts of batch i remember.
void ContactSolver::fetch_batch(std::size_t i) const {
    const BlockBatch& batch = loop_.batches[i];
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        for (const double* memory : rest_points_[static_cast<std::size_t>(k)].memory) {
            __builtin_prefetch(memory);
            __builtin_prefetch(memory + 8);
        }
    }
}

double ContactSolver::work_on_batches(RestPhase phase, std::size_t first, std::size_t last, const unsigned* only) {
    return work_on_rest({.phase = phase,
                         .batches = loop_.batches.data() + first,
                         .batch_count = last - first,
                         .blocks = rest_blocks_.data() + first,
                         .points = loop_.batch_points.data(),
                         .rest = rest_points_.data(),
                         .begin = begin_.data(),
                         .end = end_.data(),
                         .before = before_,
                         .velocity = velocity_.front().v.data(),
                         .only = only,
                         .rules = &rules_});
}

/// The block in a lane; its points stay there.
ContactBlock ContactSolver::block_in_lane(const BlockBatch& batch, std::size_t lane) const {
    ContactBlock block = loop_.blocks[static_cast<std::size_t>(batch.block[lane])];
    for (int axis = 0; axis < 3; ++axis) {
        block.frame.col(axis) = vector_in_lane(batch.frame + 3 * axis, lane);
    }
    block.r_a = vector_in_lane(batch.r_a, lane);
    block.r_b = vector_in_lane(batch.r_b, lane);
    block.node_weight = batch.node_weight.x[lane];
    return block;
}

/// measure() for batches first..last of the lanes in `only` [last - first].
double ContactSolver::measure_lanes(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::size_t first,
                                    std::size_t last, const unsigned* only) {
    double worst = work_on_batches(RestPhase::measure, first, last, only);
    for (std::size_t i = first; i < last; ++i) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            const bool is_left = loop_.batches[i].block[lane] >= 0 && (rest_blocks_[i].plain >> lane & 1u) == 0;
            if (is_left && (only == nullptr || (only[i - first] >> lane & 1u) != 0)) {
                worst = std::max(worst, measure_lane(bodies, pairs, loop_.batches[i], lane));
            }
        }
    }
    return worst;
}

/// measure_block() for a lane that is not plain.
double ContactSolver::measure_lane(const Bodies& bodies, const std::vector<PairContacts>& pairs, const BlockBatch& batch,
                                   std::size_t lane) {
    const ContactBlock block = block_in_lane(batch, lane);
    const BlockHead& head = heads_[static_cast<std::size_t>(batch.block[lane])];
    const Vec6 twist = relative_twist(block, velocity_);
    const Vec3 n = predicted_normal(bodies, block);
    double worst = 0.0;
    for (int k = 0; k < block.count; ++k) {
        BatchPoint& in_lanes = loop_.batch_points[static_cast<std::size_t>(batch.first + k)];
        const RestPoint& rest = rest_points_[static_cast<std::size_t>(batch.first + k)];
        const Contact& measured = head.contacts[k];
        RestingContact contact;
        contact.pair = head.pair;
        contact.index = head.index + k;
        contact.is_on_face = block.is_flat && measured.feature.kind == head.contacts[0].feature.kind && !is_curved(measured.feature);
        set_material_points(bodies, block, measured.at, contact);
        contact.gap_target = rest.gap_target.x[lane];
        contact.owed = {rest.owed[0].x[lane], rest.owed[1].x[lane]};
        ContactPoint point = point_in_lane(in_lanes, lane);
        worst = std::max(worst, measure_point(bodies, pairs[static_cast<std::size_t>(head.pair)], {block, twist, n, contact}, point));
        in_lanes.u_n_target.x[lane] = point.u_n_target;
        in_lanes.u_t_target[0].x[lane] = point.u_t_target.x();
        in_lanes.u_t_target[1].x[lane] = point.u_t_target.y();
    }
    return worst;
}

/// Back to blocks and points, for contacts that are added or dropped: with the impulses found so far.
void ContactSolver::leave_lanes(const Bodies& bodies, const std::vector<PairContacts>& pairs) {
    if (!in_lanes_) {
        return;
    }
    in_lanes_ = false;
    resize({loop_.blocks.size(), point_count_});
    Place place;
    Taken taken;
    for (std::size_t pair = 0; place.point < loop_.points.size(); ++pair) {
        take(bodies, pairs[pair], taken);
        place_contacts(bodies, pairs[pair], static_cast<int>(pair), place, taken);
        place.block += block_count(taken.at);
        place.point += taken.at.size();
    }
    loop_.store_impulses();
}

/// remember_block() and tell_forces() for all batches.
void ContactSolver::remember_lanes(const Bodies& bodies) {
    is_hit_.assign(bodies.props.size(), 0);
    for (const BlockBatch& batch : loop_.batches) {
        for (int k = batch.first; k < batch.first + batch.count; ++k) {
            const unsigned closing = rest_points_[static_cast<std::size_t>(k)].closing;
            for (std::size_t lane = 0; closing >> lane != 0; ++lane) {
                if ((closing >> lane & 1u) != 0 && loop_.batch_points[static_cast<std::size_t>(k)].p_n.x[lane] > 0.0) {
                    is_hit_[static_cast<std::size_t>(batch.a[lane])] = is_hit_[static_cast<std::size_t>(batch.b[lane])] = 1;
                }
            }
        }
    }
    loop_.share(loop_.batches.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            const BlockBatch& batch = loop_.batches[i];
            unsigned hit = 0;
            for (unsigned lane = 0; lane < lane_count; ++lane) {
                const unsigned of_a = is_hit_[static_cast<std::size_t>(batch.a[lane])] != 0 ? batch.moves_a : 0u;
                const unsigned of_b = is_hit_[static_cast<std::size_t>(batch.b[lane])] != 0 ? batch.moves_b : 0u;
                hit |= (of_a | of_b) & (1u << lane);
            }
            rest_blocks_[i].hit = hit;
            if (i + ahead_batches < last) {
                fetch_batch(i + ahead_batches);
            }
            work_on_batches(RestPhase::remember, i, i + 1);
        }
    });
}

/// The part of velocity_at_node() that contacts have.
void ContactSolver::add_node_impulses(const Bodies& bodies, std::vector<Velocity>& velocity) const {
    for (const BlockBatch& batch : loop_.batches) {
        for (std::size_t lane = 0; lane < lane_count && batch.block[lane] >= 0; ++lane) {
            const ContactBlock block = block_in_lane(batch, lane);
            Vec6 wrench = Vec6::Zero();
            for (int k = 0; k < block.count; ++k) {
                const ContactPoint point = point_in_lane(loop_.batch_points[static_cast<std::size_t>(batch.first + k)], lane);
                const RestPoint& rest = rest_points_[static_cast<std::size_t>(batch.first + k)];
                if ((rest.ahead >> lane & 1u) == 0 && point.p_n > 0.0) {
                    wrench += block.node_weight * rest.force_share.x[lane] * wrench_of_point(point);
                }
            }
            apply_wrench(block, wrench, bodies.props, bodies.inverse_inertia, velocity);
        }
    }
}

} // namespace sim
