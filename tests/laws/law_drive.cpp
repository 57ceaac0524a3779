/// Springs and motors of hinges and sliders against closed forms: period, damping, any stiffness; a motor at its limit and at
/// its speed; and the energy of both.
#include "sim/base/random.h"
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

namespace {

using namespace laws;

struct Machine {
    const char* name;
    sim::JointKind kind;
    double offset = 0.0; ///< [m]
    double gain = 1e-6;  ///< [-] of energy at most: what turns about its middle is a straight line for the method
    bool has_trolley = false;
};
const Machine wheel{"wheel", sim::JointKind::hinge};
const Machine cart{"cart", sim::JointKind::slider};
const Machine rod{"rod", sim::JointKind::hinge, 0.5, 1e-4};
/// How fast its spring swings is told by the block alone, not by the carriage that holds its other end.
const Machine block{"block", sim::JointKind::slider, 0.0, 1e-6, true};

/// A rod that turns about the z axis through its end or, with offset 0, its middle; or slides along x: one degree of freedom
/// without gravity.
sim::SceneDef driven_scene(Rational h, const Machine& machine) {
    sim::SceneDef scene = law_scene(h);
    scene.step.gravity.setZero();
    scene.step.tolerance = 1e-6;
    const int frame = add_frame(scene);
    const int body = add_box(scene, {0.5, 0.05, 0.05}, {{machine.offset, 0, 0}, Quat::Identity()});
    if (machine.has_trolley) {
        add_trolley(scene, frame);
        return scene;
    }
    add_joint(scene, machine.kind, {body, frame}, Vec3::Zero(),
              machine.kind == sim::JointKind::hinge ? Vec3::UnitZ() : Vec3::UnitX());
    return scene;
}

/// Of the hinge's rod about its axis [kg m^2], or mass of the slider [kg].
double inertia_of(const sim::SceneDef& scene) {
    const sim::MassProperties& mass = scene.bodies[1].mass;
    const double offset = scene.bodies[1].pose.position.norm();
    return scene.joints[0].kind == sim::JointKind::hinge ? mass.inertia(2, 2) + offset * offset * mass.mass : mass.mass;
}

/// Angle [rad] or way [m].
double position_of(const sim::SceneDef& scene, const sim::Snapshot& s) {
    const Vec3 along = s.bodies[1].orientation * Vec3::UnitX();
    return scene.joints[0].kind == sim::JointKind::hinge ? std::atan2(along.y(), along.x())
                                                         : s.bodies[1].position.x() - scene.bodies[1].pose.position.x();
}

double speed_of(const sim::SceneDef& scene, const sim::Snapshot& s) {
    return scene.joints[0].kind == sim::JointKind::hinge ? s.bodies[1].angular_velocity.z() : s.bodies[1].velocity.x();
}

/// From rest, 0.7 rad or m away from where the spring rests, for three periods: x = rest (1 - e^(-d t) (cos w t + d/w sin w t)).
TEST(law_drive, a_spring_swings_with_its_frequency_and_damping) {
    for (const Machine& machine : {wheel, cart, rod, block}) {
        for (const double damping : {0.0, 0.1}) { // of the critical one [-]
            const double rest = 0.7, w0 = 12.0;   // [rad] or [m]; [rad/s]
            const double d = damping * w0, w = std::sqrt(w0 * w0 - d * d);
            const double duration = 3.0 * 2.0 * pi / w0;
            const std::string name = std::string("spring of a ") + machine.name + (damping > 0.0 ? ", damped" : "");
            double gain = 0.0;
            const Convergence c = converge(name, "position, worst of three periods", 5e-4,
                                           {microseconds(4000), microseconds(2000), microseconds(1000)}, [&](Rational h) {
                sim::SceneDef scene = driven_scene(h, machine);
                const double k = w0 * w0 * inertia_of(scene);
                scene.joints[0].spring = sim::SpringDef{k, 2.0 * d * inertia_of(scene), rest};
                sim::World world(scene);
                double worst = 0.0;
                run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport& report) {
                    const double decay = std::exp(-d * s.time);
                    const double exact = rest * (1.0 - decay * (std::cos(w * s.time) + d / w * std::sin(w * s.time)));
                    const double exact_speed = rest * decay * w0 * w0 / w * std::sin(w * s.time);
                    worst = std::max({worst, std::abs(position_of(scene, s) - exact),
                                      std::abs(speed_of(scene, s) - exact_speed) / w0});
                    gain = std::max(gain, report.energy_gain);
                    return true;
                });
                return worst;
            });
            record({name, "gain of energy [-]", 4e-3, gain, machine.gain});
            EXPECT_LT(c.errors.back(), 5e-4) << name;
            EXPECT_TRUE(c.is_second_order(1e-12)) << name << ": order " << c.order();
            EXPECT_LT(gain, machine.gain) << name;
        }
    }
}

/// Coulomb's friction takes the same from each half of a swing, 2 mu N / k, until what is left does not move the block.
TEST(law_drive, a_block_on_a_spring_comes_to_rest_where_friction_stops_it) {
    const double mu = 0.2, rest = 0.7, w0 = 12.0; // [m]; [rad/s]
    const Convergence c = converge("block on a spring and a floor", "place of rest [m]", 2e-5,
                                   {microseconds(4000), microseconds(2000), microseconds(1000)}, [&](Rational h) {
        sim::SceneDef scene = driven_scene(h, block);
        scene.step.gravity = {0, 0, -g};
        scene.bodies[1].material = material(0.0, mu);
        add_plane(scene, Quat::Identity(), material(0.0, mu));
        scene.bodies.back().pose.position.z() = -0.05;
        const double mass = inertia_of(scene);
        scene.joints[0].spring = sim::SpringDef{w0 * w0 * mass, 0.0, rest};
        const double held = mu * (mass + scene.bodies[2].mass.mass) * g / (w0 * w0 * mass); // [m]
        double left = rest, side = -1.0;
        for (; left > held; left -= 2.0 * held) {
            side = -side;
        }
        const sim::Snapshot s = run_to(scene, 7.0); // 23 halves of a swing: 6 s
        EXPECT_LT(std::abs(speed_of(scene, s)), 1e-5) << h.value();
        return std::abs(position_of(scene, s) - (rest + side * left));
    });
    EXPECT_LT(c.errors.back(), 2e-5);
}

/// A base a hundred times lighter than its load, which would swing by itself at 0.3 rad a step if the floor did not hold it.
TEST(law_drive, a_load_on_a_light_base_that_stands_goes_on_swinging) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step.tolerance = sim::StepSettings{}.tolerance;
    const sim::MaterialDef surface = material(0.0, 0.5);
    add_plane(scene, Quat::Identity(), surface);
    const int load = add_box(scene, Vec3::Constant(0.1), {{0, 0, 0.5}, Quat::Identity()}, surface, 1250.0); // 10 kg
    const int base = add_box(scene, {0.1, 0.1, 0.05}, {{0, 0, 0.05}, Quat::Identity()}, surface, 25.0);   // 0.1 kg
    add_joint(scene, sim::JointKind::slider, {load, base}, {0, 0, 0.5}, Vec3::UnitZ());
    scene.joints[0].spring = sim::SpringDef{1e4, 0.0, 10.0 * g / 1e4};
    const double speed = 0.1; // [m/s]
    scene.bodies[static_cast<std::size_t>(load)].velocity.z() = speed;
    double fastest = 0.0; // [m/s] in the last second
    sim::World world(scene);
    run(world, scene, 20.0, [&](const sim::Snapshot& s, const sim::StepReport&) {
        fastest = s.time > 19.0 ? std::max(fastest, s.bodies[static_cast<std::size_t>(load)].velocity.z()) : 0.0;
        return true;
    });
    record({"load on a light base that stands", "amplitude lost in 20 s, relative", 1e-3, 1.0 - fastest / speed, 1e-2});
    EXPECT_NEAR(fastest / speed, 1.0, 1e-2);
}

/// However stiff, at one step: it stays where it was let go and keeps its energy.
TEST(law_drive, a_spring_is_stable_at_any_stiffness) {
    for (const Machine& machine : {wheel, cart}) {
        for (const double phase : {1e-3, 1.0, 30.0, 1e3, 1e6}) { // w h
            for (const double damping : {0.0, 1.0}) {
                sim::SceneDef scene = driven_scene(microseconds(10000), machine);
                const double w0 = phase / 0.01;
                scene.joints[0].spring = sim::SpringDef{w0 * w0 * inertia_of(scene), 2.0 * damping * w0 * inertia_of(scene), 0.1};
                sim::World world(scene);
                double farthest = 0.0, gain = 0.0;
                run(world, scene, 5.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
                    farthest = std::max(farthest, std::abs(position_of(scene, s) - 0.1));
                    gain = std::max(gain, report.energy_gain);
                    return true;
                });
                EXPECT_LT(farthest, 0.1 * (1.0 + 1e-6)) << machine.name << " " << phase << " " << damping;
                EXPECT_LT(gain, 1e-6) << machine.name << " " << phase << " " << damping;
            }
        }
    }
}

/// A box falls onto a pan that a spring holds; whatever its stiffness it comes to rest there, and nothing is gained.
TEST(law_drive, what_falls_on_a_stiff_spring_comes_to_rest) {
    for (const double stiffness : {1e5, 1e8, 1e12, 1e30, 1e99}) {
        sim::SceneDef scene = law_scene(microseconds(1000));
        scene.step.tolerance = 1e-5;
        const int frame = add_frame(scene);
        const int pan = add_box(scene, {1, 1, 0.05}, {{0, 0, -0.05}, Quat::Identity()}, material(0.0, 0.5));
        add_box(scene, {0.2, 0.2, 0.2}, {{0.1, 0.2, 0.5}, Quat::Identity()}, material(0.0, 0.5));
        add_joint(scene, sim::JointKind::slider, {pan, frame}, Vec3::Zero(), Vec3::UnitZ());
        const double rest = scene.bodies[1].mass.mass * g / stiffness; // its own weight leaves it at 0
        scene.joints[0].spring = sim::SpringDef{stiffness, 0.3 * std::sqrt(stiffness * scene.bodies[1].mass.mass), rest};
        sim::World world(scene);
        double gain = 0.0, height = 0.0, speed = 0.0;
        run(world, scene, 3.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            gain = std::max(gain, report.energy_gain);
            height = s.bodies[2].position.z() - 0.2;
            speed = s.bodies[2].velocity.norm();
            return true;
        });
        EXPECT_NEAR(height, -scene.bodies[2].mass.mass * g / stiffness, 1e-4) << stiffness;
        EXPECT_LT(speed, 1e-3) << stiffness;
        EXPECT_LT(gain, 1e-4) << stiffness;
    }
}

/// The axle's answer to an impact that is placed ahead is no force: half of it does not act before the impact, nor after it.
TEST(law_drive, a_box_that_falls_on_a_wheel_gains_nothing) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step.tolerance = 1e-5;
    const int frame = add_frame(scene);
    const int wheel_body = add_box(scene, {1, 1, 0.05}, {{0, 0, -0.05}, Quat::Identity()}, material(0.2, 0.5));
    add_box(scene, {0.2, 0.2, 0.2}, {{0.1, 0.2, 0.5}, Quat::Identity()}, material(0.2, 0.5));
    add_joint(scene, sim::JointKind::hinge, {wheel_body, frame}, Vec3::Zero(), Vec3::UnitZ());
    sim::World world(scene);
    double gain = 0.0;
    run(world, scene, 1.0, [&](const sim::Snapshot&, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        return true;
    });
    record({"box that falls on a wheel", "gain of energy [-]", 1e-3, gain, 1e-4});
    EXPECT_LT(gain, 1e-4); // 0.02 where it counts as one
}

/// With limit / inertia up to its speed, exactly, and then at its speed for ever; its work is no gain.
TEST(law_drive, a_motor_speeds_up_with_its_limit_and_keeps_its_speed) {
    for (const Machine& machine : {wheel, cart}) {
        for (const double speed : {3.0, -3.0}) {
            sim::SceneDef scene = driven_scene(microseconds(1000), machine);
            const double acceleration = 7.3; // [rad/s^2] or [m/s^2]
            scene.joints[0].motor = sim::MotorDef{speed, acceleration * inertia_of(scene)};
            sim::World world(scene);
            double worst = 0.0, at_speed = 0.0, gain = 0.0;
            const double reached = std::abs(speed) / acceleration;
            run(world, scene, 2.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
                gain = std::max(gain, report.energy_gain);
                const double error = std::abs(speed_of(scene, s) - std::copysign(std::min(acceleration * s.time, 3.0), speed));
                double& found = s.time < reached - 0.002 ? worst : at_speed;
                found = s.time < reached - 0.002 || s.time > reached + 0.002 ? std::max(found, error) : found;
                return true;
            });
            record({std::string("motor of a ") + machine.name, "speed while it speeds up", 1e-3, worst, 1e-10});
            record({std::string("motor of a ") + machine.name, "speed", 1e-3, at_speed, 1e-10});
            EXPECT_LT(worst, 1e-10);
            EXPECT_LT(at_speed, 1e-10);
            EXPECT_LT(gain, 1e-5); // the step in which it reaches its speed
        }
    }
}

/// Links with motors of all directions, speeds and limits, far more of which are too weak than strong enough. Where all that are on the
/// wrong side of their limits change at once, some take turns for ever, and joints are torn open.
TEST(law_drive, of_a_chain_of_motors_those_at_their_limits_are_found) {
    constexpr int links = 24;
    sim::Random random(1);
    const auto within = [&](double most) { return between(random, -most, most); };
    sim::SceneDef scene;
    int last = add_frame(scene);
    for (int i = 0; i < links; ++i) {
        const int link = add_box(scene, {0.1, 0.03, 0.03}, {{0.1 + 0.2 * i, 0, 0}, Quat::Identity()});
        const double x = within(1.0), y = within(1.0), z = within(1.0);
        add_joint(scene, sim::JointKind::hinge, {link, last}, {0.2 * i, 0, 0}, Vec3(x, y, z).normalized());
        const double decades = within(1.0), speed = within(10.0);
        scene.joints.back().motor = sim::MotorDef{speed, 5.0 * std::pow(10.0, decades)};
        last = link;
    }
    sim::World world(scene);
    run(world, scene, 0.2, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        EXPECT_FALSE(report.at_iteration_limit) << s.time;
        EXPECT_EQ(report.energy_gain, 0.0);
        EXPECT_LT(largest_joint_gap(scene, s), 1e-9);
        return !HasFailure();
    });
}

/// A motor that lifts a rod as far as its torque goes: it stands where gravity's is as large, and swings about there.
TEST(law_drive, a_motor_that_is_too_weak_stalls_where_the_load_is_its_limit) {
    sim::SceneDef scene = driven_scene(microseconds(1000), rod);
    scene.step.gravity = Vec3(0, -g, 0);
    const double load = scene.bodies[1].mass.mass * g * 0.5; // [N m] of the level rod
    scene.bodies[1].pose = {{0, -0.5, 0}, Quat(Eigen::AngleAxisd(-0.5 * pi, Vec3::UnitZ()))};
    scene.joints[0].motor = sim::MotorDef{1.0, 0.5 * load};
    scene.joints[0].spring = sim::SpringDef{0.0, 0.3 * load, 0.0}; // brings it to rest
    sim::World world(scene);
    double gain = 0.0, angle = 0.0;
    run(world, scene, 8.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        angle = position_of(scene, s);
        return true;
    });
    EXPECT_NEAR(angle, -0.5 * pi + std::asin(0.5), 1e-4);
    EXPECT_LT(gain, 1e-5);
}

/// Balls that bounce elsewhere restart no motor, and none of its work is counted twice.
TEST(law_drive, a_brake_takes_what_it_takes_whatever_collides_elsewhere) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    const int frame = add_frame(scene);
    const int wheel_body = add_box(scene, {0.5, 0.05, 0.05}, {{0, 0, 20}, Quat::Identity()});
    scene.bodies[1].angular_velocity = Vec3(0, 0, 20);
    add_joint(scene, sim::JointKind::hinge, {wheel_body, frame}, {0, 0, 20}, Vec3::UnitZ());
    scene.joints[0].motor = sim::MotorDef{0.0, 5.0 * scene.bodies[1].mass.inertia(2, 2)};
    add_plane(scene, Quat::Identity(), material(1.0, 0.5));
    for (int i = 0; i < 4; ++i) {
        add_sphere(scene, 0.1, {5.0 + i, 0, 0.5 + 0.1 * i}, material(1.0, 0.5));
    }
    sim::World world(scene);
    double gain = 0.0;
    int collisions = 0;
    run(world, scene, 2.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        collisions += report.collisions;
        EXPECT_NEAR(s.bodies[1].angular_velocity.z(), 20.0 - 5.0 * s.time, 1e-9);
        return true;
    });
    EXPECT_GT(collisions, 10);
    EXPECT_LT(gain, 1e-9);
}

/// A ball that bounces on a cart without friction takes none of what its motor gives.
TEST(law_drive, a_motor_gives_what_it_gives_whatever_bounces_on_its_cart) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    const int frame = add_frame(scene);
    const int cart_body = add_box(scene, {3, 0.5, 0.05}, {}, material(1.0, 0.0));
    add_joint(scene, sim::JointKind::slider, {cart_body, frame}, Vec3::Zero(), Vec3::UnitX());
    const double acceleration = 2.0; // [m/s^2]
    scene.joints[0].motor = sim::MotorDef{100.0, acceleration * scene.bodies[1].mass.mass};
    add_sphere(scene, 0.1, {0, 0, 0.2}, material(1.0, 0.0));
    sim::World world(scene);
    int collisions = 0;
    run(world, scene, 1.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        collisions += report.collisions;
        EXPECT_NEAR(s.bodies[1].velocity.x(), acceleration * s.time, 1e-9);
        return true;
    });
    EXPECT_GE(collisions, 3);
}

/// A block on a plate on a spring on a base: a ball taps the block, too softly to be told from rest below it. Half kicks of a light
/// base, which its spring presses to the floor, are no push by the floor alone.
TEST(law_drive, what_bears_a_spring_is_told_at_rest_when_its_load_is_tapped) {
    for (const double mass : {100.0, 1.0}) { // [kg] of the base
        sim::SceneDef scene = law_scene(microseconds(1000));
        scene.step.tolerance = 1e-4;
        const sim::MaterialDef surface = material(0.5, 0.5);
        add_plane(scene, Quat::Identity(), surface);
        const Vec3 half(0.5, 0.5, 0.05);
        const int base = add_box(scene, half, {{0, 0, 0.05}, Quat::Identity()}, surface, mass / (8.0 * half.prod()));
        const int plate = add_box(scene, {0.2, 0.2, 0.05}, {{0, 0, 0.35}, Quat::Identity()}, surface);
        add_box(scene, {0.1, 0.1, 0.1}, {{0, 0, 0.5}, Quat::Identity()}, surface);
        add_sphere(scene, 0.01, {0, 0, 0.615}, surface);
        add_joint(scene, sim::JointKind::slider, {plate, base}, {0, 0, 0.2}, Vec3::UnitZ());
        const double load = (scene.bodies[2].mass.mass + scene.bodies[3].mass.mass) * g;
        scene.joints[0].spring = sim::SpringDef{load / 0.1, 0.0, 0.1};
        sim::World world(scene);
        double speed = 0.0;
        int collisions = 0;
        run(world, scene, 0.3, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            speed = std::max(speed, s.bodies[static_cast<std::size_t>(base)].velocity.norm());
            collisions += report.collisions;
            return true;
        });
        EXPECT_GE(collisions, 1) << mass;
        EXPECT_LE(collisions, 10) << mass;
        EXPECT_LE(speed, 1e-4) << mass;
    }
}

/// A box on a light pan, whose spring is stiff for the step, and a ball that bounces on the box: the pan moves about as fast as the box,
/// at 0.3 m/s at most. Half a step's load alone would give the pan of 10 g 31 m/s.
TEST(law_drive, what_is_light_and_bears_much_is_not_thrown) {
    for (const double mass : {1.0, 0.01}) { // [kg]
        for (const double stiffness : {1e5, 1e8, 1e12}) {
            sim::SceneDef scene;
            const sim::MaterialDef surface = material(0.5, 0.5);
            const int frame = add_frame(scene);
            const Vec3 half(0.5, 0.5, 0.05);
            const int pan = add_box(scene, half, {{0, 0, -0.05}, Quat::Identity()}, surface, mass / (8.0 * half.prod()));
            add_box(scene, {0.2, 0.2, 0.2}, {{0.1, 0.2, 0.2}, Quat::Identity()}, surface);
            add_sphere(scene, 0.1, {0.1, 0.2, 0.7}, surface);
            add_joint(scene, sim::JointKind::slider, {pan, frame}, Vec3::Zero(), Vec3::UnitZ());
            const double load = mass + scene.bodies[2].mass.mass;
            scene.joints[0].spring = sim::SpringDef{stiffness, 0.6 * std::sqrt(stiffness * load), load * g / stiffness};
            sim::World world(scene);
            double gain = 0.0, fastest = 0.0;
            run(world, scene, 1.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
                gain = std::max(gain, report.energy_gain);
                fastest = std::max(fastest, s.bodies[1].velocity.norm());
                return true;
            });
            EXPECT_LT(gain, sim::energy_gain_allowed) << mass << " " << stiffness;
            EXPECT_LT(fastest, 0.5) << mass << " " << stiffness;
        }
    }
}

/// Nothing but the way along the axis is free, whatever pulls and turns.
TEST(law_drive, a_slider_holds_its_axis) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step.gravity.setZero();
    const int rail = add_box(scene, {1, 0.1, 0.1}, {});
    const Vec3 axis = Vec3(1, 2, -2) / 3.0;
    const int sled = add_box(scene, {0.2, 0.3, 0.1}, {{0.3, 0.1, 0.2}, Quat::Identity()});
    scene.bodies[static_cast<std::size_t>(rail)].angular_velocity = Vec3(1, -2, 0.5);
    scene.bodies[static_cast<std::size_t>(sled)].angular_velocity = Vec3(1, -2, 0.5);
    scene.bodies[static_cast<std::size_t>(sled)].velocity = Vec3(1, -2, 0.5).cross(Vec3(0.3, 0.1, 0.2));
    add_joint(scene, sim::JointKind::slider, {sled, rail}, {0.2, 0, 0.1}, axis);
    sim::World world(scene);
    const Vec3 before = angular_momentum(scene, world.take_snapshot());
    const double start = energy(scene, world.take_snapshot());
    double across = 0.0, turned = 0.0, lost = 0.0;
    sim::Snapshot end;
    run(world, scene, 1.0, [&](const sim::Snapshot& s, const sim::StepReport&) {
        const sim::BodySnapshot& a = s.bodies[1];
        const sim::BodySnapshot& b = s.bodies[0];
        const Vec3 d = b.orientation.conjugate() * (a.position - b.position) - Vec3(0.3, 0.1, 0.2);
        across = std::max(across, (d - d.dot(axis) * axis).norm());
        turned = std::max(turned, (b.orientation.conjugate() * a.orientation).vec().norm());
        lost = std::max(lost, std::abs(energy(scene, s) - start));
        end = s;
        return true;
    });
    EXPECT_LT(across, 1e-10);
    EXPECT_LT(turned, 1e-10);
    EXPECT_GT((end.bodies[1].position - end.bodies[0].position).norm(), 0.45);
    record({"slider that turns", "across its axis [m]", 1e-3, across, 1e-10});
    const Vec3 after = angular_momentum(scene, end);
    EXPECT_LT((after - before).norm(), 1e-9 * before.norm());
    EXPECT_LT(lost, 1e-6 * start);
}

} // namespace
