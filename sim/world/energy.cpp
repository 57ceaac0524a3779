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

/// Of the dynamic bodies.
EnergyWatch::Energy EnergyWatch::energy_of(const Bodies& bodies, std::span<const Velocity> velocity) const {
    Energy energy;
    for (std::size_t i = 0; i < bodies.props.size(); ++i) {
        const BodyProps& props = bodies.props[i];
        if (!props.is_static()) {
            energy.kinetic += kinetic_energy(props, bodies.pose[i].orientation, velocity[i]);
            energy.potential -= gravity_.dot(bodies.pose[i].position) / props.inverse_mass;
        }
    }
    return energy;
}

/// Of an instant whose impulses are planned [J], without what was done on the bodies.
double EnergyWatch::total(const Bodies& bodies, std::span<const Velocity> velocity) {
    const auto [kinetic, potential] = energy_of(bodies, velocity);
    largest_kinetic_ = std::max(largest_kinetic_, kinetic);
    return kinetic + potential - (work_ - ahead_);
}

bool EnergyWatch::allows(double work, const Bodies& bodies, std::span<const Velocity> velocity, double in_springs) const {
    if (work <= gain_share * slack_) {
        return true;
    }
    const auto [kinetic, potential] = energy_of(bodies, velocity);
    const double gained = std::max(kinetic + potential + in_springs - work_ - lowest_, 0.0);
    return gained + work <= slack_ + gain_share * energy_gain_allowed * (largest_kinetic_ + first_ - lowest_);
}

double EnergyWatch::gain(const Bodies& bodies, std::span<const Velocity> velocity, double in_springs) {
    const double now = total(bodies, velocity) + in_springs;
    lowest_ = std::min(lowest_, now);
    const double gained = now - lowest_ - slack_;
    return gained > 0.0 ? gained / (largest_kinetic_ + first_ - lowest_ + slack_) : 0.0;
}

} // namespace sim
