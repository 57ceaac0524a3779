/// The contacts of a solve: those that it holds, and the impulses that they start from.
#include "sim/model/integrate.h"
#include "sim/solve/contact_solver.h"
#include "sim/solve/time_of_impact.h"

#include <algorithm>

namespace sim {
namespace {

/// What stands for a contact in lanes that have none.
ContactMemory no_memory;

} // namespace

void ContactSolver::add_contacts(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const int> added,
                                 std::span<const Velocity> at_node) {
    const std::size_t first_block = loop_.blocks.size();
    std::vector<BlockContact> taken;
    for (const int index : added) {
        const PairContacts& pair = pairs[static_cast<std::size_t>(index)];
        add_solved_body(bodies, pair.manifold.body_a);
        add_solved_body(bodies, pair.manifold.body_b);
        taken.resize(pair.manifold.contacts.size());
        taken.resize(take(bodies, pair, taken.data()));
        all_in_solve_ = all_in_solve_ && taken.size() == pair.manifold.contacts.size();
        has_two_coefficients_ = has_two_coefficients_ || pair.material.mu_s != pair.material.mu_d;
        const std::size_t first = loop_.contacts.size();
        const std::size_t place = loop_.blocks.size();
        loop_.contacts.insert(loop_.contacts.end(), taken.begin(), taken.end());
        loop_.blocks.resize(place + block_count(taken));
        loop_.split(place, first, loop_.contacts.size(), block_like(pair, index));
    }
    contact_count_ = static_cast<int>(loop_.contacts.size());
    start(bodies, pairs, first_block);
    find_late_impacts(pairs, first_block, at_node);
}

void ContactSolver::drop_contacts(const Bodies& bodies, int pair) {
    all_in_solve_ = false;
    for (Block& block : loop_.blocks) {
        if (block.count > 0 && block.pair == pair) {
            const BlockBatch& batch = loop_.batch_of(block);
            for (int k = batch.first; k < batch.first + batch.count; ++k) {
                rest_points_[static_cast<std::size_t>(k)].memory[Blocks::lane_of(block)] = &no_memory.p_n;
            }
            loop_.drop(block, bodies, velocity_);
        }
    }
}

/// The contacts of a pair that the solve holds, all but the impacts that are waited for; returns their number.
std::size_t ContactSolver::take(const Bodies& bodies, const PairContacts& pair, BlockContact* to) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < pair.manifold.contacts.size(); ++i) {
        const Contact& contact = pair.manifold.contacts[i];
        if (!stop_at_impacts_ || !is_impact(bodies, pair.manifold, contact, settings_)) {
            to[count++] = {&contact, static_cast<int>(i)};
        }
    }
    return count;
}

/// Blocks and contacts of all pairs.
void ContactSolver::take_pairs(const Bodies& bodies, const std::vector<PairContacts>& pairs) {
    struct Size {
        std::size_t blocks = 0;
        std::size_t contacts = 0;
    };
    std::vector<Size> end(pairs.size() + 1); // before each pair, and at the end
    loop_.share(pairs.size(), [&](std::size_t first, std::size_t last) {
        std::vector<BlockContact> taken;
        for (std::size_t i = first; i < last; ++i) {
            end[i + 1] = {pairs[i].blocks, pairs[i].manifold.contacts.size()};
            if (stop_at_impacts_) {
                taken.resize(pairs[i].manifold.contacts.size());
                taken.resize(take(bodies, pairs[i], taken.data()));
                end[i + 1] = {block_count(taken), taken.size()};
            }
        }
    });
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        all_in_solve_ = all_in_solve_ && end[i + 1].contacts == pairs[i].manifold.contacts.size();
        has_two_coefficients_ = has_two_coefficients_ || pairs[i].material.mu_s != pairs[i].material.mu_d;
        end[i + 1].blocks += end[i].blocks;
        end[i + 1].contacts += end[i].contacts;
    }
    loop_.blocks.resize(end.back().blocks);
    loop_.contacts.resize(end.back().contacts);
    contact_count_ = static_cast<int>(end.back().contacts);
    loop_.share(pairs.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            take(bodies, pairs[i], loop_.contacts.data() + end[i].contacts);
            loop_.split(end[i].blocks, end[i].contacts, end[i + 1].contacts, block_like(pairs[i], static_cast<int>(i)));
        }
    });
}

/// Bodies that are not among them move freely over the interval: to where predicted() tells from here on.
void ContactSolver::find_solved_bodies(const Bodies& bodies, std::span<const PairContacts> pairs,
                                       std::span<const Joint> joints) {
    is_solved_.assign(bodies.props.size(), 0);
    solved_bodies_.clear();
    for (const PairContacts& pair : pairs) {
        add_solved_body(bodies, pair.manifold.body_a);
        add_solved_body(bodies, pair.manifold.body_b);
    }
    for (const Joint& joint : joints) {
        add_solved_body(bodies, joint.a);
        add_solved_body(bodies, joint.b);
    }
    std::ranges::sort(solved_bodies_);
    loop_.share(bodies.props.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            if (is_solved_[i] == 0) {
                predicted_[i] = free_motion(bodies.props[i], bodies.pose[i], velocity_[i], settings_.gravity, h_);
            }
        }
    });
}

void ContactSolver::add_solved_body(const Bodies& bodies, int body) {
    const auto i = static_cast<std::size_t>(body);
    if (is_solved_[i] == 0) {
        is_solved_[i] = 1;
        solved_bodies_.push_back(i);
        radius_[i] = bodies.props[i].is_static() ? 0.0 : bodies.props[i].bounding_radius;
    }
}

/// Batches of the blocks from `first_block` on, and what their contacts start from.
void ContactSolver::start(const Bodies& bodies, std::vector<PairContacts>& pairs, std::size_t first_block) {
    if (first_block == loop_.blocks.size()) {
        return;
    }
    const std::size_t first_batch = loop_.batches.size();
    loop_.arrange(bodies, first_block, bodies.velocity);
    rest_points_.resize(loop_.points.size());
    rest_blocks_.resize(loop_.batches.size());
    loop_.share(loop_.batches.size() - first_batch, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first_batch + first; i < first_batch + last; ++i) {
            start_batch(bodies, pairs, i);
        }
    });
    for (std::size_t i = first_block; has_two_coefficients_ && i < loop_.blocks.size(); ++i) {
        Block& block = loop_.blocks[i];
        set_mark(block, loop_.batch_of(block).sticking.x[Blocks::lane_of(block)] > 0.5);
    }
    loop_.share_colours([&](std::size_t first, std::size_t last) { work_on_batches(RestPhase::apply, first, last, velocity_); },
                        first_batch);
}

void ContactSolver::start_batch(const Bodies& bodies, std::vector<PairContacts>& pairs, std::size_t i) {
    const BlockBatch& batch = loop_.batches[i];
    RestBlock& rest = rest_blocks_[i];
    rest.plain = rest.edges = rest.hit = 0;
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        RestPoint& point = rest_points_[static_cast<std::size_t>(k)];
        std::fill_n(point.memory, lane_count, &no_memory.p_n);
        point.edges = 0;
    }
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (batch.block[lane] >= 0) {
            const Block& block = loop_.blocks[static_cast<std::size_t>(batch.block[lane])];
            start_lane(bodies, pairs[static_cast<std::size_t>(block.pair)], i, lane);
        }
    }
    work_on_batches(RestPhase::start, i, i + 1, velocity_);
}

/// Where the contacts of a lane are remembered, and how they are measured.
void ContactSolver::start_lane(const Bodies& bodies, PairContacts& pair, std::size_t i, std::size_t lane) {
    const BlockBatch& batch = loop_.batches[i];
    RestBlock& rest = rest_blocks_[i];
    const unsigned bit = 1u << lane;
    const std::span<const BlockContact> own =
        loop_.contacts_of(loop_.blocks[static_cast<std::size_t>(batch.block[lane])]);
    const ContactFeature& first = own.front().contact->feature;
    const ContactFeature& edges = own.back().contact->feature; // the last by its id, if there are any
    const bool has_edges = edges.kind == FeatureKind::edges;
    const bool is_flat = (batch.flat & bit) != 0;
    bool is_plain = is_flat || own.size() == 1;
    for (std::size_t k = 0; k < own.size(); ++k) {
        rest_points_[static_cast<std::size_t>(batch.first) + k].memory[lane] =
            &pair.memory[static_cast<std::size_t>(own[k].index)].p_n;
        const ContactFeature& feature = own[k].contact->feature;
        const bool is_on_face = is_flat && feature.kind == first.kind && !is_curved(feature);
        is_plain = is_plain && (is_on_face || (has_edges && k + 1 == own.size()));
    }
    rest.plain |= is_plain ? bit : 0u;
    if (!is_plain || !has_edges) {
        return;
    }
    rest.edges |= bit;
    rest_points_[static_cast<std::size_t>(batch.first) + own.size() - 1].edges |= bit;
    const auto a = static_cast<std::size_t>(batch.a[lane]);
    const auto b = static_cast<std::size_t>(batch.b[lane]);
    rest.reach.x[lane] = wander_share * std::min(bodies.props[a].bounding_radius, bodies.props[b].bounding_radius);
    const Vec3 edge_a = bodies.pose[a].orientation * (edges.side * edges.direction_a);
    const Vec3 edge_b = bodies.pose[b].orientation * edges.direction_b;
    for (int axis = 0; axis < 3; ++axis) {
        rest.edge_a[axis].x[lane] = edge_a[axis];
        rest.edge_b[axis].x[lane] = edge_b[axis];
    }
}

void ContactSolver::find_late_impacts(const std::vector<PairContacts>& pairs, std::size_t first_block,
                                      std::span<const Velocity> at_node) {
    const double threshold = resting_threshold(settings_);
    for (std::size_t i = first_block; i < loop_.blocks.size(); ++i) {
        const Block& block = loop_.blocks[i];
        const BlockBatch& batch = loop_.batch_of(block);
        const std::size_t lane = Blocks::lane_of(block);
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(at_node);
        const std::vector<ContactMemory>& memory = pairs[static_cast<std::size_t>(block.pair)].memory;
        for (std::size_t k = 0; k < static_cast<std::size_t>(block.count); ++k) {
            const auto at = static_cast<std::size_t>(batch.first) + k;
            const int index = loop_.contacts[static_cast<std::size_t>(block.first) + k].index;
            const bool is_new = memory[static_cast<std::size_t>(index)].last_interval == 0.0;
            if (is_new && -LanePoint(loop_.points[at], lane).normal_velocity(twist) > threshold) {
                rest_points_[at].ahead |= 1u << lane;
                rest_points_[at].closing |= 1u << lane;
            }
        }
    }
}

/// Impulses p minimise p.A p / 2 + b.p where they converge: the share s of a guess p is best at 1 - p.r / p.A p, where r is
/// how much faster than their targets the contacts part with all of it, and p.A p twice the kinetic energy of what it changes.
void ContactSolver::scale_warm_start(const Bodies& bodies, const std::vector<PairContacts>& pairs) {
    predict(bodies);
    measure(bodies, pairs);
    double work = 0.0; // p.r [J]
    for (const Block& block : loop_.blocks) {
        const BlockBatch& batch = loop_.batch_of(block);
        const std::size_t lane = Blocks::lane_of(block);
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(velocity_);
        for (const BatchPoint& of : loop_.points_of(batch).first(static_cast<std::size_t>(block.count))) {
            const LanePoint point(of, lane);
            const Vec2 target(of.u_t_target[0].x[lane], of.u_t_target[1].x[lane]);
            work += point.p_n * (point.normal_velocity(twist) - of.u_n_target.x[lane]) +
                    point.p_t.dot(point.tangential_velocity(twist) - target);
        }
    }
    double energy = 0.0; // p.A p [J]
    for (const std::size_t i : solved_bodies_) {
        if (!bodies.props[i].is_static()) {
            const Velocity change{velocity_[i].v - bodies.velocity[i].v, velocity_[i].w - bodies.velocity[i].w};
            energy += 2.0 * kinetic_energy(bodies.props[i], bodies.pose[i].orientation, change);
        }
    }
    const double share = std::clamp(1.0 - work / energy, 0.0, 1.0);
    if (!(energy > 0.0) || share > 0.5) {
        return; // all of it is nearer than none
    }
    for (const std::size_t i : solved_bodies_) {
        velocity_[i].v = bodies.velocity[i].v + share * (velocity_[i].v - bodies.velocity[i].v);
        velocity_[i].w = bodies.velocity[i].w + share * (velocity_[i].w - bodies.velocity[i].w);
    }
    for (BatchPoint& point : loop_.points) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            point.p_n.x[lane] *= share;
            point.p_t[0].x[lane] *= share;
            point.p_t[1].x[lane] *= share;
        }
    }
}

} // namespace sim
