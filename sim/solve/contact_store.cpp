#include "sim/solve/contact_solver.h"

#include <algorithm>

namespace sim {

std::span<const Velocity> ContactSolver::find_velocity_at_node(const Bodies& bodies) {
    at_node_ = bodies.velocity;
    joints_.add_weighted(joint_weight_, at_node_);
    loop_.share_colours([&](std::size_t first, std::size_t last) {
        work_on_batches(RestPhase::half_kick, first, last, at_node_);
    });
    return at_node_;
}

/// Which bodies speculative impacts hit. Such an impact acts as a whole within the interval, and so do the answers of the
/// contacts that its bodies have: the instants before and after have no part of them.
void ContactSolver::find_hit_bodies(const Bodies& bodies) {
    is_hit_.assign(bodies.props.size(), 0);
    for (const BlockBatch& batch : loop_.batches) {
        for (int k = batch.first; k < batch.first + batch.count; ++k) {
            const unsigned closing = rest_points_[static_cast<std::size_t>(k)].closing;
            for (std::size_t lane = 0; closing >> lane != 0; ++lane) {
                if ((closing >> lane & 1u) != 0 && loop_.points[static_cast<std::size_t>(k)].p_n.x[lane] > 0.0) {
                    is_hit_[static_cast<std::size_t>(batch.a[lane])] = is_hit_[static_cast<std::size_t>(batch.b[lane])] = 1;
                }
            }
        }
    }
    for (std::size_t i = 0; i < loop_.batches.size(); ++i) {
        const BlockBatch& batch = loop_.batches[i];
        unsigned hit = 0;
        for (unsigned lane = 0; lane < lane_count; ++lane) {
            const unsigned of_a = is_hit_[static_cast<std::size_t>(batch.a[lane])] != 0 ? batch.moves_a : 0u;
            const unsigned of_b = is_hit_[static_cast<std::size_t>(batch.b[lane])] != 0 ? batch.moves_b : 0u;
            hit |= (of_a | of_b) & (1u << lane);
        }
        rest_blocks_[i].hit = hit;
    }
}

void ContactSolver::store_impulses(const Bodies& bodies, std::vector<PairContacts>& pairs,
                             std::span<JointMemory> joint_memory) {
    has_doubtful_memory_ = !converged_;
    for (PairContacts& pair : pairs) {
        for (std::size_t i = 0; !all_in_solve_ && i < pair.memory.size(); ++i) {
            ContactMemory& memory = pair.memory[i];
            memory = {.id = memory.id, .core_a = memory.core_a, .slip = memory.slip};
        }
    }
    joints_.store_impulses(joint_memory);
    for (std::size_t i = 0; i < joint_memory.size(); ++i) {
        joint_memory[i].owed = 0.5 * h_ / impulse_interval(joint_weight_[i], h_);
        joint_memory[i].last_interval = h_;
    }
    find_hit_bodies(bodies);
    loop_.share(loop_.batches.size(), [&](std::size_t first, std::size_t last) {
        work_on_batches(RestPhase::store, first, last, velocity_);
    });
}

double ContactSolver::joint_rate(const Bodies& bodies) {
    std::vector<double> interval;
    for (const double weight : joint_weight_) {
        interval.push_back(impulse_interval(weight, h_));
    }
    return joints_.fastest_rate(bodies, interval);
}

} // namespace sim
