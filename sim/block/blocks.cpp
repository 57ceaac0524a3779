#include "sim/block/blocks.h"

#include "sim/base/grow.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

namespace sim {
namespace {

static_assert(offsetof(Contact, at.gap) == 0 && offsetof(Contact, at.n) == sizeof(double) &&
                  offsetof(Contact, at.a) == 4 * sizeof(double) && sizeof(Contact) >= 8 * sizeof(double),
              "prepare_kernel.cpp reads a row of 8 that begins with gap, n and a");

double combined(double x, double y) {
    if (x < 0.0 || y < 0.0) {
        return std::max({x, y, 0.0});
    }
    return std::sqrt(x * y);
}

const Vec3& normal_of(const Contact& contact) {
    return contact.at.n;
}
const Vec3& normal_of(const Contact* contact) {
    return contact->at.n;
}

/// Length of the block that begins with the first of these contacts.
template <typename Any>
std::size_t block_length(std::span<const Any> contacts) {
    const Vec3& n = normal_of(contacts[0]);
    std::size_t length = 1;
    while (length < contacts.size() && length < block_size &&
           (normal_of(contacts[length]) - n).squaredNorm() < same_share * same_share) {
        ++length;
    }
    return length;
}

template <typename Any>
std::size_t count_blocks(std::span<const Any> contacts) {
    std::size_t count = 0;
    for (; !contacts.empty(); ++count) {
        contacts = contacts.subspan(block_length(contacts));
    }
    return count;
}

/// Points of a lane in a batch that holds blocks of `count` points.
int padded_count(int count) {
    return count <= 2 ? count : count <= 4 ? 4 : count <= 6 ? 6 : block_size;
}

/// The items in the order of their keys, small numbers; of equal ones in the order they have.
template <typename Item, typename Key>
std::vector<Item> sorted_by(const std::vector<Item>& items, Key&& key) {
    std::vector<std::size_t> begin; // of each key's items
    for (const Item& item : items) {
        const auto k = static_cast<std::size_t>(key(item));
        begin.resize(std::max(begin.size(), k + 2));
        ++begin[k + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Item> sorted(items.size());
    for (const Item& item : items) {
        sorted[begin[static_cast<std::size_t>(key(item))]++] = item;
    }
    return sorted;
}

/// Once over batches, the same as another sweep.
double sweep_like(const BatchSweep& like, BlockBatch* batches, std::size_t count) {
    BatchSweep sweep = like;
    sweep.batches = batches;
    sweep.batch_count = count;
    return sweep_batches(sweep);
}

} // namespace

std::vector<Velocity> kinematic_velocity(const Bodies& bodies) {
    std::vector<Velocity> velocity(bodies.props.size());
    for (const KinematicBody& body : bodies.kinematic) {
        velocity[body.index] = bodies.velocity[body.index];
    }
    return velocity;
}

LaneFrame::LaneFrame(const BlockBatch& batch, std::size_t lane)
    : a(batch.a[lane]), b(batch.b[lane]), r_a(vector_in_lane(batch.r_a, lane)), r_b(vector_in_lane(batch.r_b, lane)) {
    frame.col(0) = vector_in_lane(batch.t1, lane);
    frame.col(2) = vector_in_lane(batch.n, lane);
    frame.col(1) = frame.col(2).cross(frame.col(0));
}

Vec6 LaneFrame::relative_twist(std::span<const Velocity> velocity) const {
    const Velocity& of_a = velocity[static_cast<std::size_t>(a)];
    const Velocity& of_b = velocity[static_cast<std::size_t>(b)];
    Vec6 twist;
    twist.head<3>() = frame.transpose() * (of_a.at(r_a) - of_b.at(r_b));
    twist.tail<3>() = frame.transpose() * (of_a.w - of_b.w);
    return twist;
}

void LaneFrame::apply(const Vec6& wrench, const Bodies& bodies, std::span<Velocity> velocity) const {
    const Vec3 p = frame * wrench.head<3>();
    const Vec3 l = frame * wrench.tail<3>();
    const auto ia = static_cast<std::size_t>(a);
    const auto ib = static_cast<std::size_t>(b);
    velocity[ia].v += bodies.props[ia].inverse_mass * p;
    velocity[ia].w += bodies.inverse_inertia[ia] * (r_a.cross(p) + l);
    velocity[ib].v -= bodies.props[ib].inverse_mass * p;
    velocity[ib].w -= bodies.inverse_inertia[ib] * (r_b.cross(p) + l);
}

Vec6 LanePoint::wrench() const {
    Vec6 wrench;
    wrench << p_t, p_n, p_n * y, -p_n * x, x * p_t.y() - y * p_t.x();
    return wrench;
}

PairMaterial pair_material(const BodyProps& a, const BodyProps& b) {
    return {combined(a.restitution, b.restitution), combined(a.mu_s, b.mu_s), combined(a.mu_d, b.mu_d)};
}

void BlockBodies::begin(const Bodies& bodies, std::span<const std::size_t> which, Workers* workers) {
    const std::size_t count = bodies.props.size();
    rows.resize(count);
    colours.resize(count);
    swept.resize(count);
    waits.resize(count);
    wedged.resize(count);
    place.resize(count, -1);
    const auto write = [&](std::size_t first, std::size_t last) {
        for (const std::size_t k : which.subspan(first, last - first)) {
            const Vec3& x = bodies.pose[k].position;
            const Mat3& j = bodies.inverse_inertia[k];
            const Eigen::Vector4d& q = bodies.pose[k].orientation.coeffs();
            const double row[] = {bodies.props[k].inverse_mass,
                                  j(0, 0), j(0, 1), j(0, 2), j(1, 1), j(1, 2), j(2, 2), 0.0,
                                  x.x(), x.y(), x.z(), q[0], q[1], q[2], q[3], bodies.props[k].bounding_radius};
            std::ranges::copy(row, rows[k].x);
        }
    };
    sim::share(workers, which.size(), write, least_shared);
}

std::size_t block_count(std::span<const Contact> contacts) {
    return count_blocks(contacts);
}
std::size_t block_count(std::span<const Contact* const> contacts) {
    return count_blocks(contacts);
}

void Blocks::clear(std::size_t block_count, std::size_t contact_count) {
    grow(blocks, block_count);
    grow(contacts, contact_count);
    batches.clear();
    points.clear();
    order_.clear();
    planned_.clear();
    colours_.clear();
}

void Blocks::split(std::span<Block> to, std::size_t first, std::size_t last, const Block& like) {
    for (Block& block : to) {
        // The last one, of most pairs the only one, takes what is left: that is told without a look at its normals.
        const std::span<const Contact* const> left = std::span(contacts).subspan(first, last - first);
        const std::size_t length = &block == &to.back() ? left.size() : block_length(left);
        block = like;
        block.first = static_cast<int>(first);
        block.count = static_cast<int>(length);
        first += length;
    }
}

void Blocks::add(std::size_t first, const Block& like) {
    const std::size_t place = blocks.size();
    blocks.resize(place + block_count(std::span<const Contact* const>(contacts).subspan(first)));
    split(std::span(blocks).subspan(place), first, contacts.size(), like);
}

/// Graph colouring: no two blocks of a colour move the same body; each takes the first colour free, and a colour of its own where
/// its bodies have used up the bits of a number. Sorted by colour, then by size.
std::vector<Blocks::Place> Blocks::coloured(const Bodies& bodies, std::size_t first_block) {
    std::vector<std::uint64_t>& used = bodies_->colours;
    const auto moves = [&](int body) { return !bodies.props[static_cast<std::size_t>(body)].is_static(); };
    for (const Block& block : std::span(blocks).subspan(first_block)) {
        for (const int body : {block.a, block.b}) {
            if (moves(body)) { // others may be of other solves, too
                used[static_cast<std::size_t>(body)] = 0;
            }
        }
    }
    std::vector<Place> places;
    places.reserve(blocks.size() - first_block);
    const int last = std::numeric_limits<std::uint64_t>::digits;
    int alone = last;
    for (std::size_t i = first_block; i < blocks.size(); ++i) {
        std::uint64_t none = 0;
        std::uint64_t& used_a = moves(blocks[i].a) ? used[static_cast<std::size_t>(blocks[i].a)] : none;
        std::uint64_t& used_b = moves(blocks[i].b) ? used[static_cast<std::size_t>(blocks[i].b)] : none;
        int colour = std::countr_one(used_a | used_b);
        if (colour < last) {
            used_a |= std::uint64_t{1} << colour;
            used_b |= std::uint64_t{1} << colour;
        } else {
            colour = alone++;
        }
        places.push_back({colour, padded_count(blocks[i].count), static_cast<int>(i)});
    }
    return sorted_by(places, [](const Place& p) { return 16 * p.colour + p.count; });
}

/// Batches of blocks of one colour and like size; those of a colour in an order that gives threads equal shares of
/// large and small ones. places: of the blocks, as coloured() has them.
void Blocks::plan_batches(std::span<const Place> places) {
    std::size_t point_count = points.size();
    make_room(order_, order_.size() + places.size());
    std::vector<PlannedBatch> of_colour;
    for (auto place = places.begin(); place != places.end();) {
        of_colour.clear();
        const int colour = place->colour;
        while (place != places.end() && place->colour == colour) {
            PlannedBatch batch{.first = order_.size(), .count = place->count};
            for (; place != places.end() && batch.lanes < lane_count && place->colour == colour && place->count == batch.count;
                 ++place) {
                order_.push_back(place->block);
                ++batch.lanes;
            }
            of_colour.push_back(batch);
        }
        for (std::size_t share = 0; share < Workers::most_ranges; ++share) {
            for (std::size_t i = share; i < of_colour.size(); i += Workers::most_ranges) {
                of_colour[i].first_point = point_count;
                point_count += static_cast<std::size_t>(of_colour[i].count);
                planned_.push_back(of_colour[i]);
            }
        }
        colours_.push_back(planned_.size());
    }
    grow(batches, planned_.size());
    grow(points, point_count);
}

std::size_t Blocks::lay_out(const Bodies& bodies, std::size_t first_block) {
    const std::size_t first_batch = batches.size();
    islands_.clear();
    if (first_block < blocks.size()) {
        plan_batches(coloured(bodies, first_block));
    }
    return first_batch;
}

std::span<const int> Blocks::blocks_in(std::size_t i) const {
    return std::span(order_).subspan(planned_[i].first, planned_[i].lanes);
}

void Blocks::arrange(const Bodies& bodies, std::size_t first_block, std::span<const Velocity> velocity) {
    bodies_->place.resize(bodies.props.size(), -1);
    find_members(first_block, [](std::size_t) { return true; });
    bodies_->begin(bodies, members_, workers);
    const std::size_t first_batch = lay_out(bodies, first_block);
    share(batches.size() - first_batch, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first_batch + first; i < first_batch + last; ++i) {
            fill_batch(i, bodies, velocity);
        }
    });
}

void Blocks::fill_batch(std::size_t i, const Bodies& bodies, std::span<const Velocity> velocity) {
    static const Contact nowhere;
    const double* at[block_size * lane_count];
    BlockBatch& batch = batches[i];
    batch.first = static_cast<int>(planned_[i].first_point);
    batch.count = planned_[i].count;
    std::fill_n(batch.block, lane_count, -1);
    std::size_t next = 0;
    for (const int block : blocks_in(i)) {
        blocks[static_cast<std::size_t>(block)].lane = static_cast<int>(lane_count * i + next);
        batch.block[next++] = block;
    }
    const std::span<BatchPoint> own = points_of(batch);
    for (BatchPoint& point : own) {
        point.there = point.edges = point.wandered = point.ahead = point.closing = 0;
    }
    batch.moves_a = batch.moves_b = batch.led = batch.face_of_a = 0;
    batch.has_friction = false;
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (batch.block[lane] < 0) {
            batch.a[lane] = batch.b[lane] = batch.a[0];
            batch.mu.x[lane] = 0.0;
            for (std::size_t k = 0; k < own.size(); ++k) {
                at[lane_count * k + lane] = &nowhere.at.gap;
            }
            continue;
        }
        const Block& block = blocks[static_cast<std::size_t>(batch.block[lane])];
        const std::span<const Contact* const> from = contacts_of(block);
        const unsigned bit = 1u << lane;
        batch.a[lane] = block.a;
        batch.b[lane] = block.b;
        const BodyProps& a = bodies.props[static_cast<std::size_t>(block.a)];
        const BodyProps& b = bodies.props[static_cast<std::size_t>(block.b)];
        batch.moves_a |= a.is_static() ? 0u : bit;
        batch.moves_b |= b.is_static() ? 0u : bit;
        batch.led |= a.is_led || b.is_led ? bit : 0u;
        batch.has_friction = batch.has_friction || block.has_friction();
        batch.mu.x[lane] = block.mu_d;
        batch.face_of_a |= from[0]->kind == FeatureKind::face_a ? bit : 0u;
        for (std::size_t k = 0; k < own.size(); ++k) {
            const bool is_there = k < from.size();
            at[lane_count * k + lane] = is_there ? &from[k]->at.gap : &nowhere.at.gap;
            own[k].there |= is_there ? bit : 0u;
        }
    }
    prepare_batches({.batches = &batch,
                     .batch_count = 1,
                     .points = points.data(),
                     .at = at,
                     .rows = bodies_->rows.data(),
                     .velocity = velocity.front().v.data()});
}

void Blocks::drop(Block& block, const Bodies& bodies, std::span<Velocity> velocity) {
    BlockBatch& batch = batch_of(block);
    const std::size_t lane = lane_of(block);
    const LaneFrame frame(batch, lane);
    for (BatchPoint& point : points_of(batch)) {
        frame.apply(-LanePoint(point, lane).wrench(), bodies, velocity);
        point.p_n.x[lane] = point.p_t[0].x[lane] = point.p_t[1].x[lane] = 0.0;
        point.u_n_target.x[lane] = no_point;
        point.there &= ~(1u << lane);
    }
    batch.block[lane] = -1;
    batch.moves_a &= ~(1u << lane);
    batch.moves_b &= ~(1u << lane);
    block.count = 0;
}

void Blocks::wake(int budget) {
    for (BlockBatch& batch : batches) {
        std::fill_n(batch.seen[2].x, lane_count, no_point);
    }
    if (extrapolated_.empty()) {
        std::vector<ExtrapolatedPoint>().swap(extrapolated_); // the solve before went without: a heap at rest needs none
    }
    extrapolated_.clear();
    budget_ = budget;
    sweeps_ = 0;
    newton_cost_ = 0.0;
    least_change_ = progress_ = std::numeric_limits<double>::infinity();
    stalls_ = false;
    softness_ = 0.0;
    for (Island& island : islands_) {
        begin_wait(island);
        island.is_served = island.resists = false;
        island.is_extrapolated = true;
    }
}

/// Repeats a share of what the last sweep did, or begins to watch what sweeps do.
void Blocks::extrapolate(std::span<Velocity> velocity) {
    if (!islands_.empty() && std::ranges::none_of(islands_, &Island::is_extrapolated)) {
        extrapolated_.clear();
        return;
    }
    if (extrapolated_.empty()) {
        grow(extrapolated_, points.size());
        share(points.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                const Lanes now[] = {points[i].p_t[0], points[i].p_t[1], points[i].p_n};
                std::ranges::copy(now, extrapolated_[i].begun);
                std::ranges::copy(now, extrapolated_[i].swept);
            }
        });
        extrapolation_.start();
        return;
    }
    for (const Island& island : islands_) {
        if (!island.is_extrapolated) {
            hold(island);
        }
    }
    const auto work = [&](std::size_t first, std::size_t last, StepParts* parts, double share_of_step) {
        extrapolate_batches({.batches = batches.data() + first,
                       .batch_count = last - first,
                       .points = points.data(),
                       .before = extrapolated_.data(),
                       .parts = parts,
                       .share = share_of_step,
                       .rows = bodies_->rows.data(),
                       .velocity = velocity.front().v.data()});
    };
    parts_.resize(batches.size());
    share_batches([&](std::size_t first, std::size_t last) { work(first, last, parts_.data() + first, 0.0); });
    StepParts of_step;
    for (const StepParts& of_batch : parts_) {
        of_step.extrapolated += of_batch.extrapolated;
        of_step.swept += of_batch.swept;
    }
    const double share_of_step = extrapolation_.next(of_step, change_ / change_before_);
    share_colours([&](std::size_t first, std::size_t last) { work(first, last, nullptr, share_of_step); });
}

/// Visits again, colour by colour, what the last sweep changed by more than `large` [m/s], while that takes no more visits than
/// another sweep: of a row that is wedged nothing else changes after some twenty sweeps.
void Blocks::visit_again(const BatchSweep& like, double large) {
    const auto is_done = [&](std::size_t i) { return std::ranges::max(batches[i].change.x) <= large; };
    again_.resize(batches.size());
    std::iota(again_.begin(), again_.end(), std::size_t{0});
    std::erase_if(again_, is_done);
    std::size_t visits = 0;
    while (!again_.empty() && visits + again_.size() <= batches.size()) {
        visits += again_.size();
        auto begin = again_.begin();
        for (const std::size_t end_of_colour : colours_) {
            const std::span of_colour(begin, std::ranges::lower_bound(begin, again_.end(), end_of_colour));
            share(
                of_colour.size(),
                [&](std::size_t first, std::size_t last) {
                    for (const std::size_t i : of_colour.subspan(first, last - first)) {
                        sweep_like(like, &batches[i], 1);
                    }
                },
                least_shared / lane_count);
            begin += static_cast<std::ptrdiff_t>(of_colour.size());
        }
        std::erase_if(again_, is_done);
    }
}

double Blocks::sweep(std::span<Velocity> velocity, double skip, double tolerance, double large,
                     const std::function<void()>& close_joints) {
    // After a sweep that was taken whole: half of what a visit finds of friction at its limit is less, and would seem to stick.
    const bool is_due = sweeps_ >= plain_sweeps && sweeps_ % newton_period == (stalls_ ? 1 : 0);
    ++sweeps_;
    if (is_due) {
        solve_stalled(velocity, skip, close_joints);
    }
    if (sweeps_ > plain_sweeps) {
        extrapolate(velocity);
    }
    if (close_joints) {
        close_joints();
    }
    const BatchSweep like{.points = points.data(),
                          .rows = bodies_->rows.data(),
                          .velocity = velocity.front().v.data(),
                          .skip = skip,
                          .tolerance = tolerance,
                          .softness = softness_,
                          .by_half = stalls_ && sweeps_ % 2 == 0};
    std::atomic<double> worst = 0.0;
    share_colours([&](std::size_t first, std::size_t last) {
        raise_to(worst, sweep_like(like, batches.data() + first, last - first));
    });
    change_before_ = std::exchange(change_, worst);
    if (sweeps_ > plain_sweeps && change_ > large) {
        visit_again(like, large);
    }
    least_change_ = std::min(least_change_, change_);
    if (sweeps_ % plain_sweeps == 0) {
        stalls_ = least_change_ > 0.5 * progress_;
        progress_ = std::exchange(least_change_, std::numeric_limits<double>::infinity());
        if (may_give_way && (stalls_ || gives_way()) && std::ranges::any_of(batches, [](const BlockBatch& b) { return b.led != 0; })) {
            softness_ = std::max(2.0 * softness_, least_softness);
        }
    }
    return change_;
}

} // namespace sim
