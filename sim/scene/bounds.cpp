#include "sim/scene/bounds.h"

#include "sim/model/film_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sim {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// Masses and moments of inertia lie between these [kg, kg m^2]: products of three of them, as in the inverse
/// of a tensor, neither vanish nor overflow.
constexpr double least_inertia = 1e-100;
constexpr double largest_inertia = 1e100;

/// Half the smallest edge, or the radius [m]; infinite for a plane and for shapes of other kinds.
double half_thickness(const Shape& shape) {
    double least = std::numeric_limits<double>::infinity();
    const auto take = [&](const auto& primitive) {
        if (const auto* box = std::get_if<Box>(&primitive)) {
            least = std::min(least, box->half_extents.minCoeff());
        } else if (const auto* sphere = std::get_if<Sphere>(&primitive)) {
            least = std::min(least, sphere->radius);
        }
    };
    if (const auto* compound = std::get_if<Compound>(&shape)) {
        for (const CompoundPart& part : compound->parts) {
            take(part.shape);
        }
    } else {
        take(shape);
    }
    return least;
}

/// Largest coordinate [m] of any point of a body at a pose; of its position if it has no end.
double reach_at(const BodyDef& body, const Pose& pose) {
    const double centre = pose.position.cwiseAbs().maxCoeff();
    const Bounds box = bounds(body.shape, pose);
    const bool has_end = !std::holds_alternative<Plane>(body.shape);
    return has_end ? std::max({centre, box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff()})
                   : centre;
}

/// At the start, or at any of its keys.
double reach_of(const BodyDef& body) {
    double reach = reach_at(body, body.pose);
    for (const CurveKey<4>& key : body.motion.keys) {
        reach = std::max(reach, reach_at(body, body.motion.pose_at(key.time)));
    }
    return reach;
}

/// Largest components of velocity and spin, of a kinematic body at its keys and in between.
Velocity fastest(const BodyDef& body) {
    Velocity most{body.velocity.cwiseAbs(), body.angular_velocity.cwiseAbs()};
    constexpr int samples = 8; // between two keys: the rate is a parabola there
    const std::vector<CurveKey<4>>& keys = body.motion.keys;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        for (int k = 0; k < samples; ++k) {
            const Velocity now = body.motion.velocity_at(keys[i].time + k * (keys[i + 1].time - keys[i].time) / samples);
            most = {most.v.cwiseMax(now.v.cwiseAbs()), most.w.cwiseMax(now.w.cwiseAbs())};
        }
    }
    return most;
}

/// The scene's settings and the bounds they imply for every body.
struct Limits {
    explicit Limits(const SceneDef& scene)
        : step(scene.step), h(scene.step.time_step.value()), duration(simulated_duration(scene.output)),
          steps(duration / h), reach(scene.step.tolerance / (eps * (2.0 + 0.5 * steps))),
          travel(scene.step.tolerance / (2.0 * eps)) {}

    const StepSettings& step;
    double h;        ///< [s]
    double duration; ///< [s]
    double steps;    ///< of the film
    /// [m] Each sum of a position and its change is rounded by up to eps / 2 of it, in each step the same way
    /// at worst, and a gap is the difference of two rounded positions.
    double reach;
    /// [m] The same at one instant: as far as a body may go from the origin.
    double travel;
};

std::optional<Excess> mass_excess(const BodyDef& body, int i) {
    if (body.is_static()) {
        return std::nullopt;
    }
    const double least = std::min(body.mass.mass, body.mass.inertia.diagonal().minCoeff());
    const double largest = std::max(body.mass.mass, body.mass.inertia.diagonal().maxCoeff());
    if (least >= least_inertia && largest <= largest_inertia) {
        return std::nullopt;
    }
    return Excess{
        i, "mass",
        fmt::format("body '{}' has mass {:.3g} kg and moments of inertia from {:.3g} kg m^2, expected "
                    "all within {:g}..{:g}, where products of three are numbers",
                    body.name, body.mass.mass, body.mass.inertia.diagonal().minCoeff(), least_inertia,
                    largest_inertia)};
}

std::optional<Excess> place_excess(const BodyDef& body, int i, const Limits& limits) {
    const double half = half_thickness(body.shape);
    if (!(half > limits.step.tolerance)) {
        return Excess{
            i, "shape",
            fmt::format("body '{}' has a half thickness of {:.3g} m, expected more than the tolerance, "
                        "{:g} m: which way leads out of an overlap would be open",
                        body.name, half, limits.step.tolerance)};
    }
    const double reach = reach_of(body);
    if (!(reach <= limits.reach)) {
        return Excess{
            i, "position",
            fmt::format("body '{}' reaches {:.3g} m from the origin, expected at most {:.3g} m: beyond, "
                        "the rounding of {:.3g} steps is more than the tolerance, {:g} m",
                        body.name, reach, limits.reach, limits.steps, limits.step.tolerance)};
    }
    return std::nullopt;
}

std::optional<Excess> motion_excess(const BodyDef& body, int i, const Limits& limits) {
    const Velocity most = fastest(body);
    const double speed = most.v.maxCoeff();
    if (!body.is_kinematic() && !(speed * limits.duration <= limits.travel)) {
        return Excess{
            i, "velocity",
            fmt::format("body '{}' has a speed of {:.3g} m/s, expected at most {:.3g} m/s: faster, it "
                        "leaves in {:g} s the range where the tolerance, {:g} m, is above rounding",
                        body.name, speed, limits.travel / limits.duration, limits.duration,
                        limits.step.tolerance)};
    }
    const Bounds box = bounds(body.shape, {}); // of a plane it has no end
    const double bound = largest_travel_in_step * 0.5 * (box.upper - box.lower).maxCoeff() / limits.h;
    if (!(speed <= bound)) {
        return Excess{i, "velocity",
                      fmt::format("body '{}' has a speed of {:.3g} m/s, expected at most {:.3g} m/s: {:g} times half "
                                  "its length a step",
                                  body.name, speed, bound, largest_travel_in_step)};
    }
    const double spin = most.w.maxCoeff();
    if (!(spin * limits.h <= largest_turn_in_step)) {
        return Excess{
            i, "angular_velocity",
            fmt::format("body '{}' has a spin of {:.3g} rad/s, expected at most {:.3g} rad/s: {:g} rad a "
                        "step",
                        body.name, spin, largest_turn_in_step / limits.h, largest_turn_in_step)};
    }
    // The largest friction a normal impulse allows, to the rounding of that impulse.
    const double friction = body.material.mu_s.value_or(0.0);
    if (!(friction * eps <= 1.0)) {
        return Excess{i, "friction",
                      fmt::format("body '{}' has a friction coefficient of {:.3g}, expected at most {:.3g}: "
                                  "above, the rounding of an impulse allows as much friction as itself",
                                  body.name, friction, 1.0 / eps)};
    }
    return std::nullopt;
}

} // namespace

std::optional<Excess> find_excess(const SceneDef& scene) {
    const Limits limits(scene);
    for (std::size_t body = 0; body < scene.bodies.size(); ++body) {
        const int i = static_cast<int>(body);
        for (const auto& excess :
             {mass_excess(scene.bodies[body], i), place_excess(scene.bodies[body], i, limits),
              motion_excess(scene.bodies[body], i, limits)}) {
            if (excess) {
                return excess;
            }
        }
    }
    if (!(scene.step.velocity_tolerance * limits.h <= scene.step.tolerance)) {
        return Excess{
            -1, "velocity_tolerance",
            fmt::format("simulation: velocity_tolerance is {:.3g} m/s, expected at most {:.3g} m/s: one "
                        "tolerance, {:g} m, a step",
                        scene.step.velocity_tolerance, scene.step.tolerance / limits.h,
                        scene.step.tolerance)};
    }
    const double fall = scene.step.gravity.cwiseAbs().maxCoeff() * limits.h * limits.h;
    if (!(fall <= limits.travel)) {
        return Excess{
            -1, "gravity",
            fmt::format("simulation: gravity is {:.3g} m/s^2, expected at most {:.3g} m/s^2: above, a "
                        "fall in one step cannot be computed to the tolerance, {:g} m",
                        scene.step.gravity.cwiseAbs().maxCoeff(), limits.travel / (limits.h * limits.h),
                        scene.step.tolerance)};
    }
    for (const JointDef& joint : scene.joints) {
        const double reach = joint.anchor.cwiseAbs().maxCoeff();
        if (!(2.0 * eps * reach <= scene.step.joint_tolerance)) {
            return Excess{
                -1, "joint_tolerance",
                fmt::format("joint '{}' is {:.3g} m from the origin, expected at most {:.3g} m: beyond, "
                            "rounding is more than joint_tolerance, {:g} m",
                            joint.name, reach, scene.step.joint_tolerance / (2.0 * eps),
                            scene.step.joint_tolerance)};
        }
    }
    return std::nullopt;
}

} // namespace sim
