#include "sim/scene/summary.h"

#include "sim/base/rational.h"
#include "sim/model/film_clock.h"
#include "sim/scene/model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace sim {

namespace {

/// Names of the alternatives of Shape, in its order, singular and plural.
constexpr std::array shape_names{std::array{"plane", "planes"},       std::array{"box", "boxes"},
                                 std::array{"sphere", "spheres"},     std::array{"cylinder", "cylinders"},
                                 std::array{"capsule", "capsules"},   std::array{"hull", "hulls"},
                                 std::array{"compound", "compounds"}};
static_assert(shape_names.size() == std::variant_size_v<Shape>);

std::string joined(const std::vector<std::string>& parts) {
    return fmt::format("{}", fmt::join(parts, ", "));
}

/// "1000 dynamic (1000 boxes)" of the bodies that belong to a kind.
template <class Belongs>
std::string describe_bodies(const SceneDef& scene, const char* kind, Belongs&& belongs) {
    std::array<int, shape_names.size()> counts{};
    int total = 0;
    for (const BodyDef& body : scene.bodies) {
        if (belongs(body)) {
            ++counts[body.shape.index()];
            ++total;
        }
    }
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (counts[i] > 0) {
            parts.push_back(fmt::format("{} {}", counts[i], shape_names[i][counts[i] == 1 ? 0 : 1]));
        }
    }
    const std::string shapes = parts.empty() ? "" : fmt::format(" ({})", joined(parts));
    return fmt::format("{} {}{}", total, kind, shapes);
}

std::string describe_joints(const SceneDef& scene) {
    const auto count = [&](JointKind kind) {
        return std::ranges::count(scene.joints, kind, &JointDef::kind);
    };
    const auto to_world =
        std::ranges::count_if(scene.joints, [](const JointDef& joint) { return joint.body_b < 0; });
    std::vector<std::string> parts;
    for (const auto& [number, name] :
         {std::pair(count(JointKind::ball), "ball"), {count(JointKind::hinge), "hinge"}, {count(JointKind::slider), "slider"}}) {
        if (number > 0) {
            parts.push_back(fmt::format("{} {}", number, name));
        }
    }
    if (to_world > 0) {
        parts.push_back(fmt::format("{} to the world", to_world));
    }
    return parts.empty() ? "none" : joined(parts);
}

/// "0.001 s" or "1/240 s": whichever is exact and short.
std::string describe_fraction(Rational x) {
    const std::string decimal = fmt::format("{}", x.value());
    return parse_rational(decimal) == x && decimal.size() <= 8 ? decimal : fmt::format("{}/{}", x.num, x.den);
}

std::string describe_camera(const CameraDef& camera, bool is_chosen) {
    std::string kind;
    switch (camera.kind) {
    case CameraKind::keys:
        kind = camera.keys.size() == 1 ? "fixed" : fmt::format("{} keys", camera.keys.size());
        break;
    case CameraKind::orbit:
        kind = fmt::format("orbit in {} s{}", camera.period, camera.body >= 0 ? " around a body" : "");
        break;
    case CameraKind::follow:
        kind = "follows a body";
        break;
    case CameraKind::track:
        kind = "tracks a body";
        break;
    case CameraKind::frame:
        kind = camera.framed.size() == 1 ? "frames a body" : fmt::format("frames {} bodies", camera.framed.size());
        break;
    }
    return fmt::format("'{}' ({}{})", camera.name, kind, is_chosen ? ", chosen" : "");
}

} // namespace

std::string describe_scene(const SceneDef& scene) {
    const StepSettings& step = scene.step;
    const OutputDef& output = scene.output;
    double mass = 0.0;
    for (const BodyDef& body : scene.bodies) {
        mass += body.mass.mass;
    }
    const std::int64_t frames = frame_count(output.duration, output.fps);
    std::vector<std::string> cameras;
    for (const CameraDef& camera : scene.cameras) {
        cameras.push_back(describe_camera(camera, scene.cameras.size() > 1 && camera.name == output.camera));
    }

    std::string text =
        scene.title.empty() ? scene.name + "\n" : fmt::format("{}: {}\n", scene.name, scene.title);
    const auto line = [&](const char* name, const std::string& value) {
        text += fmt::format("  {:<11} {}\n", name, value);
    };
    std::string bodies = describe_bodies(scene, "dynamic", [](const BodyDef& body) { return !body.is_static(); });
    bodies += ", " + describe_bodies(scene, "static", [](const BodyDef& body) { return body.is_fixed(); });
    if (std::ranges::any_of(scene.bodies, &BodyDef::is_kinematic)) {
        bodies += ", " + describe_bodies(scene, "moved by keys", [](const BodyDef& body) { return body.is_kinematic(); });
    }
    line("bodies", bodies);
    line("mass", fmt::format("{:.6g} kg", mass));
    line("joints", describe_joints(scene));
    const std::string speed =
        is_real_time(output) ? "" : fmt::format(" of film, {:.6g} s simulated", simulated_duration(output));
    line("steps", fmt::format("{} of {} s; {} s{}", step_count_of(scene), describe_fraction(step.time_step),
                              describe_fraction(output.duration), speed));
    line("frames", fmt::format("{} of {} x {} at {} a second", frames, output.width, output.height,
                               describe_fraction(output.fps)));
    line("trajectory", output.record_every == 0
                           ? "one record a frame"
                           : fmt::format("one record every {} steps", output.record_every));
    line("gravity", fmt::format("{} {} {} m/s^2", step.gravity.x(), step.gravity.y(), step.gravity.z()));
    line("tolerances",
         fmt::format("{} m contact, {} m joint, {} m/s impact, at most {} sweeps", step.tolerance,
                     step.joint_tolerance, step.velocity_tolerance, step.iteration_limit));
    std::vector<std::string> unused;
    const char* title = "model"; // of the first line only
    for (const ModelPart& part : model_parts(scene)) {
        if (part.is_on) {
            line(title, fmt::format("{}: {}", part.name, part.reason));
            title = "";
        } else {
            unused.push_back(part.name);
        }
    }
    if (!unused.empty()) {
        line("not used", joined(unused));
    }
    line("cameras", joined(cameras));
    for (const std::string& assignment : scene.overrides) {
        line("set", assignment);
    }
    return text;
}

} // namespace sim
