#include "sim/solve/half_kicks.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

/// Calls work(pair, a, b) for those that owe something, and their bodies.
template <typename Pairs, typename Work>
void for_each_owing(Pairs&& pairs, Work&& work) {
    for (auto& pair : pairs) {
        if (!pair.owed_impulse.isZero(0.0)) {
            work(pair, static_cast<std::size_t>(pair.manifold.body_a), static_cast<std::size_t>(pair.manifold.body_b));
        }
    }
}

/// Of the owed impulse, on the pair's body a, about the centre of body i [N m s].
Vec3 owed_moment_about(const PairContacts& pair, const Bodies& bodies, std::size_t i) {
    return pair.owed_moment - bodies.pose[i].position.cross(pair.owed_impulse);
}

/// Its work at these velocities of body i [J], if it acted on that.
double owed_work(const PairContacts& pair, const Bodies& bodies, std::size_t i, const Velocity& velocity) {
    return pair.owed_impulse.dot(velocity.v) + owed_moment_about(pair, bodies, i).dot(velocity.w);
}

/// Half kicks of bodies that loads connect.
struct Kicks {
    double work = 0.0;   ///< [J] at the velocities before, of those before collisions seen from kinematic bodies
    double change = 0.0; ///< [J] kinetic energy of what they change
    double room = 0.0;   ///< [J] that they may give: what those of springs and motors do; of what is told, all impulses of the instant

    /// Those of body i, which have made this of its velocity.
    void add(const Bodies& bodies, std::size_t i, const Velocity& with) {
        const BodyProps& props = bodies.props[i];
        const Quat& orientation = bodies.pose[i].orientation;
        const Velocity& before = bodies.velocity[i];
        const Velocity gained{with.v - before.v, with.w - before.w};
        work += before.v.dot(gained.v) / props.inverse_mass + before.w.dot(angular_momentum(props, orientation, gained.w));
        change += kinetic_energy(props, orientation, gained);
    }

    /// So much of them [-] as gives no more: of the share s that is s * work + s^2 * change.
    double share() const {
        const double most = std::max(room, 0.0);
        return work + change > most ? (std::sqrt(work * work + 4.0 * change * most) - work) / (2.0 * change) : 1.0;
    }
};

} // namespace

void apply_half_kicks(const Bodies& bodies, std::span<const int> connected, std::span<PairContacts> pairs, JointSolver& rows,
                      std::span<Velocity> velocity) {
    std::vector<Kicks> kicks(bodies.props.size()); // of connected bodies, by the first of them
    const auto kicks_of = [&](std::size_t body) -> Kicks& { return kicks[static_cast<std::size_t>(connected[body])]; };
    const auto of_pair = [&](std::size_t a, std::size_t b) -> Kicks& { return kicks_of(bodies.props[a].is_static() ? b : a); };
    for_each_owing(pairs, [&](const PairContacts& pair, std::size_t a, std::size_t b) {
        for (const auto& [i, sign] : {std::pair(a, 1.0), std::pair(b, -1.0)}) {
            velocity[i].v += sign * bodies.props[i].inverse_mass * pair.owed_impulse;
            velocity[i].w += sign * bodies.inverse_inertia[i] * owed_moment_about(pair, bodies, i);
            if (bodies.props[i].is_kinematic) {
                of_pair(a, b).work += sign * owed_work(pair, bodies, i, bodies.velocity[i]);
            }
        }
    });
    if (!rows.empty()) {
        rows.add_owed(velocity);
    }
    for (const int assembly : rows.assemblies()) {
        const double given = rows.half_kick_work(assembly, bodies.velocity, velocity);
        kicks_of(static_cast<std::size_t>(rows.bodies_of(assembly).front())).room += given;
    }
    for (std::size_t i = 0; i < velocity.size(); ++i) {
        if (!bodies.props[i].is_static()) {
            kicks_of(i).add(bodies, i, velocity[i]);
        }
    }
    for (std::size_t i = 0; i < velocity.size(); ++i) {
        if (const double share = kicks_of(i).share(); share < 1.0) {
            velocity[i] = between(bodies.velocity[i], velocity[i], share);
        }
    }
    for_each_owing(pairs, [&](PairContacts& pair, std::size_t a, std::size_t b) {
        pair.owed_impulse *= of_pair(a, b).share();
        pair.owed_moment *= of_pair(a, b).share();
    });
}

bool cut_half_kicks(const Bodies& bodies, std::span<const std::size_t> own, std::span<const int> held,
                    std::span<const Velocity> after, std::span<Velocity> at_node) {
    std::vector<Kicks> kicks(at_node.size()); // of bodies held together, by the first of them
    const auto kicks_of = [&](std::size_t body) -> Kicks& { return kicks[static_cast<std::size_t>(held[body])]; };
    for (const std::size_t i : own) {
        const auto energy = [&](const Velocity& of) { return kinetic_energy(bodies.props[i], bodies.pose[i].orientation, of); };
        kicks_of(i).add(bodies, i, at_node[i]);
        kicks_of(i).room += energy(after[i]) - energy(bodies.velocity[i]);
    }
    bool is_cut = false;
    for (const std::size_t i : own) {
        if (const double share = kicks_of(i).share(); share < 1.0) {
            at_node[i] = between(bodies.velocity[i], at_node[i], share);
            is_cut = true;
        }
    }
    return is_cut;
}

double half_kick_work(const Bodies& bodies, std::span<const PairContacts> pairs, std::span<const char> only,
                      std::span<const Velocity> kinematic) {
    double sum = 0.0;
    for_each_owing(pairs, [&](const PairContacts& pair, std::size_t a, std::size_t b) {
        if (only[a] != 0 || only[b] != 0) {
            sum += owed_work(pair, bodies, b, kinematic[b]) - owed_work(pair, bodies, a, kinematic[a]);
        }
    });
    return sum;
}

} // namespace sim
