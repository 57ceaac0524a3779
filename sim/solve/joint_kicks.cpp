/// What of the impulses of joints acts at either end of an interval, the work that they do, and what the next interval takes on.
#include "sim/solve/joint.h"

namespace sim {

void JointSolver::add_owed(std::span<Velocity> velocity) {
    for (Row& row : rows_) {
        row.half = row.before;
    }
    half_kick(all_, velocity);
}

void JointSolver::add_before(std::span<const int> of, std::span<const double> weight, std::span<Velocity> velocity) {
    for (const int i : of) {
        for (Row& row : rows_of(at(i))) {
            row.half = row.kind == RowKind::spring ? row.before : weight[static_cast<std::size_t>(row.joint)] * row.sum;
        }
    }
    half_kick(of, velocity);
}

/// Gives the half kicks of springs and motors. Those of the other rows are what keeps the joints closed under all forces
/// (RATTLE, Andersen 1983), whatever is told of these.
void JointSolver::half_kick(std::span<const int> of, std::span<Velocity> velocity) {
    for (const int assembly : of) {
        const std::span<Row> rows = rows_of(at(assembly));
        for (const Row& row : rows) {
            if (row.is_drive()) {
                apply(row, row.half, velocity);
            }
        }
        const Eigen::VectorXd& closing = close(at(assembly), velocity);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            rows[i].half = rows[i].is_drive() ? rows[i].half : closing[static_cast<Eigen::Index>(i)];
        }
    }
}

void JointSolver::close_again(std::span<Velocity> velocity) {
    for (Assembly& of : assemblies_) {
        close(of, velocity);
    }
}

double JointSolver::half_kick_work(int assembly, std::span<const Velocity> before, std::span<const Velocity> after) const {
    double sum = 0.0;
    for (const Row& row : rows_of(assemblies_[static_cast<std::size_t>(assembly)])) {
        sum += row.is_drive() ? 0.5 * row.half * (row_velocity(row, before) + row_velocity(row, after)) : 0.0;
    }
    return sum;
}

DriveWork JointSolver::work(std::span<const Velocity> kinematic, const Kick* kick) const {
    DriveWork sum;
    for (const Row& row : rows_) {
        double until = -row.half * row_velocity(row, kinematic);
        double ahead = -(row.sum - row.half) * row_velocity(row, kinematic);
        if (row.kind == RowKind::motor && kick != nullptr) {
            // An impulse does its work at the mean of the velocities before and after it.
            const double at_node = row_velocity(row, kick->at_node);
            until += 0.5 * row.half * (row_velocity(row, kick->before) + at_node);
            ahead += 0.5 * (row.sum - row.half) * (at_node + row_velocity(row, kick->after));
        }
        sum.all += until + ahead;
        sum.ahead += ahead;
    }
    return sum;
}

double JointSolver::half_kick_work(std::span<const Velocity> kinematic, const Kick& kick, std::span<const char> only) const {
    double sum = 0.0;
    for (const Row& row : rows_) {
        if (only[static_cast<std::size_t>(row.a)] == 0 && only[static_cast<std::size_t>(row.b)] == 0) {
            continue;
        }
        const bool is_motor = row.kind == RowKind::motor;
        const double mean = is_motor ? 0.5 * (row_velocity(row, kick.before) + row_velocity(row, kick.after)) : 0.0;
        sum += row.half * (mean - row_velocity(row, kinematic));
    }
    return sum;
}

void JointSolver::store(std::span<Joint> joints, std::span<const double> weight) const {
    for (const Row& row : rows_) {
        JointMemory& memory = joints[static_cast<std::size_t>(row.joint)].memory;
        if (row.kind == RowKind::spring) {
            memory.spring_owed = (row.sum - row.before) * (1.0 - row.late) / (1.0 + row.late);
            memory.response = row.response;
            memory.age = row.age + 1;
        } else if (row.kind == RowKind::motor) {
            memory.motor_owed = (1.0 - weight[static_cast<std::size_t>(row.joint)]) * row.sum;
        }
        memory.position = row.is_drive() ? row.gap : memory.position;
    }
}

} // namespace sim
