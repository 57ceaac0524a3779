/// Stacks at the default settings: what they cost depends neither on masses nor on the accuracy asked for.
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace {

using namespace laws;

/// Ten cubes with offsets of some centimetres; ratio: by which the topmost is heavier.
sim::SceneDef stack(double ratio) {
    constexpr int count = 10;
    sim::SceneDef scene;
    scene.name = "law";
    const sim::MaterialDef surface = material(0.0, 0.5);
    add_plane(scene, Quat::Identity(), surface);
    for (int i = 0; i < count; ++i) {
        const Vec3 at(0.04 * std::sin(2.0 * i), 0.04 * std::cos(3.0 * i), 0.5 + i);
        add_box(scene, Vec3::Constant(0.5), {at, Quat::Identity()}, surface, i + 1 == count ? 1000.0 * ratio : 1000.0);
    }
    return scene;
}

double fastest_speed(const sim::Snapshot& snapshot) { // [m/s]
    double speed = 0.0;
    for (const sim::BodySnapshot& body : snapshot.bodies) {
        speed = std::max(speed, body.velocity.norm());
    }
    return speed;
}

struct Cost {
    int steps = 0;
    int sweeps = 0;
    int unconverged = 0; ///< steps
    double speed = 0.0;  ///< [m/s] at the end, largest

    double sweeps_per_step() const { return static_cast<double>(sweeps) / steps; }
};

Cost cost_of(const sim::SceneDef& scene) {
    Cost cost;
    sim::World world(scene);
    run(world, scene, 0.3, [&](const sim::Snapshot& snapshot, const sim::StepReport& report) {
        ++cost.steps;
        cost.sweeps += report.contact_iterations + report.collision_iterations;
        cost.unconverged += report.at_iteration_limit ? 1 : 0;
        cost.speed = fastest_speed(snapshot);
        return true;
    });
    return cost;
}

TEST(law_stack, under_ten_thousand_times_its_mass_needs_no_more_sweeps) {
    const Cost equal = cost_of(stack(1.0));
    for (const double ratio : {1e2, 1e4}) {
        const Cost cost = cost_of(stack(ratio));
        record({fmt::format("stack of ten, {:g} : 1 on top", ratio), "sweeps, times those of 1 : 1", 1e-3,
                static_cast<double>(cost.sweeps) / equal.sweeps, 2.0});
        EXPECT_LE(cost.sweeps, 2 * equal.sweeps) << ratio;
        EXPECT_EQ(cost.unconverged, 0) << ratio;
        EXPECT_LE(cost.speed, 1e-4) << ratio;
    }
}

/// A long step's sweeps leave gaps beyond those at which an impact stops it. A contact that bears a load waits for none: its bodies
/// would be told the half of their weight's impulse that they are owed.
TEST(law_stack, a_tower_stands_where_steps_stop_at_impacts) {
    sim::SceneDef scene = stack(1.0);
    scene.step.impacts = sim::ImpactHandling::stop;
    scene.step.velocity_tolerance = 3e-5;
    for (const int rate : {60, 75, 100, 240}) {
        scene.step.time_step = sim::make_rational(1, rate);
        sim::World world(scene);
        int stops = 0;
        double speed = 0.0;
        run(world, scene, 1.0, [&](const sim::Snapshot& snapshot, const sim::StepReport& report) {
            stops += report.impacts_stopped_at;
            speed = std::max(speed, fastest_speed(snapshot));
            return true;
        });
        record({"stack of ten, impacts stopped at", "speed [m/s]", 1.0 / rate, speed, 1e-4});
        EXPECT_LE(speed, 1e-4) << rate;
        EXPECT_EQ(stops, 0) << rate;
    }
}

TEST(law_stack, solved_to_1e_10_metres_a_second_costs_little_more_than_to_1e_4) {
    sim::SceneDef scene = stack(1.0);
    scene.step.velocity_tolerance = 1e-4;
    const Cost rough = cost_of(scene);
    scene.step.velocity_tolerance = 1e-10;
    const Cost fine = cost_of(scene);
    constexpr double most = 8.0; // sweeps a step
    for (const auto& [name, cost] : {std::pair{"1e-4", rough}, std::pair{"1e-10", fine}}) {
        record({"stack of ten", fmt::format("sweeps a step to {} m/s", name), 1e-3, cost.sweeps_per_step(), most});
        EXPECT_LE(cost.sweeps_per_step(), most) << name;
        EXPECT_EQ(cost.unconverged, 0) << name;
    }
    EXPECT_LE(fine.speed, 1e-6);
}

/// Layers of three wooden blocks side by side, crosswise: which of three blocks carries is for rounding to tell, and load may move
/// from one to another from step to step, but no block may.
sim::SceneDef wooden_tower(int layers, double gap = 1e-4) { // [m] between neighbours
    const Vec3 half(0.0125, 0.0375, 0.0075); // [m]
    sim::SceneDef scene;
    scene.name = "law";
    const sim::MaterialDef surface = material(0.1, 0.4);
    add_plane(scene, Quat::Identity(), surface);
    for (int layer = 0; layer < layers; ++layer) {
        const Quat turn(Eigen::AngleAxisd(layer % 2 == 0 ? 0.0 : 0.5 * std::numbers::pi, Vec3::UnitZ()));
        for (int i = -1; i <= 1; ++i) {
            const Vec3 at((2.0 * half.x() + gap) * i, 0.0, (2 * layer + 1) * half.z());
            add_box(scene, half, {turn * at, turn}, surface, 600.0);
        }
    }
    return scene;
}

void judge_rest(const sim::SceneDef& scene, const std::string& name, double fastest) {
    const double h = scene.step.time_step.value();
    const Cost cost = cost_of(scene);
    constexpr double most = 4.0;
    record({name, "sweeps a step", h, cost.sweeps_per_step(), most});
    record({name, "fastest [m/s]", h, cost.speed, fastest});
    EXPECT_LE(cost.sweeps_per_step(), most) << name;
    EXPECT_LE(cost.speed, fastest) << name;
    EXPECT_EQ(cost.unconverged, 0) << name;
}

TEST(law_stack, a_tower_of_54_wooden_blocks_stands_still_at_any_velocity_tolerance) {
    const std::pair<int, double> settings[] = {{1000, 1e-7}, {1000, 1e-5}, {1000, 1e-4}, {1000, 1e-3},
                                               {500, 1e-5},  {500, 1e-3},  {250, 1e-5}};
    for (const auto& [rate, tolerance] : settings) {
        sim::SceneDef scene = wooden_tower(18);
        scene.step.time_step = {1, rate};
        scene.step.velocity_tolerance = tolerance;
        judge_rest(scene, fmt::format("tower of 54 wooden blocks, 1/{} s, {:g} m/s", rate, tolerance), 1e-5);
    }
}

/// Neighbours touch with next to no load: where they would pull, they leave the active set.
TEST(law_stack, towers_of_up_to_126_wooden_blocks_stand_still_at_the_default_settings) {
    for (const auto& [layers, gap] :
         {std::pair(24, 1e-4), {30, 1e-4}, {36, 1e-4}, {22, 5e-5}, {30, 5e-5}, {42, 5e-5}, {26, 2e-4}}) {
        judge_rest(wooden_tower(layers, gap), fmt::format("tower of {} wooden blocks {:g} m apart", 3 * layers, gap), 1e-5);
    }
}

/// What stands shakes nowhere, and gains no energy; from 0.3 s on no faster than `fastest` [m/s], with at most `sweeps` a step.
void judge_standing(const sim::SceneDef& scene, const std::string& name, double fastest, double sweeps = 4.0) {
    sim::World world(scene);
    double gain = 0.0, speed = 0.0;
    int steps = 0, swept = 0;
    run(world, scene, 1.0, [&](const sim::Snapshot& snapshot, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        if (snapshot.time > 0.3) {
            speed = std::max(speed, fastest_speed(snapshot));
            swept += report.contact_iterations;
            ++steps;
        }
        EXPECT_FALSE(report.at_iteration_limit) << name;
        return true;
    });
    const double h = scene.step.time_step.value();
    record({name, "fastest [m/s]", h, speed, fastest});
    record({name, "energy gained, relative", h, gain, sim::energy_gain_allowed});
    record({name, "sweeps a step at rest", h, static_cast<double>(swept) / steps, sweeps});
    EXPECT_LE(speed, fastest) << name;
    EXPECT_LE(swept, sweeps * steps) << name;
    EXPECT_LE(gain, sim::energy_gain_allowed) << name;
}

/// The taller a tower, the softer it bends, with the fourth power of its height. What a step that was swept on takes away of the
/// velocities that steps before have left is a force too much in the next one.
TEST(law_stack, towers_of_boxes_turned_any_way_are_swept_once_a_step) {
    for (const auto& [count, aside] : {std::pair(12, 0.01), {30, 0.01}, {40, 0.02}, {80, 0.01}, {150, 0.003}, {250, 0.002}}) {
        sim::SceneDef scene;
        scene.name = "law";
        const sim::MaterialDef surface = material(0.0, 0.5);
        add_plane(scene, Quat::Identity(), surface);
        double top = 0.0; // [m]
        for (int i = 0; i < count; ++i) {
            const Vec3 half(0.05, 0.05, 0.0375 + 0.0125 * std::sin(5.0 * i));
            const Vec3 at(aside * std::sin(2.0 * i), aside * std::cos(3.0 * i), top + half.z());
            add_box(scene, half, {at, Quat(Eigen::AngleAxisd(1.1 * i, Vec3::UnitZ()))}, surface);
            top += 2.0 * half.z();
        }
        judge_standing(scene, fmt::format("tower of {} boxes turned any way", count), 1e-5, 1.5);
    }
}

/// Their upper faces too would be on the ground as a step ends, did they fall freely. They do not, and nothing strikes them.
TEST(law_stack, plates_thinner_than_a_step_falls_rest) {
    sim::SceneDef scene;
    scene.name = "law";
    scene.step.time_step = {1, 60};
    const sim::MaterialDef surface = material(0.0, 0.5);
    add_plane(scene, Quat::Identity(), surface);
    const Vec3 half(0.05, 0.05, 0.0005);
    for (int i = 0; i < 4; ++i) {
        add_box(scene, half, {Vec3(0.0, 0.0, (2 * i + 1) * half.z()), Quat::Identity()}, surface);
    }
    judge_standing(scene, "four plates of 1 mm, steps of 1/60 s", 1e-6, 1.5);
}

/// Of bricks without mortar. What sweeps leave is little, and a factorisation costs as much as many steps' sweeps.
TEST(law_stack, walls_rest) {
    for (const auto& [columns, rows, aside] : {std::tuple(8, 8, 0.0), {10, 16, 0.0}, {10, 16, 0.002}, {6, 30, 0.001}}) {
        sim::SceneDef scene;
        scene.name = "law";
        const sim::MaterialDef surface = material(0.0, 0.6);
        add_plane(scene, Quat::Identity(), surface);
        const Vec3 half(0.1, 0.05, 0.04);
        for (int row = 0; row < rows; ++row) {
            for (int i = 0; i < columns - row % 2; ++i) {
                const Vec3 place(0.204 * (i + 0.5 * (row % 2)), 0.0, (2 * row + 1) * half.z());
                const Vec3 off(aside * std::sin(7.0 * i + 3.0 * row), aside * std::cos(5.0 * i + 2.0 * row), 0.0);
                add_box(scene, half, {place + off, Quat::Identity()}, surface);
            }
        }
        judge_standing(scene, fmt::format("wall of {} rows of {} bricks, {:g} m aside", rows, columns, aside), 1e-5);
    }
}

/// Each brick over the one below by four fifths of what the whole would fall at. Sweeps come to their end slowly: where that counts as
/// stalled, and their last changes as small enough, the stack falls.
TEST(law_stack, bricks_that_lean_stand) {
    constexpr int count = 30;
    const Vec3 half(0.1, 0.05, 0.03); // [m]
    sim::SceneDef scene;
    scene.name = "law";
    const sim::MaterialDef surface = material(0.0, 0.6);
    add_plane(scene, Quat::Identity(), surface);
    for (int i = 0; i < count; ++i) {
        const double farthest = 2.0 * half.x() / count; // [m] the centre of all above the lowest is over its edge then
        const Vec3 at(0.8 * farthest * i, 0.0, (2 * i + 1) * half.z());
        add_box(scene, half, {at, Quat::Identity()}, surface, 1800.0);
    }
    judge_standing(scene, "thirty bricks that lean", 1e-3);
}

/// On rims that touch at up to eight points, of which few can carry.
TEST(law_stack, cylinders_that_lean_stand) {
    sim::SceneDef scene;
    scene.name = "law";
    const sim::MaterialDef surface = material(0.0, 0.4);
    add_plane(scene, Quat::Identity(), surface);
    for (int i = 0; i < 10; ++i) {
        add_cylinder(scene, sim::Cylinder{0.1, 0.06}, {Vec3(0.0108 * i, 0.0, 0.06 + 0.12 * i), Quat::Identity()}, surface);
    }
    judge_standing(scene, "ten cylinders that lean", 1e-4);
}

/// Each on up to sixteen corners of which a block holds eight: were they others in every step, the stacks would shake and climb.
TEST(law_stack, cylinders_turned_any_way_stand) {
    for (const auto& [count, cylinder, aside] : {std::tuple(24, sim::Cylinder{0.05, 0.0035}, 0.0075), {16, sim::Cylinder{0.2, 0.06}, 0.04}}) {
        sim::SceneDef scene;
        scene.name = "law";
        const sim::MaterialDef surface = material(0.0, 0.5);
        add_plane(scene, Quat::Identity(), surface);
        for (int i = 0; i < count; ++i) {
            const Vec3 at(aside * std::sin(2.0 * i), aside * std::cos(3.0 * i), cylinder.half_length * (2 * i + 1));
            add_cylinder(scene, cylinder, {at, Quat(Eigen::AngleAxisd(0.6 * i, Vec3::UnitZ()))}, surface);
        }
        judge_standing(scene, fmt::format("{} cylinders turned any way", count), 1e-5);
    }
}

/// Compounds on a floor, as a scene file has them. parts: of each; places: the lines that put one there.
sim::SceneDef bodies_of_parts(const std::string& parts, std::span<const std::string> places, double mu, double density) {
    std::string text = fmt::format("[[body]]\nname = \"floor\"\nshape = {{ kind = \"plane\" }}\nstatic = true\nfriction = {}\n", mu);
    for (std::size_t i = 0; i < places.size(); ++i) {
        text += fmt::format("[[body]]\nname = \"b{}\"\nshape = {{ kind = \"compound\", parts = [{}] }}\n{}\ndensity = {}\nfriction = {}\n", i,
                            parts, places[i], density, mu);
    }
    return sim::parse_scene(text, "law.toml");
}

/// Of two boxes side by side. Each is turned by `turn` [degrees] against the one below, and carries it at up to four pairs of faces.
sim::SceneDef slabs(int count, double turn, double mu) {
    std::vector<std::string> places;
    for (int i = 0; i < count; ++i) {
        places.push_back(fmt::format("position = [{}, {}, {}]\neuler_degrees = [0.0, 0.0, {}]", i % 2 == 0 ? 0.001 : -0.001, 0.0005 * i,
                                     0.025 + 0.05 * i, turn * i));
    }
    return bodies_of_parts(R"({ kind = "box", size = [0.15, 0.3, 0.05], position = [-0.075, 0, 0] },
                              { kind = "box", size = [0.15, 0.3, 0.05], position = [0.075, 0, 0] })",
                           places, mu, 700.0);
}

/// Frusta of three to eight sides, each half a millimetre above the one below. Of faces with other normals that a pair is held by, each
/// asks for its own motion.
sim::SceneDef frusta(double aside) {
    std::string text = "[[body]]\nname = \"floor\"\nshape = { kind = \"plane\" }\nstatic = true\nfriction = 0.5\n";
    double top = 0.0; // [m]
    for (int i = 0; i < 10; ++i) {
        const int sides = 3 + i * i % 6;
        const double radius = 0.05, narrowing = 1.0 + 0.2 * std::sin(3.0 * i), half = 0.0225 + 0.0075 * std::cos(2.0 * i);
        std::string points;
        for (int k = 0; k < sides; ++k) {
            const double x = radius * std::cos(2.0 * std::numbers::pi * k / sides), y = radius * std::sin(2.0 * std::numbers::pi * k / sides);
            points += fmt::format("[{}, {}, {}], [{}, {}, {}], ", x, y, -half, narrowing * x, narrowing * y, half);
        }
        top += 0.0005 + half;
        text += fmt::format("[[body]]\nname = \"b{}\"\nshape = {{ kind = \"hull\", points = [{}] }}\nfriction = 0.5\n", i, points);
        text += fmt::format("position = [{}, {}, {}]\neuler_degrees = [0.0, 0.0, {}]\n", aside * std::sin(2.0 * i), aside * std::cos(3.0 * i),
                            top, 63.0 * i);
        top += half;
    }
    return sim::parse_scene(text, "law.toml");
}

/// Of a bottom and eight plates. It falls into another one, `aside` [m] from its middle.
sim::SceneDef cup_in_cup(double aside) {
    std::string parts = "{ kind = \"cylinder\", radius = 0.025, length = 0.004, position = [0, 0, 0.002] }";
    for (int i = 0; i < 8; ++i) {
        std::string points;
        for (const double side : {-0.5, 0.5}) {
            const double angle = std::numbers::pi / 4.0 * (i + side);
            for (const auto& [radius, height] : {std::pair(0.0271, 0.0), {0.0292, 0.0}, {0.0379, 0.09}, {0.04, 0.09}}) {
                points += fmt::format("[{}, {}, {}], ", radius * std::cos(angle), radius * std::sin(angle), height);
            }
        }
        parts += fmt::format(", {{ kind = \"hull\", points = [{}] }}", points);
    }
    const std::string places[] = {"position = [0.0, 0.0, 0.002]", fmt::format("position = [{}, 0.0, 0.062]", aside)};
    return bodies_of_parts(parts, places, 0.3, 250.0);
}

/// Rigid bodies that are held at more places than they need: the equations of all loaded contacts have no solution, or many, and a
/// step of Newton's method may load bodies without end. It is taken back then, and no sweep goes on in its direction.
TEST(law_stack, what_is_held_at_more_places_than_it_needs_stands) {
    for (const auto& [count, turn, mu] :
         {std::tuple(12, 1.0, 0.4), {12, 1.0, 0.2}, {12, 1.3, 0.4}, {16, 3.0, 0.4}, {18, 2.0, 0.6}, {20, 1.0, 0.4}}) {
        judge_standing(slabs(count, turn, mu), fmt::format("{} slabs turned by {:g} degrees, mu {:g}", count, turn, mu), 1e-4);
    }
    for (const double aside : {0.0, 0.003, 0.006, 0.008}) {
        judge_standing(frusta(aside), fmt::format("ten frusta {:g} m aside", aside), 1e-5, 2.0);
    }
    for (const double aside : {0.0005, 0.001, 0.002}) {
        judge_standing(cup_in_cup(aside), fmt::format("a cup {:g} m aside in a cup", aside), 1e-4);
    }
}

} // namespace
