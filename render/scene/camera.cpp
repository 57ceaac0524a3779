#include "render/scene/camera.h"

#include "sim/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace render {

namespace {

using sim::CameraDef;
using sim::CameraKey;
using sim::Vec3;

/// A value of a key, the opening too.
struct KeyValue {
    Vec3 eye;
    Vec3 target;
    double fov_degrees;
};

KeyValue value_at(const CameraDef& camera, double t) {
    std::vector<sim::CurveKey<7>> curve;
    for (const CameraKey& key : camera.keys) {
        curve.push_back({key.time, key.easing, {}});
        curve.back().value << key.eye, key.target, key.fov_degrees > 0.0 ? key.fov_degrees : camera.fov_degrees;
    }
    const Eigen::Matrix<double, 7, 1> value = sim::curve_at(std::span<const sim::CurveKey<7>>(curve), t).value;
    return {value.head<3>(), value.segment<3>(3), value[6]};
}

constexpr double radians_per_degree = std::numbers::pi / 180.0;

/// Share of the picture's half width and height that framed bodies reach.
constexpr double framed_share = 0.92;

/// Where the eye stands along the view, and across it, so that two opposite planes of the view's pyramid touch the bodies.
struct Fit {
    double ahead;
    double across;
};

/// angle: of each plane to the view. A ball is inside a plane if its centre lies a radius behind it.
Fit fit(const CameraDef& camera, const sim::Snapshot& snapshot, const Vec3& forward, const Vec3& side, double angle) {
    const double cosine = std::cos(angle), sine = std::sin(angle);
    double low = std::numeric_limits<double>::infinity(), high = low;
    for (const sim::FramedBody& framed : camera.framed) {
        const Vec3& centre = snapshot.bodies[static_cast<std::size_t>(framed.body)].position;
        const double along = sine * centre.dot(forward) - framed.radius;
        low = std::min(low, along + cosine * centre.dot(side));
        high = std::min(high, along - cosine * centre.dot(side));
    }
    return {(low + high) / (2.0 * sine), (low - high) / (2.0 * cosine)};
}

/// The eye that looks along the key's view and sees all framed bodies, as near as can be, with as much of the picture free
/// on one side of them as on the other.
View frame_view(const CameraDef& camera, const KeyValue& key, const sim::Snapshot& snapshot, double aspect) {
    const Vec3 forward = (key.target - key.eye).normalized();
    const Vec3 up_hint = std::abs(forward.z()) > 0.999 ? Vec3::UnitY() : Vec3::UnitZ(); // as make_camera has it
    const Vec3 right = forward.cross(up_hint).normalized();
    const std::array<Vec3, 2> sides{right, right.cross(forward)};
    const double tan_v = framed_share * std::tan(0.5 * radians_per_degree * key.fov_degrees);
    const std::array<double, 2> angles{std::atan(tan_v * aspect), std::atan(tan_v)};
    double ahead = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 2; ++i) {
        ahead = std::min(ahead, fit(camera, snapshot, forward, sides[i], angles[i]).ahead);
    }
    Vec3 eye = forward * ahead;
    for (std::size_t i = 0; i < 2; ++i) {
        // From there, planes that touch the bodies on both sides: the wider they are the farther ahead the eye would be.
        double narrow = 1e-6, wide = angles[i];
        for (int halving = 0; halving < 30; ++halving) {
            const double angle = 0.5 * (narrow + wide);
            (fit(camera, snapshot, forward, sides[i], angle).ahead < ahead ? narrow : wide) = angle;
        }
        eye += sides[i] * fit(camera, snapshot, forward, sides[i], wide).across;
    }
    const Vec3& middle = snapshot.bodies[static_cast<std::size_t>(camera.framed.back().body)].position;
    return {eye, eye + forward * std::max(middle.dot(forward) - ahead, 1e-6), key.fov_degrees};
}

} // namespace

sim::Snapshot moved(const sim::Snapshot& snapshot, double dt) {
    sim::Snapshot result = snapshot;
    result.time += dt;
    for (sim::BodySnapshot& body : result.bodies) {
        body.position += body.velocity * dt;
        const double angle = body.angular_velocity.norm() * dt;
        if (angle != 0.0) {
            const sim::Vec3 axis = body.angular_velocity.normalized();
            body.orientation = sim::Quat(Eigen::AngleAxisd(angle, axis)) * body.orientation;
        }
    }
    return result;
}

const sim::CameraDef& find_camera(const sim::SceneDef& scene, const std::string& name) {
    std::string known;
    for (const sim::CameraDef& camera : scene.cameras) {
        if (name.empty() || camera.name == name) {
            return camera;
        }
        known += (known.empty() ? "" : ", ") + camera.name;
    }
    throw sim::Error(sim::ExitCode::usage, scene.name + ": no camera \"" + name +
                                               "\"; the scene has: " + (known.empty() ? "none" : known));
}

double view_scale(const CameraDef& camera) {
    const double distance = (camera.keys.front().eye - camera.keys.front().target).norm();
    return std::max(1e-6, camera.distance > 0.0 ? camera.distance : distance);
}

double opening_degrees(double fov_degrees, double aspect) {
    constexpr double wide = 16.0 / 9.0;
    if (aspect >= wide) {
        return fov_degrees;
    }
    return 2.0 * std::atan(std::tan(0.5 * radians_per_degree * fov_degrees) * wide / aspect) / radians_per_degree;
}

View camera_view(const CameraDef& camera, const sim::Snapshot& snapshot, double aspect) {
    CHECK(!camera.keys.empty());
    const KeyValue key = value_at(camera, snapshot.time);
    const double opening = opening_degrees(key.fov_degrees, aspect);
    Vec3 centre = Vec3::Zero();
    if (camera.body >= 0) {
        CHECK(static_cast<std::size_t>(camera.body) < snapshot.bodies.size());
        centre = snapshot.bodies[static_cast<std::size_t>(camera.body)].position;
    }
    switch (camera.kind) {
    case sim::CameraKind::keys:
        break;
    case sim::CameraKind::orbit: {
        const double angle = 2.0 * std::numbers::pi * snapshot.time / camera.period;
        const sim::Quat turn(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
        return {centre + key.target + turn * (key.eye - key.target), centre + key.target, opening};
    }
    case sim::CameraKind::follow:
        return {centre + key.eye, centre + key.target, opening};
    case sim::CameraKind::track: {
        // A body that passes through the eye is looked for straight ahead.
        const Vec3 target = centre + key.target;
        return {key.eye, target == key.eye ? Vec3(target + Vec3::UnitY()) : target, opening};
    }
    case sim::CameraKind::frame:
        return frame_view(camera, key, snapshot, aspect);
    }
    return {key.eye, key.target, opening};
}

} // namespace render
