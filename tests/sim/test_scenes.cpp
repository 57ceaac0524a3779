/// The scenes of the repository: that they load, and that their numbers are those of the paper and of the
/// issue.
#include "sim/scene/file.h"

#include "sim/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

using namespace sim;

namespace {

const std::filesystem::path scenes = TUMBLE_SCENE_DIR;

SceneDef funnel() {
    return load_scene(scenes / "funnel.toml");
}

const BodyDef& body_named(const SceneDef& scene, const std::string& name) {
    for (const BodyDef& body : scene.bodies) {
        if (body.name == name) {
            return body;
        }
    }
    throw Error(ExitCode::usage, "no body " + name);
}

/// Signed distance of a point from a box, as the largest of its face distances: <= 0 inside.
double outside_of(const BodyDef& body, const Vec3& x) {
    const Vec3 local = body.pose.orientation.conjugate() * (x - body.pose.position);
    return (local.cwiseAbs() - std::get<Box>(body.shape).half_extents).maxCoeff();
}

} // namespace

TEST(scenes, all_load_and_name_themselves) {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(scenes)) {
        if (entry.path().extension() == ".toml") {
            const SceneDef scene = load_scene(entry.path());
            EXPECT_EQ(scene.name, entry.path().stem());
            EXPECT_FALSE(scene.title.empty()) << entry.path();
            EXPECT_GE(scene.cameras.size(), 1u) << entry.path();
            ++count;
        }
    }
    EXPECT_GE(count, 4);
}

TEST(scenes, funnel_has_the_papers_settings) {
    const SceneDef scene = funnel();
    EXPECT_EQ(scene.step.time_step, (Rational{1, 1000}));
    EXPECT_EQ(scene.step.tolerance, 1e-4);
    EXPECT_EQ(scene.output.duration, (Rational{6, 1}));
    int cubes = 0;
    int statics = 0;
    for (const BodyDef& body : scene.bodies) {
        EXPECT_EQ(body.material.restitution, 0.48);
        EXPECT_EQ(body.material.mu_s, 0.1);
        EXPECT_EQ(body.material.mu_d, 0.1);
        statics += body.is_static() ? 1 : 0;
        if (!body.is_static()) {
            ++cubes;
            EXPECT_EQ(std::get<Box>(body.shape).half_extents, Vec3::Constant(0.5));
            EXPECT_EQ(body.mass.mass, 1000.0);
            EXPECT_NEAR(body.mass.inertia(1, 1), 1000.0 / 6, 1e-10);
        }
    }
    EXPECT_EQ(cubes, 1000);
    EXPECT_EQ(statics, 5);
}

TEST(scenes, funnel_lattice_is_regular_and_turned_by_at_most_the_angle) {
    const SceneDef scene = funnel();
    double largest = 0.0;
    double mean = 0.0;
    Vec3 mean_axis = Vec3::Zero();
    for (int k = 0; k < 10; ++k) {
        for (int j = 0; j < 10; ++j) {
            for (int i = 0; i < 10; ++i) {
                const BodyDef& cube = body_named(scene, "cube_" + std::to_string(i + 10 * (j + 10 * k)));
                EXPECT_LE(
                    (cube.pose.position - Vec3(-5.85 + 1.3 * i, -5.85 + 1.3 * j, 17.5 + 1.3 * k)).norm(),
                    1e-13);
                const Eigen::AngleAxisd turn(cube.pose.orientation);
                largest = std::max(largest, turn.angle());
                mean += turn.angle() / 1000;
                mean_axis += turn.axis() / 1000;
            }
        }
    }
    // Uniform in 0..0.2: the mean is 0.1 with a standard deviation of 0.2 / sqrt(12000).
    EXPECT_LE(largest, 0.2 + 1e-12);
    EXPECT_GE(largest, 0.199);
    EXPECT_NEAR(mean, 0.1, 4 * 0.2 / std::sqrt(12000.0));
    // Each component has the deviation sqrt(1 / 3000).
    EXPECT_LE(mean_axis.cwiseAbs().maxCoeff(), 4 / std::sqrt(3000.0));
}

TEST(scenes, seeded_turns_are_the_same_for_ever) {
    // Recorded from the first version; sin and cos of other libraries may differ in the last digit.
    const SceneDef scene = funnel();
    const Quat first = body_named(scene, "cube_0").pose.orientation;
    const Quat last = body_named(scene, "cube_999").pose.orientation;
    EXPECT_LE((first.coeffs() - Eigen::Vector4d(-0.017764998257190311, -0.017795175414339583,
                                                0.083936964345359424, 0.99615376452904136))
                  .norm(),
              1e-14)
        << first.coeffs().format(Eigen::IOFormat(17));
    EXPECT_LE((last.coeffs() - Eigen::Vector4d(-0.012381531675920847, -0.0057326909776880177,
                                               -0.00071785156360206111, 0.99990665495167352))
                  .norm(),
              1e-14)
        << last.coeffs().format(Eigen::IOFormat(17));
    // Another seed, another turn.
    const std::vector<std::string> override{"lattice.cube.seed=2"};
    const SceneDef other = load_scene(scenes / "funnel.toml", override);
    EXPECT_GT(body_named(other, "cube_0").pose.orientation.angularDistance(first), 1e-3);
}

TEST(scenes, funnel_plates_have_the_given_inner_surfaces_and_close_the_corners) {
    const SceneDef scene = funnel();
    const std::map<std::string, Vec3> sides{{"plate_east", {1, 0, 0}},
                                            {"plate_north", {0, 1, 0}},
                                            {"plate_west", {-1, 0, 0}},
                                            {"plate_south", {0, -1, 0}}};
    for (const auto& [name, out] : sides) {
        const BodyDef& plate = body_named(scene, name);
        const Vec3 across = Vec3::UnitZ().cross(out);
        EXPECT_NEAR(2 * std::get<Box>(plate.shape).half_extents.z(), 0.5, 1e-15);
        // The inner surface runs from the mouth's edge (9 m at 16 m) to the throat's edge (2 m at 8 m), on
        // its whole width.
        for (const double t : {0.0, 0.3, 1.0}) {
            for (const double y : {-1.0, 0.0, 1.0}) {
                const double half = 9 - 7 * t;
                const Vec3 inner = out * half + across * (y * half) + Vec3(0, 0, 16 - 8 * t);
                EXPECT_NEAR(outside_of(plate, inner), 0.0, 1e-14) << name << " t=" << t << " y=" << y;
            }
        }
    }
    // Behind the inner edge between two plates there is matter, half the thickness deep and more.
    for (double t = 0.0; t <= 0.95; t += 0.01) {
        const double half = 9 - 7 * t;
        for (const double depth : {0.01, 0.1, 0.25}) {
            const Vec3 x = Vec3(half, half, 16 - 8 * t) + depth * Vec3(1, 1, -1).normalized();
            const double east = outside_of(body_named(scene, "plate_east"), x);
            const double north = outside_of(body_named(scene, "plate_north"), x);
            EXPECT_LT(std::min(east, north), 0.0) << "t=" << t << " depth=" << depth;
        }
    }
    // No plate stands into the opening.
    for (double t = 0.0; t <= 1.0; t += 0.05) {
        for (const auto& [name, out] : sides) {
            for (const auto& [other, toward] : sides) {
                const Vec3 inside = toward * (9 - 7 * t - 1e-6) * 0.999 + Vec3(0, 0, 16 - 8 * t);
                EXPECT_GT(outside_of(body_named(scene, name), inside), 0.0) << name << " " << other;
            }
        }
    }
}

TEST(scenes, incline_blocks_start_apart_and_flat_above_their_slope) {
    const SceneDef scene = load_scene(scenes / "inclined_blocks.toml");
    const BodyDef& incline = body_named(scene, "incline");
    const Vec3 normal = incline.pose.orientation * Vec3::UnitZ();
    EXPECT_NEAR(std::acos(normal.z()) * 180 / std::acos(-1.0), 20.0, 1e-9);
    int blocks = 0;
    for (const BodyDef& body : scene.bodies) {
        if (body.is_static()) {
            continue;
        }
        ++blocks;
        const double height = (body.pose.position - incline.pose.position).dot(normal) - 0.15 - 0.2;
        EXPECT_NEAR(height, 0.05, 1e-6);
        EXPECT_NEAR(body.velocity.norm(), 2.0, 1e-6);
        EXPECT_NEAR(body.velocity.dot(normal), 0.0, 1e-6);
        EXPECT_LE(body.pose.orientation.angularDistance(incline.pose.orientation), 1e-12);
    }
    EXPECT_EQ(blocks, 5);
}

TEST(scenes, tippe_top_touches_the_floor_and_can_turn_over) {
    const SceneDef scene = load_scene(scenes / "tippe_top.toml");
    const BodyDef& top = body_named(scene, "top");
    const Compound& shape = std::get<Compound>(top.shape);
    const double radius = std::get<Sphere>(shape.parts.at(0).shape).radius;
    const double offset = shape.parts.at(0).body_from_part.position.z();
    // The lowest point of the bowl is the floor.
    EXPECT_NEAR((top.pose * Vec3(0, 0, offset)).z(), radius, 1e-17);
    const double a = offset / radius;
    EXPECT_NEAR(a, 0.2, 1e-12);
    const double ratio = top.mass.inertia(0, 0) / top.mass.inertia(2, 2);
    EXPECT_GT(ratio, 1 - a);
    EXPECT_LT(ratio, 1 + a);
    EXPECT_EQ(top.angular_velocity.head<2>(), Eigen::Vector2d::Zero());
    // Rule of thumb for a good start: spin^2 a R sin(tilt) > 3.5 mu g.
    const double tilt = std::acos((top.pose.orientation * Vec3::UnitZ()).z());
    EXPECT_NEAR(tilt, 0.1, 1e-12);
    const double spin = top.angular_velocity.z();
    EXPECT_GT(spin * spin * offset * std::sin(tilt), 3.5 * *top.material.mu_d * 9.81);
    EXPECT_FALSE(top.look.lathe.empty());
}

TEST(scenes, office_toy_balls_touch_and_hang_at_one_length) {
    const SceneDef scene = load_scene(scenes / "office_toy.toml");
    ASSERT_EQ(scene.joints.size(), 5u);
    for (std::size_t i = 0; i < 5; ++i) {
        const JointDef& joint = scene.joints[i];
        EXPECT_EQ(joint.kind, JointKind::hinge);
        EXPECT_EQ(joint.body_b, -1);
        const BodyDef& ball = scene.bodies[static_cast<std::size_t>(joint.body_a)];
        EXPECT_NEAR((ball.pose.position - joint.anchor).norm(), 0.25, 1e-16);
        EXPECT_EQ(ball.material.restitution, 1.0);
        EXPECT_FALSE(ball.material.mu_s.has_value());
        const bool is_lifted = ball.pose.position.x() < joint.anchor.x() - 0.1;
        EXPECT_EQ(is_lifted, i < 2);
        // The neighbour's surface is there to the last digits; the lifted pair and the hanging three.
        if (i > 0 && i != 2) {
            const BodyDef& before = scene.bodies[static_cast<std::size_t>(scene.joints[i - 1].body_a)];
            EXPECT_NEAR((ball.pose.position - before.pose.position).norm(), 0.05, 1e-16);
        }
    }
}
