#include "sim/solve/joint.h"

#include "sim/base/error.h"
#include "sim/base/random.h"

#include <Eigen/SparseCholesky>

namespace sim {
namespace {

/// Share [-] of each diagonal added to it in the joint matrix, so that redundant rows (a closed loop of hinges) can be
/// factored, whatever the masses. The outer iterations take out what it leaves, a share of the same size each.
constexpr double regularisation = 1e-11;

/// Of the motion that fastest_rate() begins with; any that is not across the fastest one will do.
constexpr std::uint64_t mode_seed = 1;

Vec3 across(const Vec3& axis) {
    int least = 0;
    axis.cwiseAbs().minCoeff(&least);
    return axis.cross(Vec3::Unit(least)).normalized();
}

/// Calls set(gap) for each row in order: the gap vector a - b, and a hinge's two misalignments.
template <typename F>
void for_each_gap(std::span<const Joint> joints, std::span<const Pose> pose, F&& set) {
    for (const Joint& joint : joints) {
        const Pose& a = pose[static_cast<std::size_t>(joint.a)];
        const Pose& b = pose[static_cast<std::size_t>(joint.b)];
        const Vec3 d = a * joint.anchor_a - b * joint.anchor_b;
        for (int k = 0; k < 3; ++k) {
            set(d[k]);
        }
        if (joint.kind == JointKind::hinge) {
            const Vec3 axis = a.orientation * joint.axis_a;
            set(axis.dot(b.orientation * joint.across_b_1));
            set(axis.dot(b.orientation * joint.across_b_2));
        }
    }
}

} // namespace

/// The sparse factor of J M^-1 J^T and the vectors of a solve.
struct JointSolver::Factor {
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt;
    Eigen::SparseMatrix<double> matrix;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right_side;
    bool has_pattern = false;
};

JointSolver::JointSolver() = default;
JointSolver::~JointSolver() = default;
JointSolver::JointSolver(JointSolver&&) noexcept = default;
JointSolver& JointSolver::operator=(JointSolver&&) noexcept = default;

Joint make_joint(const JointDef& def, std::span<const Pose> pose, int world_body) {
    Joint joint;
    joint.kind = def.kind;
    joint.a = def.body_a;
    joint.b = def.body_b < 0 ? world_body : def.body_b;
    const Pose& a = pose[static_cast<std::size_t>(joint.a)];
    const Pose& b = pose[static_cast<std::size_t>(joint.b)];
    joint.anchor_a = a.orientation.conjugate() * (def.anchor - a.position);
    joint.anchor_b = b.orientation.conjugate() * (def.anchor - b.position);
    joint.axis_a = a.orientation.conjugate() * def.axis;
    const Vec3 first = across(def.axis);
    joint.across_b_1 = b.orientation.conjugate() * first;
    joint.across_b_2 = b.orientation.conjugate() * def.axis.cross(first);
    return joint;
}

void JointSolver::prepare(const Bodies& bodies, std::span<const Joint> joints) {
    rows_.clear();
    if (joints.empty()) {
        return;
    }
    Vec3 r_a, r_b;
    const auto add = [&](const Joint& joint, const Vec3& axis, const Vec3& arm_a, const Vec3& arm_b) {
        const auto a = static_cast<std::size_t>(joint.a);
        const auto b = static_cast<std::size_t>(joint.b);
        rows_.push_back({joint.a, joint.b, bodies.props[a].inverse_mass, bodies.props[b].inverse_mass, axis, r_a, r_b,
                         arm_a, arm_b, bodies.inverse_inertia[a] * arm_a, bodies.inverse_inertia[b] * arm_b,
                         0.0, 0.0, 0, 0, 0.0});
    };
    for (const Joint& joint : joints) {
        const Pose& a = bodies.pose[static_cast<std::size_t>(joint.a)];
        const Pose& b = bodies.pose[static_cast<std::size_t>(joint.b)];
        r_a = a.orientation * joint.anchor_a;
        r_b = b.orientation * joint.anchor_b;
        for (int k = 0; k < 3; ++k) {
            const Vec3 axis = Vec3::Unit(k);
            add(joint, axis, r_a.cross(axis), r_b.cross(axis));
        }
        if (joint.kind == JointKind::hinge) {
            const Vec3 axis = a.orientation * joint.axis_a;
            for (const Vec3& across_b : {joint.across_b_1, joint.across_b_2}) {
                const Vec3 arm = axis.cross(b.orientation * across_b);
                add(joint, Vec3::Zero(), arm, arm);
            }
        }
    }
    std::size_t next = 0;
    for_each_gap(joints, bodies.pose, [&](double gap) { rows_[next++].gap = gap; });
    next = 0;
    for (int i = 0; i < static_cast<int>(joints.size()); ++i) {
        const int count = joints[static_cast<std::size_t>(i)].kind == JointKind::hinge ? 5 : 3;
        for (int k = 0; k < count; ++k) {
            rows_[next].joint = i;
            rows_[next++].index = k;
        }
    }
    is_factored_ = false;
}

/// J M^-1 J^T: rows couple where they share a body.
void JointSolver::factorise() {
    is_factored_ = true;
    if (!factor_) {
        factor_ = std::make_unique<Factor>();
    }
    Factor& f = *factor_;
    f.entries.clear();
    const auto count = static_cast<int>(rows_.size());
    for (int i = 0; i < count; ++i) {
        const Row& x = rows_[static_cast<std::size_t>(i)];
        for (int j = 0; j <= i; ++j) {
            const Row& y = rows_[static_cast<std::size_t>(j)];
            double k = 0.0;
            bool coupled = false;
            const auto add_body = [&](int body_x, double inverse_mass, const Vec3& arm_x, double sign_x,
                                      int body_y, const Vec3& turn_y, double sign_y) {
                if (body_x == body_y && inverse_mass > 0.0) {
                    k += sign_x * sign_y * (inverse_mass * x.axis.dot(y.axis) + arm_x.dot(turn_y));
                    coupled = true;
                }
            };
            add_body(x.a, x.inverse_mass_a, x.arm_a, 1.0, y.a, y.turn_a, 1.0);
            add_body(x.a, x.inverse_mass_a, x.arm_a, 1.0, y.b, y.turn_b, -1.0);
            add_body(x.b, x.inverse_mass_b, x.arm_b, -1.0, y.a, y.turn_a, 1.0);
            add_body(x.b, x.inverse_mass_b, x.arm_b, -1.0, y.b, y.turn_b, -1.0);
            if (coupled) {
                f.entries.emplace_back(i, j, i == j ? (1.0 + regularisation) * k : k);
            }
        }
    }
    f.matrix.resize(count, count);
    f.matrix.setFromTriplets(f.entries.begin(), f.entries.end());
    if (!f.has_pattern) {
        f.ldlt.analyzePattern(f.matrix);
        f.has_pattern = true;
    }
    f.ldlt.factorize(f.matrix);
    CHECK(f.ldlt.info() == Eigen::Success);
    f.right_side.resize(count);
}

double JointSolver::row_velocity(const Row& row, std::span<const Velocity> velocity) const {
    const Velocity& a = velocity[static_cast<std::size_t>(row.a)];
    const Velocity& b = velocity[static_cast<std::size_t>(row.b)];
    return row.axis.dot(a.v - b.v) + row.arm_a.dot(a.w) - row.arm_b.dot(b.w);
}

void JointSolver::target_rest() {
    for (Row& row : rows_) {
        row.target = 0.0;
    }
}

double JointSolver::target_closed(std::span<const Joint> joints, std::span<const Pose> predicted,
                                  std::span<const Velocity> velocity, double h, double share) {
    double largest = 0.0, square = 0.0;
    std::size_t next = 0;
    const auto set = [&](double gap) {
        Row& row = rows_[next++];
        const double error = gap - (1.0 - share) * row.gap;
        row.target = row_velocity(row, velocity) - error / h;
        const bool is_of_anchors = row.index < 3; // their distance counts, not its components
        square = error * error + (is_of_anchors && row.index > 0 ? square : 0.0);
        largest = std::max(largest, std::sqrt(square));
    };
    for_each_gap(joints, predicted, set);
    return largest;
}
double JointSolver::solve(std::span<Velocity> velocity) {
    if (rows_.empty()) {
        return 0.0;
    }
    if (!is_factored_) {
        factorise();
    }
    Factor& f = *factor_;
    double change = 0.0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const double missing = rows_[i].target - row_velocity(rows_[i], velocity);
        f.right_side[static_cast<Eigen::Index>(i)] = missing;
        change = std::max(change, std::abs(missing));
    }
    const Eigen::VectorXd impulse = f.ldlt.solve(f.right_side);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const double p = impulse[static_cast<Eigen::Index>(i)];
        rows_[i].sum += p;
        apply(rows_[i], p, velocity);
    }
    return change;
}

void JointSolver::apply(const Row& row, double p, std::span<Velocity> velocity) {
    Velocity& a = velocity[static_cast<std::size_t>(row.a)];
    Velocity& b = velocity[static_cast<std::size_t>(row.b)];
    a.v += (p * row.inverse_mass_a) * row.axis;
    a.w += p * row.turn_a;
    b.v -= (p * row.inverse_mass_b) * row.axis;
    b.w -= p * row.turn_b;
}

void JointSolver::apply_half_kick(std::span<const Joint> joints, std::span<const char> only,
                                  std::span<Velocity> velocity) const {
    for (const Row& row : rows_) {
        const JointMemory& joint = joints[static_cast<std::size_t>(row.joint)].memory;
        if (only.empty() || only[static_cast<std::size_t>(row.a)] != 0 ||
            only[static_cast<std::size_t>(row.b)] != 0) {
            apply(row, joint.owed * joint.impulse[static_cast<std::size_t>(row.index)], velocity);
        }
    }
}

void JointSolver::add_weighted(std::span<const double> weight, std::span<Velocity> velocity) const {
    for (const Row& row : rows_) {
        apply(row, weight[static_cast<std::size_t>(row.joint)] * row.sum, velocity);
    }
}

double JointSolver::work(std::span<const double> weight, std::span<const Velocity> velocity) const {
    double sum = 0.0;
    for (const Row& row : rows_) {
        const double share = weight.empty() ? 1.0 : weight[static_cast<std::size_t>(row.joint)];
        sum -= share * row.sum * row_velocity(row, velocity);
    }
    return sum;
}

void JointSolver::store_impulses(std::span<Joint> joints) const {
    for (const Row& row : rows_) {
        joints[static_cast<std::size_t>(row.joint)].memory.impulse[static_cast<std::size_t>(row.index)] = row.sum;
    }
}

/// Takes away what opens the joints, at no cost to the sums of this solve.
void JointSolver::close(std::span<Velocity> velocity) {
    if (!is_factored_) {
        factorise();
    }
    Factor& f = *factor_;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        f.right_side[static_cast<Eigen::Index>(i)] = -row_velocity(rows_[i], velocity);
    }
    const Eigen::VectorXd impulse = f.ldlt.solve(f.right_side);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        apply(rows_[i], impulse[static_cast<Eigen::Index>(i)], velocity);
    }
}

double JointSolver::fastest_rate(const Bodies& bodies, std::span<const double> interval) {
    if (rows_.empty()) {
        return 0.0;
    }
    const std::size_t count = bodies.props.size();
    if (mode_.size() != count) {
        mode_.resize(count);
        Random random(mode_seed);
        for (Velocity& motion : mode_) {
            motion = {random.direction(), random.direction()};
        }
        close(mode_);
    }
    // K of a point at the arm r of a body, where the force F acts: turned by x it does the work
    // ((F . r) |x|^2 - (F . x) (r . x)) / 2 less than F does along its path.
    std::vector<Velocity> next(count);
    double work = 0.0;
    const auto add = [&](int body, const Vec3& arm, const Vec3& force) {
        const auto i = static_cast<std::size_t>(body);
        if (bodies.props[i].is_static()) {
            return;
        }
        const Vec3& turn = mode_[i].w;
        const Vec3 torque = force.dot(arm) * turn - 0.5 * (force * arm.dot(turn) + arm * force.dot(turn));
        work += torque.dot(turn);
        next[i].w += bodies.inverse_inertia[i] * torque;
    };
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const Row& row = rows_[i];
        if (row.index == 0) {
            const double s = 1.0 / interval[static_cast<std::size_t>(row.joint)];
            const Vec3 force(s * row.sum, s * rows_[i + 1].sum, s * rows_[i + 2].sum); // their axes are x, y, z
            add(row.a, row.r_a, force);
            add(row.b, row.r_b, -force);
        }
    }
    double inertia = 0.0; // twice the kinetic energy of the mode
    for (std::size_t i = 0; i < count; ++i) {
        if (!bodies.props[i].is_static()) {
            inertia += mode_[i].v.squaredNorm() / bodies.props[i].inverse_mass +
                       mode_[i].w.dot(angular_momentum(bodies.props[i], bodies.pose[i].orientation, mode_[i].w));
        }
    }
    if (!(inertia > 0.0) || work == 0.0) {
        return 0.0;
    }
    close(next);
    double largest = 0.0;
    for (const Velocity& motion : next) {
        largest = std::max({largest, motion.v.cwiseAbs().maxCoeff(), motion.w.cwiseAbs().maxCoeff()});
    }
    if (largest > 0.0) {
        for (std::size_t i = 0; i < count; ++i) {
            mode_[i] = {next[i].v / largest, next[i].w / largest};
        }
    }
    return std::sqrt(std::abs(work) / inertia);
}

} // namespace sim
