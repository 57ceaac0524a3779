/// Bodies that keys move: what they carry, drag, push and throw, against closed forms; and that what they give is no gain.
#include "sim/base/error.h"
#include "tests/laws/law_scene.h"
#include "tests/laws/law_solids.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using namespace laws;

sim::CurveKey<4> key(double time, const Vec3& position, double angle = 0.0, sim::Easing easing = sim::Easing::smooth) {
    return {time, easing, {position.x(), position.y(), position.z(), angle}};
}

/// A kinematic box; its pose and velocities at the start are those of its keys.
int add_moved_box(sim::SceneDef& scene, const Vec3& half_extents, std::vector<sim::CurveKey<4>> keys,
                  const sim::MaterialDef& surface) {
    const int index = add_box(scene, half_extents, {}, surface);
    sim::BodyDef& body = scene.bodies[static_cast<std::size_t>(index)];
    body.mass = {};
    body.motion.keys = std::move(keys);
    body.pose = body.motion.pose_at(0.0);
    body.velocity = body.motion.velocity_at(0.0).v;
    body.angular_velocity = body.motion.velocity_at(0.0).w;
    return index;
}

/// A plate goes 1.5 m within `time`, from rest to rest: its acceleration falls evenly from `most` to -most. The friction of a
/// block on it gives the share `grip` of most.
struct Ride {
    double time; ///< [s]
    double grip; ///< [-]
    double way = 1.5; ///< [m]
    double most() const { return 6.0 * way / (time * time); }

    /// Where the block comes to rest [m]. With half the grip it slips until T/2, goes with the plate until 3T/4 and slips
    /// on from there.
    double exact() const {
        if (grip >= 1.0) {
            return way;
        }
        const double friction = 0.5 * most();
        const double speed = 3.0 / 16.0 * most() * time;
        const auto plate_at = [&](double s) { return way * s * s * (3.0 - 2.0 * s); };
        return 0.125 * friction * time * time + plate_at(0.75) - plate_at(0.5) + 0.5 * speed * speed / friction;
    }
};

/// Error of the block's way [m]; gain: of energy, as the run tells it [-].
double ride(Rational h, const Ride& plate, double& gain) {
    sim::SceneDef scene = law_scene(h);
    scene.step.tolerance = 1e-6; // what one may lift bodies by is no gain; in the first steps they have hardly any energy
    const sim::MaterialDef surface = material(0.0, plate.grip * plate.most() / g);
    add_moved_box(scene, {4, 1, 0.5}, {key(0.0, {0, 0, -0.5}), key(plate.time, {plate.way, 0, -0.5})}, surface);
    const int block = add_box(scene, {0.5, 0.5, 0.05}, {{0, 0, 0.05}, Quat::Identity()}, surface);
    sim::World world(scene);
    double x = 0.0;
    run(world, scene, 1.5 * plate.time, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        x = s.bodies[static_cast<std::size_t>(block)].position.x();
        return true;
    });
    return std::abs(x - plate.exact());
}

TEST(law_kinematic, a_block_on_a_plate_sticks_or_slips_as_coulomb_says) {
    for (const double grip : {1.2, 0.5}) {
        const std::string name = grip > 1.0 ? "block that a plate carries" : "block that a plate leaves behind";
        double gain = 0.0;
        const std::vector steps{microseconds(4000), microseconds(2000), microseconds(1000)};
        const Convergence c = converge(name, "way [m]", 1e-5, steps, [&](Rational h) {
            double worst = 0.0;
            for (const double late : {0.0, 0.4, 0.8, 1.2, 1.6}) { // steps: so that friction changes at any part of one
                worst = std::max(worst, ride(h, {0.96 + late * h.value(), grip}, gain));
            }
            return worst;
        });
        record({name, "gain of energy [-]", 4e-3, gain, 1e-4});
        EXPECT_LT(c.errors.back(), 1e-5) << name;
        EXPECT_TRUE(c.is_second_order(1e-9)) << name << ": order " << c.order();
        EXPECT_LT(gain, 1e-4) << name;
    }
}

/// A belt takes a block on a spring with it until static friction gives way, at mu_s N = k x; it slips back about mu_d N / k, and
/// sticks again where it is as fast as the belt: by (mu_s - mu_d) N / k on the other side.
TEST(law_kinematic, a_belt_drags_a_block_on_a_spring_by_stick_and_slip) {
    const double mu_s = 0.4, mu_d = 0.2, speed = 0.2, w0 = 10.0; // [m/s]; [rad/s]
    const sim::MaterialDef surface = material(0.0, mu_s, mu_d);
    const std::vector steps{microseconds(4000), microseconds(2000), microseconds(1000), microseconds(500)};
    double period = 0.0, exact_period = 0.0; // [s]
    const Convergence c = converge("block that a belt drags", "turning points [m]", 2e-4, steps, [&](Rational h) {
        sim::SceneDef scene = law_scene(h);
        scene.step.tolerance = sim::StepSettings{}.tolerance;
        add_moved_box(scene, {20, 1, 0.1}, {key(0.0, {0, 0, -0.1}, 0, sim::Easing::linear), key(60.0, {60.0 * speed, 0, -0.1})}, surface);
        add_box(scene, {0.2, 0.2, 0.1}, {{0, 0, 0.1}, Quat::Identity()}, surface);
        scene.bodies[1].velocity.x() = speed;
        const int carriage = add_trolley(scene, add_frame(scene));
        const double mass = scene.bodies[1].mass.mass, k = w0 * w0 * mass;
        scene.joints[0].spring = sim::SpringDef{k, 0.0, 0.0};
        const double per_mu = (mass + scene.bodies[static_cast<std::size_t>(carriage)].mass.mass) * g / k; // [m]
        const double slip = (mu_s - mu_d) * per_mu, swing = std::hypot(slip, speed / w0);
        exact_period = 2.0 * (pi - std::atan(slip * w0 / speed)) / w0 + 2.0 * slip / speed;
        double least = 0.0, most = 0.0, last_turn = 0.0, v_before = 0.0;
        sim::World world(scene);
        run(world, scene, 3.0, [&](const sim::Snapshot& s, const sim::StepReport&) {
            const double x = s.bodies[1].position.x(), v = s.bodies[1].velocity.x();
            least = std::min(least, x);
            most = std::max(most, x);
            if (v_before < 0.0 && v >= 0.0) {
                const double turn = s.time - h.value() * v / (v - v_before);
                period = turn - std::exchange(last_turn, turn);
            }
            v_before = v;
            return true;
        });
        return std::max(std::abs(least - (mu_d * per_mu - swing)), std::abs(most - (mu_d * per_mu + swing)));
    });
    record({"block that a belt drags", "period, relative", 5e-4, std::abs(period / exact_period - 1.0), 2e-3});
    EXPECT_LT(c.errors.back(), 1e-4); // static friction gives way up to a step late
    EXPECT_NEAR(period / exact_period, 1.0, 2e-3);
}

TEST(law_kinematic, a_ball_leaves_a_piston_as_newton_says) {
    for (const double e : {0.0, 0.5, 1.0}) {
        sim::SceneDef scene = law_scene(microseconds(1000));
        scene.step.gravity.setZero();
        scene.step.impacts = e == 1.0 ? sim::ImpactHandling::stop : sim::ImpactHandling::ahead;
        const double speed = 3.0; // [m/s]
        add_moved_box(scene, {0.5, 1, 1}, {key(0.0, {-1, 0, 0}, 0, sim::Easing::linear), key(1.0, {speed - 1, 0, 0})},
                      material(e, 0.0));
        const int ball = add_sphere(scene, 0.25, {0, 0, 0}, material(e, 0.0));
        sim::World world(scene);
        double gain = 0.0, v = 0.0;
        run(world, scene, 0.5, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            gain = std::max(gain, report.energy_gain);
            v = s.bodies[static_cast<std::size_t>(ball)].velocity.x();
            return true;
        });
        EXPECT_NEAR(v, (1.0 + e) * speed, 1e-9) << e;
        EXPECT_LT(gain, 1e-9) << e;
    }
}

/// A ball that rolls on a turntable goes round in a circle that closes, at 2/7 of the table's rate (Earnshaw 1844).
TEST(law_kinematic, a_ball_on_a_turntable_comes_back) {
    const double rate = 2.0 * pi, radius = 0.05, speed = 0.3, from = 0.5; // [rad/s], [m], [m/s], [m] from the axis
    const std::vector steps{microseconds(4000), microseconds(2000), microseconds(1000)};
    const Convergence c = converge("ball on a turntable", "place and speed after two circles [m], [m/s]", 1e-5, steps, [&](Rational h) {
        sim::SceneDef scene = law_scene(h);
        scene.step.tolerance = sim::StepSettings{}.tolerance;
        const sim::MaterialDef surface = material(0.0, 0.8);
        add_moved_box(scene, {2, 2, 0.1}, {key(0.0, {0, 0, -0.1}, 0.0, sim::Easing::linear), key(20.0, {0, 0, -0.1}, 20.0 * rate)},
                      surface);
        const int ball = add_sphere(scene, radius, {from, 0, radius}, surface);
        sim::BodyDef& body = scene.bodies[static_cast<std::size_t>(ball)];
        body.velocity = {speed, 0, 0};
        body.angular_velocity = {rate * from / radius, speed / radius, 0}; // the touch moves as the table does there
        const sim::BodySnapshot end = run_to(scene, 2.0 * 2.0 * pi / (2.0 / 7.0 * rate)).bodies[static_cast<std::size_t>(ball)];
        return std::max((end.position - Vec3(from, 0, radius)).norm(), (end.velocity - Vec3(speed, 0, 0)).norm());
    });
    EXPECT_LT(c.errors.back(), 1e-5);
    EXPECT_TRUE(c.is_second_order(1e-9)) << "order " << c.order();
}

/// The block takes the turntable's speed with it where friction gives its centripetal force, and not where it does not.
TEST(law_kinematic, a_turntable_carries_a_block_round) {
    const auto slip = [](Rational h, double mu) {
        sim::SceneDef scene = law_scene(h);
        scene.step.tolerance = 1e-6;
        const sim::MaterialDef surface = material(0.0, mu);
        const double turn = 2.0 * pi;
        add_moved_box(scene, {3, 3, 0.5}, {key(0.0, {0, 0, -0.5}), key(4.0, {0, 0, -0.5}, turn)}, surface);
        const int block = add_box(scene, {0.2, 0.2, 0.05}, {{1, 0, 0.05}, Quat::Identity()}, surface);
        double gain = 0.0;
        sim::World world(scene);
        sim::Snapshot end;
        run(world, scene, 4.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            gain = std::max(gain, report.energy_gain);
            end = s;
            return true;
        });
        EXPECT_LT(gain, 1e-5) << mu;
        return (end.bodies[static_cast<std::size_t>(block)].position - Vec3(1, 0, 0.05)).norm();
    };
    // At T/2 the table turns fastest, 1.5 times as fast as on the average: w^2 r = 5.55 m/s^2 = 0.566 g.
    const Convergence c = converge("block on a turntable", "where it is after a turn [m]", 1e-5,
                                   {microseconds(4000), microseconds(2000), microseconds(1000)},
                                   [&](Rational h) { return slip(h, 0.6); });
    EXPECT_LT(c.errors.back(), 1e-5);
    EXPECT_TRUE(c.is_second_order(1e-9)) << c.order();
    EXPECT_GT(slip(microseconds(1000), 0.54), 0.01);
}

/// A lift, a push, an impact and what hangs on it at once.
TEST(law_kinematic, what_a_hand_gives_is_no_gain) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step.tolerance = 1e-6;
    add_moved_box(scene, {1, 1, 0.5}, {key(0.0, {0, 0, -0.5}), key(0.5, {0, 0, 1.5}), key(1.0, {2, 0, 0.5})}, material(0.3, 0.8));
    add_box(scene, {0.2, 0.2, 0.2}, {{0, 0, 0.2}, Quat::Identity()}, material(0.3, 0.8));
    add_sphere(scene, 0.2, {0.5, 0.5, 0.7}, material(0.9, 0.3));
    add_box(scene, {0.1, 0.1, 0.5}, {{1.2, 0, -0.5}, Quat::Identity()});
    add_joint(scene, sim::JointKind::ball, {3, 0}, {1.2, 0, 0});
    sim::World world(scene);
    const double start = energy(scene, world.take_snapshot());
    double gain = 0.0, highest = start;
    run(world, scene, 1.5, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        highest = std::max(highest, energy(scene, s));
        return true;
    });
    record({"box, ball and pendulum on a hand", "gain of energy in 1.5 s [-]", 1e-3, gain, 1e-4});
    EXPECT_LT(gain, 1e-4);
    EXPECT_GT(highest, start + scene.bodies[1].mass.mass * g);
}

/// Two hands close further than what is between them is wide, lift it, and let it go. No motion gives what they ask for: contacts
/// give way, and hold it by friction; asked for all of it, impulses grow without end, and throw it at hundreds of metres a second.
TEST(law_kinematic, what_hands_pinch_is_lifted_and_let_go) {
    const double half = 0.05; // of what they pinch [m]
    const std::pair<std::string, sim::Shape> shapes[] = {
        {"a cube", sim::Box{Vec3::Constant(half)}}, {"a ball", sim::Sphere{half}}, {"a cylinder", sim::Cylinder{half, half}}};
    std::int64_t sweeps = 0, steps = 0;
    for (const auto& [name, shape] : shapes) {
        for (const double too_far : {2e-4, 5e-3}) { // each of them [m]
            sim::SceneDef scene;
            const sim::MaterialDef surface = material(0.0, 0.5);
            add_plane(scene, Quat::Identity(), surface);
            for (const double side : {-1.0, 1.0}) {
                const auto at = [&](double apart, double height) { return Vec3(side * (half + 0.02 + apart), 0, half + height); };
                const auto stop_at = [&](double time, double apart, double height) {
                    return key(time, at(apart, height), 0.0, sim::Easing::stop);
                };
                add_moved_box(scene, {0.02, 0.06, 0.04},
                              {stop_at(0.05, 0.02, 0.0), stop_at(0.25, -too_far, 0.0), stop_at(0.7, -too_far, 0.3),
                               stop_at(0.8, -too_far, 0.3), stop_at(0.9, 0.02, 0.3)},
                              surface);
            }
            const auto body = static_cast<std::size_t>(add_box(scene, Vec3::Constant(half), {{0, 0, half}, Quat::Identity()}, surface));
            scene.bodies[body].shape = shape;
            scene.bodies[body].mass = sim::mass_properties(shape, 1000.0);
            sim::World world(scene);
            double gain = 0.0, deepest = 0.0, fastest = 0.0, aside = 0.0, height = 0.0;
            run(world, scene, 0.95, [&](const sim::Snapshot& s, const sim::StepReport& report) {
                gain = std::max(gain, report.energy_gain);
                deepest = std::max(deepest, report.max_penetration);
                sweeps += report.contact_iterations + report.collision_iterations;
                fastest = std::max(fastest, s.bodies[body].velocity.norm());
                aside = std::abs(s.bodies[body].velocity.x());
                height = s.time <= 0.8 ? s.bodies[body].position.z() : height;
                return true;
            });
            const std::string what = fmt::format("{}, pinched {} m too far", name, 2.0 * too_far);
            record({what, "lifted by 0.3 m, error [m]", 1e-3, height - half - 0.3, 1e-3});
            record({what, "overlap of a side beyond half of it [m]", 1e-3, deepest - too_far, scene.step.tolerance});
            record({what, "largest speed [m/s]", 1e-3, fastest, 1.5});
            record({what, "aside when let go [m/s]", 1e-3, aside, 0.1});
            record({what, "gain of energy [-]", 1e-3, gain, sim::energy_gain_allowed});
            EXPECT_NEAR(height, half + 0.3, 1e-3) << what;
            EXPECT_LE(deepest, too_far + scene.step.tolerance) << what;
            EXPECT_LE(fastest, 1.5) << what;
            EXPECT_LE(aside, 0.1) << what;
            EXPECT_LE(gain, sim::energy_gain_allowed) << what;
            steps += world.step_index();
        }
    }
    EXPECT_LE(sweeps / steps, 180);
}

/// A hand, or a plate that a joint holds at it, presses a wall of cubes against a block that is fixed, further than there is room. It
/// sinks in as far, and nothing else does, though much rests on what is pressed.
TEST(law_kinematic, what_a_hand_presses_gives_way_to_the_hand_alone) {
    const double half = 0.05;    // of a cube [m]
    const double too_far = 5e-3; // [m]
    for (const bool has_plate : {false, true}) {
        sim::SceneDef scene;
        const sim::MaterialDef surface = material(0.0, 0.5);
        add_plane(scene, Quat::Identity(), surface);
        const int fixed = add_box(scene, {0.02, 0.2, 0.3}, {{3.0 * half + 0.02, 0, 0.3}, Quat::Identity()}, surface);
        scene.bodies[static_cast<std::size_t>(fixed)].mass = {};
        for (int row = 0; row < 4; ++row) {
            for (const double column : {-1.0, 0.0, 1.0}) {
                add_box(scene, Vec3::Constant(half), {{2.0 * half * column, 0, half * (1 + 2 * row)}, Quat::Identity()}, surface);
            }
        }
        const Vec3 face(-3.0 * half, 0, half); // that is pressed
        const double plate = has_plate ? 0.03 : 0.0;
        const auto stop_at = [&](double time, double x) {
            return key(time, face + Vec3(x - plate - 0.02, 0, 0), 0.0, sim::Easing::stop);
        };
        int presses = add_moved_box(scene, {0.02, 0.04, 0.04},
                                    {stop_at(0.1, -0.02), stop_at(0.3, too_far), stop_at(0.4, too_far), stop_at(0.6, -0.02)}, surface);
        if (has_plate) {
            const int hand = presses;
            presses = add_box(scene, {0.01, 0.04, 0.04}, {face - Vec3(0.03, 0, 0), Quat::Identity()}, surface);
            add_joint(scene, sim::JointKind::hinge, {presses, hand}, face - Vec3(0.05, 0, 0), Vec3::UnitZ());
        }
        sim::World world(scene);
        double gain = 0.0, deepest = 0.0, elsewhere = 0.0, open = 0.0;
        run(world, scene, 0.8, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            gain = std::max(gain, report.energy_gain);
            for (const reference::PairGap& pair : reference::near_pairs(solids(scene), placements(s), 0.0, jointed_pairs(scene))) {
                double& most = pair.b == presses ? deepest : elsewhere;
                most = std::max(most, -pair.gap);
            }
            open = std::max(open, largest_joint_gap(scene, s));
            return true;
        });
        const std::string what =
            fmt::format("cubes pressed against a block {} m too far, by {}", too_far, has_plate ? "a hand's plate" : "a hand");
        record({what, "it sinks in less or more than that [m]", 1e-3, std::abs(deepest - too_far), 1e-3});
        record({what, "overlap of others [m]", 1e-3, elsewhere, scene.step.tolerance});
        record({what, "joint's gap [m]", 1e-3, open, scene.step.joint_tolerance});
        record({what, "gain of energy [-]", 1e-3, gain, sim::energy_gain_allowed});
        EXPECT_NEAR(deepest, too_far, 1e-3) << what;
        EXPECT_LE(elsewhere, scene.step.tolerance) << what;
        EXPECT_LE(open, scene.step.joint_tolerance) << what;
        EXPECT_LE(gain, sim::energy_gain_allowed) << what;
    }
}

/// No motion keeps a chain closed that two hands pull longer than it is.
TEST(law_kinematic, a_chain_that_hands_tear_ends_the_run_and_says_so) {
    constexpr double link = 0.1; // [m]
    sim::SceneDef scene;
    for (const double side : {-1.0, 1.0}) {
        const Vec3 at(side * 2.5 * link, 0, 1);
        add_moved_box(scene, Vec3::Constant(0.05), {key(0.0, at), key(1.0, at + Vec3(side * 0.5, 0, 0))}, {});
    }
    for (int i = 0; i < 4; ++i) {
        const double x = (i - 1.5) * link;
        const int index = add_box(scene, {0.04, 0.01, 0.01}, {{x, 0, 1}, Quat::Identity()}, {});
        scene.bodies[static_cast<std::size_t>(index)].name = fmt::format("link {}", i);
        add_joint(scene, sim::JointKind::ball, {index, i == 0 ? 0 : index - 1}, {x - 0.5 * link, 0, 1}, Vec3::UnitY());
    }
    add_joint(scene, sim::JointKind::ball, {5, 1}, {2.0 * link, 0, 1}, Vec3::UnitY());
    try {
        sim::World world(scene);
        for (int i = 0; i < 1000; ++i) {
            world.step();
        }
        FAIL() << "it goes on";
    } catch (const sim::Error& error) {
        EXPECT_EQ(error.code(), sim::ExitCode::stopped);
        EXPECT_NE(std::string(error.what()).find("the joint of 'link"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("is torn open by "), std::string::npos) << error.what();
    }
}

} // namespace
