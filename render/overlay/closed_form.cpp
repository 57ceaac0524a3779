#include "render/overlay/closed_form.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace render {

namespace {

using sim::Vec3;

/// Two set values: geometric mean; one: that; none: 0.
double of_pair(const std::optional<double>& a, const std::optional<double>& b) {
    return a && b ? std::sqrt(*a * *b) : a.value_or(b.value_or(0.0));
}

/// Distance from `from` along the unit vector `along` to where it leaves the sides of a box centred at 0.
double distance_to_side(const Vec3& from, const Vec3& along, const Vec3& half_extents) {
    double distance = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 2; ++i) {
        if (along[i] != 0.0) {
            distance = std::min(distance, (std::copysign(half_extents[i], along[i]) - from[i]) / along[i]);
        }
    }
    return distance;
}

} // namespace

double SlidingBlock::distance(double t) const {
    const bool stops = acceleration < 0.0 && rests;
    const double moving = stops ? std::min(t, speed / -acceleration) : t;
    return moving * (speed + 0.5 * acceleration * moving);
}

SlidingBlock sliding_block(const sim::SceneDef& scene, int body, int incline) {
    const sim::BodyDef& block = scene.bodies[static_cast<std::size_t>(body)];
    const sim::BodyDef& plane = scene.bodies[static_cast<std::size_t>(incline)];
    const sim::Quat plane_from_world = plane.pose.orientation.conjugate();
    const Vec3 g = plane_from_world * scene.step.gravity;
    const double pressing = std::abs(g.z());
    const Vec3 downhill = Vec3(g.x(), g.y(), 0.0);
    SlidingBlock result;
    result.speed = block.velocity.norm();
    const Vec3 along = result.speed > 0.0      ? Vec3(plane_from_world * block.velocity / result.speed)
                       : downhill.norm() > 0.0 ? Vec3(downhill.normalized())
                                               : Vec3(Vec3::UnitX());
    result.acceleration = g.dot(along) - of_pair(block.material.mu_d, plane.material.mu_d) * pressing;
    result.rests = of_pair(block.material.mu_s, plane.material.mu_s) * pressing >= downhill.norm();
    if (result.speed == 0.0 && result.rests) {
        result.acceleration = 0.0;
    }
    const sim::Box& box = std::get<sim::Box>(plane.shape);
    result.end = distance_to_side(plane_from_world * (block.pose.position - plane.pose.position), along,
                                  box.half_extents);
    return result;
}

} // namespace render
