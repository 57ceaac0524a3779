#include "sim/base/error.h"
#include "sim/scene/file.h"
#include "sim/world/state.h"
#include "sim/world/world.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace sim;

namespace {

/// Cubes in rows of `side`, each turned a little, that fall on a floor and into each other.
SceneDef heap_of_cubes(int side) {
    return parse_scene(fmt::format(R"(
[simulation]
time_step = "1/500"
[[body]]
name = "floor"
shape = {{ kind = "plane" }}
static = true
[[lattice]]
name = "cube"
count = [{0}, {0}, {0}]
spacing = [1.3, 1.3, 1.3]
origin = [0, 0, 0.9]
turn_max_degrees = 10
seed = 3
[lattice.body]
shape = {{ kind = "box", size = [1, 1, 1] }}
density = 1000
friction = 0.4
restitution = 0.3
)", side),
                       "heap.toml");
}

/// Cubes of 1 m on a floor.
SceneDef cubes(const std::string& count, const std::string& spacing, const std::string& gravity) {
    return parse_scene(fmt::format(R"(
[simulation]
gravity = {}
[[body]]
name = "floor"
shape = {{ kind = "plane" }}
static = true
friction = 0.5
[[lattice]]
name = "box"
count = {}
spacing = {}
origin = [0, 0, 0.5]
[lattice.body]
shape = {{ kind = "box", size = [1, 1, 1] }}
friction = 0.5
)",
                                   gravity, count, spacing),
                       "cubes.toml");
}

/// What a run of `steps` steps ends with.
struct Outcome {
    std::uint64_t hash = 0;
    double max_penetration = 0.0;
    int unconverged = 0;
    int most_pairs = 0; ///< with contacts, in a step
};

Outcome run(const SceneDef& scene, int threads, int steps) {
    World world(scene, threads);
    Outcome outcome;
    for (int i = 0; i < steps; ++i) {
        const StepReport report = world.step();
        outcome.max_penetration = std::max(outcome.max_penetration, report.max_penetration);
        outcome.unconverged += report.at_iteration_limit;
        outcome.most_pairs = std::max(outcome.most_pairs, report.manifolds);
    }
    outcome.hash = state_hash(world.take_snapshot());
    return outcome;
}

} // namespace

TEST(world, any_number_of_threads_gives_the_same_state) {
    SceneDef scene = heap_of_cubes(5);
    scene.step.tolerance = 1e-4;
    const Outcome one = run(scene, 1, 230);
    EXPECT_EQ(run(scene, 2, 230).hash, one.hash);
    EXPECT_EQ(run(scene, 5, 230).hash, one.hash);
}

TEST(world, any_number_of_threads_gives_the_same_state_of_a_large_group) {
    const SceneDef scene = cubes("[7, 7, 7]", "[1.0001, 1.0001, 1.0001]", "[6, 2, -9.81]"); // one that slides apart
    const Outcome one = run(scene, 1, 60);
    EXPECT_GE(one.most_pairs, 600); // so many that threads share the loops of a group
    EXPECT_EQ(run(scene, 2, 60).hash, one.hash);
    EXPECT_EQ(run(scene, 5, 60).hash, one.hash);
}

TEST(world, any_number_of_threads_gives_the_same_state_of_many_islands) {
    const SceneDef scene = cubes("[8, 8, 40]", "[2, 2, 1.0001]", "[0, 0, -9.81]"); // ten groups: each thread solves some
    const Outcome one = run(scene, 1, 10);
    EXPECT_EQ(run(scene, 2, 10).hash, one.hash);
    EXPECT_EQ(run(scene, 5, 10).hash, one.hash);
}

TEST(world, any_number_of_threads_gives_the_same_state_of_many_islands_with_joints) {
    SceneDef scene = cubes("[4, 8, 1]", "[1.05, 4, 1]", "[7, 2, -9.81]"); // eight chains of four that slide, each a group
    for (int i = 1; i < 32; ++i) {
        if (i % 4 > 0) {
            const Pose& pose = scene.bodies[static_cast<std::size_t>(i)].pose;
            JointDef joint;
            joint.name = std::to_string(i);
            joint.body_a = i;
            joint.body_b = i + 1;
            joint.anchor = pose.position + Vec3(0.525, 0, 0);
            scene.joints.push_back(joint);
        }
    }
    const Outcome one = run(scene, 1, 200);
    EXPECT_GE(one.most_pairs, 32);
    EXPECT_EQ(run(scene, 2, 200).hash, one.hash);
    EXPECT_EQ(run(scene, 5, 200).hash, one.hash);
}

TEST(world, overlaps_stay_within_the_tolerance_in_every_reported_step) {
    const SceneDef scene = heap_of_cubes(2);
    const Outcome outcome = run(scene, 1, 500);
    EXPECT_EQ(outcome.unconverged, 0);
    EXPECT_LE(outcome.max_penetration, scene.step.tolerance);
}

TEST(world, a_tower_of_twenty_is_carried_within_twenty_sweeps) {
    // Started from nothing in every step, sweeps alone would need hundreds to bring the weight down to the floor.
    const SceneDef scene = parse_scene(R"(
[simulation]
warm_start = false
iteration_limit = 20
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
[[lattice]]
name = "box"
count = [1, 1, 20]
spacing = [1, 1, 1]
origin = [0, 0, 0.5]
[lattice.body]
shape = { kind = "box", size = [1, 1, 1] }
density = 1000
friction = 0.5
)",
                                       "tower.toml");
    World world(scene);
    for (int i = 0; i < 20; ++i) {
        EXPECT_LE(world.step().residual, 1e-10); // 1e-7 m/s, the tolerance of velocities, over 1 ms
    }
}

TEST(world, no_step_takes_more_work_than_ten_solves_and_tells_where_it_fell_short) {
    SceneDef scene = heap_of_cubes(5);
    scene.step.tolerance = 1e-9; // far below what three sweeps reach
    scene.step.velocity_tolerance = 1e-12;
    scene.step.iteration_limit = 3;
    World world(scene);
    int short_of = 0, out_of_work = 0;
    for (int i = 0; i < 230; ++i) {
        const StepReport report = world.step();
        EXPECT_LE(report.contact_iterations + report.collision_iterations, 11 * scene.step.iteration_limit) << i;
        out_of_work += report.is_out_of_work ? 1 : 0;
        if (report.at_iteration_limit) {
            ++short_of;
            EXPECT_GE(report.unsettled.a, 0);
            EXPECT_GE(report.unsettled.island, 1);
            EXPECT_LE(report.unsettled.island, 125);
        } else {
            EXPECT_EQ(report.unsettled.island, 0);
        }
    }
    EXPECT_GT(short_of, 0);
    EXPECT_GT(out_of_work, 0);
}

/// Two hands draw the ends of a rod apart: joints whose load has no bound ask for ten thousand intervals a step.
TEST(world, joints_that_are_torn_open_take_no_more_work_than_a_step_has) {
    std::string text = "simulation = { time_step = \"1/500\", iteration_limit = 20 }\n"
                       "[[body]]\nname = \"rod\"\nshape = { kind = \"capsule\", radius = 0.1, length = 0.8 }\ndensity = 1000\n";
    for (const auto& [name, x] : {std::pair("left", -1.0), std::pair("right", 1.0)}) {
        text += fmt::format("[[body]]\nname = \"{0}\"\nshape = {{ kind = \"sphere\", radius = 0.1 }}\nposition = [{1}, 0, 0]\n"
                            "keys = [{{ time = 0 }}, {{ time = 1, position = [{2}, 0, 0] }}]\n"
                            "[[joint]]\nname = \"{0} end\"\nkind = \"ball\"\nbodies = [\"rod\", \"{0}\"]\nanchor = [{3}, 0, 0]\n",
                            name, x, 2.0 * x, 0.5 * x);
    }
    const SceneDef scene = parse_scene(text, "torn.toml");
    World world(scene);
    StepReport report;
    for (int i = 0; i < 100; ++i) {
        report = world.step();
        EXPECT_LE(report.divisions, 20) << i; // a plan counts as ten sweeps at least
    }
    EXPECT_TRUE(report.at_iteration_limit);
    EXPECT_GE(report.unsettled.joint, 0);
    EXPECT_GT(report.unsettled.error, 0.01);
    EXPECT_EQ(report.unsettled.error, report.joint_gap);
}

/// A ball between a floor and one a million times as heavy collides 3141 times in one step. A plan without sweeps would not hold
/// what lies beside them.
TEST(world, collisions_leave_the_plan_half_of_a_steps_work) {
    SceneDef scene = parse_scene(R"(
[simulation]
time_step = "1/500"
iteration_limit = 20
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
[[body]]
name = "light"
shape = { kind = "sphere", radius = 0.5 }
position = [0, 0, 0.5]
mass = 1
restitution = 1
[[body]]
name = "heavy"
shape = { kind = "sphere", radius = 0.5 }
position = [0, 0, 1.505]
velocity = [0, 0, -1]
mass = 1e6
restitution = 1
)",
                                 "squeezed.toml");
    World world(scene);
    int short_of = 0;
    for (int i = 0; i < 10; ++i) {
        const StepReport report = world.step();
        short_of += report.at_iteration_limit ? 1 : 0;
        EXPECT_FALSE(report.is_out_of_work) << i;
    }
    EXPECT_GT(short_of, 0);
}

/// Also where sweeps pass over blocks whose bodies hardly move, and extrapolation leaves some of them pulling.
TEST(world, no_contact_pulls) {
    SceneDef scene = heap_of_cubes(8);
    scene.step.velocity_tolerance = 0.05;
    for (BodyDef& body : scene.bodies) {
        body.material.mu_s = body.material.mu_d = 0.1;
    }
    WorldState world(scene, 1);
    world.begin();
    int pulls = 0, loaded = 0;
    for (int i = 0; i < 400; ++i) {
        world.step();
        for (const PairContacts& pair : world.search.pairs) {
            for (const Contact& contact : pair.manifold.contacts) {
                loaded += contact.memory.p_n > 0.0 ? 1 : 0;
                pulls += contact.memory.p_n < 0.0 ? 1 : 0;
            }
        }
    }
    EXPECT_GT(loaded, 100000);
    EXPECT_EQ(pulls, 0);
}

TEST(world, time_is_the_step_index_times_the_step) {
    World world(heap_of_cubes(3));
    for (int i = 0; i < 7; ++i) {
        world.step();
    }
    EXPECT_EQ(world.step_index(), 7);
    EXPECT_EQ(world.time(), 7.0 / 500.0);
}

TEST(world, a_state_beyond_the_range_of_numbers_stops_the_run_and_names_the_body) {
    SceneDef scene = heap_of_cubes(3);
    scene.bodies.resize(2); // the floor and one cube
    scene.bodies[1].velocity.z() = std::numeric_limits<double>::max();
    try {
        World world(scene);
        world.step();
        world.step();
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::stopped);
        EXPECT_NE(std::string(error.what()).find("cube"), std::string::npos) << error.what();
    }
}
