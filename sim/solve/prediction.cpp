#include "sim/solve/prediction.h"

#include "sim/model/integrate.h"

#include <utility>

namespace sim {

void Prediction::begin(const Bodies& bodies, const Vec3& gravity_of_scene, double interval) {
    gravity = gravity_of_scene;
    h = interval;
    velocity = bodies.velocity;
    const std::size_t count = bodies.props.size();
    pose.resize(count);
    rows.resize(count);
    solved.clear();
    is_solved.assign(count, 0);
    is_reached.assign(count, 0);
    for (const KinematicBody& body : bodies.kinematic) {
        velocity[body.index] = body.motion.mean_velocity(bodies.time, interval);
        add(static_cast<int>(body.index));
    }
}

bool Prediction::add(int body) {
    const auto i = static_cast<std::size_t>(body);
    const bool is_new = std::exchange(is_solved[i], 1) == 0;
    if (is_new) {
        solved.push_back(i);
    }
    return is_new;
}

void Prediction::move_others(const Bodies& bodies, Workers* workers) {
    solved.clear();
    std::vector<std::size_t> fixed;
    for (std::size_t i = 0; i < is_solved.size(); ++i) {
        if (is_solved[i] != 0) {
            solved.push_back(i);
            if (bodies.props[i].is_static()) {
                fixed.push_back(i);
            }
        }
    }
    update(bodies, fixed, workers);
    const auto move = [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            if (is_solved[i] == 0) {
                pose[i] = free_motion(bodies.props[i], bodies.pose[i], velocity[i], gravity, h);
            }
        }
    };
    share(workers, bodies.props.size(), move, least_shared);
}

void Prediction::update(const Bodies& bodies, std::span<const std::size_t> changed, Workers* workers) {
    const auto move = [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            const std::size_t i = changed[k];
            pose[i] = free_motion(bodies.props[i], bodies.pose[i], velocity[i], gravity, h);
            Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> turn(rows[i].x);
            Eigen::Map<Vec3> position(rows[i].x + turn.size());
            turn = (pose[i].orientation * bodies.pose[i].orientation.conjugate()).toRotationMatrix();
            position = pose[i].position;
        }
    };
    share(workers, changed.size(), move, least_shared);
}

} // namespace sim
