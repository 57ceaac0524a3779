#include "sim/world/energy.h"

#include <algorithm>

namespace sim {
namespace {

/// [J] that a body gains where it is pushed out of an overlap within the tolerance.
double slack_of(const BodyProps& props, const StepSettings& settings) {
    return props.is_static() ? 0.0 : settings.gravity.norm() * settings.tolerance / props.inverse_mass;
}

} // namespace

void EnergyWatch::start(const Bodies& bodies, std::span<const Velocity> velocity, const StepSettings& settings,
                        double in_springs) {
    gravity_ = settings.gravity;
    slack_ = largest_kinetic_ = 0.0;
    for (const BodyProps& props : bodies.props) {
        slack_ += slack_of(props, settings);
    }
    first_ = lowest_ = total(bodies, velocity) + in_springs;
}

void EnergyWatch::admit(const Bodies& bodies, std::size_t body, const StepSettings& settings) {
    const BodyProps& props = bodies.props[body];
    const Pose& pose = bodies.pose[body];
    slack_ += slack_of(props, settings);
    work_ += kinetic_energy(props, pose.orientation, bodies.velocity[body]) - gravity_.dot(pose.position) / props.inverse_mass;
}

/// Kinetic and potential energy of the dynamic bodies [J], the latter from the world's origin, without what was done on them.
double EnergyWatch::total(const Bodies& bodies, std::span<const Velocity> velocity) {
    double kinetic = 0.0;
    double potential = 0.0;
    for (std::size_t i = 0; i < bodies.props.size(); ++i) {
        const BodyProps& props = bodies.props[i];
        if (!props.is_static()) {
            kinetic += kinetic_energy(props, bodies.pose[i].orientation, velocity[i]);
            potential -= gravity_.dot(bodies.pose[i].position) / props.inverse_mass;
        }
    }
    largest_kinetic_ = std::max(largest_kinetic_, kinetic);
    return kinetic + potential - (work_ - ahead_);
}

double EnergyWatch::gain(const Bodies& bodies, std::span<const Velocity> velocity, double in_springs) {
    const double now = total(bodies, velocity) + in_springs;
    lowest_ = std::min(lowest_, now);
    const double gained = now - lowest_ - slack_;
    return gained > 0.0 ? gained / (largest_kinetic_ + first_ - lowest_ + slack_) : 0.0;
}

} // namespace sim
