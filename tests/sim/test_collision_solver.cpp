#include "sim/collide/narrow_phase.h"
#include "sim/solve/collision_solver.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace sim;

namespace {

struct Impacts {
    Bodies bodies;
    std::vector<PairContacts> pairs;
    StepSettings settings{.gravity = Vec3::Zero()};
    std::vector<Velocity> velocity;

    std::int64_t most_sweeps = 100000;
    std::vector<EnergyLoss> lost;

    void pair(int a, int b) {
        PairContacts& found = pairs.emplace_back();
        found.manifold.body_a = a;
        found.manifold.body_b = b;
        const auto ia = static_cast<std::size_t>(a);
        const auto ib = static_cast<std::size_t>(b);
        std::vector<FoundContact> contacts;
        find_contacts({bodies.props[ia].shape, bodies.pose[ia]}, {bodies.props[ib].shape, bodies.pose[ib]}, 1e-3, contacts);
        replace_contacts(found, contacts);
        found.material = pair_material(bodies.props[ia], bodies.props[ib]);
    }
    CollisionReport resolve() {
        velocity = bodies.velocity;
        Blocks memory;
        JointSolver joints;
        CollisionSolver solver(memory, joints);
        solver.most_sweeps = most_sweeps;
        solver.lost = lost;
        return solver.resolve(bodies, pairs, settings, velocity);
    }
    Vec3 momentum(const std::vector<Velocity>& u) const {
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = 0; i < u.size(); ++i) {
            sum += u[i].v / bodies.props[i].inverse_mass;
        }
        return sum;
    }
    Vec3 spin(const std::vector<Velocity>& u) const {
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = 0; i < u.size(); ++i) {
            sum += bodies.pose[i].position.cross(u[i].v / bodies.props[i].inverse_mass) +
                   angular_momentum(bodies.props[i], bodies.pose[i].orientation, u[i].w);
        }
        return sum;
    }
};

/// Five equal balls in a touching row along x; the first `moving` come in at 1 m/s.
Impacts row_of_five(int moving, double e) {
    Impacts scene;
    for (int i = 0; i < 5; ++i) {
        const double speed = i < moving ? 1.0 : 0.0;
        add_body(scene.bodies, make_props(Sphere{0.5}, 1000.0, e), {Vec3(i, 0, 0), Quat::Identity()},
                 {Vec3(speed, 0, 0), Vec3::Zero()});
    }
    for (int i = 0; i < 4; ++i) {
        scene.pair(i, i + 1);
    }
    return scene;
}

} // namespace

TEST(collision_solver, as_many_balls_leave_a_row_as_came_in) {
    for (int moving = 1; moving <= 4; ++moving) {
        Impacts scene = row_of_five(moving, 1.0);
        const CollisionReport report = scene.resolve();
        EXPECT_TRUE(report.converged);
        for (int i = 0; i < 5; ++i) {
            // Each of at most 8 passes ends within the velocity tolerance of 1e-7 m/s.
            EXPECT_NEAR(scene.velocity[static_cast<std::size_t>(i)].v.x(), i >= 5 - moving ? 1.0 : 0.0, 1e-6)
                << moving << " in, ball " << i;
        }
    }
}

TEST(collision_solver, plastic_row_moves_on_together) {
    Impacts scene = row_of_five(2, 0.0);
    scene.resolve();
    for (const Velocity& velocity : scene.velocity) {
        EXPECT_NEAR(velocity.v.x(), 0.4, 1e-5); // sweeps end at changes of 1e-7 m/s, a chain of 5 amplifies
    }
}

TEST(collision_solver, ball_on_a_wall_leaves_with_e_times_its_speed) {
    for (const double e : {0.0, 0.3, 1.0}) {
        Impacts scene;
        add_body(scene.bodies, make_props(Sphere{0.5}, 1000.0, e), {Vec3(0, 0, 0.5), Quat::Identity()},
                 {Vec3(2, 0, -3), Vec3::Zero()});
        add_body(scene.bodies, make_props(Plane{}, 0.0, e), Pose{});
        scene.pair(0, 1);
        const CollisionReport report = scene.resolve();
        EXPECT_EQ(report.collisions, 1);
        EXPECT_LE((scene.velocity[0].v - Vec3(2, 0, 3 * e)).norm(), 1e-12);
        EXPECT_EQ(report.touched, (std::vector<char>{1, 0}));
    }
}

/// Where a contact placed ahead of the impact took the speed, other contacts may have given some of what it took.
TEST(collision_solver, a_ball_that_was_stopped_ahead_gets_back_what_it_lost) {
    for (const double share : {1.0, 0.25, 0.0, -1.0}) {
        Impacts scene;
        add_body(scene.bodies, make_props(Sphere{0.5}, 1000.0, 1.0), {Vec3(0, 0, 0.5), Quat::Identity()});
        add_body(scene.bodies, make_props(Plane{}, 0.0, 1.0), Pose{});
        scene.pair(0, 1);
        const double taken = 0.5 * 9.0 / scene.bodies.props[0].inverse_mass; // [J] at 3 m/s
        ContactMemory& memory = scene.pairs.front().manifold.contacts.front().memory;
        scene.pairs.front().was_ahead = true;
        memory.approach_speed = 3.0;
        memory.p_t.x() = taken;
        scene.lost = {{0, share * taken}};
        scene.resolve();
        EXPECT_NEAR(scene.velocity[0].v.z(), 3.0 * std::sqrt(std::max(share, 0.0)), 1e-9) << share;
    }
}

/// A sliding ball without spin stops slipping if mu >= 2/7 u_t / ((1 + e) u_n): it then rolls with 5/7 of
/// u_t.
TEST(collision_solver, rough_ball_rolls_with_five_sevenths_of_its_speed) {
    Impacts scene;
    add_body(scene.bodies, make_props(Sphere{0.5}, 1000.0, 0.5, 1.0), {Vec3(0, 0, 0.5), Quat::Identity()},
             {Vec3(1.4, 0, -1), Vec3::Zero()});
    add_body(scene.bodies, make_props(Plane{}, 0.0, 0.5, 1.0), Pose{});
    scene.pair(0, 1);
    scene.resolve();
    EXPECT_NEAR(scene.velocity[0].v.x(), 1.0, 1e-6);
    EXPECT_NEAR(scene.velocity[0].w.y(), 2.0, 1e-6); // v / r
    EXPECT_NEAR(scene.velocity[0].v.z(), 0.5, 1e-6);
}

TEST(collision_solver, separating_and_slow_contacts_are_left_alone) {
    Impacts scene = row_of_five(1, 1.0);
    scene.bodies.velocity[0].v.x() = -1.0;
    EXPECT_EQ(scene.resolve().passes, 0);
    EXPECT_EQ(scene.velocity[0].v, Vec3(-1, 0, 0));
    scene.settings.gravity = Vec3(0, 0, -10);
    scene.bodies.velocity[0].v.x() = 0.04; // threshold sqrt(2 * 10 * 1e-4) = 0.0447 m/s
    const CollisionReport report = scene.resolve();
    EXPECT_EQ(report.passes, 0);
    EXPECT_EQ(report.touched, std::vector<char>(5, 0));
}

/// Newton's law with friction can gain energy in an oblique impact of boxes; the solver takes that away.
TEST(collision_solver, oblique_impacts_keep_momentum_and_never_gain_energy) {
    Numbers numbers(1);
    int impacts = 0;
    for (int i = 0; i < 400 && impacts < 100; ++i) {
        Impacts scene;
        const double e = numbers.between(0.0, 1.0);
        const double mu = numbers.between(0.0, 1.0);
        const Pose a = numbers.pose(0.3);
        Pose b = numbers.pose(0.3);
        const Box box_a{Vec3(0.5, 0.3, 0.2)};
        const Box box_b{Vec3(0.2, 0.4, 0.6)};
        // Move b out along x until the boxes just touch.
        double near = 0.0;
        double far = 5.0;
        for (int k = 0; k < 60; ++k) {
            const double middle = 0.5 * (near + far);
            const Pose moved{b.position + Vec3(middle, 0, 0), b.orientation};
            (separation({box_a, a}, {box_b, moved}) > 0.0 ? far : near) = middle;
        }
        b.position.x() += far;
        add_body(scene.bodies, make_props(box_a, 1000.0, e, mu), a,
                 {numbers.vector(3.0), numbers.vector(5.0)});
        add_body(scene.bodies, make_props(box_b, 300.0, e, mu), b,
                 {numbers.vector(3.0), numbers.vector(5.0)});
        scene.pair(0, 1);
        const CollisionReport report = scene.resolve();
        if (report.passes == 0) {
            continue;
        }
        ++impacts;
        EXPECT_TRUE(report.converged);
        const double before = kinetic_energy(scene.bodies, scene.bodies.velocity);
        EXPECT_LE(kinetic_energy(scene.bodies, scene.velocity), before * (1.0 + 1e-12));
        const Vec3 momentum = scene.momentum(scene.bodies.velocity);
        EXPECT_LE((scene.momentum(scene.velocity) - momentum).norm(), 1e-12 * before);
        // Both arms end in the same point up to the gap, 1e-15 m: angular momentum is kept too.
        EXPECT_LE((scene.spin(scene.velocity) - scene.spin(scene.bodies.velocity)).norm(), 1e-12 * before);
    }
    EXPECT_EQ(impacts, 100);
}

/// A tilted rod that bounces elastically and whose slip friction reverses: the law alone would add
/// p_t . (u_t before + after) / 2 > 0.
TEST(collision_solver, energy_that_newtons_law_with_friction_adds_is_taken_away) {
    Numbers numbers(2);
    int taken = 0;
    for (int i = 0; i < 100; ++i) {
        Impacts scene;
        const Box rod{Vec3(0.5, 0.02, 0.03)};
        const Quat tilt = turned(Quat::Identity(), Vec3(0.1, numbers.between(0.4, 1.2), 0.0));
        const Vec3 reach = (tilt.conjugate() * Vec3::UnitZ()).cwiseAbs();
        const Pose pose{Vec3(0, 0, reach.dot(rod.half_extents)), tilt};
        const double e = numbers.between(0.9, 1.0);
        add_body(scene.bodies, make_props(rod, 1000.0, e, 0.8), pose,
                 {Vec3(numbers.between(-1.0, 1.0), 0.0, -2.0), Vec3::Zero()});
        add_body(scene.bodies, make_props(Plane{}, 0.0, e, 0.8), Pose{});
        scene.pair(0, 1);
        const CollisionReport report = scene.resolve();
        const double before = kinetic_energy(scene.bodies, scene.bodies.velocity);
        EXPECT_LE(kinetic_energy(scene.bodies, scene.velocity), before * (1.0 + 1e-12));
        taken += report.energy_removed > 1e-3 * before;
    }
    EXPECT_GT(taken, 5);
}

/// A ball between a wall and a ball `ratio` times as heavy that comes in, all touching: they collide
/// floor(pi / atan(1 / sqrt(ratio))) times (Galperin, Playing pool with pi, 2003).
Impacts squeezed_ball(double ratio) {
    Impacts scene;
    add_body(scene.bodies, make_props(Plane{}, 0.0, 1.0), {Vec3::Zero(), Quat::Identity()});
    add_body(scene.bodies, make_props(Sphere{0.5}, 1.0, 1.0), {Vec3(0, 0, 0.5), Quat::Identity()});
    add_body(scene.bodies, make_props(Sphere{0.5}, ratio, 1.0), {Vec3(0, 0, 1.5), Quat::Identity()},
             {Vec3(0, 0, -1), Vec3::Zero()});
    scene.pair(0, 1);
    scene.pair(1, 2);
    return scene;
}

TEST(collision_solver, a_squeezed_ball_collides_as_often_as_the_digits_of_pi_say) {
    for (const double ratio : {3.0, 100.0, 1e4}) {
        Impacts scene = squeezed_ball(ratio);
        const CollisionReport report = scene.resolve();
        EXPECT_TRUE(report.converged);
        EXPECT_EQ(report.collisions, static_cast<int>(std::floor(std::acos(-1.0) / std::atan(1.0 / std::sqrt(ratio)))));
        const double before = kinetic_energy(scene.bodies, scene.bodies.velocity);
        EXPECT_NEAR(kinetic_energy(scene.bodies, scene.velocity) / before, 1.0, 1e-12);
    }
}

/// What touches both walls cannot leave both: where Newton's law asks for that, the pass is plastic.
TEST(collision_solver, a_row_wedged_between_two_walls_comes_to_rest) {
    Impacts scene;
    for (const double x : {-1.0, 3.0}) {
        add_body(scene.bodies, make_props(Box{}, 0.0, 0.9), {Vec3(x, 0, 0), Quat::Identity()});
    }
    for (int i = 0; i < 3; ++i) {
        add_body(scene.bodies, make_props(Sphere{0.5}, 1000.0, 0.9), {Vec3(i, 0, 0), Quat::Identity()},
                 {Vec3(1.0 - i, 0, 0), Vec3::Zero()});
    }
    scene.pair(0, 2);
    scene.pair(2, 3);
    scene.pair(3, 4);
    scene.pair(1, 4);
    const CollisionReport report = scene.resolve();
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.passes, 12);
    for (const Velocity& velocity : scene.velocity) {
        EXPECT_LE(velocity.v.norm(), 0.05); // below what counts as an impact
    }
}

TEST(collision_solver, passes_that_come_to_no_end_are_reported) {
    Impacts scene = squeezed_ball(1e6); // 3141 collisions
    scene.most_sweeps = 4000;
    const CollisionReport report = scene.resolve();
    EXPECT_FALSE(report.converged);
    EXPECT_LE(report.passes, 400); // ten sweeps are counted for each
    EXPECT_GT(report.passes, 100);
    EXPECT_GT(report.unsettled.change, 0.0);
    EXPECT_GE(std::min(report.unsettled.a, report.unsettled.b), 0);
}
