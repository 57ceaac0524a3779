#include "sim/model/interpolate.h"

#include "sim/model/integrate.h"

#include <algorithm>

namespace sim {

namespace {

BodySnapshot between(const BodySnapshot& a, const BodySnapshot& b, double span, double share) {
    const double s = share, s2 = s * s, s3 = s2 * s;
    const double weight = 3 * s2 - 2 * s3; // of b
    BodySnapshot body;
    body.position = a.position * (1.0 - weight) + b.position * weight +
                    (a.velocity * (s3 - 2 * s2 + s) + b.velocity * (s3 - s2)) * span;
    body.velocity = (b.position - a.position) * ((6 * s - 6 * s2) / span) + a.velocity * (3 * s2 - 4 * s + 1) +
                    b.velocity * (3 * s2 - 2 * s);
    // Angular velocity taken to change evenly: both turns then agree, to second order in the time.
    const Vec3 change = b.angular_velocity - a.angular_velocity;
    const double rest = 1.0 - s;
    const Quat on = turned(a.orientation, (a.angular_velocity * s + change * (0.5 * s2)) * span);
    const Quat back = turned(b.orientation, (change * (0.5 * rest * rest) - b.angular_velocity * rest) * span);
    body.orientation = on.slerp(weight, back);
    body.angular_velocity = a.angular_velocity + change * s;
    return body;
}

/// Mean accelerations from one record to the next: of the centre [m/s^2] and of the turning [rad/s^2].
struct Acceleration {
    Vec3 linear;
    Vec3 angular;
};

Acceleration acceleration(const Snapshot& from, const Snapshot& to, std::size_t body) {
    const double span = to.time - from.time;
    return {(to.bodies[body].velocity - from.bodies[body].velocity) / span,
            (to.bodies[body].angular_velocity - from.bodies[body].angular_velocity) / span};
}

} // namespace

Snapshot interpolated(const SceneDef& scene, const Snapshot& a, const Snapshot& b, double share) {
    Snapshot state;
    const double span = b.time - a.time;
    state.step = a.step;
    state.time = a.time + share * span;
    state.contact_count = a.contact_count;
    state.contacts = a.contacts;
    state.impacts = b.impacts;
    state.bodies.reserve(a.bodies.size());
    for (std::size_t i = 0; i < a.bodies.size(); ++i) {
        const double release = scene.bodies[i].release;
        if (release <= a.time) {
            state.bodies.push_back(between(a.bodies[i], b.bodies[i], span, share));
        } else if (state.time <= release) {
            state.bodies.push_back(a.bodies[i]);
        } else {
            const double flight = b.time - release;
            state.bodies.push_back(between(a.bodies[i], b.bodies[i], flight, (state.time - release) / flight));
        }
    }
    return state;
}

std::vector<double> interpolation_errors(const RecordWindow& window, const std::vector<double>& radii) {
    const double span = window.b->time - window.a->time;
    std::vector<double> errors;
    for (std::size_t i = 0; i < radii.size(); ++i) {
        const Acceleration here = acceleration(*window.a, *window.b, i);
        const auto jump_from = [&](const Snapshot* from, const Snapshot* to) {
            if (from == nullptr || to == nullptr) {
                return here.linear.norm() + radii[i] * here.angular.norm();
            }
            const Acceleration there = acceleration(*from, *to, i);
            return (here.linear - there.linear).norm() + radii[i] * (here.angular - there.angular).norm();
        };
        const double jump = std::min(jump_from(window.before, window.a), jump_from(window.b, window.after));
        errors.push_back(jump * span * span / 8.0);
    }
    return errors;
}

} // namespace sim
