#include "sim/scene/file.h"
#include "tests/support/out_folder.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/keys.h"
#include "sim/scene/tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <set>
#include <sys/stat.h>

using namespace sim;

namespace {

const std::filesystem::path scene_folder = TUMBLE_SCENE_DIR;

/// The message of the error that a scene gives; empty if it gives none.
std::string message_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
    try {
        parse_scene(text, "scene.toml", overrides);
        return "";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::usage) << error.what();
        return error.what();
    }
}

/// One case of bad_scenes.txt.
struct BadScene {
    std::string what;
    std::string text;
    std::vector<std::string> overrides;
    std::string message;
};

std::vector<BadScene> read_bad_scenes() {
    std::vector<BadScene> cases;
    std::ifstream file(std::string(TUMBLE_SOURCE_DIR) + "/tests/sim/bad_scenes.txt");
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("## ")) {
            cases.push_back({line.substr(3), "", {}, ""});
        } else if (cases.empty() || line.empty()) {
            continue;
        } else if (line.starts_with("=> ")) {
            cases.back().message = line.substr(3);
        } else if (line.starts_with("--set ")) {
            cases.back().overrides.push_back(line.substr(6));
        } else {
            cases.back().text += line + "\n";
        }
    }
    return cases;
}

const std::string ball_text = "[[body]]\nname = \"ball\"\nshape = { kind = \"sphere\", radius = 0.5 }\n";

/// The smallest good table of each section: keys with their values.
using Entries = std::vector<std::pair<std::string, std::string>>;
Entries smallest_table(const std::string& path) {
    static const std::map<std::string, Entries> tables{
        {"body", {{"name", "'x'"}, {"shape", "{ kind = 'sphere', radius = 1 }"}}},
        {"shape box", {{"kind", "'box'"}, {"size", "[1, 1, 1]"}}},
        {"shape sphere", {{"kind", "'sphere'"}, {"radius", "1"}}},
        {"shape cylinder", {{"kind", "'cylinder'"}, {"radius", "1"}, {"length", "1"}}},
        {"shape capsule", {{"kind", "'capsule'"}, {"radius", "1"}, {"length", "1"}}},
        {"shape hull", {{"kind", "'hull'"}, {"points", "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]"}}},
        {"shape rock", {{"kind", "'rock'"}, {"size", "[1, 1, 1]"}}},
        {"part cylinder", {{"kind", "'cylinder'"}, {"radius", "1"}, {"length", "1"}}},
        {"part capsule", {{"kind", "'capsule'"}, {"radius", "1"}, {"length", "1"}}},
        {"part hull", {{"kind", "'hull'"}, {"points", "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]"}}},
        {"part rock", {{"kind", "'rock'"}, {"size", "[1, 1, 1]"}}},
        {"shape plane", {{"kind", "'plane'"}}},
        {"shape compound", {{"kind", "'compound'"}, {"parts", "[{ kind = 'sphere', radius = 1 }]"}}},
        {"part box", {{"kind", "'box'"}, {"size", "[1, 1, 1]"}}},
        {"part sphere", {{"kind", "'sphere'"}, {"radius", "1"}}},
        {"lattice",
         {{"name", "'x'"},
          {"count", "[1, 1, 1]"},
          {"spacing", "[1, 1, 1]"},
          {"body", "{ shape = { kind = 'sphere', radius = 1 } }"}}},
        {"lattice.body", {{"shape", "{ kind = 'sphere', radius = 1 }"}}},
        {"funnel",
         {{"name", "'x'"},
          {"mouth", "9"},
          {"mouth_height", "9"},
          {"throat", "1"},
          {"throat_height", "1"},
          {"thickness", "1"}}},
        {"joint",
         {{"name", "'x'"},
          {"kind", "'hinge'"},
          {"bodies", "['ball']"},
          {"anchor", "[0, 0, 1]"},
          {"axis", "[0, 1, 0]"}}},
        {"camera", {{"name", "'x'"}, {"eye", "[1, 2, 3]"}, {"target", "[0, 0, 0]"}}},
        {"plot", {{"quantity", "'distance'"}, {"bodies", "['ball']"}}},
        {"caption", {{"text", "'x'"}}},
        {"output.speed_keys", {{"time", "0"}, {"speed", "1"}}},
        {"lattice.mix", {{"shape", "{ kind = 'sphere', radius = 1 }"}}},
        {"camera.keys", {{"time", "0"}, {"eye", "[1, 2, 3]"}, {"target", "[0, 0, 0]"}}},
        {"body.keys", {{"time", "0"}}},
        {"joint.spring", {{"stiffness", "1"}}},
        {"joint.motor", {{"speed", "1"}, {"limit", "1"}}},
    };
    const auto found = tables.find(path);
    return found == tables.end() ? Entries{} : found->second;
}

/// What some keys need beside them to have an effect, and what they replace.
struct Company {
    Entries with;
    std::set<std::string> without;
};
Company company_of(const std::string& key) {
    static const std::map<std::string, Company> companies{
        {"half_extents", {{}, {"size"}}},
        {"file", {{}, {"points", "parts"}}},
        {"inertia", {{{"mass", "1"}}, {}}},
        {"centre_of_mass", {{{"mass", "1"}, {"inertia", "[1, 1, 1]"}}, {}}},
        {"mu_s", {{{"mu_d", "0.1"}}, {}}},
        {"mu_d", {{{"mu_s", "0.1"}}, {}}},
        {"keys", {{}, {"eye", "target"}}},
        {"period", {{{"kind", "'orbit'"}}, {}}},
        {"color_range", {{{"color_by", "'speed'"}}, {}}},
        {"gate_height", {{{"seed_key", "'lattice.x.seed'"}}, {}}},
    };
    const auto found = companies.find(key);
    return found == companies.end() ? Company{} : found->second;
}

/// A scene with one table of the section, otherwise good, whose `key` has the given value.
std::string scene_with(const std::string& path, const std::string& key, const std::string& value) {
    Company company = company_of(key);
    if (path == "camera" && key == "body") {
        company.with = {{"kind", "'follow'"}};
    }
    if (path == "body" && key == "axis") {
        company.with = {{"keys", "[{ time = 0 }]"}};
    }
    if (path == "camera" && key == "bodies") {
        company.with = {{"kind", "'frame'"}};
    }
    Entries entries = smallest_table(path);
    std::erase_if(entries, [&](const auto& entry) {
        return entry.first == key || company.without.contains(entry.first);
    });
    entries.insert(entries.end(), company.with.begin(), company.with.end());
    entries.emplace_back(key, value);
    const bool is_inline = path.starts_with("shape ") || path.starts_with("part ") || path.ends_with("keys") ||
                           path == "joint.spring" || path == "joint.motor";
    std::string table;
    for (const auto& [name, text] : entries) {
        table += (is_inline && !table.empty() ? ", " : "") + name + " = " + text + (is_inline ? "" : "\n");
    }
    if (path.starts_with("shape ")) {
        return "[[body]]\nname = 'x'\nstatic = true\nshape = { " + table + " }\n";
    }
    if (path.starts_with("part ")) {
        return "[[body]]\nname = 'x'\nshape = { kind = 'compound', parts = [{ " + table + " }] }\n";
    }
    if (path == "camera.keys") {
        return "[[camera]]\nname = 'x'\nkeys = [{ " + table + " }]\n";
    }
    if (path == "joint.spring" || path == "joint.motor") {
        const std::string kind = key == "rest" ? "slider" : "hinge";
        return ball_text + "[[joint]]\nname = 'x'\nkind = '" + kind + "'\nbodies = ['ball']\nanchor = [0, 0, 1]\naxis = [0, 1, 0]\n" +
               path.substr(6) + " = { " + table + " }\n";
    }
    if (path == "body.keys") {
        return ball_text + "keys = [{ " + table + " }]\n";
    }
    if (path == "output.speed_keys") {
        return "[output]\nspeed_keys = [{ " + table + " }]\n";
    }
    if (path == "lattice.mix") {
        return "[[lattice]]\nname = 'x'\ncount = [1, 1, 1]\nspacing = [1, 1, 1]\nbody = { shape = { kind = 'sphere', "
               "radius = 1 } }\n[[lattice.mix]]\n" + table;
    }
    if (path == "lattice.body") {
        return "[[lattice]]\nname = 'x'\ncount = [1, 1, 1]\nspacing = [1, 1, 1]\n[lattice.body]\n" + table;
    }
    const bool is_single = std::set<std::string>{"simulation", "output", "light", "overlay", "study"}.contains(path);
    const std::string header = path.empty() ? "" : is_single ? "[" + path + "]\n" : "[[" + path + "]]\n";
    return (path == "joint" || path == "plot" ? ball_text : "") + header + table;
}

} // namespace

// --- what is wrong ---------------------------------------------------------------------------------------

TEST(scene_file, bad_scenes_give_exactly_their_message) {
    const std::vector<BadScene> cases = read_bad_scenes();
    ASSERT_GE(cases.size(), 60u);
    for (const BadScene& bad : cases) {
        EXPECT_EQ(message_of(bad.text, bad.overrides), bad.message) << bad.what;
        EXPECT_EQ(bad.message.find('\n'), std::string::npos) << bad.what;
    }
}

TEST(scene_file, missing_file_is_an_io_error_with_its_name) {
    try {
        load_scene("no_such_scene.toml");
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        EXPECT_NE(std::string(error.what()).find("no_such_scene.toml"), std::string::npos) << error.what();
    }
}

TEST(scene_file, file_that_is_not_utf8_has_a_place) {
    EXPECT_TRUE(message_of("title = \"\xff\xfe\"\n").starts_with("scene.toml:1:"))
        << message_of("title = \"\xff\xfe\"\n");
}

TEST(scene_file, suggestions_are_near_or_a_list) {
    EXPECT_EQ(suggestion("tolerence", {"time_step", "tolerance"}), "; did you mean 'tolerance'?");
    EXPECT_EQ(suggestion("ab", {"ba"}),
              "; did you mean 'ba'?"); // one swap; two replacements would be too many
    EXPECT_EQ(suggestion("size", {"kind", "radius"}), "; expected one of: kind, radius");
    EXPECT_EQ(suggestion("x", {}), "");
    EXPECT_EQ(suggestion("x", std::vector<std::string>(33, "something")), "");
}

TEST(scene_file, jointed_bodies_may_overlap_and_touching_ones_are_no_overlap) {
    const std::string other = "[[body]]\nname = \"other\"\nshape = { kind = \"sphere\", radius = 0.5 }\n";
    const std::string near = "position = [0.9, 0, 0]\n";
    const std::string joint =
        "[[joint]]\nname = \"j\"\nkind = \"ball\"\nbodies = [\"other\", \"ball\"]\nanchor = [0.5, 0, 0]\n";
    EXPECT_NE(message_of(ball_text + other + near), "");
    EXPECT_EQ(message_of(ball_text + other + near + joint), "");
    EXPECT_EQ(message_of(ball_text + other + "position = [1, 0, 0]\n"), "");
    EXPECT_EQ(message_of(ball_text + other + near, {"simulation.tolerance=0.11"}), "");
    EXPECT_EQ(message_of(ball_text + "static = true\n" + other + near + "static = true\n"), "");
}

// --- hulls from OBJ files --------------------------------------------------------------------------------

const std::string obj_scene = R"([[body]]
name = "Fels ☃"
shape = { kind = "hull", file = "rock.obj" } # of a scanner
position = [0, 0, 2]
)";

/// Writes a scene and its OBJ file into a folder of the test's own, for tests run side by side; and loads it.
SceneDef load_with_obj(const std::string& obj) {
    const std::filesystem::path folder = test::out_folder("obj") /
                                         testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder);
    write_file(folder / "rock.obj", obj);
    write_file(folder / "scene.toml", obj_scene);
    return load_scene(folder / "scene.toml");
}

TEST(scene_file, hull_from_an_obj_file_puts_its_points_into_the_scenes_text) {
    const SceneDef scene = load_with_obj(
        "# a tetrahedron\no rock\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv\t0 1e0 0\nvn 0 0 1\nv 0 0 1\nf 1 2 3\n");
    EXPECT_DOUBLE_EQ(scene.bodies[0].mass.mass, 1000.0 / 6.0);
    EXPECT_NE(scene.text.find(R"({ kind = "hull", points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]] } # of a)"),
              std::string::npos)
        << scene.text;
    // The text alone says the same, as a trajectory needs it.
    const SceneDef again = parse_scene(scene.text, "elsewhere.toml");
    EXPECT_EQ(shape_to_json(again.bodies[0].shape), shape_to_json(scene.bodies[0].shape));
}

TEST(scene_file, the_bytes_of_a_logo_come_into_the_scenes_text) {
    const std::filesystem::path folder = test::out_folder("obj") / "logo";
    std::filesystem::create_directories(folder);
    for (const std::size_t more : {0, 1, 2, 200}) {
        std::string png = "\x89PNG\r\n\x1a\n";
        for (std::size_t i = 0; i < more; ++i) {
            png += static_cast<char>(7 * i);
        }
        write_file(folder / "logo.png", png);
        write_file(folder / "scene.toml", "[overlay]\nlogo = 'logo.png' # ours\n" + ball_text);
        const SceneDef scene = load_scene(folder / "scene.toml");
        EXPECT_EQ(scene.overlay.logo, png);
        EXPECT_NE(scene.text.find("logo = \"data:image/png;base64,iVBORw0KGgo"), std::string::npos) << scene.text;
        EXPECT_EQ(parse_scene(scene.text, "elsewhere.toml").overlay.logo, png);
    }
    write_file(folder / "logo.png", std::string("JPEG"));
    EXPECT_THROW(load_scene(folder / "scene.toml"), Error);
    EXPECT_THROW(parse_scene("[overlay]\nlogo = \"data:image/png;base64,iVBORw0KGgo\"\n" + ball_text, "s.toml"), Error);
}

TEST(scene_file, a_byte_order_mark_hides_no_vertex_of_an_obj_file) {
    const SceneDef scene = load_with_obj("\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n");
    EXPECT_DOUBLE_EQ(scene.bodies[0].mass.mass, 1000.0 / 6.0);
}

TEST(scene_file, a_pipe_for_an_obj_file_is_refused_and_not_waited_for) {
    const std::filesystem::path folder = std::filesystem::path(TUMBLE_OUT_DIR) / "test_obj" / "pipe";
    std::filesystem::create_directories(folder);
    std::filesystem::remove(folder / "rock.obj");
    ASSERT_EQ(mkfifo((folder / "rock.obj").c_str(), 0600), 0);
    try {
        parse_scene(obj_scene, (folder / "scene.toml").string());
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        EXPECT_TRUE(std::string(error.what()).ends_with("rock.obj: not a file")) << error.what();
    }
}

TEST(scene_file, a_name_that_no_folder_may_have_is_refused) {
    const std::string text = "title = \"x\"\n";
    for (const char* file : {"...toml", "..toml", "folder/...toml", "two\nlines.toml", "bell\a.toml", "", "folder/"}) {
        try {
            parse_scene(text, file);
            FAIL() << file;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::usage);
            EXPECT_NE(std::string(error.what()).find("cannot be the name"), std::string::npos) << error.what();
        }
    }
    EXPECT_EQ(parse_scene(text, "folder/Ma\xC3\x9F 'x'.toml").name, "Ma\xC3\x9F 'x'");
}

TEST(scene_file, missing_obj_file_is_an_io_error_with_the_place_of_its_name) {
    try {
        parse_scene(obj_scene, "no_such_folder/scene.toml");
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        EXPECT_STREQ(error.what(), "no_such_folder/scene.toml:3:33: body 'Fels ☃' shape: cannot read "
                                   "no_such_folder/rock.obj: No such file or directory");
    }
}

TEST(scene_file, obj_file_with_a_bad_line_is_refused_with_its_place) {
    const auto message = [](const std::string& obj) -> std::string {
        try {
            load_with_obj(obj);
        } catch (const Error& error) {
            const std::string text = error.what();
            return text.substr(text.rfind("rock.obj"));
        }
        return "";
    };
    EXPECT_EQ(message("v 0 0 0\nv 1 0\n"), "rock.obj:2: v is followed by 2 numbers, expected three");
    EXPECT_EQ(message("v 0 0 0\n\nv 1 x 0\n"), "rock.obj:3: 'x' stands after v, expected a finite number");
    EXPECT_EQ(message("v 0 0 inf\n"), "rock.obj:1: 'inf' stands after v, expected a finite number");
}

TEST(scene_file, groups_of_an_obj_file_are_parts_and_stand_in_the_scenes_text) {
    const std::filesystem::path folder = std::filesystem::path(TUMBLE_OUT_DIR) / "test_obj" / "groups";
    std::filesystem::create_directories(folder);
    const std::string two = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 9 9 9\ng a\nf 1 2 3\nf 1 2 4\n"
                            "o b\nv 3 0 0\nv 4 0 0\nv 3 1 0\nv 3 0 1\nf -4 -3 -2\nf 6//1 7 9/2\n";
    write_file(folder / "two.obj", two);
    const std::string text = "[[body]]\nname = 'pair'\nshape = { kind = \"compound\", file = \"two.obj\" }\n";
    write_file(folder / "scene.toml", text);
    const SceneDef scene = load_scene(folder / "scene.toml");
    ASSERT_EQ(std::get<Compound>(scene.bodies[0].shape).parts.size(), 2u);
    EXPECT_DOUBLE_EQ(scene.bodies[0].mass.mass, 2.0 * 1000.0 / 6.0); // no corner is the unused vertex
    const SceneDef again = parse_scene(scene.text, "elsewhere.toml");
    EXPECT_EQ(shape_to_json(again.bodies[0].shape), shape_to_json(scene.bodies[0].shape));
    write_file(folder / "two.obj", std::string("v 0 0 0\ng a\nf 1 2 3\n"));
    try {
        load_scene(folder / "scene.toml");
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("two.obj:3: '2' stands after f, expected the number of a vertex, 1 to 1"),
                  std::string::npos)
            << error.what();
    }
}

TEST(scene_file, a_lattice_may_be_shaken_and_mixed_the_same_way_for_ever) {
    const std::string lattice = "[[lattice]]\nname = 'x'\ncount = [10, 10, 10]\nspacing = [1, 1, 1]\n"
                                "jitter = [0.1, 0, 0.2]\nbody = { shape = { kind = 'sphere', radius = 0.2 } }\n"
                                "[[lattice.mix]]\nshare = 3\nshape = { kind = 'box', size = [0.2, 0.2, 0.2] }\n";
    const SceneDef scene = parse_scene(lattice, "scene.toml");
    const SceneDef again = parse_scene(lattice, "scene.toml");
    int boxes = 0;
    Vec3 most = Vec3::Zero();
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        boxes += std::holds_alternative<Box>(scene.bodies[i].shape) ? 1 : 0;
        const auto k = static_cast<int>(i);
        const Vec3 place(k % 10, k / 10 % 10, k / 100);
        most = most.cwiseMax((scene.bodies[i].pose.position - place).cwiseAbs());
        EXPECT_EQ(scene.bodies[i].pose.position, again.bodies[i].pose.position);
    }
    EXPECT_NEAR(boxes, 750, 42); // three standard deviations of 1000 draws: 3 sqrt(1000 0.75 0.25) = 41
    EXPECT_LE(most.x(), 0.1);
    EXPECT_GT(most.x(), 0.099);
    EXPECT_EQ(most.y(), 0.0);
    EXPECT_GT(most.z(), 0.199);
}

// --- the key table ---------------------------------------------------------------------------------------

TEST(scene_keys, reference_page_is_that_of_the_parser) {
    const std::string page = scene_key_reference();
    const std::string file = read_text_file(scene_folder / "README.md");
    if (page != file) {
        const std::filesystem::path candidate = std::filesystem::path(TUMBLE_OUT_DIR) / "scene_keys.md";
        std::filesystem::create_directories(candidate.parent_path());
        write_file(candidate, page);
        FAIL() << "scenes/README.md differs from the parser's table; the page it should be is " << candidate;
    }
}

TEST(scene_keys, names_are_unique_within_a_table) {
    for (const SectionSpec& section : scene_sections()) {
        const std::vector<std::string> names = section.key_names();
        EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size()) << section.path;
        for (const KeySpec& key : section.keys) {
            EXPECT_FALSE(key.meaning.empty()) << section.path << " " << key.name;
        }
    }
}

/// A date is wrong for every key, so every key that is read complains of it.
TEST(scene_keys, every_key_of_the_reference_is_read) {
    for (const SectionSpec& section : scene_sections()) {
        for (const KeySpec& key : section.keys) {
            const std::string name(key.name);
            const std::string text = scene_with(std::string(section.path), name, "1979-05-27");
            const std::string message = message_of(text);
            EXPECT_NE(message.find(name + " is a date or time, expected " + describe_expected(key)),
                      std::string::npos)
                << text << message;
        }
    }
}

TEST(scene_keys, given_defaults_are_accepted) {
    for (const SectionSpec& section : scene_sections()) {
        for (const KeySpec& key : section.keys) {
            if (!key.default_text.empty() && key.default_text != required_key) {
                const std::string name(key.name);
                EXPECT_EQ(
                    message_of(scene_with(std::string(section.path), name, std::string(key.default_text))),
                    "")
                    << section.path << " " << name;
            }
        }
    }
}

TEST(scene_file, defaults_are_those_of_the_structs) {
    const SceneDef scene = parse_scene("", "empty.toml");
    const StepSettings step;
    EXPECT_EQ(scene.name, "empty");
    EXPECT_EQ(scene.step.time_step, step.time_step);
    EXPECT_EQ(scene.step.gravity, step.gravity);
    EXPECT_EQ(scene.step.tolerance, step.tolerance);
    EXPECT_EQ(scene.step.joint_tolerance, step.joint_tolerance);
    EXPECT_EQ(scene.step.velocity_tolerance, step.velocity_tolerance);
    EXPECT_EQ(scene.step.resting_distance, step.resting_distance);
    EXPECT_EQ(scene.step.resting_speed_floor, step.resting_speed_floor);
    EXPECT_EQ(scene.step.iteration_limit, step.iteration_limit);
    EXPECT_EQ(scene.step.impacts, step.impacts);
    EXPECT_EQ(scene.step.warm_start, step.warm_start);
    const OutputDef output;
    EXPECT_EQ(scene.output.width, output.width);
    EXPECT_EQ(scene.output.height, output.height);
    EXPECT_EQ(scene.output.smooth_edges, output.smooth_edges);
    EXPECT_EQ(scene.output.shadow_size, output.shadow_size);
    EXPECT_EQ(scene.output.crf, output.crf);
    EXPECT_EQ(scene.output.effort, output.effort);
    EXPECT_EQ(scene.output.shutter, output.shutter);
    EXPECT_EQ(scene.output.subframes, output.subframes);
    EXPECT_EQ(scene.output.fps, output.fps);
    EXPECT_EQ(scene.output.duration, output.duration);
    EXPECT_EQ(scene.output.record_every, output.record_every);
    const LightDef light;
    EXPECT_LE((scene.light.to_sun - light.to_sun.normalized()).norm(), 1e-15);
    EXPECT_EQ(scene.light.sun_color, light.sun_color);
    EXPECT_EQ(scene.light.sun_intensity, light.sun_intensity);
    EXPECT_EQ(scene.light.sky_zenith, light.sky_zenith);
    EXPECT_EQ(scene.light.sky_horizon, light.sky_horizon);
    EXPECT_EQ(scene.light.sky_intensity, light.sky_intensity);
    ASSERT_EQ(scene.cameras.size(), 1u);
    ASSERT_EQ(scene.cameras[0].keys.size(), 1u);

    const SceneDef one = parse_scene(ball_text, "one.toml");
    const LookDef look;
    ASSERT_EQ(one.bodies.size(), 1u);
    EXPECT_EQ(one.bodies[0].look.color, look.color);
    EXPECT_EQ(one.bodies[0].look.pattern_color, look.pattern_color);
    EXPECT_EQ(one.bodies[0].look.pattern, look.pattern);
    EXPECT_EQ(one.bodies[0].look.roughness, look.roughness);
    EXPECT_EQ(one.bodies[0].look.metallic, look.metallic);
    EXPECT_EQ(one.bodies[0].look.visible, look.visible);
    EXPECT_FALSE(one.bodies[0].material.restitution || one.bodies[0].material.mu_s ||
                 one.bodies[0].material.mu_d);
    EXPECT_DOUBLE_EQ(one.bodies[0].mass.mass, 1000.0 * std::numbers::pi / 6);
}

TEST(scene_file, presets_give_what_a_scene_leaves_out) {
    const SceneDef draft = parse_scene("[output]\npreset = \"draft\"\ncrf = 30\n", "draft.toml");
    EXPECT_FALSE(draft.output.smooth_edges);
    EXPECT_FALSE(draft.output.soft_shadows);
    EXPECT_FALSE(draft.output.ambient_occlusion);
    EXPECT_EQ(draft.output.width, 1280);
    EXPECT_EQ(draft.output.shadow_size, 512);
    EXPECT_EQ(draft.output.crf, 30);
    EXPECT_EQ(draft.output.effort, "ultrafast");
    const std::vector<std::string> overrides{"output.preset=\"final\"", "output.height=720"};
    const SceneDef last =
        parse_scene("[output]\neffort = \"slow\"\nsmooth_edges = false\n", "last.toml", overrides);
    EXPECT_FALSE(last.output.smooth_edges);
    EXPECT_EQ(last.output.width, 1920);
    EXPECT_EQ(last.output.height, 720);
    EXPECT_EQ(last.output.shadow_size, 2048);
    EXPECT_EQ(last.output.crf, 16);
    EXPECT_EQ(last.output.effort, "slow");
}

TEST(scene_file, a_plane_without_colours_is_dark) {
    const SceneDef scene =
        parse_scene("[[body]]\nname = \"floor\"\nstatic = true\nshape = { kind = \"plane\" }\n"
                    "[[body]]\nname = \"wall\"\nstatic = true\nshape = { kind = \"plane\" }\n"
                    "color = [1, 1, 1]\neuler_degrees = [90, 0, 0]\n",
                    "planes.toml");
    EXPECT_EQ(scene.bodies[0].look.color, floor_color);
    EXPECT_EQ(scene.bodies[0].look.pattern_color, floor_line_color);
    EXPECT_EQ(scene.bodies[1].look.color, Vec3(1, 1, 1));
}

// --- what is right ---------------------------------------------------------------------------------------

TEST(scene_file, times_are_exact) {
    const SceneDef scene = parse_scene(
        "[simulation]\ntime_step = \"1/240\"\n[output]\nfps = \"24000/1001\"\nduration = 0.5\n", "s.toml");
    EXPECT_EQ(scene.step.time_step, (Rational{1, 240}));
    EXPECT_EQ(scene.output.fps, (Rational{24000, 1001}));
    EXPECT_EQ(scene.output.duration, (Rational{1, 2}));
}

TEST(scene_file, body_frame_has_its_origin_in_the_centre_of_mass) {
    const SceneDef scene = parse_scene(R"([[body]]
name = "top"
shape = { kind = "sphere", radius = 2 }
mass = 3
centre_of_mass = [0, 0, -0.5]
inertia = [1, 2, 2.5, 0.1, 0.2, 0.3]
position = [10, 20, 30]
euler_degrees = [90, 0, 0]
velocity = [1, 2, 3]
angular_velocity = [4, 5, 6]
lathe = [[0, -2], [2, 0], [0, 2]]
)",
                                       "s.toml");
    const BodyDef& body = scene.bodies.at(0);
    EXPECT_EQ(body.mass.centre_of_mass, Vec3::Zero());
    EXPECT_EQ(body.mass.mass, 3.0);
    EXPECT_EQ(body.mass.inertia(1, 1), 2.0);
    EXPECT_EQ(body.mass.inertia(0, 1), 0.1);
    EXPECT_EQ(body.mass.inertia(2, 0), 0.2);
    EXPECT_EQ(body.mass.inertia(1, 2), 0.3);
    // Turned by 90 degrees about x, -z of the body is +y of the world.
    EXPECT_LE((body.pose.position - Vec3(10, 20.5, 30)).norm(), 1e-14);
    EXPECT_EQ(body.velocity, Vec3(1, 2, 3));
    EXPECT_EQ(body.angular_velocity, Vec3(4, 5, 6));
    // The sphere is where it was.
    const Compound& compound = std::get<Compound>(body.shape);
    EXPECT_EQ(compound.parts.at(0).body_from_part.position, Vec3(0, 0, 0.5));
    EXPECT_LE((body.pose * Vec3(0, 0, 0.5) - Vec3(10, 20, 30)).norm(), 1e-14);
    EXPECT_EQ(body.look.lathe.at(0), Eigen::Vector2d(0, -1.5));
    EXPECT_EQ(body.look.lathe.at(2), Eigen::Vector2d(0, 2.5));
}

TEST(scene_file, what_is_drawn_stays_where_the_shape_is) {
    const SceneDef scene = parse_scene(R"([[body]]
name = "chair"
shape = { kind = "box", size = [1, 1, 1] }
mass = 3
centre_of_mass = [0, 0, -0.5]
inertia = [1, 1, 1]
drawn = { kind = "cylinder", radius = 1, length = 2 }
)", "s.toml");
    EXPECT_EQ(std::get<Compound>(scene.bodies.at(0).shape).parts.at(0).body_from_part.position, Vec3(0, 0, 0.5));
    EXPECT_EQ(std::get<Compound>(*scene.bodies.at(0).drawn).parts.at(0).body_from_part.position, Vec3(0, 0, 0.5));
}

TEST(scene_file, orientations_agree_in_all_three_ways) {
    const auto orientation = [](const std::string& line) {
        return parse_scene(ball_text + line, "s.toml").bodies.at(0).pose.orientation;
    };
    const double c = std::cos(std::numbers::pi / 12);
    const double s = std::sin(std::numbers::pi / 12);
    const Quat expected(c, 0, s, 0);
    EXPECT_LE(orientation("euler_degrees = [0, 30, 0]\n").angularDistance(expected), 1e-15);
    EXPECT_LE(orientation("axis_angle_degrees = [0, 5, 0, 30]\n").angularDistance(expected), 1e-15);
    // Six digits are mended to unit length.
    const Quat rounded = orientation("orientation = [0.965926, 0, 0.258819, 0]\n");
    EXPECT_LE(rounded.angularDistance(expected), 1e-5);
    EXPECT_NEAR(rounded.norm(), 1.0, 1e-15);
    // x first, then y: the body's z axis goes to -y and stays there.
    const Quat both = orientation("euler_degrees = [90, 90, 0]\n");
    EXPECT_LE((both * Vec3::UnitZ() - Vec3(0, -1, 0)).norm(), 1e-15);
    EXPECT_LE((both * Vec3::UnitY() - Vec3(1, 0, 0)).norm(), 1e-15);
    // z last: the body's x axis goes to -z by y and stays there; its y axis goes to -x.
    const Quat last = orientation("euler_degrees = [0, 90, 90]\n");
    EXPECT_LE((last * Vec3::UnitX() - Vec3(0, 0, -1)).norm(), 1e-15);
    EXPECT_LE((last * Vec3::UnitY() - Vec3(-1, 0, 0)).norm(), 1e-15);
}

TEST(scene_file, mass_and_density_give_the_same_homogeneous_body) {
    const SceneDef by_density = parse_scene(ball_text + "density = 6\n", "s.toml");
    const SceneDef by_mass = parse_scene(ball_text + "mass = 3.14159265358979312\n", "s.toml");
    EXPECT_NEAR(by_density.bodies[0].mass.mass, std::numbers::pi, 1e-14);
    EXPECT_NEAR(by_mass.bodies[0].mass.mass, std::numbers::pi, 1e-14);
    EXPECT_LE((by_density.bodies[0].mass.inertia - by_mass.bodies[0].mass.inertia).norm(), 1e-14);
    EXPECT_TRUE(std::holds_alternative<Sphere>(by_mass.bodies[0].shape));
}

TEST(scene_file, srgb_texts_become_linear_light) {
    const SceneDef scene = parse_scene(ball_text + "color = \"#ff8000\"\n", "s.toml");
    EXPECT_EQ(scene.bodies[0].look.color.x(), 1.0);
    EXPECT_NEAR(scene.bodies[0].look.color.y(), 0.2158605, 1e-7); // IEC 61966-2-1 of 128 / 255
    EXPECT_EQ(scene.bodies[0].look.color.z(), 0.0);
}

TEST(scene_file, overrides_reach_every_kind_of_place) {
    const std::string text = ball_text + "velocity = [1, 2, 3]\n";
    const std::vector<std::string> overrides{"simulation.tolerance=1e-6",  "simulation.impacts=stop",
                                             "simulation.time_step=1/500", "body.ball.velocity.1 = -7",
                                             "body.0.shape.radius=0.25",   "body.ball.color=#ffffff",
                                             "body.'ball'.friction=0.3",   "light.sun_intensity=2",
                                             "title=\"with spaces\"",      "simulation.tolerance=1e-7"};
    const SceneDef scene = parse_scene(text, "s.toml", overrides);
    EXPECT_EQ(scene.step.tolerance, 1e-7);
    EXPECT_EQ(scene.step.impacts, ImpactHandling::stop);
    EXPECT_EQ(scene.step.time_step, (Rational{1, 500}));
    EXPECT_EQ(scene.bodies[0].velocity, Vec3(1, -7, 3));
    EXPECT_EQ(std::get<Sphere>(scene.bodies[0].shape).radius, 0.25);
    EXPECT_EQ(scene.bodies[0].look.color, Vec3(1, 1, 1));
    EXPECT_EQ(scene.bodies[0].material.mu_d, 0.3);
    EXPECT_EQ(scene.light.sun_intensity, 2.0);
    EXPECT_EQ(scene.title, "with spaces");
    EXPECT_EQ(scene.text, text);
    EXPECT_EQ(scene.overrides, overrides);
}

TEST(scene_file, joints_to_the_world_have_no_second_body) {
    const SceneDef scene = parse_scene(ball_text + R"(
[[joint]]
name = "one"
kind = "ball"
bodies = ["ball"]
anchor = [0, 0, 1]
[[joint]]
name = "two"
kind = "hinge"
bodies = ["world", "ball"]
anchor = [0, 0, 1]
axis = [0, 2, 0]
)",
                                       "s.toml");
    ASSERT_EQ(scene.joints.size(), 2u);
    for (const JointDef& joint : scene.joints) {
        EXPECT_EQ(joint.body_a, 0);
        EXPECT_EQ(joint.body_b, -1);
    }
    EXPECT_EQ(scene.joints[1].axis, Vec3(0, 1, 0));
}

TEST(scene_file, names_may_have_spaces_and_any_letters) {
    const SceneDef scene =
        parse_scene("[[body]]\nname = \"Bällchen nr. 1 ☃\"\nshape = { kind = \"plane\" }\nstatic = true\n",
                    "scenes/ein film.toml");
    EXPECT_EQ(scene.bodies[0].name, "Bällchen nr. 1 ☃");
    EXPECT_EQ(scene.name, "ein film");
}

TEST(scene_file, scene_without_a_camera_has_all_bodies_in_view) {
    const SceneDef scene = parse_scene(ball_text + "position = [100, 0, 7]\n", "s.toml");
    ASSERT_EQ(scene.cameras.size(), 1u);
    const CameraKey& key = scene.cameras[0].keys.at(0);
    EXPECT_LE((key.target - Vec3(100, 0, 7)).norm(), 1e-12);
    // The ball's radius is 0.5; the camera opens by 40 degrees.
    const double distance = (key.eye - key.target).norm();
    EXPECT_GT(std::sin(20 * std::numbers::pi / 180) * distance, 0.5);
    EXPECT_LT(distance, 5.0);
}

TEST(scene_file, scene_without_a_camera_has_what_keys_move_in_view) {
    const SceneDef scene = parse_scene(ball_text + "keys = [{ time = 0 }, { time = 1, position = [0, 0, 9], easing = \"stop\" }, "
                                                   "{ time = 2, position = [0, 8, 0] }]\n",
                                       "s.toml");
    const CameraKey& key = scene.cameras[0].keys.at(0);
    const Vec3 ahead = (key.target - key.eye).normalized();
    for (const Vec3& at : {Vec3(0, 0, 0), Vec3(0, 0, 9), Vec3(0, 4, 4.5), Vec3(0, 8, 0)}) {
        const Vec3 seen = at - key.eye;
        EXPECT_LE(std::acos(ahead.dot(seen.normalized())) + std::asin(0.5 / seen.norm()), 20 * std::numbers::pi / 180) << at;
    }
}
