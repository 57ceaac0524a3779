/// tumble check: reads and validates scenes, and prints what they contain.
#include "render/cmd/options.h"
#include "sim/scene_file.h"

#include <fmt/format.h>

#include <cstdio>
#include <map>

namespace cmd {

namespace {

const char* kind_of(const sim::Shape& shape) {
    constexpr const char* names[] = {"plane", "box", "sphere", "compound"};
    static_assert(std::variant_size_v<sim::Shape> == std::size(names));
    return names[shape.index()];
}

/// "1000 box, 2 sphere"
std::string counts_text(const std::map<std::string, int>& counts) {
    std::string text;
    for (const auto& [name, count] : counts) {
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, name);
    }
    return text.empty() ? "none" : text;
}

void print_scene(const sim::SceneDef& scene) {
    std::map<std::string, int> moving, fixed, joints;
    double mass = 0.0;
    for (const sim::BodyDef& body : scene.bodies) {
        ++(body.is_static() ? fixed : moving)[kind_of(body.shape)];
        mass += body.mass.mass;
    }
    for (const sim::JointDef& joint : scene.joints) {
        ++joints[joint.kind == sim::JointKind::ball ? "ball" : "hinge"];
    }
    std::string cameras;
    for (const sim::CameraDef& camera : scene.cameras) {
        cameras += (cameras.empty() ? "" : ", ") + camera.name;
    }
    const sim::OutputDef& output = scene.output;
    const double h = scene.step.time_step.value();
    std::string text = fmt::format("{}: {}\n", scene.name, scene.title.empty() ? "(no title)" : scene.title);
    text += fmt::format("  dynamic bodies  {}; {:.6g} kg\n", counts_text(moving), mass);
    text += fmt::format("  static bodies   {}\n", counts_text(fixed));
    text += fmt::format("  joints          {}\n", counts_text(joints));
    text += fmt::format("  cameras         {}\n", cameras);
    text += fmt::format("  film            {} frames of {}x{} at {:.6g} frames/s, {:.6g} s\n",
                        sim::frame_count(output.duration, output.fps), output.width, output.height,
                        output.fps.value(), output.duration.value());
    text += fmt::format("  simulation      {:.0f} steps of {:g} s, tolerance {:g} m\n",
                        output.duration.value() / h, h, scene.step.tolerance);
    std::fputs(text.c_str(), stdout);
}

} // namespace

void check_scenes(const Options& options) {
    const std::vector<std::string> overrides = overrides_of(options);
    for (const std::string& input : options.inputs) {
        const sim::SceneDef scene = sim::load_scene(input, overrides);
        if (!options.is_quiet) {
            print_scene(scene);
        }
    }
}

} // namespace cmd
