#include "sim/block/newton.h"

#include "sim/block/blocks.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

/// Solutions with one factorisation [-]: at most so many, until `compliance` is left of what was missing at first, or one takes
/// less than this share of the square of what is missing: rigid bodies cannot do it, and would be loaded without bound.
constexpr std::size_t refinements = 8;
constexpr double least_gain = 0.03;

using Matrix6 = BodyFactors::Matrix6;

Mat3 inverse_inertia_of(const BodyRows& row) {
    Mat3 j;
    j << row.x[1], row.x[2], row.x[3], row.x[2], row.x[4], row.x[5], row.x[3], row.x[5], row.x[6];
    return j;
}

bool slides(const LanePoint& point, double mu) {
    return point.p_n > 0.0 && point.p_t.norm() >= (1.0 - same_share) * mu * point.p_n;
}

/// Coefficients of a body's velocity (v, w) in a velocity that has `twist` coefficients of the block's twist.
Vec6 of_body(const Vec6& twist, const Mat3& frame, const Vec3& r) {
    const Vec3 along = frame * twist.head<3>();
    Vec6 coefficients;
    coefficients << along, r.cross(along) + frame * twist.tail<3>();
    return coefficients;
}

} // namespace

double sliding_share(const Blocks& loop, const Island& island) {
    double load = 0.0;
    double sliding = 0.0;
    for (const int i : island.blocks) {
        const Block& block = loop.blocks[static_cast<std::size_t>(i)];
        const BlockBatch& batch = loop.batch_of(block);
        for (const BatchPoint& in_lanes : loop.points_of(batch)) {
            const LanePoint point(in_lanes, Blocks::lane_of(block));
            load += point.p_n;
            sliding += block.has_friction() && slides(point, batch.mu.x[Blocks::lane_of(block)]) ? point.p_n : 0.0;
        }
    }
    return load > 0.0 ? sliding / load : 0.0;
}

/// Velocities of the loaded points: their mean, and their slopes along the axes in which the points spread.
void IslandNewton::add_normal_rows(const Blocks& loop, Active& active, const Vec6& twist) {
    const Block& block = loop.blocks[static_cast<std::size_t>(active.block)];
    const BlockBatch& batch = loop.batches[static_cast<std::size_t>(block.lane) / lane_count];
    const std::size_t lane = Blocks::lane_of(block);
    active.centre.setZero();
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
    double mean = 0.0;
    for (const bool second : {false, true}) { // the centre first
        for (const BatchPoint& in_lanes : loop.points_of(batch)) {
            const LanePoint point(in_lanes, lane);
            if (!(point.p_n > 0.0)) {
                continue;
            }
            const Eigen::Vector2d arm(point.y, -point.x);
            if (!second) {
                active.count += 1.0;
                active.centre += arm;
                mean += in_lanes.u_n_target.x[lane] - point.normal_velocity(twist);
                continue;
            }
            const Eigen::Vector2d rho = arm - active.centre;
            spread += rho * rho.transpose();
            slope += rho * (in_lanes.u_n_target.x[lane] - point.normal_velocity(twist));
        }
        if (!second) {
            active.centre /= active.count;
        }
    }
    Row row;
    row.twist << 0.0, 0.0, 1.0, active.centre, 0.0;
    row.missing = mean / active.count;
    rows_.push_back(row);
    active.normal_rows = 1;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
    const double extent = active.count * active.centre.squaredNorm() + spread.trace();
    for (int k = 1; k >= 0; --k) { // the longer first
        if (axes.eigenvalues()[k] <= collinear * extent) {
            break;
        }
        const int place = active.normal_rows - 1;
        active.axes.col(place) = axes.eigenvectors().col(k);
        active.moments[place] = axes.eigenvalues()[k];
        row.twist << 0.0, 0.0, 0.0, active.axes.col(place), 0.0;
        row.missing = active.axes.col(place).dot(slope) / active.moments[place];
        rows_.push_back(row);
        ++active.normal_rows;
    }
}

/// Slip at the centre of the load, and turning about the normal; none if the block slides.
void IslandNewton::add_friction_rows(const Blocks& loop, Active& active, const Vec6& twist) {
    const Block& block = loop.blocks[static_cast<std::size_t>(active.block)];
    const BlockBatch& batch = loop.batches[static_cast<std::size_t>(block.lane) / lane_count];
    const std::size_t lane = Blocks::lane_of(block);
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    for (const BatchPoint& in_lanes : loop.points_of(batch)) {
        const LanePoint point(in_lanes, lane);
        if (slides(point, batch.mu.x[lane])) {
            return;
        }
        active.load += point.p_n;
        moment += point.p_n * Eigen::Vector2d(point.x, point.y);
    }
    active.pressure = moment / active.load;
    Eigen::Vector2d slip = Eigen::Vector2d::Zero();
    double turn = 0.0;
    for (const BatchPoint& in_lanes : loop.points_of(batch)) {
        const LanePoint point(in_lanes, lane);
        const Eigen::Vector2d rho = Eigen::Vector2d(point.x, point.y) - active.pressure;
        const Eigen::Vector2d missing =
            Eigen::Vector2d(in_lanes.u_t_target[0].x[lane], in_lanes.u_t_target[1].x[lane]) - point.tangential_velocity(twist);
        slip += point.p_n / active.load * missing;
        active.turning += point.p_n * rho.squaredNorm();
        turn += point.p_n * (rho.x() * missing.y() - rho.y() * missing.x());
    }
    Row row;
    row.twist << 1.0, 0.0, 0.0, 0.0, 0.0, -active.pressure.y();
    row.missing = slip.x();
    rows_.push_back(row);
    row.twist << 0.0, 1.0, 0.0, 0.0, 0.0, active.pressure.x();
    row.missing = slip.y();
    rows_.push_back(row);
    active.friction_rows = 2;
    if (active.turning > collinear * (active.load * active.pressure.squaredNorm() + active.turning)) {
        row.twist << 0.0, 0.0, 0.0, 0.0, 0.0, 1.0;
        row.missing = turn / active.turning;
        rows_.push_back(row);
        active.friction_rows = 3;
    }
}

void IslandNewton::add_block(const Blocks& loop, int index, double mass_share, std::span<const Velocity> velocity) {
    const Block& block = loop.blocks[static_cast<std::size_t>(index)];
    const BlockBatch& batch = loop.batches[static_cast<std::size_t>(block.lane) / lane_count];
    const std::size_t lane = Blocks::lane_of(block);
    double load = 0.0;
    for (const BatchPoint& point : loop.points_of(batch)) {
        load += point.p_n.x[lane];
    }
    if (!(load > 0.0)) {
        return;
    }
    const LaneFrame frame(batch, lane);
    const Vec6 twist = frame.relative_twist(velocity);
    Active active;
    active.block = index;
    active.first = rows_.size();
    add_normal_rows(loop, active, twist);
    if (block.has_friction()) {
        add_friction_rows(loop, active, twist);
    }
    Matrix6 response;
    for (int i = 0; i < 6; ++i) {
        for (int j = 0; j <= i; ++j) {
            response(i, j) = response(j, i) = batch.response[i * (i + 1) / 2 + j].x[lane];
        }
    }
    for (std::size_t k = active.first; k < rows_.size(); ++k) {
        Row& row = rows_[k];
        row.compliance = compliance * mass_share * row.twist.dot(response * row.twist);
        row.of_a = of_body(row.twist, frame.frame, frame.r_a);
        row.of_b = -of_body(row.twist, frame.frame, frame.r_b);
    }
    active_.push_back(active);
}

/// Which bodies have equations together, by loaded contacts or joints.
void IslandNewton::find_fill(const Blocks& loop, std::span<const int> place, const Island& island) {
    std::vector<std::array<int, 2>> pairs;
    const auto add = [&](int body_a, int body_b) {
        const std::array pair{place[static_cast<std::size_t>(body_a)], place[static_cast<std::size_t>(body_b)]};
        if (pair[0] >= 0 && pair[1] >= 0) {
            pairs.push_back(pair);
        }
    };
    for (const Active& active : active_) {
        const Block& block = loop.blocks[static_cast<std::size_t>(active.block)];
        add(block.a, block.b);
    }
    for (const int assembly : island.assemblies) {
        for (const auto [a, b] : loop.joints->pairs_of(assembly)) {
            add(a, b);
        }
    }
    factors_.begin(static_cast<int>(island.bodies.size()), pairs);
}

/// Mass matrix + sum of rows^T rows / compliance: the equations with the impulses eliminated. heaviest: of the island's bodies [kg].
/// Returns whether it has factors.
bool IslandNewton::factorise(const Blocks& loop, std::span<const BodyRows> rows, std::span<const int> place, const Island& island,
                             double heaviest) {
    for (const int body : island.bodies) {
        const BodyRows& row = rows[static_cast<std::size_t>(body)];
        Matrix6 mass = Matrix6::Zero();
        mass.topLeftCorner<3, 3>() = Mat3::Identity() / row.x[0];
        mass.bottomRightCorner<3, 3>() = inverse_inertia_of(row).inverse();
        factors_.add(place[static_cast<std::size_t>(body)], mass);
    }
    for (const int assembly : island.assemblies) {
        loop.joints->add_equations(assembly, heaviest, place, factors_);
    }
    for (const Active& active : active_) {
        const Block& block = loop.blocks[static_cast<std::size_t>(active.block)];
        const int a = place[static_cast<std::size_t>(block.a)];
        const int b = place[static_cast<std::size_t>(block.b)];
        Matrix6 of_a = Matrix6::Zero();
        Matrix6 of_b = Matrix6::Zero();
        Matrix6 between = Matrix6::Zero();
        const auto count = static_cast<std::size_t>(active.normal_rows + active.friction_rows);
        for (const Row& row : std::span(rows_).subspan(active.first, count)) {
            const double per = 1.0 / row.compliance;
            of_a += per * row.of_a * row.of_a.transpose();
            of_b += per * row.of_b * row.of_b.transpose();
            between += per * row.of_a * row.of_b.transpose();
        }
        if (a >= 0) {
            factors_.add(a, of_a);
        }
        if (b >= 0) {
            factors_.add(b, of_b);
        }
        if (a >= 0 && b >= 0) {
            factors_.add(a, b, between);
        }
    }
    return factors_.factorise();
}

/// With the present factors; missing: of the targets [rows].
IslandNewton::Direction IslandNewton::solution(const Blocks& loop, std::span<const int> place, const Island& island,
                                               const Eigen::VectorXd& missing) {
    Eigen::VectorXd load = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * island.bodies.size()));
    const auto for_each = [&](auto&& work) { // row, its index, places of its bodies
        for (const Active& active : active_) {
            const Block& block = loop.blocks[static_cast<std::size_t>(active.block)];
            const int a = place[static_cast<std::size_t>(block.a)];
            const int b = place[static_cast<std::size_t>(block.b)];
            const auto count = static_cast<std::size_t>(active.normal_rows + active.friction_rows);
            for (std::size_t k = active.first; k < active.first + count; ++k) {
                work(rows_[k], static_cast<Eigen::Index>(k), a, b);
            }
        }
    };
    for_each([&](const Row& row, Eigen::Index k, int a, int b) {
        if (a >= 0) {
            load.segment<6>(6 * a) += missing[k] / row.compliance * row.of_a;
        }
        if (b >= 0) {
            load.segment<6>(6 * b) += missing[k] / row.compliance * row.of_b;
        }
    });
    factors_.solve(load);
    const Eigen::VectorXd& change = load; // of the velocities
    const auto size = static_cast<Eigen::Index>(rows_.size());
    Direction found{Eigen::VectorXd(size), Eigen::VectorXd(size)};
    for_each([&](const Row& row, Eigen::Index k, int a, int b) {
        found.moved[k] = (a >= 0 ? row.of_a.dot(change.segment<6>(6 * a)) : 0.0) +
                         (b >= 0 ? row.of_b.dot(change.segment<6>(6 * b)) : 0.0);
        found.impulse[k] = (missing[k] - found.moved[k]) / row.compliance;
    });
    return found;
}

/// Square of what is missing [J], each weighted by its compliance.
double IslandNewton::missing_square() const {
    double sum = 0.0;
    for (const Row& row : rows_) {
        sum += row.missing * row.missing / row.compliance;
    }
    return sum;
}

/// Impulses that leave least missing, until its square is `enough` (generalised conjugate residuals: Eisenstat, Elman & Schultz
/// 1983, "Variational iterative methods for nonsymmetric systems of linear equations"). Where blocks ask for more than rigid
/// bodies can do, something is: a solution for it would be impulses that hold against each other, and move nothing, as large as the
/// compliance is small. So each is for what the bodies can do of it, which is what such a solution moves.
void IslandNewton::find_impulses(const Blocks& loop, std::span<const int> place, const Island& island, double enough) {
    const auto size = static_cast<Eigen::Index>(rows_.size());
    Eigen::VectorXd weight(size);
    Eigen::VectorXd missing(size);
    for (Eigen::Index k = 0; k < size; ++k) {
        weight[k] = 1.0 / rows_[static_cast<std::size_t>(k)].compliance;
        missing[k] = rows_[static_cast<std::size_t>(k)].missing;
    }
    const auto product = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& y) { return x.cwiseProduct(weight).dot(y); };
    std::vector<Direction> taken; // what they move is orthonormal
    while (taken.size() < refinements && product(missing, missing) > enough) {
        const Direction possible = solution(loop, place, island, missing);
        Direction next = solution(loop, place, island, possible.moved);
        for (const Direction& before : taken) {
            const double share = product(before.moved, next.moved);
            next.moved -= share * before.moved;
            next.impulse -= share * before.impulse;
        }
        const double length = std::sqrt(product(next.moved, next.moved));
        if (!(length > 0.0)) {
            return;
        }
        next.moved /= length;
        next.impulse /= length;
        const double step = product(next.moved, missing);
        if (step * step < least_gain * product(missing, missing)) {
            return;
        }
        missing -= step * next.moved;
        for (Eigen::Index k = 0; k < size; ++k) {
            rows_[static_cast<std::size_t>(k)].impulse += step * next.impulse[k];
        }
        taken.push_back(std::move(next));
    }
}

/// The impulses that a loaded point is to have: what is found goes to the points of a block linearly, friction in proportion to
/// the load that they had.
LanePoint IslandNewton::found_at(const Active& active, const LanePoint& at) const {
    const auto impulse = [&](int k) { return rows_[active.first + static_cast<std::size_t>(k)].impulse; };
    const int friction = active.normal_rows;
    const Eigen::Vector2d rho = Eigen::Vector2d(at.y, -at.x) - active.centre;
    LanePoint found = at;
    found.p_n += impulse(0) / active.count;
    for (int k = 1; k < active.normal_rows; ++k) {
        found.p_n += impulse(k) * active.axes.col(k - 1).dot(rho) / active.moments[k - 1];
    }
    if (active.friction_rows > 0) {
        found.p_t += at.p_n / active.load * Vec2(impulse(friction), impulse(friction + 1));
    }
    if (active.friction_rows > 2) {
        const Eigen::Vector2d arm = Eigen::Vector2d(at.x, at.y) - active.pressure;
        found.p_t += at.p_n / active.turning * impulse(friction + 2) * Vec2(-arm.y(), arm.x());
    }
    return found;
}

/// Gives the loaded points of a block the impulses found, and its bodies what that changes. Points that would pull (eq. 2, 3) leave
/// the set, and carry nothing; those whose friction would exceed its limit (eq. 6) bear that, and their block slides. Returns whether
/// there are any.
bool IslandNewton::take_found(Blocks& loop, const Active& active, std::span<const BodyRows> rows,
                              std::span<Velocity> velocity) const {
    const Block& block = loop.blocks[static_cast<std::size_t>(active.block)];
    BlockBatch& batch = loop.batch_of(block);
    const std::size_t lane = Blocks::lane_of(block);
    const double mu = batch.mu.x[lane];
    bool any = false;
    Vec6 wrench = Vec6::Zero();
    for (BatchPoint& point : loop.points_of(batch)) {
        const LanePoint at(point, lane);
        if (!(at.p_n > 0.0)) {
            continue;
        }
        LanePoint found = found_at(active, at);
        if (found.p_n < 0.0) {
            found.p_n = 0.0;
            found.p_t.setZero();
            any = true;
        } else if (active.friction_rows > 0 && found.p_t.norm() > mu * found.p_n) {
            found.p_t *= mu * found.p_n / found.p_t.norm();
            any = true;
        }
        point.p_n.x[lane] = found.p_n;
        point.p_t[0].x[lane] = found.p_t.x();
        point.p_t[1].x[lane] = found.p_t.y();
        found.p_n -= at.p_n;
        found.p_t -= at.p_t;
        wrench += found.wrench();
    }
    const LaneFrame frame(batch, lane);
    const Vec3 p = frame.frame * wrench.head<3>();
    const Vec3 l = frame.frame * wrench.tail<3>();
    const auto push = [&](int body, const Vec3& r, double sign) {
        const auto i = static_cast<std::size_t>(body);
        if (rows[i].x[0] == 0.0) {
            return; // of other solves, too
        }
        velocity[i].v += sign * rows[i].x[0] * p;
        velocity[i].w += sign * (inverse_inertia_of(rows[i]) * (r.cross(p) + l));
    };
    push(block.a, frame.r_a, 1.0);
    push(block.b, frame.r_b, -1.0);
    return any;
}

bool IslandNewton::step(Blocks& loop, Island& island, BlockBodies& bodies, std::span<Velocity> velocity, const NewtonLimits& limits) {
    const std::span<const BodyRows> rows = bodies.rows;
    std::vector<int>& place = bodies.place;
    const auto inverse_mass = [&](int body) { return rows[static_cast<std::size_t>(body)].x[0]; };
    const double least = inverse_mass(*std::ranges::min_element(island.bodies, {}, inverse_mass));
    for (std::size_t i = 0; i < island.bodies.size(); ++i) {
        place[static_cast<std::size_t>(island.bodies[i])] = static_cast<int>(i);
    }
    begin(loop, island, velocity);
    double begun = 0.0; // [J] what the first active set misses
    find_loaded(loop, island, place);
    enter_set(loop, island, place, velocity, limits.least);
    is_loaded_.assign(island.bodies.size(), 1);
    bool changes = true; // the active set
    island.cost = 0.0;
    for (int round = 0; changes && round < newton_rounds; ++round) {
        active_.clear();
        rows_.clear();
        for (const int i : island.blocks) {
            const Block& block = loop.blocks[static_cast<std::size_t>(i)];
            const double own = std::max(inverse_mass(block.a), inverse_mass(block.b));
            add_block(loop, i, least / own, velocity);
        }
        const double missing = missing_square();
        begun = round == 0 ? missing : begun;
        find_fill(loop, place, island);
        const double cost = island.cost + static_cast<double>(factors_.products());
        // Sets that miss so much more than the first one throw the bodies ever farther: hardly one that follows stays.
        if (compliance * missing > begun || cost > limits.cost || !factorise(loop, rows, place, island, 1.0 / least)) {
            break;
        }
        island.cost = cost;
        find_impulses(loop, place, island, compliance * compliance * begun);
        changes = false;
        for (const Active& active : active_) {
            changes = take_found(loop, active, rows, velocity) || changes;
        }
        if (!island.assemblies.empty()) {
            loop.joints->solve(island.assemblies, velocity);
        }
        changes = enter_set(loop, island, place, velocity, limits.least) || changes;
    }
    for (const int body : island.bodies) {
        place[static_cast<std::size_t>(body)] = -1;
    }
    const bool is_good = !changes && is_nearer(loop, island, velocity);
    if (!is_good) {
        take_back(loop, island, velocity);
    }
    return is_good;
}

} // namespace sim
