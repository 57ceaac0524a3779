#pragma once
/// Bodies, poses and numbers that the tests of sim/ share.
#include "sim/block/blocks.h"
#include "sim/model/integrate.h"

#include <cstdint>

/// The same numbers on every platform (splitmix64; Steele, Lea, Flood 2014).
class Numbers {
public:
    explicit Numbers(std::uint64_t seed) : state_(seed) {}

    double between(double low, double high) {
        return low + (high - low) * static_cast<double>(next() >> 11) * 0x1p-53;
    }
    sim::Vec3 vector(double size) {
        const double x = between(-size, size);
        const double y = between(-size, size);
        return {x, y, between(-size, size)};
    }
    sim::Vec3 direction() {
        for (;;) {
            const sim::Vec3 v = vector(1.0);
            if (v.norm() > 0.1 && v.norm() < 1.0) {
                return v.normalized();
            }
        }
    }
    sim::Quat orientation() {
        const sim::Vec3 axis = direction();
        return sim::turned(sim::Quat::Identity(), axis * between(0.0, 3.0));
    }
    sim::Pose pose(double size) {
        const sim::Vec3 position = vector(size);
        return {position, orientation()};
    }

private:
    std::uint64_t next() {
        std::uint64_t z = state_ += 0x9E3779B97F4A7C15ull;
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
        return z ^ (z >> 31);
    }
    std::uint64_t state_;
};

/// density [kg/m^3]; 0: static.
inline sim::BodyProps make_props(const sim::Shape& shape, double density, double e = 0.0, double mu = 0.0) {
    sim::BodyDef def;
    def.shape = shape;
    if (density > 0.0) {
        def.mass = sim::mass_properties(shape, density);
    }
    def.material = {e, mu, mu};
    return sim::make_body_props(def);
}

/// Adds a body; returns its index.
inline int add_body(sim::Bodies& bodies, const sim::BodyProps& props, const sim::Pose& pose,
                    const sim::Velocity& velocity = {}) {
    bodies.props.push_back(props);
    bodies.pose.push_back(pose);
    bodies.velocity.push_back(velocity);
    bodies.inverse_inertia.push_back(sim::inverse_inertia_world(props, pose.orientation));
    return static_cast<int>(bodies.props.size()) - 1;
}

inline double kinetic_energy(const sim::Bodies& bodies, const std::vector<sim::Velocity>& velocity) {
    double energy = 0.0;
    for (std::size_t i = 0; i < velocity.size(); ++i) {
        if (!bodies.props[i].is_static()) {
            energy += 0.5 * (velocity[i].v.squaredNorm() / bodies.props[i].inverse_mass +
                             velocity[i].w.dot(sim::angular_momentum(
                                 bodies.props[i], bodies.pose[i].orientation, velocity[i].w)));
        }
    }
    return energy;
}
