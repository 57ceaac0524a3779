/// A world that was saved goes on as if it had not been.
#include "sim/base/bytes.h"
#include "sim/base/error.h"
#include "sim/base/random.h"
#include "sim/scene/file.h"
#include "sim/world/world.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

using namespace sim;

namespace {

/// Rocks, pins and cubes, some of which spin fast, fall on a floor and into each other.
std::string heap_text(const std::string& simulation) {
    return "[simulation]\ntime_step = \"1/300\"\n" + simulation + R"(
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
friction = 0.4
[[lattice]]
name = "rock"
count = [2, 2, 3]
spacing = [1.5, 1.5, 1.5]
origin = [0, 0, 1]
turn_max_degrees = 180
seed = 7
[lattice.body]
shape = { kind = "rock", size = [1.35, 1.1, 0.9], corners = 14, seed = 100 }
density = 2600
restitution = 0.3
friction = 0.25
[[lattice]]
name = "cube"
count = [2, 2, 2]
spacing = [1.8, 1.8, 1.8]
origin = [0.1, 0.2, 7]
turn_max_degrees = 30
seed = 8
[lattice.body]
shape = { kind = "box", size = [1, 1, 1] }
density = 1000
mu_s = 0.4
mu_d = 0.3
angular_velocity = [30, 160, 0]
[[lattice]]
name = "pin"
count = [2, 2, 1]
spacing = [1.4, 1.4, 1.4]
origin = [0, 0, 5.5]
[lattice.body]
shape = { kind = "cylinder", radius = 0.3, length = 0.9 }
density = 1000
friction = 0.3
)";
}

/// Four balls on a rope let go level, the last one so heavy that the taut rope vibrates faster than whole steps follow.
std::string rope_text() {
    std::string text;
    for (int i = 0; i < 4; ++i) {
        text += fmt::format("[[body]]\nname = \"{0}\"\nshape = {{ kind = \"sphere\", radius = 0.05 }}\ndensity = {1}\n"
                            "position = [{2}, 0, 0]\n[[joint]]\nname = \"{0}\"\nkind = \"ball\"\nbodies = [\"{0}\"{3}]\n"
                            "anchor = [{4}, 0, 0]\n",
                            i, i == 3 ? 1e9 : 1e3, 0.2 * (i + 1), i > 0 ? fmt::format(", \"{}\"", i - 1) : "", 0.2 * i);
    }
    return text;
}

World copy_of(const World& world, const SceneDef& scene, int threads) {
    ByteWriter saved;
    world.save(saved);
    ByteReader from(saved.bytes());
    World copy = World::restored(scene, threads, from);
    copy.record_impacts();
    return copy;
}

/// All of a report but its times.
std::string text_of(const StepReport& r) {
    return fmt::format("{} pairs {} manifolds {} collisions {} passes {} contacts {} joints {} {} sweeps {} stops {} "
                       "divisions {:a} m {:a} m {:a} m {:a} gain {} {} unsettled {} {} {} {} {:a} {:a}",
                       r.pairs, r.manifolds, r.collisions, r.collision_passes, r.contacts, r.joints, r.collision_iterations,
                       r.contact_iterations, r.impacts_stopped_at, r.divisions, r.residual, r.joint_gap, r.max_penetration,
                       r.energy_gain, r.at_iteration_limit, r.is_out_of_work, r.unsettled.joint, r.unsettled.a, r.unsettled.b,
                       r.unsettled.island, r.unsettled.change, r.unsettled.error);
}

/// A step of both, which are to do the same. Returns what it reports.
StepReport same_step(World& a, World& b) {
    const StepReport of_a = a.step();
    EXPECT_EQ(text_of(of_a), text_of(b.step()));
    const Snapshot state_a = a.take_snapshot(ContactDetail::all);
    const Snapshot state_b = b.take_snapshot(ContactDetail::all);
    EXPECT_EQ(state_hash(state_a), state_hash(state_b));
    EXPECT_EQ(state_a.contacts.size(), state_b.contacts.size());
    for (std::size_t i = 0; i < std::min(state_a.contacts.size(), state_b.contacts.size()); ++i) {
        EXPECT_EQ(state_a.contacts[i].impulse, state_b.contacts[i].impulse);
    }
    if (a.step_index() % 7 == 0) {
        const std::vector<ContactSnapshot> impacts_a = a.take_impacts();
        const std::vector<ContactSnapshot> impacts_b = b.take_impacts();
        EXPECT_EQ(impacts_a.size(), impacts_b.size());
        for (std::size_t i = 0; i < std::min(impacts_a.size(), impacts_b.size()); ++i) {
            EXPECT_EQ(impacts_a[i].impulse, impacts_b[i].impulse);
        }
    }
    return of_a;
}

/// What happened in the steps of a test.
struct Seen {
    int divisions = 0;
    int stops = 0;
    int unsettled = 0;
    double energy_gain = 0.0;
};

/// A world that is saved, thrown away and restored, on average every `period` steps, beside one that is not.
Seen expect_goes_on(const SceneDef& scene, int steps, int period) {
    Random random(static_cast<std::uint64_t>(steps));
    World whole(scene);
    World parts(scene);
    whole.record_impacts();
    parts.record_impacts();
    int restored = 0;
    Seen seen;
    while (whole.step_index() < steps && !testing::Test::HasFailure()) {
        if (random.uniform() * period < 1.0) {
            parts = copy_of(parts, scene, 1 + ++restored % 3);
        }
        SCOPED_TRACE(scene.name + fmt::format(", step {}", whole.step_index()));
        const StepReport report = same_step(whole, parts);
        seen.divisions += report.divisions;
        seen.stops += report.impacts_stopped_at;
        seen.unsettled += report.at_iteration_limit ? 1 : 0;
        seen.energy_gain = std::max(seen.energy_gain, report.energy_gain);
    }
    EXPECT_GT(restored, steps / period / 2);
    return seen;
}

SceneDef scene_of(const std::string& name) {
    return load_scene(TUMBLE_SCENE_DIR "/" + name);
}

} // namespace

TEST(checkpoint, a_heap_of_hulls_cylinders_and_boxes_goes_on) {
    const Seen seen = expect_goes_on(parse_scene(heap_text(""), "heap.toml"), 700, 20);
    EXPECT_GT(seen.divisions, 0);
}

TEST(checkpoint, a_heap_that_is_stirred_and_poured_on_goes_on) {
    const std::string paddle = "[[body]]\nname = \"paddle\"\nshape = { kind = \"box\", size = [8, 0.2, 0.5] }\n"
                               "position = [0, -1, 0.3]\nkeys = [{ time = 0 }, { time = 1, angle_degrees = 200 }]\n";
    const std::string stream = "[[lattice]]\nname = \"late\"\ncount = [1, 1, 30]\nspacing = [1, 1, 0]\norigin = [0.7, 0.7, 20]\n"
                               "release = 0.1\nrelease_interval = 0.03\nbody = { shape = { kind = \"box\", size = [0.3, 0.3, "
                               "0.3] }, velocity = [0, 0, -12] }\n";
    const Seen seen = expect_goes_on(parse_scene(heap_text("") + paddle + stream, "stirred.toml"), 250, 10);
    EXPECT_LT(seen.energy_gain, 1e-3);
}

TEST(checkpoint, springs_and_motors_go_on) {
    const std::string wheel = R"([[body]]
name = "wheel"
shape = { kind = "box", size = [3, 0.2, 0.3] }
position = [0, -3, 2]
[[joint]]
name = "axle"
kind = "hinge"
bodies = ["wheel"]
anchor = [0, -3, 2]
axis = [0, 1, 0]
motor = { speed = 5, limit = 2000 }
spring = { stiffness = 300, damping = 20 }
[[body]]
name = "float"
shape = { kind = "sphere", radius = 0.3 }
position = [1.2, -3, 3.2]
[[joint]]
name = "rail"
kind = "slider"
bodies = ["float"]
anchor = [1.2, -3, 3.2]
axis = [0, 0, 1]
spring = { stiffness = 4000, rest = -0.5 }
)";
    expect_goes_on(parse_scene(heap_text("") + wheel, "driven.toml"), 250, 10);
}

TEST(checkpoint, steps_that_do_not_converge_go_on) {
    const Seen seen = expect_goes_on(parse_scene(heap_text("iteration_limit = 3\n"), "heap.toml"), 400, 10);
    EXPECT_GT(seen.unsettled, 0);
}

TEST(checkpoint, joints_and_stops_at_impacts_go_on) {
    EXPECT_GT(expect_goes_on(scene_of("office_toy.toml"), 2000, 1).stops, 0);
    expect_goes_on(scene_of("laws/pendulum_chain.toml"), 1000, 20);
    EXPECT_GT(expect_goes_on(parse_scene(rope_text(), "rope.toml"), 600, 10).divisions, 0);
    EXPECT_GT(expect_goes_on(parse_scene(heap_text("impacts = \"stop\"\n"), "heap.toml"), 60, 6).stops, 0);
}

TEST(checkpoint, rolling_sliding_and_bouncing_go_on) {
    expect_goes_on(scene_of("tippe_top.toml"), 2000, 40);
    expect_goes_on(scene_of("inclined_blocks.toml"), 1000, 30);
    expect_goes_on(scene_of("laws/bouncing_ball.toml"), 1000, 20);
    expect_goes_on(scene_of("coin.toml"), 1000, 20);
}

TEST(checkpoint, many_bodies_go_on) {
    expect_goes_on(scene_of("dominoes.toml"), 800, 40);
    expect_goes_on(scene_of("marbles.toml"), 300, 15);
}

TEST(checkpoint, restored_before_every_step_it_goes_on) {
    const SceneDef scene = parse_scene(heap_text(""), "heap.toml");
    EXPECT_GT(expect_goes_on(scene, 300, 1).divisions, 0);
}

TEST(checkpoint, too_few_bytes_are_an_error) {
    const SceneDef scene = scene_of("laws/bouncing_ball.toml");
    World world(scene);
    world.step();
    ByteWriter saved;
    world.save(saved);
    const std::size_t whole = saved.bytes().size();
    for (const std::size_t size : {std::size_t{0}, whole / 3, whole - 1}) {
        ByteReader from(std::string_view(saved.bytes()).substr(0, size));
        EXPECT_THROW(World::restored(scene, 1, from), Error) << size;
    }
}

TEST(bytes, come_back_and_their_checksum_sees_each_bit) {
    ByteWriter out;
    out(std::array<int, 2>{3, 4});
    out(std::string("word"));
    out(std::vector<double>{0.5, -1.0, 2.0});
    ByteReader in(out.bytes());
    std::array<int, 2> numbers{};
    std::string word;
    std::vector<double> values;
    in(numbers);
    in(word);
    in(values);
    EXPECT_EQ(numbers, (std::array<int, 2>{3, 4}));
    EXPECT_EQ(word, "word");
    EXPECT_EQ(values, (std::vector<double>{0.5, -1.0, 2.0}));
    EXPECT_THROW(in(values), Error);
    const std::uint64_t sum = checksum(out.bytes());
    for (std::size_t bit = 0; bit < 8 * out.bytes().size(); ++bit) {
        std::string changed = out.bytes();
        changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
        EXPECT_NE(checksum(changed), sum) << bit;
    }
    EXPECT_NE(checksum(out.bytes().substr(1)), sum);
}
