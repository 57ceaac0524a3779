/// The inner pieces alone: manifolds of two boxes, the check of their separation, and the search for pairs.
#include "sim/broad_phase.h"
#include "sim/integrate.h"
#include "sim/narrow_phase.h"
#include "sim/scene_file.h"
#include "sim/world.h"
#include "tests/laws/reference/gap.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

namespace {

using sim::Pose;
using sim::Quat;
using sim::Vec3;

/// A unit cube on another: face on face, turned by 0.3 rad so that eight points come out, or edge on edge.
Pose upper_pose(bool edges) {
    const double quarter = std::acos(-1.0) / 4;
    if (!edges) {
        return {Vec3(0.2, 0.1, 1.0), Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ()))};
    }
    return {Vec3(0.1, 0.2, std::sqrt(2.0)), Quat(Eigen::AngleAxisd(quarter, Vec3::UnitY()))};
}

Pose lower_pose(bool edges) {
    const double quarter = std::acos(-1.0) / 4;
    return {Vec3::Zero(), edges ? Quat(Eigen::AngleAxisd(quarter, Vec3::UnitX())) : Quat::Identity()};
}

void box_box_manifold(benchmark::State& state) {
    const bool edges = state.range(0) == 1;
    const sim::Shape cube = sim::Box{};
    const Pose lower = lower_pose(edges), upper = upper_pose(edges);
    std::vector<sim::Contact> contacts;
    for (auto _ : state) {
        sim::find_contacts(cube, lower, cube, upper, 1e-3, contacts);
        benchmark::DoNotOptimize(contacts.data());
    }
    state.SetLabel((edges ? "edge on edge, points " : "face on face, points ") +
                   std::to_string(contacts.size()));
}
BENCHMARK(box_box_manifold)->Arg(0)->Arg(1);

void box_box_separation(benchmark::State& state) {
    const bool edges = state.range(0) == 1;
    const sim::Shape cube = sim::Box{};
    const Pose lower = lower_pose(edges), upper = upper_pose(edges);
    for (auto _ : state) {
        benchmark::DoNotOptimize(sim::separation(cube, lower, cube, upper));
    }
    state.SetLabel(edges ? "edge on edge" : "face on face");
}
BENCHMARK(box_box_separation)->Arg(0)->Arg(1);

void box_box_gap_of_the_independent_check(benchmark::State& state) {
    const Pose lower = lower_pose(false), upper = upper_pose(false);
    const reference::OrientedBox a{lower.position, lower.orientation.toRotationMatrix(), Vec3::Constant(0.5)};
    const reference::OrientedBox b{upper.position, upper.orientation.toRotationMatrix(), Vec3::Constant(0.5)};
    for (auto _ : state) {
        benchmark::DoNotOptimize(reference::gap(a, b));
    }
}
BENCHMARK(box_box_gap_of_the_independent_check);

/// The funnel's lattice as it starts, pressed together so that each cube has near neighbours.
void broad_phase_update(benchmark::State& state) {
    const int n = static_cast<int>(state.range(0));
    std::vector<sim::BodyProps> props;
    std::vector<sim::Bounds> boxes;
    for (int i = 0; i < n * n * n; ++i) {
        sim::BodyDef def;
        def.shape = sim::Box{};
        def.mass = sim::mass_properties(def.shape, 1000.0);
        def.pose.position = 1.05 * Vec3(i % n, i / n % n, i / n / n);
        props.push_back(sim::make_body_props(def));
        boxes.push_back(sim::bounds(def.shape, def.pose));
        boxes.back().lower.array() -= 0.05;
        boxes.back().upper.array() += 0.05;
    }
    sim::BroadPhase broad_phase(props);
    std::vector<sim::BodyPair> pairs;
    for (auto _ : state) {
        broad_phase.find_pairs(boxes, pairs);
        benchmark::DoNotOptimize(pairs.data());
    }
    state.SetLabel("pairs " + std::to_string(pairs.size()));
    state.SetItemsProcessed(state.iterations() * n * n * n);
}
BENCHMARK(broad_phase_update)->Arg(10)->Arg(20)->Unit(benchmark::kMicrosecond);

/// One step of the funnel while its cubes still fall: everything but the solving.
void funnel_step_in_free_fall(benchmark::State& state) {
    const sim::SceneDef scene = sim::load_scene(TUMBLE_SCENE_DIR "/funnel.toml");
    sim::World world(scene);
    for (auto _ : state) {
        world.step();
    }
}
BENCHMARK(funnel_step_in_free_fall)->Iterations(300)->Unit(benchmark::kMicrosecond);

} // namespace

BENCHMARK_MAIN();
