#include "render/scene/camera.h"

#include "sim/base/error.h"

#include <cmath>
#include <numbers>

namespace render {

namespace {

using sim::CameraKey;
using sim::Vec3;

/// Velocity of the curve at key i: the slope between its neighbours (Catmull & Rom 1974, uneven times).
Vec3 key_velocity(const std::vector<CameraKey>& keys, std::size_t i, Vec3 CameraKey::*field) {
    if (i == 0 || i + 1 == keys.size()) {
        return Vec3::Zero();
    }
    return (keys[i + 1].*field - keys[i - 1].*field) / (keys[i + 1].time - keys[i - 1].time);
}

/// Cubic Hermite curve between keys i and i + 1 at time t.
Vec3 between_keys(const std::vector<CameraKey>& keys, std::size_t i, double t, Vec3 CameraKey::*field) {
    const double span = keys[i + 1].time - keys[i].time;
    const double s = (t - keys[i].time) / span;
    const double s2 = s * s;
    const double s3 = s2 * s;
    const Vec3 v0 = key_velocity(keys, i, field) * span;
    const Vec3 v1 = key_velocity(keys, i + 1, field) * span;
    return keys[i].*field * (2 * s3 - 3 * s2 + 1) + v0 * (s3 - 2 * s2 + s) +
           keys[i + 1].*field * (3 * s2 - 2 * s3) + v1 * (s3 - s2);
}

CameraKey key_at(const std::vector<CameraKey>& keys, double t) {
    if (t <= keys.front().time) {
        return keys.front();
    }
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        if (t < keys[i + 1].time) {
            return {t, between_keys(keys, i, t, &CameraKey::eye),
                    between_keys(keys, i, t, &CameraKey::target)};
        }
    }
    return keys.back();
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

View camera_view(const sim::CameraDef& camera, const sim::Snapshot& snapshot) {
    CHECK(!camera.keys.empty());
    const CameraKey key = key_at(camera.keys, snapshot.time);
    switch (camera.kind) {
    case sim::CameraKind::keys:
        break;
    case sim::CameraKind::orbit: {
        const double angle = 2.0 * std::numbers::pi * snapshot.time / camera.period;
        const sim::Quat turn(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
        return {key.target + turn * (key.eye - key.target), key.target, camera.fov_degrees};
    }
    case sim::CameraKind::follow: {
        CHECK(camera.body >= 0 && static_cast<std::size_t>(camera.body) < snapshot.bodies.size());
        const Vec3& centre = snapshot.bodies[static_cast<std::size_t>(camera.body)].position;
        return {centre + key.eye, centre + key.target, camera.fov_degrees};
    }
    }
    return {key.eye, key.target, camera.fov_degrees};
}

} // namespace render
