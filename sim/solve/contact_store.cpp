#include "sim/solve/resting_contacts.h"

#include "sim/base/disjoint_sets.h"
#include "sim/solve/time_of_impact.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace sim {
namespace {

/// Blocks of which an impact reaches a body, bit by lane.
unsigned reached_lanes(const BlockBatch& batch, std::span<const char> is_reached) {
    unsigned of_a = 0;
    unsigned of_b = 0;
    for (unsigned lane = 0; lane < lane_count; ++lane) {
        of_a |= static_cast<unsigned>(is_reached[static_cast<std::size_t>(batch.a[lane])]) << lane;
        of_b |= static_cast<unsigned>(is_reached[static_cast<std::size_t>(batch.b[lane])]) << lane;
    }
    return (of_a & batch.moves_a) | (of_b & batch.moves_b);
}

} // namespace

/// The mark of eq. 6, and the coefficient that goes with it.
void RestingContacts::set_mark(Block& block, bool sticks) {
    BlockBatch& batch = loop.batch_of(block);
    const std::size_t lane = Blocks::lane_of(block);
    batch.sticking = (batch.sticking & ~(1u << lane)) | static_cast<unsigned>(sticks) << lane;
    batch.mu.x[lane] = sticks ? block.mu_s : block.mu_d;
}

bool RestingContacts::update_marks(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                                   std::span<const Velocity> velocity) {
    bool changed = false;
    for (std::size_t i = 0; has_two_coefficients_ && i < loop.blocks.size(); ++i) {
        Block& block = loop.blocks[i];
        if (block.count > 0 && block.mu_d != block.mu_s) {
            changed = update_mark(bodies, pairs[static_cast<std::size_t>(block.pair)], block, velocity) || changed;
        }
    }
    return changed;
}

/// A marked block that is at its limit and slips loses its mark; a sliding one that the step would reverse has stopped
/// within it, and sticks if static friction can hold it.
bool RestingContacts::update_mark(const Bodies& bodies, const PairContacts& pair, Block& block,
                                  std::span<const Velocity> velocity) {
    const BlockBatch& batch = loop.batch_of(block);
    const std::size_t lane = Blocks::lane_of(block);
    const LaneFrame frame(batch, lane);
    const Vec6 twist = frame.relative_twist(velocity);
    const Vec6 before = frame.relative_twist(bodies.velocity);
    const bool is_sticking = (batch.sticking >> lane & 1u) != 0;
    const double mu = batch.mu.x[lane];
    const Vec2 fall = frame.frame.leftCols<2>().transpose() * relative_gravity(bodies, pair.manifold, settings_);
    bool slips = false;
    bool at_limit = false;
    double reversal = 0.0;
    for (int k = 0; k < block.count; ++k) {
        const BatchPoint& in_lanes = loop.points[static_cast<std::size_t>(batch.first + k)];
        const LanePoint point(in_lanes, lane);
        if (point.p_n == 0.0) {
            continue;
        }
        const Vec2 target(in_lanes.u_t_target[0].x[lane], in_lanes.u_t_target[1].x[lane]);
        const Vec2 slip = point.tangential_velocity(twist) - target;
        slips = slips || slip.norm() > rules_.velocity_tolerance;
        at_limit = at_limit || point.p_t.norm() >= rules_.limit * mu * point.p_n;
        const ContactMemory& memory = loop.contacts[static_cast<std::size_t>(block.first + k)]->memory;
        if (!memory.is_sticking()) {
            reversal += point.p_n * slip.dot(point.tangential_velocity(before) - 0.5 * memory.last_interval * fall);
        }
    }
    const bool lost = is_sticking && slips && at_limit;
    const bool stopped = !is_sticking && at_limit && reversal < 0.0;
    if (lost || stopped) {
        set_mark(block, stopped);
    }
    return lost || stopped;
}

/// How much of the block's impulses is a force [-].
double RestingContacts::force_share(const Block& block) const {
    const BlockBatch& batch = loop.batch_of(block);
    const std::size_t lane = Blocks::lane_of(block);
    double sum = 0.0;
    for (const BatchPoint& point : loop.points_of(batch)) {
        sum += point.p_n.x[lane];
    }
    const double force = rest_blocks[static_cast<std::size_t>(block.lane) / lane_count].load.x[lane];
    return sum > 0.0 ? std::min(force / sum, 1.0) : 1.0;
}

/// Which bodies impacts hit, and which they reach through joints, and through contacts that pass them on. An impact acts as a whole
/// within the interval, and so do the answers of the contacts that these bodies have: the instants before and after have no part of
/// them.
void RestingContacts::find_hit_bodies(std::span<const std::span<const int>> assemblies, std::span<char> is_reached) {
    // Calls reach(body, is it reached?) for these bodies of the lanes.
    const auto for_each_in = [&](const int* body, unsigned lanes, auto&& reach) {
        for (; lanes != 0; lanes &= lanes - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
            reach(lane, is_reached[static_cast<std::size_t>(body[lane])]);
        }
    };
    bool is_passed_on = false;
    const auto pass_on = [&](char& a, char& b) {
        is_passed_on = is_passed_on || a != b;
        a = b = a | b;
    };
    for (std::size_t i = 0; i < loop.batches.size(); ++i) {
        const BlockBatch& batch = loop.batches[i];
        const auto reach = [&](std::size_t, char& body) {
            body = 1;
            is_passed_on = true;
        };
        for_each_in(batch.a, rest_blocks[i].hit & batch.moves_a, reach);
        for_each_in(batch.b, rest_blocks[i].hit & batch.moves_b, reach);
    }
    while (std::exchange(is_passed_on, false)) {
        for (std::size_t i = 0; i < loop.batches.size(); ++i) {
            const BlockBatch& batch = loop.batches[i];
            for_each_in(batch.a, rest_blocks[i].grows & batch.moves_a & batch.moves_b, [&](std::size_t lane, char& a) {
                pass_on(a, is_reached[static_cast<std::size_t>(batch.b[lane])]);
            });
        }
        for (const std::span<const int> assembly : assemblies) {
            for (const int body : assembly) {
                pass_on(is_reached[static_cast<std::size_t>(assembly.front())], is_reached[static_cast<std::size_t>(body)]);
            }
        }
    }
}

void RestingContacts::store(const std::vector<PairContacts>& pairs, std::span<const int> own,
                            std::span<const std::span<const int>> assemblies, Prediction& to, std::span<Velocity> at_node) {
    find_hit_bodies(assemblies, to.is_reached);
    loop.share_colours([&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            RestWork work = work_of(RestPhase::store, i, i + 1, to.velocity);
            work.at_node = at_node.front().v.data();
            rest_blocks[i].hit = reached_lanes(loop.batches[i], to.is_reached);
            work_with_memory(work, i);
        }
    });
    if (!has_all_) {
        forget_left_out(pairs, own);
    }
}

/// Contacts that no block holds have no impulses.
void RestingContacts::forget_left_out(const std::vector<PairContacts>& pairs, std::span<const int> own) const {
    std::vector<const Contact*> held;
    for (const Block& block : loop.blocks) {
        const std::span<const Contact* const> in_block = loop.contacts_of(block);
        held.insert(held.end(), in_block.begin(), in_block.end());
    }
    std::ranges::sort(held);
    for (const int i : own) {
        for (const Contact& contact : pairs[static_cast<std::size_t>(i)].manifold.contacts) {
            if (!std::ranges::binary_search(held, &contact)) {
                contact.memory = {};
            }
        }
    }
}

void RestingContacts::unite_loaded(std::vector<int>& connected) const {
    for (std::size_t i = 0; i < loop.batches.size(); ++i) {
        const BlockBatch& batch = loop.batches[i];
        for (unsigned lanes = batch.moves_a & batch.moves_b; lanes != 0; lanes &= lanes - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
            if (rest_blocks[i].load.x[lane] > 0.0) {
                unite(connected, batch.a[lane], batch.b[lane]);
            }
        }
    }
}

DriveWork RestingContacts::work_by(std::span<const Velocity> velocity) const {
    DriveWork sum;
    for (const Block& block : loop.blocks) {
        if (block.count == 0) {
            continue;
        }
        const BlockBatch& batch = loop.batch_of(block);
        const std::size_t lane = Blocks::lane_of(block);
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(velocity);
        const double after = 1.0 - batch.node_weight.x[lane] * force_share(block);
        for (std::size_t k = 0; k < static_cast<std::size_t>(block.count); ++k) {
            const BatchPoint& in_lanes = loop.points_of(batch)[k];
            const LanePoint point(in_lanes, lane);
            const double work =
                -(point.p_n * point.normal_velocity(twist) + point.p_t.dot(point.tangential_velocity(twist)));
            const bool is_ahead = (in_lanes.ahead >> lane & 1u) != 0;
            sum.all += work;
            sum.ahead += is_ahead || point.p_n == 0.0 ? work : after * work;
        }
    }
    return sum;
}

} // namespace sim
