#include "sim/solve/contact_solver.h"

#include <algorithm>

namespace sim {

std::vector<Velocity> ContactSolver::velocity_at_node(const Bodies& bodies) const {
    std::vector<Velocity> velocity = bodies.velocity;
    joints_.add_weighted(joint_weight_, velocity);
    if (in_lanes_) {
        add_node_impulses(bodies, velocity);
        return velocity;
    }
    for (const ContactBlock& block : loop_.blocks) {
        Vec6 wrench = Vec6::Zero();
        for (int k = block.first; k < block.first + block.count; ++k) {
            const ContactPoint& point = loop_.points[static_cast<std::size_t>(k)];
            const RestingContact& contact = contacts_[static_cast<std::size_t>(k)];
            if (!contact.is_ahead && point.p_n > 0.0) {
                wrench += block.node_weight * contact.force_share * wrench_of_point(point);
            }
        }
        apply_wrench(block, wrench, bodies.props, bodies.inverse_inertia, velocity);
    }
    return velocity;
}

/// Which part of each impulse is a force. An impact held ahead acts as a whole within the interval, and so do the answers
/// of the contacts that its bodies have: of those the instants before and after have no part.
void ContactSolver::tell_forces(const Bodies& bodies) {
    is_hit_.assign(bodies.props.size(), 0);
    for (const ContactBlock& block : loop_.blocks) {
        for (int k = block.first; k < block.first + block.count; ++k) {
            if (contacts_[static_cast<std::size_t>(k)].would_close && loop_.points[static_cast<std::size_t>(k)].p_n > 0.0) {
                is_hit_[static_cast<std::size_t>(block.a)] = is_hit_[static_cast<std::size_t>(block.b)] = 1;
            }
        }
    }
    const double gravity = settings_.gravity.norm();
    for (const ContactBlock& block : loop_.blocks) {
        const auto a = static_cast<std::size_t>(block.a);
        const auto b = static_cast<std::size_t>(block.b);
        const bool is_hit = (is_hit_[a] != 0 && !bodies.props[a].is_static()) ||
                            (is_hit_[b] != 0 && !bodies.props[b].is_static());
        const double weight = gravity * impulse_interval(block.node_weight, h_) /
                              std::max(bodies.props[a].inverse_mass, bodies.props[b].inverse_mass); // [N s]
        for (int k = block.first; k < block.first + block.count; ++k) {
            RestingContact& contact = contacts_[static_cast<std::size_t>(k)];
            const double p_n = loop_.points[static_cast<std::size_t>(k)].p_n;
            const double force = std::max(contact.load, weight);
            const bool may_answer = is_hit || contact.load > 0.0 || contact.restarts;
            contact.force_share = may_answer && p_n > largest_growth * force ? force / p_n : 1.0;
        }
    }
}

void ContactSolver::remember(const Bodies& bodies, std::vector<PairContacts>& pairs,
                             std::span<JointMemory> joint_memory) {
    for (PairContacts& pair : pairs) {
        for (std::size_t i = 0; !all_in_solve_ && i < pair.memory.size(); ++i) {
            ContactMemory& memory = pair.memory[i];
            memory = {.id = memory.id, .core_a = memory.core_a, .slip = memory.slip};
        }
    }
    joints_.remember(joint_memory);
    for (std::size_t i = 0; i < joint_memory.size(); ++i) {
        joint_memory[i].owed = 0.5 * h_ / impulse_interval(joint_weight_[i], h_);
        joint_memory[i].last_interval = h_;
    }
    if (in_lanes_) {
        remember_lanes(bodies);
        return;
    }
    tell_forces(bodies);
    loop_.share(loop_.blocks.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            remember_block(loop_.blocks[k], pairs);
        }
    });
}

void ContactSolver::remember_block(const ContactBlock& block, std::vector<PairContacts>& pairs) const {
    const Vec6 twist = relative_twist(block, velocity_);
    const auto in_world = [&](const Vec2& x) {
        return Vec3(x.x() * block.frame.col(0) + x.y() * block.frame.col(1));
    };
    bool at_limit = false;
    bool slips = false;
    for (int k = block.first; k < block.first + block.count; ++k) {
        const ContactPoint& point = loop_.points[static_cast<std::size_t>(k)];
        at_limit = at_limit || is_at_limit(point, block.mu_d);
        slips = slips || (point.p_n > 0.0 && h_ * (tangential_velocity(point, twist) - point.u_t_target).norm() >
                                                 iteration_share * settings_.tolerance);
    }
    // Where mu_s = mu_d the mark is of no concern to the solve, and lost here (eq. 6).
    const bool keeps_mark = block.is_sticking && !(block.mu_d == block.mu_s && at_limit && slips);
    for (int k = block.first; k < block.first + block.count; ++k) {
        const ContactPoint& point = loop_.points[static_cast<std::size_t>(k)];
        const RestingContact& contact = contacts_[static_cast<std::size_t>(k)];
        ContactMemory& memory =
            pairs[static_cast<std::size_t>(contact.pair)].memory[static_cast<std::size_t>(contact.index)];
        const bool loaded = point.p_n > 0.0;
        memory.interval = impulse_interval(block.node_weight, h_);
        memory.force_share = contact.force_share;
        memory.last_interval = loaded && !contact.is_ahead ? h_ : 0.0;
        memory.approach_speed = 0.0;
        memory.energy_taken = 0.0;
        const double gap = contact.gap_target - h_ * (point.u_n_target - normal_velocity(point, twist));
        if (contact.would_close && gap <= settings_.tolerance) {
            // An impact: no force that the next step could start from, but a speed and the work to give
            // back.
            memory.approach_speed = contact.approach_speed;
            memory.energy_taken =
                -0.5 * point.p_n * (contact.u_n_before + normal_velocity(point, twist)) -
                0.5 * point.p_t.dot(tangential_before(block, point) + tangential_velocity(point, twist));
        }
        memory.p_n = contact.is_ahead ? 0.0 : point.p_n;
        memory.p_t = contact.is_ahead ? Vec3(Vec3::Zero()) : in_world(point.p_t);
        const bool sticks = loaded && block.has_friction() && (keeps_mark || !at_limit);
        memory.mark = sticks ? 1.0 : 0.0;
        if (!block.has_friction()) {
            continue;
        }
        const Vec3 d_t = in_world(h_ * (tangential_velocity(point, twist) - point.u_t_target) - contact.owed);
        memory.slip = sticks ? Vec3(memory.slip + d_t) : Vec3(Vec3::Zero());
        memory.sliding = sticks ? Vec3(Vec3::Zero()) : Vec3(d_t / h_);
    }
}

double ContactSolver::joint_rate(const Bodies& bodies) {
    std::vector<double> interval;
    for (const double weight : joint_weight_) {
        interval.push_back(impulse_interval(weight, h_));
    }
    return joints_.fastest_rate(bodies, interval);
}

} // namespace sim
