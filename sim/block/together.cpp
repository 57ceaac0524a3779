#include "sim/block/together.h"

#include "sim/block/contact_graph.h"

#include <algorithm>
#include <iterator>

namespace sim {
namespace {

/// With more blocks they are visited in batches.
constexpr std::size_t most_blocks = 64;

Vec3 impulse_of(const ContactPoint& point) {
    return {point.p_t.x(), point.p_t.y(), point.p_n};
}

} // namespace

bool TogetherSweeps::fits(const ContactBlocks& loop) {
    return loop.blocks.size() <= most_blocks;
}

void TogetherSweeps::begin(const ContactBlocks& loop, const Bodies& bodies) {
    momentum_.begin();
    carried_.clear();
    const std::vector<int> level = contact_levels(loop.blocks, bodies.props);
    const auto group_of = [&](const ContactBlock& block) {
        return level[static_cast<std::size_t>(block.a)] + level[static_cast<std::size_t>(block.b)];
    };
    blocks_ = loop.blocks;
    std::ranges::stable_sort(blocks_, {}, group_of);
    group_.clear();
    responses_.clear();
    std::ranges::transform(blocks_, std::back_inserter(group_), group_of);
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
        const ContactBlock& block = blocks_[k];
        // A body counts as so many times lighter as the group has blocks on it.
        const auto shares = [&](int body) {
            double count = 0.0;
            for (std::size_t i = 0; i < blocks_.size(); ++i) {
                count += group_[i] == group_[k] && (blocks_[i].a == body || blocks_[i].b == body) ? 1.0 : 0.0;
            }
            return count;
        };
        const double of_a = shares(block.a);
        const double of_b = shares(block.b);
        const double k_t = block_response(block, loop.points_of(block), bodies).k_t;
        responses_.push_back({of_a * block_response(block, {}, bodies, false, true).twist +
                                  of_b * block_response(block, {}, bodies, true, false).twist,
                              k_t * std::max(of_a, of_b)});
    }
}

double TogetherSweeps::sweep(ContactBlocks& loop, const Bodies& bodies, std::span<Velocity> velocity) {
    if (momentum_.carries()) {
        carry_on(loop, bodies, velocity);
    }
    change_ = 0.0;
    for (std::size_t first = 0; first < blocks_.size();) {
        std::size_t last = first;
        wrenches_.clear();
        for (; last < blocks_.size() && group_[last] == group_[first]; ++last) {
            const ContactBlock& block = blocks_[last];
            double change = 0.0;
            wrenches_.push_back(block_wrench(block, responses_[last], loop.points_of(block),
                                             relative_twist(block, velocity), change));
            change_ = std::max(change_, change);
        }
        for (std::size_t k = first; k < last; ++k) {
            apply_wrench(blocks_[k], wrenches_[k - first], bodies.props, bodies.inverse_inertia, velocity);
        }
        first = last;
    }
    return change_;
}

void TogetherSweeps::carry_on(ContactBlocks& loop, const Bodies& bodies, std::span<Velocity> velocity) {
    if (carried_.empty()) {
        std::ranges::transform(loop.points, std::back_inserter(carried_), impulse_of);
        swept_ = carried_;
        momentum_.start(change_);
        return;
    }
    double along = 0.0;
    for (std::size_t i = 0; i < loop.points.size(); ++i) {
        const Vec3 p = impulse_of(loop.points[i]);
        along += (p - carried_[i]).dot(p - swept_[i]);
    }
    const double momentum = momentum_.next(along, change_);
    for (const ContactBlock& block : blocks_) {
        const Vec6 before = wrench_of(loop.points_of(block));
        for (int k = block.first; k < block.first + block.count; ++k) {
            const auto i = static_cast<std::size_t>(k);
            const Vec3 p = impulse_of(loop.points[i]);
            carried_[i] = p + momentum * (p - swept_[i]);
            swept_[i] = p;
            loop.points[i].p_t = carried_[i].head<2>();
            loop.points[i].p_n = carried_[i].z();
        }
        apply_wrench(block, wrench_of(loop.points_of(block)) - before, bodies.props, bodies.inverse_inertia, velocity);
    }
}

} // namespace sim
