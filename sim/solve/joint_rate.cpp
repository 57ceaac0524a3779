/// How fast joints vibrate under their load.
#include "sim/base/random.h"
#include "sim/solve/joint.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

/// Of the motion that fastest_rates() begins with; any that is not across the fastest one will do.
constexpr std::uint64_t mode_seed = 1;

} // namespace

std::vector<double> JointSolver::fastest_rates(const Bodies& bodies, std::span<const double> interval) {
    const std::size_t count = bodies.props.size();
    const bool is_first = mode_.size() != count;
    next_.resize(count);
    if (is_first) {
        mode_.resize(count);
        Random random(mode_seed);
        for (std::size_t i = 0; i < count; ++i) {
            const Velocity motion{random.direction(), random.direction()};
            mode_[i] = assembly_of_[i] < 0 ? Velocity{} : motion;
        }
    }
    std::vector<double> rates;
    for (Assembly& of : assemblies_) {
        double& rate = rates.emplace_back();
        if (is_first) { // of a random motion it is about half of the fastest
            close(of, mode_);
        }
        for (int round = 0; round < (is_first ? most_rounds : 1); ++round) {
            rate = improve_mode(of, bodies, interval);
        }
    }
    return rates;
}

/// One step of the power iteration. Returns the rate of the mode before it.
double JointSolver::improve_mode(Assembly& of, const Bodies& bodies, std::span<const double> interval) {
    const std::span<Row> rows = rows_of(of);
    // K of a point at the arm r of a body, where the force F acts: turned by x it does the work
    // ((F . r) |x|^2 - (F . x) (r . x)) / 2 less than F does along its path.
    for (const int body : of.bodies) {
        next_[static_cast<std::size_t>(body)] = {};
    }
    double work = 0.0;
    const auto add = [&](int body, const Vec3& arm, const Vec3& force) {
        const auto i = static_cast<std::size_t>(body);
        if (bodies.props[i].is_static()) {
            return;
        }
        const Vec3& turn = mode_[i].w;
        const Vec3 torque = force.dot(arm) * turn - 0.5 * (force * arm.dot(turn) + arm * force.dot(turn));
        work += torque.dot(turn);
        next_[i].w += bodies.inverse_inertia[i] * torque;
    };
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Row& row = rows[i];
        if (row.index == 0) {
            const double s = 1.0 / interval[static_cast<std::size_t>(row.joint)];
            Vec3 force(s * row.sum, s * rows[i + 1].sum, s * rows[i + 2].sum); // their axes are x, y, z
            if (rows[i + 2].kind != RowKind::point) { // a slider's, which are two across it
                force = s * (row.sum * row.axis + rows[i + 1].sum * rows[i + 1].axis);
            }
            add(row.a, row.r_a, force);
            add(row.b, row.r_b, -force);
        }
    }
    double inertia = 0.0; // twice the kinetic energy of the mode
    for (const int body : of.bodies) {
        const auto i = static_cast<std::size_t>(body);
        inertia += mode_[i].v.squaredNorm() / bodies.props[i].inverse_mass +
                   mode_[i].w.dot(angular_momentum(bodies.props[i], bodies.pose[i].orientation, mode_[i].w));
    }
    if (!(inertia > 0.0) || work == 0.0) {
        return 0.0;
    }
    close(of, next_);
    double largest = 0.0;
    for (const int body : of.bodies) {
        const Velocity& motion = next_[static_cast<std::size_t>(body)];
        largest = std::max({largest, motion.v.cwiseAbs().maxCoeff(), motion.w.cwiseAbs().maxCoeff()});
    }
    if (largest > 0.0) {
        for (const int body : of.bodies) {
            const Velocity& motion = next_[static_cast<std::size_t>(body)];
            mode_[static_cast<std::size_t>(body)] = {motion.v / largest, motion.w / largest};
        }
    }
    return std::sqrt(std::abs(work) / inertia);
}

} // namespace sim
