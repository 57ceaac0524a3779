/// Cylinders: rolling on, rolling down an incline, standing, and Euler's disk.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace laws;

constexpr double disk_radius = 0.1; // [m]

/// On its side on a floor tilted by `angle` about y, its axis along y; velocity down the slope, rolling.
sim::SceneDef side_scene(Rational h, double mu, double v0, double angle) {
    sim::SceneDef scene = law_scene(h);
    const Quat turn(Eigen::AngleAxisd(angle, Vec3::UnitY()));
    const Quat lying(Eigen::AngleAxisd(0.5 * pi, Vec3::UnitX()));
    add_plane(scene, turn, material(0.0, mu));
    add_cylinder(scene, {disk_radius, 0.15}, {turn * Vec3(0, 0, disk_radius), turn * lying}, material(0.0, mu));
    scene.bodies[1].velocity = turn * Vec3(v0, 0, 0);
    scene.bodies[1].angular_velocity = Vec3(0, v0 / disk_radius, 0);
    return scene;
}

TEST(law_cylinder, rolls_down_an_incline_at_two_thirds_of_g_sin) {
    const double angle = 0.3, t = 2.0, a = 2.0 / 3.0 * g * std::sin(angle);
    const Convergence c = converge(
        "cylinder rolling down an incline", "distance after 2 s, relative", 1e-6,
        {microseconds(8000), microseconds(4000), microseconds(2000), microseconds(1000)}, [&](Rational h) {
            const Vec3 start = side_scene(h, 0.3, 0.0, angle).bodies[1].pose.position;
            const sim::Snapshot end = run_to(side_scene(h, 0.3, 0.0, angle), t);
            return std::abs((end.bodies[1].position - start).norm() / (0.5 * a * t * t) - 1.0);
        });
    EXPECT_LT(c.errors.back(), 1e-6);
    EXPECT_TRUE(c.is_second_order(1e-9)) << "order " << c.order();
}

TEST(law_cylinder, rolling_loses_no_energy_and_keeps_its_course) {
    const sim::Snapshot end = run_to(side_scene(microseconds(1000), 0.2, 1.0, 0.0), 20.0);
    EXPECT_NEAR(end.bodies[1].velocity.x(), 1.0, 1e-9);
    EXPECT_NEAR(end.bodies[1].position.x(), 20.0, 1e-7);
    EXPECT_NEAR(end.bodies[1].position.y(), 0.0, 1e-9);
    EXPECT_NEAR(end.bodies[1].position.z(), disk_radius, 1e-9);
}

TEST(law_cylinder, stands_at_rest_on_a_slope_below_the_friction_angle) {
    for (const double angle : {0.0, 0.2}) {
        sim::SceneDef scene = law_scene(microseconds(1000));
        const Quat turn(Eigen::AngleAxisd(angle, Vec3::UnitY()));
        add_plane(scene, turn, material(0.0, 0.3));
        add_cylinder(scene, {0.1, 0.15}, {turn * Vec3(0, 0, 0.15), turn}, material(0.0, 0.3));
        const sim::Snapshot end = run_to(scene, 5.0);
        EXPECT_LE((end.bodies[1].position - scene.bodies[1].pose.position).norm(), 1e-9) << angle;
        EXPECT_LE(end.bodies[1].angular_velocity.norm(), 1e-9) << angle;
    }
}

/// A log of 1 m over two others side by side or, where `in_groove`, over a V of two boards, all so wide [m] along its axis: it
/// falls by about 1 mm, one end first.
sim::SceneDef log_scene(double width, bool in_groove) {
    constexpr double radius = 0.12; // [m]
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step = {}; // the tolerances of a scene that asks for none
    const Quat lying(Eigen::AngleAxisd(0.5 * pi, Vec3::UnitX()));
    const Quat leaning(Eigen::AngleAxisd(1e-3, Vec3::UnitX()));
    for (const double side : {-1.0, 1.0}) {
        const Quat turn(Eigen::AngleAxisd(-0.25 * pi * side, Vec3::UnitY()));
        if (in_groove) {
            add_box(scene, {0.5, 0.5 * width, 0.1}, {turn * Vec3(0.5 * side, 0, -0.1), turn}, material(0.0, 0.5));
        } else {
            add_cylinder(scene, {radius, 0.5 * width}, {Vec3(0.125 * side, 0, 0), lying}, material(0.0, 0.5));
        }
        scene.bodies.back().mass = {};
    }
    const double height = in_groove ? radius * std::numbers::sqrt2 : std::sqrt(4.0 * radius * radius - 0.125 * 0.125);
    add_cylinder(scene, {radius, 0.5}, {Vec3(0, 0, height + 1e-3), leaning * lying}, material(0.0, 0.5));
    return scene;
}

TEST(law_cylinder, a_log_rests_on_what_ends_before_it_with_it_or_after_it) {
    for (const bool in_groove : {false, true}) {
        for (const double width : {0.4, 1.0, 1.6}) {
            const sim::SceneDef scene = log_scene(width, in_groove);
            sim::World world(scene);
            double fastest = 0.0; // [m/s] at its ends
            run(world, scene, 1.0, [&](const sim::Snapshot& now, const sim::StepReport&) {
                const sim::BodySnapshot& log = now.bodies[2];
                const double speed = log.velocity.norm() + 0.5 * log.angular_velocity.norm();
                fastest = world.time() > 0.5 ? std::max(fastest, speed) : 0.0;
                return true;
            });
            // Places are rounded to 1e-16 m, which a step of 1e-3 s makes 1e-13 m/s of; what rocks goes on at 1e-3 m/s.
            EXPECT_LE(fastest, 1e-10) << (in_groove ? "groove " : "logs ") << width;
        }
    }
}

/// Steady precession of a disk whose centre rests and whose rim rolls: about the vertical at Omega, with the angular
/// velocity along the line from the centre to the contact, such that Omega x L is the torque of the weight.
struct SteadyDisk {
    double omega = 0.0;
    Vec3 w = Vec3::Zero();
    double height = 0.0;

    SteadyDisk(const sim::Cylinder& disk, double tilt) {
        const double r = disk.radius, l = disk.half_length;
        const double across = r * r / 4.0 + l * l / 3.0, axial = r * r / 2.0; // moments for a mass of 1
        const Vec3 k(std::sin(tilt), 0.0, std::cos(tilt));
        const Vec3 to_contact = r * Vec3(k - Vec3(0, 0, 1.0 / k.z())).normalized() - l * k;
        const double ratio = -Vec3::UnitZ().cross(to_contact).y() / k.cross(to_contact).y();
        const Vec3 unit = Vec3::UnitZ() + ratio * k;
        const Vec3 momentum = across * unit + (axial - across) * unit.dot(k) * k;
        const double rate = Vec3::UnitZ().cross(momentum).y();
        const double torque = to_contact.cross(Vec3(0, 0, g)).y();
        omega = std::sqrt(torque / rate);
        w = omega * unit;
        height = -to_contact.z();
    }
};

sim::SceneDef disk_scene(Rational h, const sim::Cylinder& disk, double tilt) {
    const SteadyDisk steady(disk, tilt);
    sim::SceneDef scene = law_scene(h);
    add_plane(scene, Quat::Identity(), material(0.0, 0.3));
    add_cylinder(scene, disk, {Vec3(0, 0, steady.height), Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()))}, material(0.0, 0.3));
    scene.bodies[1].angular_velocity = steady.w;
    return scene;
}

TEST(law_cylinder, eulers_disk_precesses_at_its_rate) {
    const sim::Cylinder disk{0.0375, 0.0064};
    for (const double degrees : {20.0, 10.0, 5.0}) {
        const double tilt = degrees * pi / 180.0;
        const SteadyDisk steady(disk, tilt);
        // Thin disk: 4 g / (r sin tilt); thickness changes it by a few per cent.
        EXPECT_NEAR(steady.omega, std::sqrt(4.0 * g / (disk.radius * std::sin(tilt))), 0.05 * steady.omega);
        const auto error = [&](Rational h) {
            const sim::SceneDef scene = disk_scene(h, disk, tilt);
            // The azimuth of the axis, summed over two turns.
            sim::World world(scene, 1);
            double turned = 0.0, last = 0.0, worst_tilt = 0.0;
            const double duration = 4.0 * pi / steady.omega;
            run(world, scene, duration, [&](const sim::Snapshot& now, const sim::StepReport&) {
                const Vec3 axis = now.bodies[1].orientation * Vec3::UnitZ();
                const double azimuth = std::atan2(axis.y(), axis.x());
                turned += std::remainder(azimuth - last, 2.0 * pi);
                last = azimuth;
                worst_tilt = std::max(worst_tilt, std::abs(std::acos(axis.z()) / tilt - 1.0));
                return true;
            });
            const double time = std::round(duration / h.value()) * h.value();
            return std::max(std::abs(turned / (steady.omega * time) - 1.0), worst_tilt);
        };
        converge("Euler's disk, tilt " + std::to_string(static_cast<int>(degrees)) + " degrees",
                 "rate and tilt over two turns, relative", 1e-2, {microseconds(200), microseconds(100)}, error);
        EXPECT_LT(error(microseconds(100)), 1e-2) << degrees;
    }
}

/// At the default settings: what touches within the tolerance above the floor beside the lowest point is no impact.
TEST(law_cylinder, eulers_disk_keeps_its_energy) {
    const sim::Cylinder disk{0.0375, 0.0064};
    for (const double degrees : {20.0, 5.0, 2.0, 1.0}) {
        const double tilt = degrees * pi / 180.0;
        for (const int us : {1000, 200}) {
            sim::SceneDef scene = disk_scene(microseconds(us), disk, tilt);
            scene.step.tolerance = sim::StepSettings{}.tolerance;
            sim::World world(scene);
            double start = 0.0, lost = 0.0, worst_tilt = 0.0;
            run(world, scene, 0.4, [&](const sim::Snapshot& now, const sim::StepReport&) {
                start = start == 0.0 ? energy(scene, now) : start;
                lost = 1.0 - energy(scene, now) / start;
                worst_tilt = std::max(worst_tilt, std::abs(std::acos((now.bodies[1].orientation * Vec3::UnitZ()).z()) / tilt - 1.0));
                return true;
            });
            record({"Euler's disk, tilt " + std::to_string(static_cast<int>(degrees)) + " degrees, default settings",
                    "energy lost in 0.4 s, relative", 1e-6 * us, std::abs(lost), 1e-4});
            EXPECT_LT(std::abs(lost), 1e-4) << degrees << " " << us;
            EXPECT_LT(worst_tilt, 1e-2) << degrees << " " << us;
        }
    }
}

} // namespace
