#include "sim/solve/half_kicks.h"

#include "sim/base/disjoint_sets.h"

#include <algorithm>
#include <numeric>

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
    double work = 0.0;   ///< [J] at the velocities before, seen from kinematic bodies
    double change = 0.0; ///< [J] kinetic energy of what they change

    /// So much of them [-] as gives no energy: of the share s that is s * work + s^2 * change.
    double share() const { return work + change > 0.0 ? std::max(-work / change, 0.0) : 1.0; }
};

} // namespace

std::vector<int> connected_by_loads(const Bodies& bodies, std::span<const PairContacts> pairs) {
    std::vector<int> first(bodies.props.size());
    std::iota(first.begin(), first.end(), 0);
    for_each_owing(pairs, [&](const PairContacts&, std::size_t a, std::size_t b) {
        if (!bodies.props[a].is_static() && !bodies.props[b].is_static()) {
            unite(first, static_cast<int>(a), static_cast<int>(b));
        }
    });
    for (int& of : first) {
        of = first[static_cast<std::size_t>(of)]; // that one, earlier, is right
    }
    return first;
}

void apply_half_kicks(const Bodies& bodies, std::span<const int> connected, std::span<PairContacts> pairs,
                      std::span<Velocity> velocity) {
    std::vector<Velocity> change(bodies.props.size());
    std::vector<Kicks> kicks(bodies.props.size()); // of connected bodies, by the first of them
    const auto kicks_of = [&](std::size_t body) -> Kicks& { return kicks[static_cast<std::size_t>(connected[body])]; };
    const auto of_pair = [&](std::size_t a, std::size_t b) -> Kicks& { return kicks_of(bodies.props[a].is_static() ? b : a); };
    for_each_owing(pairs, [&](const PairContacts& pair, std::size_t a, std::size_t b) {
        for (const auto& [i, sign] : {std::pair(a, 1.0), std::pair(b, -1.0)}) {
            change[i].v += sign * bodies.props[i].inverse_mass * pair.owed_impulse;
            change[i].w += sign * bodies.inverse_inertia[i] * owed_moment_about(pair, bodies, i);
            of_pair(a, b).work += sign * owed_work(pair, bodies, i, bodies.velocity[i]);
        }
    });
    for (std::size_t i = 0; i < change.size(); ++i) {
        if (!bodies.props[i].is_static()) {
            kicks_of(i).change += kinetic_energy(bodies.props[i], bodies.pose[i].orientation, change[i]);
        }
    }
    for (std::size_t i = 0; i < change.size(); ++i) {
        velocity[i].v += kicks_of(i).share() * change[i].v;
        velocity[i].w += kicks_of(i).share() * change[i].w;
    }
    for_each_owing(pairs, [&](PairContacts& pair, std::size_t a, std::size_t b) {
        pair.owed_impulse *= of_pair(a, b).share();
        pair.owed_moment *= of_pair(a, b).share();
    });
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
