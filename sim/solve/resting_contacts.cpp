#include "sim/solve/resting_contacts.h"

#include "sim/base/grow.h"
#include "sim/solve/time_of_impact.h"

#include <algorithm>
#include <atomic>
#include <numeric>

namespace sim {
namespace {

static_assert(offsetof(ContactMemory, p_n) == 0 && offsetof(ContactMemory, approach_speed) == 7 * sizeof(double) &&
                  sizeof(ContactMemory) == 8 * sizeof(double),
              "rest_kernel.cpp reads and writes them by their places");
static_assert(offsetof(ContactFeature, direction_b) == offsetof(ContactFeature, direction_a) + 3 * sizeof(double) &&
                  offsetof(ContactFeature, direction_a) + 8 * sizeof(double) <= sizeof(ContactFeature),
              "rest_kernel.cpp reads a row of 8 that begins with them");

/// What stands for the features of crossing edges in lanes that have none.
const ContactFeature no_edges;

} // namespace

void RestingContacts::follow(const StepSettings& settings, const RestRules& rules) {
    settings_ = settings;
    rules_ = rules;
}

void RestingContacts::begin(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> own, Prediction& to,
                            std::span<Velocity> uncertain) {
    before_ = bodies.velocity.front().v.data();
    end_ = to.rows.data();
    has_two_coefficients_ = false;
    has_all_ = true;
    take_all(bodies, pairs, own);
    sorted_blocks_ = loop.blocks.size();
    start(bodies, pairs, 0, to, uncertain);
}

void RestingContacts::add(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> added,
                                 std::span<const Velocity> at_node, Prediction& to) {
    const std::size_t first_block = loop.blocks.size();
    std::vector<const Contact*> taken;
    for (const int index : added) {
        const PairContacts& pair = pairs[static_cast<std::size_t>(index)];
        taken.resize(pair.manifold.contacts.size());
        taken.resize(take(bodies, pair, taken.data()));
        has_all_ = has_all_ && taken.size() == pair.manifold.contacts.size();
        has_two_coefficients_ = has_two_coefficients_ || pair.material.mu_s != pair.material.mu_d;
        const std::size_t first = loop.contacts.size();
        loop.contacts.insert(loop.contacts.end(), taken.begin(), taken.end());
        loop.add(first, block_like(pair, index));
    }
    start(bodies, pairs, first_block, to, {});
    if (!at_node.empty()) {
        find_late_impacts(first_block, at_node);
    }
}

void RestingContacts::drop(const Bodies& bodies, int pair, Prediction& to) {
    const auto drop_if_its = [&](Block& block) {
        if (block.count > 0 && block.pair == pair) {
            remember(block);
            loop.drop(block, bodies, to.velocity);
            RestBlock& rest = rest_blocks[static_cast<std::size_t>(block.lane) / lane_count];
            rest.crossing[Blocks::lane_of(block)] = no_edges.direction_a.data(); // its manifold is to change
        }
    };
    const auto sorted_end = loop.blocks.begin() + static_cast<std::ptrdiff_t>(sorted_blocks_);
    const auto first = std::ranges::lower_bound(loop.blocks.begin(), sorted_end, pair, {}, &Block::pair);
    std::for_each(first, std::ranges::upper_bound(first, sorted_end, pair, {}, &Block::pair), drop_if_its);
    std::for_each(sorted_end, loop.blocks.end(), drop_if_its);
}

/// Its contacts remember the block's impulses as they are now, for those that are to take their place in this solve.
void RestingContacts::remember(const Block& block) const {
    const BlockBatch& batch = loop.batch_of(block);
    const std::size_t lane = Blocks::lane_of(block);
    const LaneFrame frame(batch, lane);
    const double share = force_share(block);
    auto at = static_cast<std::size_t>(batch.first);
    for (const Contact* contact : loop.contacts_of(block)) {
        const LanePoint point(loop.points[at++], lane);
        ContactMemory& memory = contact->memory;
        const double interval = impulse_interval(batch.node_weight.x[lane], rules_.h);
        memory.p_n = point.p_n;
        memory.p_t = frame.frame.leftCols<2>() * point.p_t;
        memory.signed_interval = memory.is_sticking() ? -interval : interval;
        memory.force_share = share;
    }
}

/// The contacts of a pair that the solve holds, all but the impacts that are waited for; returns their number.
std::size_t RestingContacts::take(const Bodies& bodies, const PairContacts& pair, const Contact** to) const {
    std::size_t count = 0;
    for (const Contact& contact : pair.manifold.contacts) {
        if (settings_.impacts != ImpactHandling::stop || !is_impact(bodies, pair.manifold, contact, settings_)) {
            to[count++] = &contact;
        }
    }
    return count;
}

/// Blocks and contacts of the pairs.
void RestingContacts::take_all(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> own) {
    const auto pair_of = [&](std::size_t i) -> const PairContacts& { return pairs[static_cast<std::size_t>(own[i])]; };
    struct Size {
        std::size_t blocks = 0;
        std::size_t contacts = 0;
    };
    std::vector<Size> end(own.size() + 1); // before each pair, and at the end
    loop.share(own.size(), [&](std::size_t first, std::size_t last) {
        std::vector<const Contact*> taken;
        for (std::size_t i = first; i < last; ++i) {
            const PairContacts& pair = pair_of(i);
            end[i + 1] = {pair.blocks, pair.manifold.contacts.size()};
            if (settings_.impacts == ImpactHandling::stop) {
                taken.resize(pair.manifold.contacts.size());
                taken.resize(take(bodies, pair, taken.data()));
                end[i + 1] = {block_count(taken), taken.size()};
            }
        }
    });
    for (std::size_t i = 0; i < own.size(); ++i) {
        const PairContacts& pair = pair_of(i);
        has_all_ = has_all_ && end[i + 1].contacts == pair.manifold.contacts.size();
        has_two_coefficients_ = has_two_coefficients_ || pair.material.mu_s != pair.material.mu_d;
        end[i + 1].blocks += end[i].blocks;
        end[i + 1].contacts += end[i].contacts;
    }
    loop.clear(end.back().blocks, end.back().contacts);
    loop.share(own.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            take(bodies, pair_of(i), loop.contacts.data() + end[i].contacts);
            loop.split(std::span(loop.blocks).subspan(end[i].blocks, end[i + 1].blocks - end[i].blocks), end[i].contacts,
                       end[i + 1].contacts, block_like(pair_of(i), own[i]));
        }
    });
}

/// Batches of the blocks from `first_block` on, and what their contacts start from.
void RestingContacts::start(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::size_t first_block, Prediction& to,
                            std::span<Velocity> uncertain) {
    const std::size_t first_batch = loop.lay_out(bodies, first_block);
    grow(rest_points, loop.points.size());
    grow(rest_blocks, loop.batches.size());
    const auto start_some = [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            loop.fill_batch(i, bodies, bodies.velocity);
            start_batch(pairs, i, to.velocity);
            if (!uncertain.empty()) {
                work(RestPhase::uncertain, i, i + 1, uncertain);
            }
        }
    };
    loop.share_colours(start_some, first_batch);
    for (std::size_t i = first_block; has_two_coefficients_ && i < loop.blocks.size(); ++i) {
        Block& block = loop.blocks[i];
        set_mark(block, (loop.batch_of(block).sticking >> Blocks::lane_of(block) & 1u) != 0);
    }
}

void RestingContacts::start_batch(const std::vector<PairContacts>& pairs, std::size_t i, std::span<Velocity> velocity) {
    const BlockBatch& batch = loop.batches[i];
    RestBlock& rest = rest_blocks[i];
    rest.plain = rest.edges = rest.hit = rest.fresh = 0;
    std::fill_n(rest.crossing, lane_count, no_edges.direction_a.data());
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (batch.block[lane] >= 0) {
            const Block& block = loop.blocks[static_cast<std::size_t>(batch.block[lane])];
            const PairContacts& pair = pairs[static_cast<std::size_t>(block.pair)];
            rest.least_gap.x[lane] = pair.least_gap;
            rest.fresh |= static_cast<unsigned>(pair.is_struck) << lane;
            start_lane(pair.manifold, i, lane);
        }
    }
    work_with_memory(work_of(RestPhase::start, i, i + 1, velocity), i);
}

/// Work on batch i that reads or writes what its contacts remember.
void RestingContacts::work_with_memory(RestWork work, std::size_t i) {
    ContactMemory none; // what stands for a contact in lanes that have none
    double* memory[block_size * lane_count];
    const BlockBatch& batch = loop.batches[i];
    std::fill_n(memory, lane_count * batch.count, &none.p_n);
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (batch.block[lane] < 0) {
            continue;
        }
        const Block& block = loop.blocks[static_cast<std::size_t>(batch.block[lane])];
        std::size_t k = 0;
        for (const Contact* contact : loop.contacts_of(block)) {
            memory[lane_count * k++ + lane] = &contact->memory.p_n;
        }
    }
    work.memory = memory;
    work_on_rest(work);
}

/// How the contacts of a lane are measured.
void RestingContacts::start_lane(const Manifold& manifold, std::size_t i, std::size_t lane) {
    const BlockBatch& batch = loop.batches[i];
    RestBlock& rest = rest_blocks[i];
    const unsigned bit = 1u << lane;
    const std::span<const Contact* const> own =
        loop.contacts_of(loop.blocks[static_cast<std::size_t>(batch.block[lane])]);
    const Contact& first = *own.front();
    const Contact& last = *own.back(); // by its id: crossing edges, if there are any
    const bool has_edges = last.kind == FeatureKind::edges;
    bool is_plain = first.feature == 0 || own.size() == 1;
    for (const Contact* contact : own) {
        const bool is_on_face = contact->kind == first.kind && contact->feature == 0;
        is_plain = is_plain && (is_on_face || (has_edges && contact == &last));
    }
    rest.plain |= is_plain ? bit : 0u;
    if (!is_plain || !has_edges) {
        return;
    }
    rest.edges |= bit;
    loop.points_of(batch)[own.size() - 1].edges |= bit;
    rest.crossing[lane] = manifold.features[last.feature - 1u].direction_a.data();
}

void RestingContacts::find_late_impacts(std::size_t first_block, std::span<const Velocity> at_node) {
    const double threshold = resting_threshold(settings_);
    for (std::size_t i = first_block; i < loop.blocks.size(); ++i) {
        const Block& block = loop.blocks[i];
        const BlockBatch& batch = loop.batch_of(block);
        const std::size_t lane = Blocks::lane_of(block);
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(at_node);
        for (std::size_t k = 0; k < static_cast<std::size_t>(block.count); ++k) {
            const auto at = static_cast<std::size_t>(batch.first) + k;
            const Contact& contact = *loop.contacts[static_cast<std::size_t>(block.first) + k];
            const bool is_new = contact.memory.last_interval == 0.0;
            if (is_new && -LanePoint(loop.points[at], lane).normal_velocity(twist) > threshold) {
                loop.points[at].ahead |= 1u << lane;
                loop.points[at].closing |= 1u << lane;
            }
        }
    }
}

double RestingContacts::work(RestPhase phase, std::size_t first, std::size_t last, std::span<Velocity> velocity) {
    return work_on_rest(work_of(phase, first, last, velocity));
}

RestWork RestingContacts::work_of(RestPhase phase, std::size_t first, std::size_t last, std::span<Velocity> velocity) {
    return {.phase = phase,
            .batches = loop.batches.data() + first,
            .batch_count = last - first,
            .blocks = rest_blocks.data() + first,
            .points = loop.points.data(),
            .rest = rest_points.data(),
            .begin = loop.rows().data(),
            .end = end_,
            .before = before_,
            .velocity = velocity.empty() ? nullptr : velocity.front().v.data(),
            .rules = &rules_};
}

/// Of what a phase sums up over all batches [J].
double RestingContacts::sum(RestPhase phase, const double* before, std::span<Velocity> velocity) {
    sums_.resize(loop.batches.size());
    loop.share_batches([&](std::size_t first, std::size_t last) {
        RestWork work = work_of(phase, first, last, velocity);
        work.before = before;
        work.sums = sums_.data() + first;
        work_on_rest(work);
    });
    return std::accumulate(sums_.begin(), sums_.end(), 0.0);
}

double RestingContacts::uncertain_work(std::span<const Velocity> velocity) {
    return sum(RestPhase::uncertain_work, velocity.front().v.data(), {});
}

double RestingContacts::impulse_work(std::span<Velocity> velocity) {
    return sum(RestPhase::impulse_work, before_, velocity);
}

double RestingContacts::hold_overlaps(double pace) {
    std::atomic<double> most = 0.0;
    loop.share_batches([&](std::size_t first, std::size_t last) {
        RestWork work = work_of(RestPhase::hold_overlaps, first, last, {});
        work.pace = pace;
        raise_to(most, work_on_rest(work));
    });
    return most;
}

double RestingContacts::give_way(std::span<Velocity> velocity) {
    if (!loop.gives_way()) {
        return 0.0;
    }
    std::atomic<double> most = 0.0;
    loop.share_batches([&](std::size_t first, std::size_t last) {
        RestWork work = work_of(RestPhase::give_way, first, last, velocity);
        work.softness = loop.softness();
        raise_to(most, work_on_rest(work));
    });
    return most;
}

void RestingContacts::scale_uncertain(double kept) {
    loop.share_batches([&](std::size_t first, std::size_t last) {
        RestWork work = work_of(RestPhase::scale, first, last, {});
        work.kept = kept;
        work_on_rest(work);
    });
}

} // namespace sim
