#include "sim/scene/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>

namespace sim {

namespace {

/// Parts [-] into which the way from key to key of a body is cut where a camera is to see it.
constexpr int poses_between_keys = 16;

void check_view(const Section& section, const CameraKey& key, std::string_view at) {
    if (key.eye == key.target) {
        section.fail(at, "eye and target are the same point, expected two different ones");
    }
}

std::vector<CameraKey> read_camera_keys(Section& camera) {
    std::vector<CameraKey> keys;
    for (const TreeNode* node : camera.tables("keys")) {
        Section section(camera.source(), *node, scene_section("camera.keys"),
                        fmt::format("{} key {}", camera.title(), keys.size()));
        keys.push_back({section.number("time"), section.vector("eye"), section.vector("target"),
                        section.optional_number("fov_degrees").value_or(0.0),
                        static_cast<Easing>(section.choice("easing"))});
        check_view(section, keys.back(), "eye");
        if (keys.size() > 1 && keys.back().time <= keys[keys.size() - 2].time) {
            section.fail("time", fmt::format("time is {}, expected more than that of the key before, {}",
                                             keys.back().time, keys[keys.size() - 2].time));
        }
    }
    return keys;
}

/// Radius of the ball about the centre of mass that holds the body.
double radius_of(const BodyDef& body) {
    const Bounds box = bounds(body.shape, Pose{});
    return box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm();
}

std::vector<FramedBody> read_framed(Section& section, const SceneDef& scene, const BodyFinder& find) {
    std::vector<FramedBody> framed;
    const auto add = [&](int body) {
        framed.push_back({body, radius_of(scene.bodies[static_cast<std::size_t>(body)])});
    };
    for (const std::string& name : section.texts("bodies")) {
        const int body = find(name, section.place_of("bodies"), section.title());
        if (body < 0 || std::holds_alternative<Plane>(scene.bodies[static_cast<std::size_t>(body)].shape)) {
            section.fail("bodies", fmt::format("'{}' has no end, expected names of bodies that have one", name));
        }
        add(body);
    }
    for (std::size_t i = 0; i < scene.bodies.size() && !section.has("bodies"); ++i) {
        if (!scene.bodies[i].is_static()) {
            add(static_cast<int>(i));
        }
    }
    if (framed.empty()) {
        section.fail("bodies", "there is no body to be framed, expected at least one");
    }
    return framed;
}

/// From where the ball that holds all framed bodies at the start fills the opening.
double distance_to(const CameraDef& camera, const SceneDef& scene) {
    const auto centre_of = [&](const FramedBody& framed) -> const Vec3& {
        return scene.bodies[static_cast<std::size_t>(framed.body)].pose.position;
    };
    Vec3 middle = Vec3::Zero();
    for (const FramedBody& framed : camera.framed) {
        middle += centre_of(framed) / static_cast<double>(camera.framed.size());
    }
    double radius = 0.0;
    for (const FramedBody& framed : camera.framed) {
        radius = std::max(radius, (centre_of(framed) - middle).norm() + framed.radius);
    }
    return radius / std::sin(camera.fov_degrees / 2.0 * std::numbers::pi / 180.0);
}

} // namespace

CameraDef read_camera(const TextSource& source, const TreeNode& node, const std::string& title, const SceneDef& scene,
                      const BodyFinder& find) {
    Section section(source, node, scene_section("camera"), title);
    CameraDef camera;
    camera.name = section.text("name");
    camera.kind = static_cast<CameraKind>(section.choice("kind"));
    camera.fov_degrees = section.number("fov_degrees");
    if (section.has("keys") && camera.kind == CameraKind::keys) {
        camera.keys = read_camera_keys(section);
        section.finish("beside keys");
        if (camera.keys.empty()) {
            section.fail("keys", "keys is an empty array, expected at least one key");
        }
    } else if (camera.kind == CameraKind::track) {
        camera.keys = {{0.0, section.vector("eye"), section.has("target") ? section.vector("target") : Vec3::Zero()}};
    } else {
        camera.keys = {{0.0, section.vector("eye"), section.vector("target")}};
        check_view(section, camera.keys[0], "eye");
    }
    if (camera.kind == CameraKind::orbit) {
        camera.period = section.number("period");
    }
    const bool needs_body = camera.kind == CameraKind::follow || camera.kind == CameraKind::track;
    if (needs_body || (camera.kind == CameraKind::orbit && section.has("body"))) {
        const std::string name = section.text("body");
        camera.body = find(name, section.place_of("body"), title);
        if (camera.body < 0) {
            section.fail("body", "the world cannot be followed, expected the name of a body");
        }
    }
    if (camera.kind == CameraKind::track) {
        const Vec3& centre = scene.bodies[static_cast<std::size_t>(camera.body)].pose.position;
        camera.distance = (camera.keys[0].eye - centre - camera.keys[0].target).norm();
    }
    if (camera.kind == CameraKind::frame) {
        camera.framed = read_framed(section, scene, find);
        camera.distance = distance_to(camera, scene);
    }
    section.finish("in a camera of this kind");
    if (std::ranges::find(scene.cameras, camera.name, &CameraDef::name) != scene.cameras.end()) {
        section.fail("name", "the name is taken by an earlier camera, expected another");
    }
    return camera;
}

CameraDef default_camera(const SceneDef& scene) {
    CameraDef camera;
    camera.keys = {CameraKey{}};
    Vec3 lower = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 upper = -lower;
    const auto include = [&](const Shape& shape, const Pose& pose) {
        const Bounds box = bounds(shape, pose);
        if (box.lower.allFinite()) {
            lower = lower.cwiseMin(box.lower);
            upper = upper.cwiseMax(box.upper);
        }
    };
    for (const BodyDef& body : scene.bodies) {
        include(body.shape, body.pose);
        for (std::size_t i = 1; i < body.motion.keys.size(); ++i) {
            const double from = body.motion.keys[i - 1].time;
            const double to = body.motion.keys[i].time;
            for (int k = 0; k <= poses_between_keys; ++k) {
                include(body.shape, body.motion.pose_at(from + (to - from) * k / poses_between_keys));
            }
        }
    }
    if (lower.allFinite()) {
        // The ball around the bounding box fills the vertical opening but for a tenth.
        const double radius = (upper - lower).norm() / 2.0;
        const double distance = 1.1 * radius / std::sin(camera.fov_degrees / 2.0 * std::numbers::pi / 180.0);
        camera.keys[0].target = (lower + upper) / 2.0;
        camera.keys[0].eye = camera.keys[0].target + distance * Vec3(0.55, -0.75, 0.37).normalized();
    }
    return camera;
}

} // namespace sim
