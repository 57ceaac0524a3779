#include "sim/scene/keys.h"

#include "sim/base/error.h"
#include "sim/scene/key_groups.h"

#include <fmt/format.h>

#include <algorithm>

namespace sim {

namespace {

using namespace key_groups;

// --- groups of keys that several tables share ------------------------------------------------------------

const Keys kind_keys{{"kind", choice, "", required_key, "what the shape is; each kind has its own keys", any,
                      "box sphere cylinder capsule hull rock plane compound"}};

const Keys box_keys = kind_keys + Keys{
    {"half_extents", vector, "m", none, "half the edges along x, y, z; this or `size`", positive, ""},
    {"size", vector, "m", none, "the edges along x, y, z; this or `half_extents`", positive, ""},
};

const Keys sphere_keys = kind_keys + Keys{
    {"radius", number, "m", required_key, "radius of the sphere, centred at the origin of its frame", positive, ""},
};

const Keys cylinder_keys = kind_keys + Keys{
    {"radius", number, "m", required_key, "of the cylinder, whose axis is z", positive, ""},
    {"length", number, "m", required_key, "along z, half of it on each side of the origin", positive, ""},
};

const Keys capsule_keys = kind_keys + Keys{
    {"radius", number, "m", required_key, "of the cylinder along z and of the half balls at its ends", positive, ""},
    {"length", number, "m", required_key, "between the half balls' centres", positive, ""},
};

const Keys hull_keys = kind_keys + Keys{
    {"points", points, "m", none, "whose convex hull it is; points that lie within are left out; this or `file`", any, ""},
    {"file", text, "", none,
     "OBJ file, relative to the scene file, whose vertices [m] are the points. Its faces are not used", any, ""},
};

const Keys rock_keys = kind_keys + Keys{
    {"size", vector, "m", required_key, "axes of the ellipsoid on which its corners lie", positive, ""},
    {"corners", integer, "", "16", "random points whose convex hull it is", {4, 1000}, ""},
    {"seed", integer, "", "1", "of those points; in a lattice each body adds its number", {0, 9e15}, ""},
};

const Keys orientation_keys{
    {"orientation", quaternion, "", none, "unit quaternion w, x, y, z: world from body", any, ""},
    {"axis_angle_degrees", axis_angle, "", none, "axis x, y, z and the angle about it [degrees]", any, ""},
    {"euler_degrees", vector, "degrees", none, "turned about the fixed x axis, then y, then z", any, ""},
};

const Keys part_keys =
    Keys{{"position", vector, "m", "[0, 0, 0]", "of the part's frame in the compound's frame", any, ""}} +
    orientation_keys;

const Keys material_keys{
    {"restitution", number, "", none,
     "e of an impact; 0: no rebound, 1: no loss. Of two bodies the geometric mean counts, of e as of friction; of one that "
     "leaves it out the other's", unit_interval, ""},
    {"friction", number, "", none, "sets mu_s and mu_d both", not_negative, ""},
    {"mu_s", number, "", none, "static friction coefficient, at least mu_d; with mu_d", not_negative, ""},
    {"mu_d", number, "", none, "dynamic friction coefficient; with mu_s", not_negative, ""},
};

const Keys look_keys{
    {"color", color, "", "[0.7, 0.7, 0.7]", "of the surface; a plane without one is dark", unit_interval, ""},
    {"pattern", choice, "", "\"plain\"", "drawn on the surface so that its turning is seen", any,
     "plain stripes checker grid"},
    {"pattern_color", color, "", "[0.15, 0.15, 0.15]", "of the pattern; on a plane, of its grid", unit_interval, ""},
    {"roughness", number, "", "0.5", "of the surface: small is shiny", {0.05, 1.0}, ""},
    {"metallic", number, "", "0.0", "0: like plastic, 1: like metal", unit_interval, ""},
    {"visible", boolean, "", "true", "whether it is drawn", any, ""},
};

constexpr const char* release_text =
    "when it comes: until then it is not there; rounded up to the end of a step. Its place must be free then, else the run ends. "
    "Not of a body in a joint";

const Keys placed_body_keys{
    {"name", text, "", required_key, "how messages, joints, cameras and `--set` call it; unique", any, ""},
    {"position", vector, "m", "[0, 0, 0]", "of the origin of the shape's frame", any, ""},
    {"release", number, "s", "0", release_text, not_negative, ""},
};

/// What a body of a pattern has too.
const Keys template_body_keys =
    Keys{
        {"shape", table, "", required_key, "what it collides as; see the tables of shapes", any,
         "{ kind = ... }"},
        {"static", boolean, "", "false", "never moves; has no mass and no velocity", any, ""},
        {"density", number, "kg/m^3", none,
         "of a homogeneous body; parts of a compound are summed as if they did not overlap. 1000 if neither density nor mass is "
         "given", positive, ""},
        {"mass", number, "kg", none, "instead of density: homogeneous unless inertia is given", positive, ""},
        {"centre_of_mass", vector, "m", none,
         "in the shape's frame; with mass and inertia. Left out: that of the homogeneous body", any, ""},
        {"inertia", moments, "kg m^2", none,
         "about the centre of mass, axes of the shape's frame: xx, yy, zz or xx, yy, zz, xy, xz, yz (entries of the matrix); "
         "with mass", any, ""},
    } +
    orientation_keys +
    Keys{
        {"velocity", vector, "m/s", "[0, 0, 0]", "of the centre of mass at the start", any, ""},
        {"angular_velocity", vector, "rad/s", "[0, 0, 0]", "at the start, in the world's axes", any, ""},
    } +
    material_keys + look_keys +
    Keys{{"drawn", table, "", none,
          "a shape that is drawn instead, in the same frame: what collides may be simpler than what is seen", any,
          "{ kind = ... }"},
         {"lathe", profile, "m", none,
          "(radius, z) points from bottom to top of the shape's frame: a surface of revolution about its z "
          "axis that "
          "is drawn instead of the shape",
          any, ""}};

const Keys motion_keys{
    {"keys", tables, "", none,
     "makes the body kinematic: they move it, whatever it meets, and it has no mass", any, "[{ time = ... }]"},
    {"axis", direction, "", "[0, 0, 1]", "of their angles, through the origin of the shape's frame, in the world's axes", any,
     ""},
};

const Keys motion_key_keys{
    {"time", number, "s", required_key, "larger than that of the key before", not_negative, ""},
    {"position", vector, "m", none, "of the origin of the shape's frame; left out: that of the body", any, ""},
    {"angle_degrees", number, "degrees", "0", "by which it is turned; 720 is twice round", any, ""},
    {"easing", choice, "", "\"smooth\"",
     "how it moves on to the next key: `smooth`, through both without a stop, at rest at the first and the last; `stop`, at rest "
     "at both; `linear`, at one speed, which begins and ends with a jerk", any, "smooth stop linear"},
};

// --- the tables ------------------------------------------------------------------------------------------

SectionSpec top_section() {
    return {"",
            "top of the file",
            "Keys before the first table, and the tables themselves.",
            {
                {"title", text, "", "\"\"", "one line on what the scene shows", any, ""},
                {"simulation", table, "", none, "how it is computed", any, "[simulation]"},
                {"output", table, "", none, "what is written", any, "[output]"},
                {"light", table, "", none, "sun and sky", any, "[light]"},
                {"overlay", table, "", none, "text and more over the pictures", any, "[overlay]"},
                {"plot", tables, "", none, "plots over the pictures", any, "[[plot]]"},
                {"caption", tables, "", none, "text over the pictures for a time", any, "[[caption]]"},
                {"study", table, "", none, "what `tumble study` holds it against", any, "[study]"},
                {"camera", tables, "", none,
                 "cameras; without one all bodies are brought into view, as they are at the start and as keys move them", any,
                 "[[camera]]"},
                {"body", tables, "", none, "bodies", any, "[[body]]"},
                {"lattice", tables, "", none, "many equal bodies in a lattice", any, "[[lattice]]"},
                {"funnel", tables, "", none, "four plates from a square mouth to a square throat", any,
                 "[[funnel]]"},
                {"joint", tables, "", none, "joints", any, "[[joint]]"},
            }};
}

SectionSpec simulation_section() {
    return {
        "simulation",
        "[simulation]",
        "Every tolerance and limit of the solver.",
        {
            {"time_step", fraction, "s", "0.001", "h; independent of the frame rate", {0.0, 1.0, true}, ""},
            {"gravity", vector, "m/s^2", "[0, 0, -9.81]", "g; z is up", any, ""},
            {"tolerance", number, "m", "1e-4", "largest gap error of a resting contact and largest overlap", positive, ""},
            {"joint_tolerance", number, "m", "1e-10", "largest gap of a joint", positive, ""},
            {"velocity_tolerance", number, "m/s", "1e-7",
             "the iteration ends when no contact changes by more", positive, ""},
            {"resting_distance", number, "m", "1e-4",
             "eps_c: an approach slower than sqrt(2 g eps_c) is a resting contact, a faster one an impact", positive, ""},
            {"resting_speed_floor", number, "m/s", "1e-6", "least value of that speed, for zero gravity", positive, ""},
            {"iteration_limit", integer, "sweeps", "2000", "of one solve; a step has ten times as many", {1, 1e9}, ""},
            {"impacts", choice, "", "\"auto\"",
             "`ahead`: contacts are placed before an impact, cheap with many bodies; `stop`: the step is divided at the "
             "time of impact, which keeps the energy of elastic ones; `auto`: `stop` where a body has a restitution of 0.9 "
             "or more", any, "auto ahead stop"},
            {"warm_start", boolean, "", "true", "start from the impulses of the last step", any, ""},
        }};
}

SectionSpec output_section() {
    return {"output",
            "[output]",
            "The film and the trajectory.",
            {
                {"preset", choice, "", "\"standard\"",
                 "gives the next eight keys where they are left out: draft, standard, final", any,
                 "draft standard final"},
                {"width", integer, "px", none, "of a frame: 1280, 1280, 1920", {1, 16384}, ""},
                {"height", integer, "px", none, "of a frame: 720, 720, 1080", {1, 16384}, ""},
                {"smooth_edges", boolean, "", none, "false, true, true", any, ""},
                {"soft_shadows", boolean, "", none, "false, true, true", any, ""},
                {"ambient_occlusion", boolean, "", none, "less sky where bodies are near: false, true, true", any, ""},
                {"shadow_size", integer, "px", none, "side of the shadow map: 512, 1024, 2048", {64, 8192}, ""},
                {"crf", integer, "", none,
                 "rate factor of the film; 0: lossless, which browsers do not play: 23, 18, 16", {0, 51}, ""},
                {"effort", choice, "", none,
                 "of the film's encoder, against its size: ultrafast, veryfast (searching less for motion than x264's "
                 "own), medium", any,
                 "ultrafast superfast veryfast faster fast medium slow slower veryslow"},
                {"encoder", text, "", "\"auto\"",
                 "of the film, by libavcodec's name: libx265, libsvtav1, h264_nvenc or another of H.264, HEVC or AV1, in MP4; "
                 "libvpx-vp9, in WebM; prores_ks, in QuickTime; ffv1 (lossless), in Matroska; auto: libx264, whose "
                 "bytes do not depend on the machine", any, ""},
                {"bits", integer, "bit", "8", "of a colour in the film: 8, or 10 where the encoder has it", {8, 10}, ""},
                {"gl", text, "", "\"auto\"",
                 "what draws: osmesa or egl (in software), egl:0, egl:1, ... (graphics cards; `tumble devices` lists "
                 "them); auto: osmesa where there is one, else egl", any, ""},
                {"shutter", number, "", "0",
                 "motion blur: share of the time between two frames in which the shutter is open", unit_interval, ""},
                {"subframes", integer, "", "8", "pictures that a blurred frame is the mean of", {1, 256}, ""},
                {"passes", words, "", "[]",
                 "beside each frame, as 32-bit OpenEXR: `depth`, `normal`, `body`, `motion`, `alpha`; as PNG: `rgba`, bodies "
                 "before nothing, `depth16`, millimetres, and `rgb16`, the picture in 16 bits; not of blurred frames; what "
                 "the numbers mean: render/film/README.md", any, "depth normal body motion alpha rgba depth16 rgb16"},
                {"fps", fraction, "1/s", "60", "frame k shows step round(k / (fps h))", {0.0, 1e4, true}, ""},
                {"duration",
                 fraction,
                 "s",
                 "6",
                 "of the film: round(duration fps) frames, at least one",
                 {0.0, 1e6, true}, ""},
                {"speed", number, "", "1",
                 "simulated seconds a second of film: 0.25 is slow motion; frames between two steps are interpolated",
                 {0.0, 1000.0, true}, ""},
                {"speed_keys", tables, "", none, "instead of speed, where it changes: straight from key to key", any,
                 "[{ time = ... }]"},
                {"record_every",
                 integer,
                 "steps",
                 "0",
                 "a trajectory record every so many steps; 0: one a frame",
                 {0, 1e9}, ""},
                {"camera", text, "", none, "name of the camera; left out: the first", any, ""},
            }};
}

SectionSpec speed_section() {
    return {"output.speed_keys",
            "speed_keys = [{ ... }]",
            "How fast the film runs from one time on.",
            {
                {"time", number, "s", required_key, "of the film; larger than that of the key before", not_negative, ""},
                {"speed", number, "", required_key, "simulated seconds a second of film; 0: the picture stands",
                 {0.0, 1000.0}, ""},
            }};
}

std::vector<SectionSpec> body_sections() {
    return {
        {"body", "[[body]]", "One body.", placed_body_keys + template_body_keys + motion_keys},
        {"body.keys", "keys = [{ ... }]",
         "Where a kinematic body is at one time. Before the first key and from the last on it stands.", motion_key_keys},
        {"shape box", "shape = { kind = \"box\", ... }",
         "Edges along the axes of its frame, centred at its origin.", box_keys},
        {"shape sphere", "shape = { kind = \"sphere\", ... }", "Centred at the origin of its frame.",
         sphere_keys},
        {"shape cylinder", "shape = { kind = \"cylinder\", ... }", "Axis along z, centred at its origin.",
         cylinder_keys},
        {"shape capsule", "shape = { kind = \"capsule\", ... }",
         "All points within a radius of a segment along z, centred at its origin.", capsule_keys},
        {"shape hull", "shape = { kind = \"hull\", ... }", "The convex hull of points.", hull_keys},
        {"shape rock", "shape = { kind = \"rock\", ... }",
         "The convex hull of random points; the same seed gives the same rock for ever.", rock_keys},
        {"shape plane", "shape = { kind = \"plane\" }",
         "The half space z <= 0 of its frame: ground without an end. Static bodies only.", kind_keys},
        {"shape compound",
         "shape = { kind = \"compound\", ... }",
         "Several parts that move together.",
         kind_keys + Keys{{"parts", tables, "", none,
                           "bounded shapes of one piece, at least one; they may overlap; this or `file`", any,
                           "[{ kind = ... }]"},
                          {"file", text, "", none,
                           "OBJ file, relative to the scene file: each group of faces (`g` or `o`) is a part, the "
                           "convex hull of its vertices [m]",
                           any, ""}}},
        {"part box", "parts = [{ kind = \"box\", ... }]", "A box in a compound.", box_keys + part_keys},
        {"part sphere", "parts = [{ kind = \"sphere\", ... }]", "A sphere in a compound.",
         sphere_keys + part_keys},
        {"part cylinder", "parts = [{ kind = \"cylinder\", ... }]", "A cylinder in a compound.",
         cylinder_keys + part_keys},
        {"part capsule", "parts = [{ kind = \"capsule\", ... }]", "A capsule in a compound.",
         capsule_keys + part_keys},
        {"part hull", "parts = [{ kind = \"hull\", ... }]", "A hull in a compound.", hull_keys + part_keys},
        {"part rock", "parts = [{ kind = \"rock\", ... }]", "A rock in a compound.", rock_keys + part_keys},
    };
}

std::vector<SectionSpec> pattern_sections() {
    return {
        {"lattice",
         "[[lattice]]",
         "Equal bodies in rows, columns and layers, named NAME_0, NAME_1, ... (x first).",
         {
             {"name", text, "", required_key, "beginning of the bodies' names", any, ""},
             {"count", counts, "", required_key, "bodies along x, y, z", {1, 1e6}, ""},
             {"spacing", vector, "m", required_key, "between neighbours along x, y, z", any, ""},
             {"origin", vector, "m", "[0, 0, 0]", "position of the first body", any, ""},
             {"turn_max_degrees", number, "degrees", "0",
              "each body is turned by a random angle up to this about a random axis", {0.0, 180.0}, ""},
             {"seed", integer, "", "1", "of turns, jitter and mixture; the same seed gives the same for ever", {0, 9e15}, ""},
             {"jitter", vector, "m", "[0, 0, 0]",
              "each body is moved at random by up to this along x, y, z, either way", not_negative, ""},
             {"release", number, "s", "0", "when they come, the lowest layer first: as for a body", not_negative, ""},
             {"release_interval", number, "s", "0",
              "from the release of one layer to that of the next above: with spacing 0 along z they come out of one place",
              not_negative, ""},
             {"palette", colors, "", none, "colour of each layer, in turn; left out: that of the body", unit_interval, ""},
             {"body", table, "", required_key, "keys of `[[body]]` but name and position", any,
              "{ shape = ... }"},
             {"mix", tables, "", none, "more bodies: each place takes `body`, whose share is 1, or one of these at random",
              any, "[{ shape = ... }]"},
         }},
        {"lattice.body", "[lattice.body]", "The body of a lattice.", template_body_keys},
        {"lattice.mix", "[[lattice.mix]]", "Another body of a lattice.",
         Keys{{"share", number, "", "1", "how often it is taken, beside 1 of `body`", positive, ""}} +
             template_body_keys},
        {"funnel", "[[funnel]]",
         "Four static plates about the z axis, named NAME_east, NAME_north, NAME_west, NAME_south, closed at "
         "the corners. Lengths are measured at their inner surfaces. They collide as boxes, and are drawn up to where they "
         "meet.",
         Keys{
             {"name", text, "", required_key, "beginning of the plates' names", any, ""},
             {"position", vector, "m", "[0, 0, 0]", "of the point on its axis from which heights count", any, ""},
             {"mouth", number, "m", required_key, "edge of the square above, larger than the throat", positive, ""},
             {"mouth_height", number, "m", required_key, "larger than the throat's height", any, ""},
             {"throat", number, "m", required_key, "edge of the square below", positive, ""},
             {"throat_height", number, "m", required_key, "where the square below is", any, ""},
             {"thickness", number, "m", required_key, "of the plates", positive, ""},
         } + material_keys +
             look_keys},
    };
}

SectionSpec joint_section() {
    return {"joint",
     "[[joint]]",
     "Holds two bodies together, or one in the world. Two bodies in a joint do not touch each other. What hangs straight between two "
     "ends bears its load by forces without bound, for which steps are divided up to a hundred times: let it sag.",
     {
         {"name", text, "", required_key, "how messages and `--set` call it; unique", any, ""},
         {"kind", choice, "", required_key,
          "`ball`: the anchors stay together; `hinge`: the axes stay parallel too; `slider`: nothing turns, and the first body "
          "moves along the axis", any, "ball hinge slider"},
         {"bodies", names, "", required_key,
          "names of two bodies; only one, or \"world\": held by the world", any, ""},
         {"anchor", vector, "m", required_key, "point that both share, in the world at the start", any, ""},
         {"axis", direction, "", none, "of a hinge or slider, in the world at the start", any, ""},
         {"spring", table, "", none, "of a hinge or slider", any, "{ stiffness = ... }"},
         {"motor", table, "", none, "of a hinge or slider", any, "{ speed = ..., limit = ... }"},
         {"drawn", boolean, "", "true", "as a rod from the anchor to the first body's centre of mass; not of a slider", any, ""},
     }};
}

SectionSpec spring_section() {
    return {"joint.spring", "spring = { ... }",
            "Draws a hinge or slider back to where it rests; computed such that it is stable at any step.",
            {
                {"stiffness", number, "N m/rad or N/m", required_key, "0: a damper", not_negative, ""},
                {"damping", number, "N m s/rad or N s/m", "0", "against the joint's speed", not_negative, ""},
                {"rest_degrees", number, "degrees", "0",
                 "of a hinge: where it rests; the first body against the second, from the start", any, ""},
                {"rest", number, "m", "0", "of a slider: the same", any, ""},
            }};
}

SectionSpec motor_section() {
    return {"joint.motor", "motor = { ... }", "Turns a hinge, or moves a slider.",
            {
                {"speed", number, "rad/s or m/s", required_key, "of the first body against the second", any, ""},
                {"limit", number, "N m or N", required_key, "largest torque or force", positive, ""},
            }};
}

SectionSpec study_section() {
    return {"study",
            "[study]",
            "What `tumble study` takes as the truth. Without it: a converged solution of the same scene.",
            {
                {"law", choice, "", "\"none\"",
                 "the closed form of its motion: a box on an inclined plane; a ball that bounces, or that slips until "
                 "it rolls; bodies that rest; one body without gravity",
                 any, "none sliding_block bouncing_ball rolling_ball tower free_rotation"},
                {"seed_key", text, "", none,
                 "key of a whole number, such as lattice.cube.seed, that is varied from run to run: the motion is "
                 "chaotic, and errors are those of the means over the runs", any, ""},
                {"gate_height", number, "m", "0", "bodies below it have passed: throughput; with seed_key", any, ""},
                {"promises", pairs, "", none,
                 "error and cost (processor time of a simulated second) that a study found of the presets preview, "
                 "standard, accurate: three pairs; a run with --preset tells what it reached beside them", not_negative, ""},
            }};
}

std::vector<SectionSpec> all_sections() {
    std::vector<SectionSpec> sections{top_section(), simulation_section(), output_section(), speed_section()};
    const std::vector<SectionSpec> joints{joint_section(), spring_section(), motor_section()};
    for (const std::vector<SectionSpec>& group : {body_sections(), pattern_sections(), joints, view_sections(),
                                                  overlay_sections(), {study_section()}}) {
        sections.insert(sections.end(), group.begin(), group.end());
    }
    return sections;
}

} // namespace

const KeySpec* SectionSpec::find(std::string_view name) const {
    const auto found = std::ranges::find(keys, name, &KeySpec::name);
    return found == keys.end() ? nullptr : &*found;
}

std::vector<std::string> SectionSpec::key_names() const {
    std::vector<std::string> result;
    for (const KeySpec& key : keys) {
        result.emplace_back(key.name);
    }
    return result;
}

std::span<const SectionSpec> scene_sections() {
    static const std::vector<SectionSpec> sections = all_sections();
    return sections;
}

const SectionSpec& scene_section(std::string_view path) {
    const std::span<const SectionSpec> sections = scene_sections();
    const auto found = std::ranges::find(sections, path, &SectionSpec::path);
    CHECK(found != sections.end());
    return *found;
}

} // namespace sim
