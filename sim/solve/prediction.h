#pragma once
/// The bodies of a solve: their velocities after its impulses, and where these take them (eq. 7).
#include "sim/block/blocks.h"

namespace sim {

/// Arrays of [body_count], kept between steps.
struct Prediction {
    std::vector<Velocity> velocity;  ///< at t0 after the impulses
    std::vector<Pose> pose;          ///< at t0 + h
    std::vector<BodyRows> rows;      ///< the same of the solved bodies, for the kernels
    std::vector<std::size_t> solved; ///< bodies in contacts or joints, and kinematic ones; the others move freely
    std::vector<char> is_solved;     ///< is it one of them?
    std::vector<char> is_reached;    ///< by an impact, or by contacts that pass it on: once impulses are stored
    Vec3 gravity = Vec3::Zero();     ///< [m/s^2]
    double h = 0.0;                  ///< [s]

    /// Only kinematic bodies are solved yet; velocities are those of `bodies`, theirs such that they end where their keys
    /// have them.
    void begin(const Bodies& bodies, const Vec3& gravity_of_scene, double interval);
    /// Returns whether it was not yet.
    bool add(int body);
    /// Once they are added: puts them in ascending order, and moves all that no impulse moves.
    void move_others(const Bodies& bodies, Workers* workers);
    /// Where solved bodies, whose velocities have changed, move now.
    void update(const Bodies& bodies, std::span<const std::size_t> changed, Workers* workers);
};

} // namespace sim
