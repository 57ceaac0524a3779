/// A set-up with a plane of symmetry keeps it, within ten times the tolerance of the solve.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

#include <array>

namespace {

using namespace laws;

/// Largest difference [m] of the positions of body `a` and the mirror image (x -> -x) of body `b`.
double asymmetry(const sim::Snapshot& s, int a, int b) {
    const Vec3 p = s.bodies[a].position, q = s.bodies[b].position;
    return (p - Vec3(-q.x(), q.y(), q.z())).norm();
}

TEST(law_symmetry, a_ball_breaks_a_triangle_of_six) {
    for (const auto impacts : {sim::ImpactHandling::stop, sim::ImpactHandling::ahead}) {
        sim::SceneDef scene = law_scene(microseconds(1000));
        scene.step.impacts = impacts;
        const double radius = 0.1, row = std::sqrt(3.0) * radius;
        const sim::MaterialDef surface = material(0.9, 0.1);
        add_plane(scene, Quat::Identity(), surface);
        add_sphere(scene, radius, {0, -0.5, radius}, surface);
        scene.bodies[1].velocity = Vec3(0, 2, 0);
        for (int r = 0; r < 3; ++r) {
            for (int i = 0; i <= r; ++i) {
                add_sphere(scene, radius, {(2 * i - r) * radius, r * row, radius}, surface);
            }
        }
        sim::World world(scene);
        double largest = 0.0;
        run(world, scene, 1.0, [&](const sim::Snapshot& s, const sim::StepReport&) {
            largest = std::max({largest, asymmetry(s, 1, 1) / 2, asymmetry(s, 2, 2) / 2, asymmetry(s, 3, 4),
                                asymmetry(s, 5, 7), asymmetry(s, 6, 6) / 2});
            return true;
        });
        record({"symmetry, triangle of six balls", "largest asymmetry [m]", 1e-3, largest,
                10 * scene.step.tolerance});
        EXPECT_LE(largest, 10 * scene.step.tolerance);
        EXPECT_GT(run_to(scene, 1.0).bodies[7].position.x(), 1.5 * radius); // it did break
    }
}

struct Pyramid {
    double gap;     ///< [m] between the two boxes below
    double drop;    ///< [m]
    Vec3 half;      ///< half extents of all three [m]
    double tilt;    ///< [rad] of the two boxes below, towards each other
    double mu, e;
};

constexpr double pyramid_tolerance = 1e-6; // [m]

/// Two boxes side by side, body 1 and 2, and one on top, let fall.
sim::SceneDef pyramid_scene(const Pyramid& p, sim::ImpactHandling impacts) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step.impacts = impacts;
    scene.step.tolerance = pyramid_tolerance;
    scene.step.velocity_tolerance = 1e-7;
    const sim::MaterialDef surface = material(p.e, p.mu);
    add_plane(scene, Quat::Identity(), surface);
    const double wide = p.half.x() * std::cos(p.tilt) + p.half.z() * std::sin(p.tilt);
    const double high = p.half.x() * std::sin(p.tilt) + p.half.z() * std::cos(p.tilt);
    for (const double side : {-1.0, 1.0}) {
        const Vec3 at(side * (wide + 0.5 * p.gap), 0, high + p.drop);
        add_box(scene, p.half, {at, Quat(Eigen::AngleAxisd(-side * p.tilt, Vec3::UnitY()))}, surface);
    }
    add_box(scene, p.half, {Vec3(0, 0, 2 * high + p.half.z() + 2 * p.drop), Quat::Identity()}, surface);
    return scene;
}

/// So it does beside a pendulum that hangs elsewhere.
TEST(law_symmetry, a_pyramid_of_three_boxes_lands_as_its_mirror_image) {
    const Vec3 cube(0.5, 0.5, 0.5), flat(0.5, 0.5, 0.2), tall(0.3, 0.5, 0.6);
    const std::array<Pyramid, 10> cases{
        Pyramid{0.1, 0.3, cube, 0, 0.4, 0.5},  Pyramid{0.1, 0.05, cube, 0, 0.4, 0.5},
        Pyramid{0.0, 0.05, cube, 0, 0.4, 0.5}, Pyramid{0.0, 0.05, cube, 0, 0.0, 0.5},
        Pyramid{0.0, 0.2, cube, 0, 0.1, 0.9},  Pyramid{0.3, 0.05, flat, 0, 0.7, 0.2},
        Pyramid{0.05, 0.5, tall, 0, 0.4, 1.0}, Pyramid{0.2, 0.2, cube, 0, 0.5, 0.0},
        Pyramid{0.05, 0.1, flat, 0.4, 0.4, 0.3}, Pyramid{0.001, 0.05, cube, 0, 0.0, 0.5}};
    for (const auto& [impacts, has_pendulum] : {std::pair{sim::ImpactHandling::stop, false}, std::pair{sim::ImpactHandling::ahead, false},
                                                std::pair{sim::ImpactHandling::ahead, true}}) {
        double largest = 0.0;
        for (const Pyramid& p : cases) {
            sim::SceneDef scene = pyramid_scene(p, impacts);
            if (has_pendulum) {
                const int bob = add_sphere(scene, 0.1, {50, 0, 50});
                add_joint(scene, sim::JointKind::ball, {bob, -1}, {50, 1, 50});
            }
            sim::World world(scene);
            double of_case = 0.0;
            int collisions = 0;
            run(world, scene, 1.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
                of_case = std::max({of_case, asymmetry(s, 1, 2), asymmetry(s, 3, 3) / 2});
                collisions += report.collisions;
                return true;
            });
            EXPECT_GT(collisions, 8);
            EXPECT_LE(of_case, 10 * pyramid_tolerance) << "case " << &p - cases.data();
            largest = std::max(largest, of_case);
        }
        record({std::string("symmetry, ten pyramids, ") +
                    (impacts == sim::ImpactHandling::stop ? "impacts stopped" : "contacts ahead") +
                    (has_pendulum ? ", a pendulum elsewhere" : ""),
                "largest asymmetry in 1 s [m]", 1e-3, largest, 10 * pyramid_tolerance});
    }
}

} // namespace
