#include "sim/solve/joint.h"

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <utility>

namespace sim {
namespace {

/// Share [-] of each diagonal added to it in the joint matrix, so that redundant rows (a closed loop of hinges) can be
/// factored, whatever the masses. The outer iterations take out what it leaves, a share of the same size each.
constexpr double regularisation = 1e-11;

/// A spring is too stiff for the step where this share [-] of the square of its phase in it is near 1: below, what its force
/// is late by, which brakes it, is of fifth order. A light base that a floor holds counts as free.
constexpr double stiff_share = 0.25;

} // namespace

/// Of an assembly: the sparse factor of J M^-1 J^T and the vectors of a solve.
struct JointSolver::Factor {
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt;
    Eigen::SparseMatrix<double> matrix; ///< its lower triangle: what is not always 0, column by column
    Eigen::VectorXd right_side;
    Eigen::VectorXd impulse;
};

JointSolver::JointSolver() = default;
JointSolver::~JointSolver() = default;
JointSolver::JointSolver(JointSolver&&) noexcept = default;
JointSolver& JointSolver::operator=(JointSolver&&) noexcept = default;

void JointSolver::prepare(const Bodies& bodies, std::span<const Joint> joints) {
    if (joints.empty()) {
        return;
    }
    if (assemblies_.empty()) {
        find_assemblies(bodies, joints);
    }
    const std::vector<Row> before = std::exchange(rows_, {});
    const auto couples_alike = [](const Row& x, const Row& y) {
        return x.axis == y.axis && x.arm_a == y.arm_a && x.arm_b == y.arm_b && x.turn_a == y.turn_a && x.turn_b == y.turn_b &&
               x.softness == y.softness && x.is_out == y.is_out;
    };
    for (Assembly& of : assemblies_) {
        of.first = rows_.size();
        for (const int i : of.joints) {
            add_rows(bodies, joints[static_cast<std::size_t>(i)], i, of);
        }
        of.count = rows_.size() - of.first;
        of.is_factored = of.is_factored &&
                         std::ranges::equal(rows_of(of), std::span(before).subspan(of.first, of.count), couples_alike);
    }
    begin_solve(joints);
    for (Assembly& of : assemblies_) {
        if (of.has_springs) {
            find_responses(of);
        }
    }
}

/// Of springs, with what the joints leave of bodies: how fast one swings is not told by bodies that others hold. Springs take no part in
/// the factor then. Of all of them as a scene begins, then of one in each interval, the oldest: they change as bodies turn.
void JointSolver::find_responses(Assembly& of) {
    take_out_drives(of, true);
    if (!of.is_factored) {
        factorise(of);
    }
    Factor& f = *of.factor;
    const std::span<Row> rows = rows_of(of);
    const auto find = [&](Row& spring) {
        for (std::size_t i = 0; i < rows.size(); ++i) {
            f.right_side[static_cast<Eigen::Index>(i)] = rows[i].is_out ? 0.0 : coupling(rows[i], spring).value_or(0.0);
        }
        spring.response = std::max(*coupling(spring, spring) - f.right_side.dot(f.ldlt.solve(f.right_side)), 0.0);
        spring.age = 0;
    };
    Row* oldest = nullptr;
    for (Row& row : rows) {
        if (row.kind == RowKind::spring && row.response < 0.0) {
            find(row);
        } else if (row.kind == RowKind::spring && (oldest == nullptr || row.age > oldest->age)) {
            oldest = &row;
        }
    }
    if (oldest != nullptr) {
        find(*oldest);
    }
}

/// In the order of their first joints.
void JointSolver::find_assemblies(const Bodies& bodies, std::span<const Joint> joints) {
    const auto moves = [&](int body) { return !bodies.props[static_cast<std::size_t>(body)].is_static(); };
    std::vector<int> first = sets_of_one(bodies.props.size());
    for (const Joint& joint : joints) {
        if (moves(joint.a) && moves(joint.b)) {
            unite(first, joint.a, joint.b);
        }
    }
    find_firsts(first);
    assembly_of_.assign(bodies.props.size(), -1);
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const int body = moves(joints[i].a) ? joints[i].a : joints[i].b;
        int& assembly = assembly_of_[static_cast<std::size_t>(first[static_cast<std::size_t>(body)])];
        if (assembly < 0) {
            assembly = static_cast<int>(assemblies_.size());
            all_.push_back(assembly);
            assemblies_.emplace_back();
        }
        at(assembly).joints.push_back(static_cast<int>(i));
        if (moves(joints[i].a) && moves(joints[i].b)) {
            at(assembly).pairs.push_back({joints[i].a, joints[i].b});
        }
    }
    for (std::size_t i = 0; i < first.size(); ++i) {
        assembly_of_[i] = assembly_of_[static_cast<std::size_t>(first[i])];
        if (assembly_of_[i] >= 0) {
            at(assembly_of_[i]).bodies.push_back(static_cast<int>(i));
        }
    }
}

void JointSolver::unite_bodies(std::vector<int>& sets) const {
    for (const Assembly& of : assemblies_) {
        for (const int body : of.bodies) {
            unite(sets, of.bodies.front(), body);
        }
    }
}

void JointSolver::add_equations(int assembly, double heaviest, std::span<const int> place, BodyFactors& to) const {
    for (const Row& row : rows_of(at(assembly))) {
        if (row.is_out) {
            continue;
        }
        const double share = compliance / (heaviest * std::max(row.inverse_mass_a, row.inverse_mass_b));
        const double per = 1.0 / (share * *coupling(row, row) + row.softness);
        Vec6 of_a;
        Vec6 of_b;
        of_a << row.axis, row.arm_a;
        of_b << -row.axis, -row.arm_b;
        const int a = row.inverse_mass_a > 0.0 ? place[static_cast<std::size_t>(row.a)] : -1;
        const int b = row.inverse_mass_b > 0.0 ? place[static_cast<std::size_t>(row.b)] : -1;
        if (a >= 0) {
            to.add(a, per * of_a * of_a.transpose());
        }
        if (b >= 0) {
            to.add(b, per * of_b * of_b.transpose());
        }
        if (a >= 0 && b >= 0) {
            to.add(a, b, per * of_a * of_b.transpose());
        }
    }
}

void JointSolver::keep(std::span<const int> of) {
    for (const int i : of) {
        for (Row& row : rows_of(at(i))) {
            row.kept_sum = row.sum;
            row.was_out = row.is_out;
        }
    }
}

void JointSolver::take_kept(std::span<const int> of) {
    for (const int i : of) {
        for (Row& row : rows_of(at(i))) {
            row.sum = row.kept_sum;
            const bool is_out = std::exchange(row.is_out, row.was_out);
            at(i).is_factored = at(i).is_factored && is_out == row.is_out;
        }
    }
}

void JointSolver::begin_solve(std::span<const Joint> joints) {
    for (Assembly& of : assemblies_) {
        take_out_drives(of, false);
        for (Row& row : rows_of(of)) {
            of.is_factored = of.is_factored && row.softness == 0.0;
            row.target = row.sum = row.half = row.late = row.softness = 0.0;
            row.most = std::numeric_limits<double>::infinity();
            const JointMemory& memory = joints[static_cast<std::size_t>(row.joint)].memory;
            row.before = row.kind == RowKind::spring ? memory.spring_owed : row.kind == RowKind::motor ? memory.motor_owed : 0.0;
        }
    }
}

void JointSolver::add_rows(const Bodies& bodies, const Joint& joint, int index, Assembly& of) {
    const auto a = static_cast<std::size_t>(joint.a);
    const auto b = static_cast<std::size_t>(joint.b);
    const Pose& pose_a = bodies.pose[a];
    const Pose& pose_b = bodies.pose[b];
    const Vec3 r_a = pose_a.orientation * joint.anchor_a;
    // What a slider draws out belongs to the arm.
    const Vec3 d = pose_a * joint.anchor_a - pose_b * joint.anchor_b;
    const Vec3 held_b = pose_b.orientation * joint.anchor_b;
    const Vec3 r_b = joint.kind == JointKind::slider ? Vec3(held_b + d) : held_b;
    const std::size_t first = rows_.size();
    const auto add = [&](RowKind kind, const Vec3& axis, const Vec3& arm_a, const Vec3& arm_b, double gap) -> Row& {
        return rows_.emplace_back(Row{.kind = kind,
                                      .joint = index,
                                      .index = static_cast<int>(rows_.size() - first),
                                      .a = joint.a,
                                      .b = joint.b,
                                      .inverse_mass_a = bodies.props[a].inverse_mass,
                                      .inverse_mass_b = bodies.props[b].inverse_mass,
                                      .axis = axis,
                                      .r_a = r_a,
                                      .r_b = r_b,
                                      .arm_a = arm_a,
                                      .arm_b = arm_b,
                                      .turn_a = bodies.inverse_inertia[a] * arm_a,
                                      .turn_b = bodies.inverse_inertia[b] * arm_b,
                                      .gap = gap});
    };
    const JointAxes axes = joint_axes(joint, pose_a, pose_b);
    for (int k = 0; k < axes.point_count; ++k) {
        const Vec3& axis = axes.points[static_cast<std::size_t>(k)];
        add(RowKind::point, axis, r_a.cross(axis), r_b.cross(axis), axis.dot(d));
    }
    for (int k = 0; k < axes.angle_count; ++k) {
        const Vec3& of_a = axes.angles_a[static_cast<std::size_t>(k)];
        const Vec3& of_b = axes.angles_b[static_cast<std::size_t>(k)];
        const Vec3 arm = of_a.cross(of_b);
        add(RowKind::angle, Vec3::Zero(), arm, arm, of_a.dot(of_b));
    }
    for (const RowKind kind : {RowKind::motor, RowKind::spring}) {
        if (!(kind == RowKind::motor ? joint.motor.has_value() : joint.spring.has_value())) {
            continue;
        }
        const bool is_slider = joint.kind == JointKind::slider;
        const Vec3 axis = is_slider ? pose_b.orientation * joint.axis_b : pose_a.orientation * joint.axis_a;
        Row& row = is_slider ? add(kind, axis, r_a.cross(axis), r_b.cross(axis), 0.0) : add(kind, Vec3::Zero(), axis, axis, 0.0);
        row.gap = drive_position(joint, pose_a, pose_b, joint.memory.position);
        row.response = joint.memory.response;
        row.age = joint.memory.age;
        of.has_motors = of.has_motors || kind == RowKind::motor;
        of.has_springs = of.has_springs || kind == RowKind::spring;
    }
}

/// Of J M^-1 J^T; nullopt where the rows share no body that moves.
std::optional<double> JointSolver::coupling(const Row& x, const Row& y) {
    std::optional<double> k;
    const auto add_body = [&](int body_x, double inverse_mass, const Vec3& arm_x, double sign_x, int body_y, const Vec3& turn_y,
                              double sign_y) {
        if (body_x == body_y && inverse_mass > 0.0) {
            k = k.value_or(0.0) + sign_x * sign_y * (inverse_mass * x.axis.dot(y.axis) + arm_x.dot(turn_y));
        }
    };
    add_body(x.a, x.inverse_mass_a, x.arm_a, 1.0, y.a, y.turn_a, 1.0);
    add_body(x.a, x.inverse_mass_a, x.arm_a, 1.0, y.b, y.turn_b, -1.0);
    add_body(x.b, x.inverse_mass_b, x.arm_b, -1.0, y.a, y.turn_a, 1.0);
    add_body(x.b, x.inverse_mass_b, x.arm_b, -1.0, y.b, y.turn_b, -1.0);
    return k;
}

/// J M^-1 J^T. Which rows couple is found once: a scene's joints stay what they are.
void JointSolver::factorise(Assembly& of) {
    of.is_factored = true;
    const bool is_first = !of.factor;
    if (is_first) {
        of.factor = std::make_unique<Factor>();
    }
    Factor& f = *of.factor;
    const auto count = static_cast<int>(of.count);
    const auto row = [&](Eigen::Index i) -> const Row& { return rows_[of.first + static_cast<std::size_t>(i)]; };
    if (is_first) {
        std::vector<Eigen::Triplet<double>> entries;
        for (int i = 0; i < count; ++i) {
            for (int j = 0; j <= i; ++j) {
                if (coupling(row(i), row(j))) {
                    entries.emplace_back(i, j);
                }
            }
        }
        f.matrix.resize(count, count);
        f.matrix.setFromTriplets(entries.begin(), entries.end());
        f.ldlt.analyzePattern(f.matrix);
        f.right_side.resize(count);
    }
    for (int j = 0; j < count; ++j) {
        for (Eigen::SparseMatrix<double>::InnerIterator entry(f.matrix, j); entry; ++entry) {
            const Row& x = row(entry.row());
            double k = x.is_out || row(j).is_out ? 0.0 : *coupling(x, row(j));
            if (entry.row() == j) {
                k = x.is_out ? 1.0 : (1.0 + regularisation) * k + x.softness;
            }
            entry.valueRef() = k;
        }
    }
    f.ldlt.factorize(f.matrix);
    CHECK(f.ldlt.info() == Eigen::Success);
}

double JointSolver::row_velocity(const Row& row, std::span<const Velocity> velocity) const {
    const Velocity& a = velocity[static_cast<std::size_t>(row.a)];
    const Velocity& b = velocity[static_cast<std::size_t>(row.b)];
    return row.axis.dot(a.v - b.v) + row.arm_a.dot(a.w) - row.arm_b.dot(b.w);
}

/// What the row's velocity lacks; a soft row does without what its impulse makes up for.
double JointSolver::missing_of(const Row& row, std::span<const Velocity> velocity) const {
    return row.target - row.softness * row.sum - row_velocity(row, velocity);
}

void JointSolver::take_out_drives(Assembly& of, bool is_out) {
    for (Row& row : rows_of(of)) {
        const bool was_out = std::exchange(row.is_out, row.is_drive() && is_out);
        of.is_factored = of.is_factored && row.is_out == was_out;
    }
}

void JointSolver::target_rest() {
    for (Row& row : rows_) {
        row.target = 0.0;
    }
    for (Assembly& of : assemblies_) {
        take_out_drives(of, true);
    }
}

JointSolver::Opening JointSolver::widest(std::span<const int> of) const {
    Opening found;
    for (const int i : of) {
        if (const Opening& widest = assemblies_[static_cast<std::size_t>(i)].widest; widest.gap >= found.gap) {
            found = widest;
        }
    }
    return found;
}

bool JointSolver::has_drives(std::span<const int> of) const {
    return std::ranges::any_of(of, [&](int i) {
        const Assembly& assembly = assemblies_[static_cast<std::size_t>(i)];
        return assembly.has_motors || assembly.has_springs;
    });
}

double JointSolver::target_closed(std::span<const int> of, std::span<const Joint> joints, const Prediction& to, double share) {
    double largest = 0.0, square = 0.0, square_gap = 0.0;
    JointAxes axes;
    Vec3 d; // of the joint's anchors
    for (const int assembly : of) {
        Opening& widest = at(assembly).widest = {};
        for (Row& row : rows_of(at(assembly))) {
            const Joint& joint = joints[static_cast<std::size_t>(row.joint)];
            const Pose& a = to.pose[static_cast<std::size_t>(row.a)];
            const Pose& b = to.pose[static_cast<std::size_t>(row.b)];
            const double u = row_velocity(row, to.velocity);
            if (row.index == 0) {
                axes = joint_axes(joint, a, b);
                d = a * joint.anchor_a - b * joint.anchor_b;
            }
            if (row.is_drive()) {
                at(assembly).is_factored &= target_drive(joint, row, drive_position(joint, a, b, row.gap), u, to.h);
                continue;
            }
            const bool is_point = row.kind == RowKind::point;
            const auto k = static_cast<std::size_t>(is_point ? row.index : row.index - axes.point_count);
            const double gap = is_point ? axes.points[k].dot(d) : axes.angles_a[k].dot(axes.angles_b[k]);
            const double error = gap - (1.0 - share) * row.gap;
            row.target = u - error / to.h;
            // The distance of anchors counts, not its components.
            const bool goes_on = is_point && row.index > 0;
            square = error * error + (goes_on ? square : 0.0);
            square_gap = gap * gap + (goes_on ? square_gap : 0.0);
            largest = std::max(largest, std::sqrt(square));
            if (const double distance = std::sqrt(square_gap); distance >= widest.gap) {
                widest = {row.joint, distance};
            }
        }
    }
    return largest;
}

/// position: the joint's at t0 + h, reached with row_velocity u. With x linear in u, half the impulse of an interval is
/// a = -k ((1 - s) x(t0) + (1 + s) x - 2 rest) h/4 - c (x - x(t0)) / 2 = -(stretch + soft u), s = late. The row's impulse,
/// before + (1 + s) a, is p where u + p / ((1 + s) soft) is the target. Returns whether its softness is what it was.
bool JointSolver::target_drive(const Joint& joint, Row& row, double position, double row_velocity, double h) {
    if (row.kind == RowKind::motor) {
        row.target = row_velocity + joint.motor->speed - (position - row.gap) / h;
        row.most = joint.motor->limit * 0.5 * (joint.memory.last_interval + h);
        return true;
    }
    const auto& [stiffness, damping, rest] = *joint.spring;
    const double slow = damping * h * row.response;
    const double phase_square = stiff_share * (stiffness * h * h * row.response + slow * slow);
    row.late = phase_square * phase_square / (1.0 + phase_square * phase_square);
    const double end = 1.0 + row.late;
    const double still = position - h * row_velocity; // reached with u = 0
    const double soft = 0.25 * end * stiffness * h * h + 0.5 * damping * h;
    const double stretch =
        0.25 * stiffness * h * ((1.0 - row.late) * row.gap + end * still - 2.0 * rest) + 0.5 * damping * (still - row.gap);
    const double softness = 1.0 / (end * soft);
    row.target = softness * (row.before - end * stretch);
    return std::exchange(row.softness, softness) == softness;
}

/// A motor never gives more than its limit; at it the others are solved anew. Those that give more come to their limits, those at
/// them that are to give less take part again: all at once while they become fewer, and once where they do not; then only the last,
/// until they do (block principal pivoting, Kostreva 1978), or two take turns for ever. Returns false if one changed.
bool JointSolver::keep_limits(Assembly& of, std::span<Velocity> velocity, Pivots& pivots) {
    std::vector<Row*> wrong;
    for (Row& row : rows_of(of)) {
        if (row.kind == RowKind::motor &&
            (row.is_out ? missing_of(row, velocity) * row.sum < 0.0 : std::abs(row.sum) > row.most)) {
            wrong.push_back(&row);
        }
    }
    const bool are_fewer = wrong.size() < pivots.fewest;
    const bool are_all = are_fewer || pivots.may_try || ++pivots.rounds == of.count;
    pivots.may_try = are_fewer;
    pivots.fewest = std::min(pivots.fewest, wrong.size());
    for (Row* const row : std::span(wrong).subspan(are_all ? 0 : wrong.size() - 1)) {
        row->is_out = !row->is_out;
        of.is_factored = false;
        if (row->is_out) {
            const double limited = std::clamp(row->sum, -row->most, row->most);
            apply(*row, limited - row->sum, velocity);
            row->sum = limited;
        }
    }
    return wrong.empty();
}

double JointSolver::solve(std::span<const int> of, std::span<Velocity> velocity) {
    double change = 0.0;
    for (const int i : of) {
        change = std::max(change, solve(at(i), velocity));
    }
    return change;
}

double JointSolver::solve(Assembly& of, std::span<Velocity> velocity) {
    const std::span<Row> rows = rows_of(of);
    double change = 0.0;
    for (Pivots pivots; pivots.rounds < rows.size();) {
        if (!of.is_factored) {
            factorise(of);
        }
        Factor& f = *of.factor;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const double missing = rows[i].is_out ? 0.0 : missing_of(rows[i], velocity);
            f.right_side[static_cast<Eigen::Index>(i)] = missing;
            change = std::max(change, std::abs(rows[i].softness > 0.0 ? rows[i].share() * missing : missing));
        }
        const Eigen::VectorXd impulse = f.ldlt.solve(f.right_side);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const double p = impulse[static_cast<Eigen::Index>(i)];
            rows[i].sum += p;
            apply(rows[i], p, velocity);
        }
        if (!of.has_motors || keep_limits(of, velocity, pivots)) {
            break;
        }
    }
    return change;
}

void JointSolver::apply(const Row& row, double p, std::span<Velocity> velocity) {
    const auto push = [&](int body, double inverse_mass, const Vec3& turn, double impulse) {
        if (inverse_mass > 0.0) { // what does not move is of other assemblies, too
            Velocity& of_body = velocity[static_cast<std::size_t>(body)];
            of_body.v += (impulse * inverse_mass) * row.axis;
            of_body.w += impulse * turn;
        }
    };
    push(row.a, row.inverse_mass_a, row.turn_a, p);
    push(row.b, row.inverse_mass_b, row.turn_b, -p);
}

/// Takes away what opens the joints, at no cost to the sums of this solve; springs and motors take no part any more. Returns
/// the impulses that it takes [rows].
const Eigen::VectorXd& JointSolver::close(Assembly& of, std::span<Velocity> velocity) {
    take_out_drives(of, true);
    if (!of.is_factored) {
        factorise(of);
    }
    Factor& f = *of.factor;
    const std::span<Row> rows = rows_of(of);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        f.right_side[static_cast<Eigen::Index>(i)] = rows[i].is_out ? 0.0 : -row_velocity(rows[i], velocity);
    }
    f.impulse = f.ldlt.solve(f.right_side);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        apply(rows[i], f.impulse[static_cast<Eigen::Index>(i)], velocity);
    }
    return f.impulse;
}

} // namespace sim
