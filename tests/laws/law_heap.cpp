/// Heaps of every kind of shape: in each step that is not reported, no overlap beyond the tolerance, by a check that
/// shares no code with sim/.
#include "sim/base/random.h"
#include "sim/model/polytope.h"
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"
#include "tests/laws/tub.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace {

using namespace laws;

enum class Kind { box, cylinder, capsule, hull, ball };
constexpr std::array kind_names{"boxes", "cylinders", "capsules", "hulls", "balls"};

sim::Shape random_shape(Kind kind, sim::Random& random) {
    switch (kind) {
    case Kind::cylinder:
        return sim::Cylinder{between(random, 0.1, 0.3), between(random, 0.1, 0.3)};
    case Kind::capsule:
        return sim::Capsule{between(random, 0.1, 0.2), between(random, 0.1, 0.2)};
    case Kind::hull: {
        std::vector<Vec3> points;
        for (int i = 0; i < 14; ++i) {
            points.push_back(0.3 * random.direction());
        }
        const sim::Polytope hull = *sim::convex_hull(points);
        return sim::Hull{std::make_shared<sim::Polytope>(sim::moved(hull, -sim::volume_moments(hull).centroid))};
    }
    case Kind::ball:
        return sim::Sphere{between(random, 0.1, 0.3)};
    default:
        return sim::Box{
            {between(random, 0.15, 0.3), between(random, 0.15, 0.3), between(random, 0.15, 0.3)}};
    }
}

/// `count` bodies of the given kinds in turn, let fall on the floor in layers of four.
sim::SceneDef heap_scene(int count, const std::vector<Kind>& kinds, sim::ImpactHandling impacts) {
    sim::SceneDef scene;
    scene.name = "law";
    scene.step.impacts = impacts;
    const sim::MaterialDef surface = material(0.3, 0.5);
    add_plane(scene, Quat::Identity(), surface);
    sim::Random random(11);
    for (int i = 0; i < count; ++i) {
        // No body reaches 0.53 m from its centre.
        const Vec3 at(1.2 * (i % 2) + 0.1 * random.uniform(), 1.2 * (i / 2 % 2) + 0.1 * random.uniform(),
                      0.55 + 1.1 * (i / 4));
        const Quat turn(Eigen::AngleAxisd(between(random, 0.0, pi), random.direction()));
        sim::BodyDef body;
        body.name = fmt::format("body_{}", i + 1);
        body.shape = random_shape(kinds[static_cast<std::size_t>(i) % kinds.size()], random);
        body.mass = sim::mass_properties(body.shape, 1000.0);
        body.mass.centre_of_mass = Vec3::Zero();
        body.pose = {at, turn};
        body.material = surface;
        scene.bodies.push_back(body);
    }
    return scene;
}

/// Share [-] of the steps of a heap that may be reported as not converged.
constexpr double largest_unconverged = 0.01;

void judge_heap(const std::string& name, const sim::SceneDef& scene, double duration) {
    sim::World world(scene);
    double overlap = 0.0, gain = 0.0;
    int unconverged = 0;
    const double start = energy(scene, world.take_snapshot());
    bool was_told = false; // a step tells how the motion in the next one was planned
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        unconverged += report.at_iteration_limit ? 1 : 0;
        const bool before = std::exchange(was_told, report.at_iteration_limit);
        if (!report.at_iteration_limit && !before) {
            overlap = std::max(overlap, largest_overlap(scene, s));
        }
        gain = std::max(gain, energy(scene, s) / start - 1.0);
        return true;
    });
    const std::string how = scene.step.impacts == sim::ImpactHandling::stop ? "impacts stopped" : "contacts ahead";
    record({fmt::format("heap of {}, {}", name, how), fmt::format("overlap in {} s [m]", duration), 1e-3, overlap,
            scene.step.tolerance});
    record({fmt::format("heap of {}, {}", name, how), "steps not converged", 1e-3, static_cast<double>(unconverged),
            no_value});
    // The check of rods is a search to 1e-9 m.
    EXPECT_LE(overlap, scene.step.tolerance + 1e-9) << name;
    EXPECT_LE(gain, 1e-9) << name;
    EXPECT_LE(unconverged, largest_unconverged * duration / scene.step.time_step.value()) << name;
}

TEST(law_heap, of_every_kind_of_shape_overlaps_by_no_more_than_the_tolerance) {
    for (const auto impacts : {sim::ImpactHandling::ahead, sim::ImpactHandling::stop}) {
        for (std::size_t kind = 0; kind < kind_names.size(); ++kind) {
            judge_heap(fmt::format("8 {}", kind_names[kind]), heap_scene(8, {static_cast<Kind>(kind)}, impacts), 0.7);
        }
    }
}

TEST(law_heap, of_all_kinds_of_shapes_together_overlaps_by_no_more_than_the_tolerance) {
    using enum Kind;
    judge_heap("10 of all kinds", heap_scene(10, {box, cylinder, capsule, hull, ball}, sim::ImpactHandling::ahead), 1.0);
}

/// The step is cut short just after contacts were found for the whole of it.
TEST(law_heap, of_24_cylinders_gains_no_energy_where_impacts_cut_steps_short) {
    judge_heap("24 cylinders", heap_scene(24, {Kind::cylinder}, sim::ImpactHandling::stop), 0.62);
}

// 12 divisions; where the touch of edges that has wandered too far may come back within a solve: 62, for gaps then jump between two
// values of which none meets its target; more, too, where repair does not keep features together that take turns, each letting the
// other overlap. Where a force is told point by point, not block by block, one heap gains 6e-3 of its energy. At most 176 sweeps;
// where no sweep takes half, two points 2 mm apart take turns in the last of these heaps, for all that a step has.
TEST(law_heap, steps_of_mixed_shapes_are_seldom_divided_soon_done_and_gain_nothing) {
    int divisions = 0;
    int sweeps = 0;
    double gain = 0.0;
    std::vector<int> seeds(100);
    std::iota(seeds.begin(), seeds.end(), 1);
    seeds.push_back(259);
    for (const int seed : seeds) {
        sim::World world(sim::parse_scene(tub, "tub.toml", std::vector<std::string>{fmt::format("lattice.piece.seed={}", seed)}));
        for (int step = 0; step < 600; ++step) {
            const sim::StepReport report = world.step();
            divisions += report.divisions;
            sweeps = std::max(sweeps, report.contact_iterations);
            gain = std::max(gain, report.energy_gain);
        }
    }
    record({"101 heaps of 64 shapes of four kinds, 600 steps", "divisions of steps [-]", 1e-3, static_cast<double>(divisions),
            40.0});
    record({"101 heaps of 64 shapes of four kinds, 600 steps", "sweeps of a step [-]", 1e-3, static_cast<double>(sweeps), 500.0});
    record({"101 heaps of 64 shapes of four kinds, 600 steps", "energy gained in a step [-]", 1e-3, gain,
            sim::energy_gain_allowed});
    EXPECT_LE(divisions, 40);
    EXPECT_LE(sweeps, 500);
    EXPECT_LE(gain, sim::energy_gain_allowed);
}

/// Grains of 22 to 26 mm in layers of `side` times `side`, which fall into a tube.
struct Silo {
    double radius; ///< [m]
    int side;
    int layers;
    std::uint64_t seed;

    int grains() const { return side * side * layers; }
    sim::SceneDef scene() const { // the floor, the grains, then the wall
        sim::SceneDef scene;
        scene.name = "law";
        const sim::MaterialDef surface = material(0.3, 0.5);
        add_plane(scene, Quat::Identity(), surface);
        sim::Random random(seed);
        for (int i = 0; i < grains(); ++i) {
            const double size = between(random, 0.011, 0.013);
            const double middle = 0.5 * (side - 1);
            const int layer = i / (side * side);
            const int row = i / side % side;
            const Vec3 at = 0.03 * Vec3(i % side - middle, row - middle, 1 + layer);
            const double y = random.uniform(); // one after the other: arguments are evaluated in any order
            const double x = random.uniform();
            add_sphere(scene, size, at + 1e-3 * Vec3(x, y, 0.0), surface, 2500.0);
            const double v_y = random.uniform();
            const double v_x = random.uniform();
            scene.bodies.back().velocity = 0.2 * Vec3(v_x - 0.5, v_y - 0.5, 0.0);
        }
        for (int i = 0; i < 12; ++i) {
            const Quat turn(Eigen::AngleAxisd(i * pi / 6.0, Vec3::UnitZ()));
            add_box(scene, {0.01, 0.03, 1.0}, {turn * Vec3(radius + 0.01, 0.0, 1.0), turn}, surface, 0.0);
        }
        return scene;
    }
};

/// They come to rest within `duration` [s]: floor and wall bear all of their weight, by friction too, and steps take few sweeps.
/// most: sweeps a step, of all steps and of the last hundred [-].
void judge_silo(const Silo& silo, double duration, const std::array<double, 2>& most) {
    const sim::SceneDef scene = silo.scene();
    const double h = scene.step.time_step.value();
    const std::string name = fmt::format("{} grains fall into a silo", silo.grains());
    sim::World world(scene);
    double sweeps = 0.0, late = 0.0;
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        sweeps += report.contact_iterations * h / duration;
        late += s.time > duration - 99.5 * h ? 0.01 * report.contact_iterations : 0.0;
        return true;
    });
    const auto is_grain = [&](int body) { return body > 0 && body <= silo.grains(); };
    double weight = 0.0, borne = 0.0; // [N]
    for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
        weight += is_grain(i) ? g * scene.bodies[static_cast<std::size_t>(i)].mass.mass : 0.0;
    }
    for (const sim::ContactSnapshot& contact : world.take_snapshot(sim::ContactDetail::all).contacts) {
        const auto [a, b] = contact.bodies;
        borne += ((is_grain(a) ? 1.0 : 0.0) - (is_grain(b) ? 1.0 : 0.0)) * static_cast<double>(contact.impulse.z()) / h;
    }
    record({name, "sweeps a step, of all [-]", h, sweeps, most[0]});
    record({name, "sweeps a step, of the last hundred [-]", h, late, most[1]});
    record({name, "error of what floor and wall bear, of the weight [-]", h, std::abs(borne / weight - 1.0), 1e-3});
    EXPECT_LE(sweeps, most[0]);
    EXPECT_LE(late, most[1]);
    EXPECT_NEAR(borne / weight, 1.0, 1e-3);
}

/// Where what extrapolation makes of sweeps may overshoot ever farther, 128 a step.
TEST(law_heap, grains_in_a_silo_come_to_rest) {
    judge_silo({.radius = 0.08, .side = 4, .layers = 30, .seed = 4}, 1.5, {100.0, 20.0});
}

/// There, 667.
TEST(law_heap, DISABLED_many_grains_in_a_silo_come_to_rest) {
    judge_silo({.radius = 0.1, .side = 5, .layers = 36, .seed = 3}, 2.5, {120.0, 100.0});
}

TEST(law_heap, DISABLED_of_24_of_each_kind_and_of_all_kinds_overlaps_by_no_more_than_the_tolerance) {
    using enum Kind;
    for (const auto impacts : {sim::ImpactHandling::ahead, sim::ImpactHandling::stop}) {
        for (std::size_t kind = 0; kind < kind_names.size(); ++kind) {
            judge_heap(fmt::format("24 {}", kind_names[kind]), heap_scene(24, {static_cast<Kind>(kind)}, impacts), 1.5);
        }
    }
    judge_heap("50 of all kinds", heap_scene(50, {box, cylinder, capsule, hull, ball}, sim::ImpactHandling::ahead), 3.0);
}

} // namespace
