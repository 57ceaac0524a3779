#include "sim/scene/file.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/body.h"
#include "sim/scene/bounds.h"
#include "sim/scene/camera.h"
#include "sim/scene/inlined.h"
#include "sim/scene/layer.h"
#include "sim/scene/overlap.h"
#include "sim/scene/pattern.h"
#include "sim/scene/section.h"
#include "sim/scene/shape.h"
#include "sim/scene/study.h"
#include "sim/scene/tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace sim {

namespace {

/// What joints call the ground when they hold a body in the world.
constexpr std::string_view world_name = "world";

/// Where a body's name and position stand in the text.
struct BodyPlaces {
    TextPlace name;
    TextPlace position;
};

/// A scene while it is read. Places are kept for the checks that need all bodies.
struct Loading {
    const TextSource& source;
    SceneDef scene;
    std::map<std::string, int> body_index; ///< by name
    std::vector<BodyPlaces> places;        ///< [body_count]
};

/// How messages call a table of an array: by its name, or by its number from 0.
std::string title_of(std::string_view kind, const TreeNode& node, std::size_t index) {
    const TreeNode* name = node.find("name");
    return name != nullptr && name->kind == TreeKind::text ? fmt::format("{} '{}'", kind, name->text)
                                                           : fmt::format("{} {}", kind, index);
}

// --- settings --------------------------------------------------------------------------------------------

StepSettings read_simulation(const TextSource& source, const TreeNode& node) {
    Section section(source, node, scene_section("simulation"), "simulation");
    StepSettings step;
    step.time_step = section.fraction("time_step");
    step.gravity = section.vector("gravity");
    step.tolerance = section.number("tolerance");
    step.joint_tolerance = section.number("joint_tolerance");
    step.velocity_tolerance = section.number("velocity_tolerance");
    step.resting_distance = section.number("resting_distance");
    step.resting_speed_floor = section.number("resting_speed_floor");
    step.iteration_limit = section.integer("iteration_limit");
    step.impacts = static_cast<ImpactHandling>(section.choice("impacts"));
    step.warm_start = section.boolean("warm_start");
    return step;
}

void read_speed(OutputDef& output, Section& section) {
    if (!section.has("speed_keys")) {
        output.speed = section.number("speed");
        return;
    }
    if (section.has("speed")) {
        section.fail("speed", "expected speed or speed_keys, not both");
    }
    for (const TreeNode* node : section.tables("speed_keys")) {
        Section key(section.source(), *node, scene_section("output.speed_keys"),
                    fmt::format("output speed key {}", output.speed_keys.size()));
        output.speed_keys.push_back({key.number("time"), key.number("speed")});
        const std::size_t count = output.speed_keys.size();
        if (count > 1 && output.speed_keys[count - 1].time <= output.speed_keys[count - 2].time) {
            key.fail("time", fmt::format("time is {}, expected more than that of the key before, {}",
                                         output.speed_keys[count - 1].time, output.speed_keys[count - 2].time));
        }
    }
    if (output.speed_keys.empty()) {
        section.fail("speed_keys", "speed_keys is an empty array, expected at least one key");
    }
}

OutputDef read_output(const TextSource& source, const TreeNode& node) {
    Section section(source, node, scene_section("output"), "output");
    OutputDef output = output_of(static_cast<Preset>(section.choice("preset")));
    for (const auto& [key, value] :
         {std::pair("width", &output.width), std::pair("height", &output.height),
          std::pair("shadow_size", &output.shadow_size), std::pair("crf", &output.crf)}) {
        *value = section.has(key) ? section.integer(key) : *value;
    }
    for (const auto& [key, value] :
         {std::pair("smooth_edges", &output.smooth_edges), std::pair("soft_shadows", &output.soft_shadows),
          std::pair("ambient_occlusion", &output.ambient_occlusion)}) {
        *value = section.has(key) ? section.boolean(key) : *value;
    }
    if (section.has("effort")) {
        output.effort = choices_of(
            *scene_section("output").find("effort"))[static_cast<std::size_t>(section.choice("effort"))];
    }
    output.shutter = section.number("shutter");
    output.subframes = section.integer("subframes");
    for (const int word : section.words("passes")) {
        output.passes[static_cast<std::size_t>(word)] = true;
    }
    if (output.has_passes() && output.shutter > 0.0) {
        section.fail("passes", "passes show one instant, expected shutter = 0");
    }
    output.fps = section.fraction("fps");
    output.duration = section.fraction("duration");
    read_speed(output, section);
    output.record_every = section.integer("record_every");
    output.camera = section.has("camera") ? section.text("camera") : "";
    output.encoder = section.text("encoder");
    output.bits = section.integer("bits");
    if (output.bits == 9) {
        section.fail("bits", "bits is 9, expected 8 or 10");
    }
    output.gl = section.text("gl");
    if (const std::string fault = gl_word_fault(output.gl); !fault.empty()) {
        section.fail("gl", "gl " + fault);
    }
    if (frame_count(output.duration, output.fps) < 1) {
        section.fail("duration",
                     fmt::format("duration {} s at {} frames a second makes no frame, expected at least "
                                 "{:.4g} s",
                                 output.duration.value(), output.fps.value(), 0.5 / output.fps.value()));
    }
    return output;
}

LightDef read_light(const TextSource& source, const TreeNode& node) {
    Section section(source, node, scene_section("light"), "light");
    LightDef light;
    light.to_sun = section.direction("to_sun");
    light.sun_color = section.color("sun_color");
    light.sun_intensity = section.number("sun_intensity");
    light.sky_zenith = section.color("sky_zenith");
    light.sky_horizon = section.color("sky_horizon");
    light.sky_intensity = section.number("sky_intensity");
    return light;
}

// --- bodies ----------------------------------------------------------------------------------------------

std::vector<std::string> body_names(const SceneDef& scene) {
    std::vector<std::string> names;
    for (const BodyDef& body : scene.bodies) {
        names.push_back(body.name);
    }
    return names;
}

/// Of the position's component that an override gave, of the position, or of the name.
TextPlace place_of_position(const TreeNode& node) {
    const TreeNode* position = node.find("position");
    if (position == nullptr) {
        return node.find("name")->place;
    }
    for (const TreeNode& component : position->children) {
        if (component.place.assignment >= 0) {
            return component.place;
        }
    }
    return position->place;
}

void add_body(Loading& loading, BodyDef body, const TreeNode& node) {
    const TreeNode* name = node.find("name");
    if (body.name == world_name) {
        fail_at(loading.source, name->place,
                "a body is named 'world', expected another name: joints call the ground so");
    }
    const auto [first, is_new] =
        loading.body_index.emplace(body.name, static_cast<int>(loading.scene.bodies.size()));
    if (!is_new) {
        const TextPlace& other = loading.places[static_cast<std::size_t>(first->second)].name;
        fail_at(loading.source, name->place,
                fmt::format("body '{}' has the same name as the one at {}, expected another name", body.name,
                            loading.source.describe(other)));
    }
    loading.places.push_back({name->place, place_of_position(node)});
    loading.scene.bodies.push_back(std::move(body));
}

void read_bodies(Loading& loading, Section& top) {
    std::size_t index = 0;
    for (const TreeNode* node : top.tables("body")) {
        add_body(loading, read_body(loading.source, *node, title_of("body", *node, index++)), *node);
    }
    index = 0;
    for (const TreeNode* node : top.tables("funnel")) {
        for (BodyDef& plate : read_funnel(loading.source, *node, title_of("funnel", *node, index++))) {
            add_body(loading, std::move(plate), *node);
        }
    }
    index = 0;
    for (const TreeNode* node : top.tables("lattice")) {
        for (BodyDef& body : read_lattice(loading.source, *node, title_of("lattice", *node, index++))) {
            add_body(loading, std::move(body), *node);
        }
    }
}

/// To the end of a step, as World::time() has it.
void round_releases(SceneDef& scene) {
    constexpr double same_step = 1e-6; // rounded only away from it
    const Rational h = scene.step.time_step;
    for (BodyDef& body : scene.bodies) {
        if (body.release > 0.0) {
            const double step = std::ceil(body.release / h.value() - same_step);
            body.release = step * static_cast<double>(h.num) / static_cast<double>(h.den);
        }
    }
}

// --- joints ----------------------------------------------------------------------------------------------

/// Index of a body, -1 for the world.
int find_body(const Loading& loading, const std::string& name, const TextPlace& place,
              const std::string& title) {
    if (name == world_name) {
        return -1;
    }
    const auto found = loading.body_index.find(name);
    if (found == loading.body_index.end()) {
        fail_at(loading.source, place,
                fmt::format("{}: there is no body '{}'{}", title, name,
                            suggestion(name, body_names(loading.scene))));
    }
    return found->second;
}

/// As for masses: products of three such numbers neither vanish nor overflow.
void refuse_extreme(const Section& section, std::string_view key, double value) {
    if (value != 0.0 && !(value >= 1e-100 && value <= 1e100)) {
        section.fail(key, fmt::format("{} is {}, expected within 1e-100..1e100", key, value));
    }
}

/// Spring and motor of a hinge or slider. sign: -1 where the first body named is the joint's second.
void read_drives(const Loading& loading, Section& joint, JointDef& def, double sign) {
    if (joint.has("spring")) {
        Section section(loading.source, joint.table("spring"), scene_section("joint.spring"), joint.title() + " spring");
        const bool is_hinge = def.kind == JointKind::hinge;
        const double rest = is_hinge ? section.number("rest_degrees") * (std::numbers::pi / 180.0) : section.number("rest");
        def.spring = {section.number("stiffness"), section.number("damping"), sign * rest};
        section.finish(is_hinge ? "at a hinge" : "at a slider");
        if (def.spring->stiffness == 0.0 && def.spring->damping == 0.0) {
            section.fail("stiffness", "stiffness and damping are 0, expected one of them > 0");
        }
        refuse_extreme(section, "stiffness", def.spring->stiffness);
        refuse_extreme(section, "damping", def.spring->damping);
    }
    if (joint.has("motor")) {
        Section section(loading.source, joint.table("motor"), scene_section("joint.motor"), joint.title() + " motor");
        def.motor = {sign * section.number("speed"), section.number("limit")};
        refuse_extreme(section, "limit", def.motor->limit);
        const double most = largest_turn_in_step / loading.scene.step.time_step.value();
        if (def.kind == JointKind::hinge && std::abs(def.motor->speed) > most) {
            section.fail("speed", fmt::format("speed is {:.3g} rad/s, expected at most {:.3g} rad/s: {:g} rad a step",
                                              def.motor->speed, most, largest_turn_in_step));
        }
    }
}

void read_joint(Loading& loading, const TreeNode& node, const std::string& title) {
    Section section(loading.source, node, scene_section("joint"), title);
    JointDef joint;
    joint.name = section.text("name");
    joint.kind = static_cast<JointKind>(section.choice("kind"));
    const std::vector<std::string> names = section.names("bodies");
    const TextPlace place = section.place_of("bodies");
    joint.body_a = find_body(loading, names[0], place, title);
    joint.body_b = names.size() > 1 ? find_body(loading, names[1], place, title) : -1;
    const bool is_swapped = joint.body_a < 0;
    if (is_swapped) {
        std::swap(joint.body_a, joint.body_b);
    }
    const auto is_held = [&](int body) {
        return body < 0 || loading.scene.bodies[static_cast<std::size_t>(body)].is_static();
    };
    if (joint.body_a == joint.body_b && joint.body_a >= 0) {
        section.fail("bodies", fmt::format("joins '{}' to itself, expected two bodies", names[0]));
    }
    if (is_held(joint.body_a) && is_held(joint.body_b)) {
        section.fail("bodies", "neither body can move, expected at least one that is neither static nor moved by keys");
    }
    for (const int body : {joint.body_a, joint.body_b}) {
        if (body >= 0 && loading.scene.bodies[static_cast<std::size_t>(body)].release > 0.0) {
            section.fail("bodies", fmt::format("'{}' is released later, expected bodies that are there from the start",
                                               loading.scene.bodies[static_cast<std::size_t>(body)].name));
        }
    }
    joint.anchor = section.vector("anchor");
    if (joint.kind != JointKind::ball) {
        joint.axis = section.direction("axis");
        read_drives(loading, section, joint, is_swapped ? -1.0 : 1.0);
    }
    joint.is_drawn = joint.kind != JointKind::slider && section.boolean("drawn");
    section.finish(joint.kind == JointKind::ball ? "in a ball joint" : "in a slider");
    for (const JointDef& other : loading.scene.joints) {
        if (other.name == joint.name) {
            section.fail("name", "the name is taken by an earlier joint, expected another");
        }
    }
    loading.scene.joints.push_back(std::move(joint));
}

// --- cameras ---------------------------------------------------------------------------------------------

void read_cameras(Loading& loading, Section& top, const BodyFinder& find) {
    SceneDef& scene = loading.scene;
    std::size_t index = 0;
    for (const TreeNode* node : top.tables("camera")) {
        scene.cameras.push_back(read_camera(loading.source, *node, title_of("camera", *node, index++), scene, find));
    }
    if (scene.cameras.empty()) {
        scene.cameras.push_back(default_camera(scene));
    }
}

/// output.camera must be one of the cameras.
void check_chosen_camera(const Loading& loading, const TreeNode& output) {
    const std::string& name = loading.scene.output.camera;
    std::vector<std::string> names;
    for (const CameraDef& camera : loading.scene.cameras) {
        names.push_back(camera.name);
    }
    if (!name.empty() && std::ranges::find(names, name) == names.end()) {
        fail_at(loading.source, output.find("camera")->place,
                fmt::format("output: there is no camera '{}'{}", name, suggestion(name, names)));
    }
}

// --- the whole scene -------------------------------------------------------------------------------------

/// Bodies must not overlap at the start: the solver would throw them apart.
void check_overlaps(const Loading& loading) {
    const std::optional<StartOverlap> overlap = find_start_overlap(loading.scene);
    if (!overlap) {
        return;
    }
    const auto name = [&](int body) { return loading.scene.bodies[static_cast<std::size_t>(body)].name; };
    const std::string others =
        overlap->pair_count > 1 ? fmt::format(", the deepest of {}{} overlaps", overlap->pair_count,
                                              overlap->pair_count == most_overlaps ? " or more" : "")
                                : "";
    fail_at(
        loading.source, loading.places[static_cast<std::size_t>(overlap->body_b)].position,
        fmt::format(
            "body '{}' overlaps body '{}' by {:.4g} m at the start{}, expected at most the tolerance, {} m",
            name(overlap->body_b), name(overlap->body_a), overlap->penetration, others,
            loading.scene.step.tolerance));
}

/// No quantity may be beyond what can be computed to the tolerances.
void check_bounds(const Loading& loading, const TreeNode& simulation) {
    const std::optional<Excess> excess = find_excess(loading.scene);
    if (!excess) {
        return;
    }
    if (excess->body < 0) {
        const TreeNode* value = simulation.find(excess->key);
        fail_at(loading.source, value != nullptr ? value->place : simulation.place, excess->message);
    }
    const BodyPlaces& places = loading.places[static_cast<std::size_t>(excess->body)];
    fail_at(loading.source, excess->key == "position" ? places.position : places.name, excess->message);
}

} // namespace

std::string scene_name_of(const std::string& file) {
    std::string name = std::filesystem::path(file).stem().string();
    if (!is_file_name(name)) {
        throw Error(ExitCode::usage,
                    fmt::format("{}: '{}' cannot be the name of a scene's folder and files; give the file another name",
                                file, name));
    }
    return name;
}

SceneDef parse_scene(const std::string& text, const std::string& file,
                     std::span<const std::string> overrides) {
    const TextSource source{file, {overrides.begin(), overrides.end()}};
    TreeNode root = parse_tree(text, source);
    for (std::size_t i = 0; i < overrides.size(); ++i) {
        apply_assignment(root, source, static_cast<int>(i));
    }

    Section top(source, root, scene_section(""), "top of the file");
    const TreeNode empty;
    const auto table = [&](std::string_view key) -> const TreeNode& {
        return top.has(key) ? top.table(key) : empty;
    };
    Loading loading{source, {}, {}, {}};
    SceneDef& scene = loading.scene;
    scene.name = scene_name_of(file);
    scene.title = top.text("title");
    scene.step = read_simulation(source, table("simulation"));
    scene.output = read_output(source, table("output"));
    scene.light = read_light(source, table("light"));
    read_study(source, table("study")); // for what is wrong with it: study_of() reads it where it is wanted
    read_bodies(loading, top);
    round_releases(scene);
    std::size_t index = 0;
    for (const TreeNode* node : top.tables("joint")) {
        read_joint(loading, *node, title_of("joint", *node, index++));
    }
    const BodyFinder find = [&](const std::string& name, const TextPlace& place, const std::string& title) {
        return find_body(loading, name, place, title);
    };
    read_cameras(loading, top, find);
    check_chosen_camera(loading, table("output"));
    scene.overlay = read_overlay(source, table("overlay"), find);
    index = 0;
    for (const TreeNode* node : top.tables("plot")) {
        scene.plots.push_back(read_plot(source, *node, fmt::format("plot {}", index++), scene, find));
    }
    index = 0;
    for (const TreeNode* node : top.tables("caption")) {
        scene.captions.push_back(read_caption(source, *node, fmt::format("caption {}", index++)));
    }
    check_bounds(loading, table("simulation"));
    check_overlaps(loading);
    scene.text = text_with_files(text, root, source);
    scene.overrides = source.assignments;
    return std::move(loading.scene);
}

std::string gl_word_fault(const std::string& word) {
    constexpr std::string_view card = "egl:";
    constexpr std::size_t most_digits = 3;
    const std::string_view digits = std::string_view(word).substr(std::min(card.size(), word.size()));
    const bool is_card = word.starts_with(card) && !digits.empty() && digits.size() <= most_digits &&
                         std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; });
    if (is_card || word == "auto" || word == "osmesa" || word == "egl") {
        return "";
    }
    return fmt::format("'{}': expected auto, osmesa, egl, or egl:0, egl:1, ... of a graphics card{}", word,
                       near_miss(word, {"auto", "osmesa", "egl", "egl:0"}));
}

SceneDef load_scene(const std::filesystem::path& path, std::span<const std::string> overrides) {
    return parse_scene(read_text_file(path), path.string(), overrides);
}

} // namespace sim
