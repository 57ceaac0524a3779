/// The inner pieces alone: manifolds and axes of two boxes, the search for pairs, one sweep, a call of libccd.
#include "sim/block/blocks.h"
#include "sim/collide/box_box.h"
#include "sim/collide/broad_phase.h"
#include "sim/collide/narrow_phase.h"
#include "sim/model/integrate.h"
#include "sim/scene/file.h"
#include "sim/world/world.h"
#include "tests/laws/reference/gap.h"

#include <benchmark/benchmark.h>
#include <ccd/ccd.h>
#include <ccd/vec3.h>

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
    std::vector<sim::FoundContact> contacts;
    for (auto _ : state) {
        sim::find_contacts({cube, lower}, {cube, upper}, 1e-3, contacts);
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
        benchmark::DoNotOptimize(sim::separation({cube, lower}, {cube, upper}));
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

/// Axes of eight thousand pairs of cubes.
void axes_of_8000_pairs(benchmark::State& state) {
    std::vector<sim::PlacedBoxRow> rows;
    std::vector<sim::BoxAxes> axes(8000);
    std::vector<sim::AxesSearch> searches;
    for (int i = 0; i < 8000; ++i) {
        rows.push_back(sim::box_row({}, {Vec3::Constant(0.3 * (i % 7)), Quat(Eigen::AngleAxisd(0.37 * i, Vec3(1, 2, 3).normalized()))}));
        if (i % sim::lane_count == 0) {
            searches.emplace_back();
        }
        sim::AxesSearch& search = searches.back();
        search.a[search.count] = i;
        search.b[search.count] = (i * 31 + 1) % 8000;
        search.axes[search.count++] = &axes[static_cast<std::size_t>(i)];
    }
    for (auto _ : state) {
        for (sim::AxesSearch& search : searches) {
            search.boxes = rows.data();
            sim::find_axes(search);
        }
        benchmark::DoNotOptimize(axes.data());
    }
    state.SetItemsProcessed(state.iterations() * 8000);
}
BENCHMARK(axes_of_8000_pairs)->Unit(benchmark::kMicrosecond);

/// One sweep over a block of n x n x n cubes stacked face on face, with friction: every block is visited.
void one_sweep(benchmark::State& state) {
    const int n = static_cast<int>(state.range(0));
    sim::Bodies bodies;
    sim::BodyDef def;
    def.shape = sim::Box{};
    def.mass = sim::mass_properties(def.shape, 1000.0);
    for (int i = 0; i < n * n * n; ++i) {
        bodies.props.push_back(sim::make_body_props(def));
        bodies.pose.push_back({Vec3(i % n, i / n % n, i / n / n), Quat::Identity()});
        bodies.velocity.push_back({Vec3(0.01 * (i % 3), 0.0, -0.1 * (i % 5)), Vec3::Zero()});
        bodies.inverse_inertia.push_back(sim::inverse_inertia_world(bodies.props.back(), Quat::Identity()));
    }
    sim::Blocks loop;
    std::vector<std::vector<sim::Contact>> contacts(static_cast<std::size_t>(n * n * n - n * n));
    for (int i = 0; i + n * n < n * n * n; ++i) {
        const auto lower = static_cast<std::size_t>(i);
        const auto upper = static_cast<std::size_t>(i + n * n);
        std::vector<sim::Contact>& own = contacts[lower];
        std::vector<sim::FoundContact> found;
        sim::find_contacts({def.shape, bodies.pose[lower]}, {def.shape, bodies.pose[upper]}, 1e-3, found);
        own = {found.begin(), found.end()};
        sim::Block like;
        like.a = i;
        like.b = i + n * n;
        like.mu_s = like.mu_d = 0.1;
        const std::size_t first = loop.contacts.size();
        for (const sim::Contact& contact : own) {
            loop.contacts.push_back(&contact);
        }
        loop.add(first, like);
    }
    loop.arrange(bodies, 0, bodies.velocity);
    std::vector<sim::Velocity> velocity = bodies.velocity;
    for (auto _ : state) {
        loop.wake(); // as the first of a solve: neither extrapolated nor finished by Newton's method
        benchmark::DoNotOptimize(loop.sweep(velocity, -1.0, 1e-3));
    }
    state.SetLabel("blocks " + std::to_string(loop.blocks.size()));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(loop.points.size()));
}
BENCHMARK(one_sweep)->Arg(5)->Arg(10)->Arg(20)->Unit(benchmark::kMicrosecond);

/// A cube as libccd sees it.
struct CcdCube {
    Pose pose;
};
void support_of_cube(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
    const Pose& pose = static_cast<const CcdCube*>(object)->pose;
    const Vec3 d = pose.orientation.conjugate() * Vec3(direction->v[0], direction->v[1], direction->v[2]);
    const Vec3 corner = pose * Vec3(std::copysign(0.5, d.x()), std::copysign(0.5, d.y()), std::copysign(0.5, d.z()));
    ccdVec3Set(result, corner.x(), corner.y(), corner.z());
}

/// libccd's penetration (GJK and EPA) of two cubes: what a general pair of convex bodies starts from.
void libccd_call(benchmark::State& state) {
    const CcdCube a{lower_pose(false)};
    CcdCube b{upper_pose(false)};
    b.pose.position.z() -= 1e-3;
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = support_of_cube;
    ccd.support2 = support_of_cube;
    ccd.max_iterations = 100;
    for (auto _ : state) {
        ccd_real_t depth = 0;
        ccd_vec3_t direction;
        ccd_vec3_t position;
        benchmark::DoNotOptimize(ccdGJKPenetration(&a, &b, &ccd, &depth, &direction, &position));
    }
}
BENCHMARK(libccd_call);

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
