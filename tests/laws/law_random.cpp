/// Random scenes, seeded: what must hold of all of them.
#include "sim/base/random.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using namespace laws;

constexpr int seeds = 4;
constexpr double overlap_tolerance = 1e-6; // [m]

Vec3 vector_within(sim::Random& random, double length) {
    return {between(random, -length, length), between(random, -length, length), between(random, -length, length)};
}

Quat random_turn(sim::Random& random) {
    const Vec3 axis = vector_within(random, 1.0);
    return Quat(Eigen::AngleAxisd(between(random, 0.0, pi), (axis + Vec3(0.01, 0, 0)).normalized()));
}

/// Eight boxes and balls at the corners of a cube, on their way to its middle.
sim::SceneDef swarm(int seed, double restitution) {
    sim::Random random(static_cast<std::uint64_t>(seed));
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step.gravity = Vec3::Zero();
    scene.step.tolerance = overlap_tolerance;
    for (int i = 0; i < 8; ++i) {
        const Vec3 corner(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        const sim::MaterialDef surface = material(restitution, between(random, 0.0, 0.6));
        const Vec3 place = 0.8 * corner + vector_within(random, 0.1);
        const int body =
            random.uniform() < 0.4
                ? add_sphere(scene, between(random, 0.2, 0.4), place, surface)
                : add_box(scene, Vec3::Constant(0.3) + vector_within(random, 0.1), {place, random_turn(random)}, surface);
        scene.bodies[static_cast<std::size_t>(body)].velocity = -1.5 * corner + vector_within(random, 0.4);
        scene.bodies[static_cast<std::size_t>(body)].angular_velocity = vector_within(random, 3.0);
    }
    return scene;
}

/// The same bodies in a heap on the floor.
sim::SceneDef heap(int seed) {
    sim::SceneDef scene = swarm(seed, 0.4);
    scene.step.gravity = Vec3(0, 0, -g);
    scene.step.tolerance = 1e-5;
    for (sim::BodyDef& body : scene.bodies) {
        body.pose.position.z() += 1.8;
    }
    add_plane(scene, Quat::Identity(), material(0.4, 0.5));
    return scene;
}

TEST(law_random, collisions_of_free_bodies_keep_momentum_and_lose_energy) {
    for (int seed = 1; seed <= seeds; ++seed) {
        sim::SceneDef scene = swarm(seed, 0.5);
        // A contact placed ahead acts across its gap: its friction turns both bodies by it.
        scene.step.impacts = sim::ImpactHandling::stop;
        sim::World world(scene);
        const sim::Snapshot first = world.take_snapshot();
        const Vec3 p = momentum(scene, first), l = angular_momentum(scene, first);
        const double scale = 1e3, start = energy(scene, first); // [N s] of one of the bodies
        double moved = 0.0, turned = 0.0, energy_before = start, gain = 0.0, overlap = 0.0;
        int collisions = 0, unconverged = 0;
        run(world, scene, 0.8, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            moved = std::max(moved, (momentum(scene, s) - p).norm());
            turned = std::max(turned, (angular_momentum(scene, s) - l).norm());
            gain = std::max(gain, energy(scene, s) - energy_before);
            energy_before = energy(scene, s);
            collisions += report.collisions;
            unconverged += report.at_iteration_limit ? 1 : 0;
            if (s.step % 20 == 0) {
                overlap = std::max(overlap, largest_overlap(scene, s));
            }
            return true;
        });
        EXPECT_GT(collisions, 4) << "seed " << seed;
        EXPECT_LT(moved / scale, 1e-9) << "seed " << seed;
        // At a touch the two points are a tolerance apart at most: that times a friction impulse of 100 N s.
        EXPECT_LT(turned / scale, 1e-7) << "seed " << seed;
        EXPECT_LT(gain / start, 1e-9) << "seed " << seed;
        EXPECT_LT(energy_before, 0.999 * start) << "seed " << seed;
        EXPECT_LE(overlap, scene.step.tolerance) << "seed " << seed;
        EXPECT_EQ(unconverged, 0) << "seed " << seed;
    }
}

TEST(law_random, a_heap_keeps_its_tolerance_and_gains_no_energy) {
    for (int seed = 1; seed <= seeds; ++seed) {
        const sim::SceneDef scene = heap(seed);
        sim::World world(scene);
        const double start = energy(scene, world.take_snapshot());
        double highest = 0.0, overlap = 0.0;
        run(world, scene, 1.2, [&](const sim::Snapshot& s, const sim::StepReport&) {
            highest = std::max(highest, energy(scene, s) - start);
            if (s.step % 20 == 0) {
                overlap = std::max(overlap, largest_overlap(scene, s));
            }
            return true;
        });
        EXPECT_LE(overlap, scene.step.tolerance) << "seed " << seed;
        EXPECT_LT(highest / start, 1e-9) << "seed " << seed;
    }
}

TEST(law_random, threads_do_not_change_the_result) {
    for (int seed = 1; seed <= 2; ++seed) {
        std::vector<std::uint64_t> hashes;
        for (const int threads : {1, 2, 5}) {
            sim::World world(heap(seed), threads);
            for (int i = 0; i < 800; ++i) {
                world.step();
            }
            hashes.push_back(sim::state_hash(world.take_snapshot()));
        }
        EXPECT_EQ(hashes[0], hashes[1]) << "seed " << seed;
        EXPECT_EQ(hashes[0], hashes[2]) << "seed " << seed;
    }
}

/// x -> -x: vectors lose the sign of x, axial ones those of y and z.
Vec3 mirrored(const Vec3& v) {
    return {-v.x(), v.y(), v.z()};
}
Vec3 mirrored_axial(const Vec3& w) {
    return {w.x(), -w.y(), -w.z()};
}

/// Largest distance [m] of any body from its counterpart, up to `until` [s].
template <class Change, class Back>
double deviation(const sim::SceneDef& scene, double until, const Change& change, const Back& back) {
    sim::SceneDef other = scene;
    for (sim::BodyDef& body : other.bodies) {
        change(body);
    }
    sim::World one(scene), two(other);
    double largest = 0.0;
    while (one.time() < until) {
        one.step();
        two.step();
        const sim::Snapshot a = one.take_snapshot(), b = two.take_snapshot();
        for (std::size_t i = 0; i < a.bodies.size(); ++i) {
            largest = std::max(largest, (a.bodies[i].position - back(b.bodies[i].position)).norm());
        }
    }
    return largest;
}

/// A collision multiplies what two runs differ by, by ten or so; half a second has three or four of them a body.
constexpr double counterpart_bound = 1e-6; // [m] after 0.5 s

TEST(law_random, the_mirrored_scene_gives_the_mirrored_result) {
    double worst = 0.0;
    for (int seed = 1; seed <= seeds; ++seed) {
        const double found = deviation(
            swarm(seed, 0.5), 0.5,
            [](sim::BodyDef& body) {
                const Quat q = body.pose.orientation;
                body.pose = {mirrored(body.pose.position), Quat(q.w(), q.x(), -q.y(), -q.z())};
                body.velocity = mirrored(body.velocity);
                body.angular_velocity = mirrored_axial(body.angular_velocity);
            },
            mirrored);
        EXPECT_LT(found, counterpart_bound) << "seed " << seed;
        worst = std::max(worst, found);
    }
    record({"random scenes, mirrored", "distance from the mirrored result in 0.5 s [m]", 1e-3, worst, counterpart_bound});
}

TEST(law_random, the_turned_scene_gives_the_turned_result) {
    const Quat turn(Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()));
    double worst = 0.0;
    for (int seed = 1; seed <= seeds; ++seed) {
        const double found = deviation(
            swarm(seed, 0.5), 0.5,
            [&](sim::BodyDef& body) {
                body.pose = {turn * body.pose.position, turn * body.pose.orientation};
                body.velocity = turn * body.velocity;
                body.angular_velocity = turn * body.angular_velocity;
            },
            [&](const Vec3& position) { return Vec3(turn.conjugate() * position); });
        EXPECT_LT(found, counterpart_bound) << "seed " << seed;
        worst = std::max(worst, found);
    }
    record({"random scenes, turned", "distance from the turned result in 0.5 s [m]", 1e-3, worst, counterpart_bound});
}

} // namespace
