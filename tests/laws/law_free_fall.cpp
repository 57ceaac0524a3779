/// Free flight: position and velocity at the ends of steps are exact for constant gravity, at any step size.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

namespace {

using namespace laws;

TEST(law_free_fall, thrown_bodies_follow_the_parabola_and_keep_their_spin) {
    for (const Rational h : {microseconds(40000), microseconds(10000), microseconds(1000)}) {
        sim::SceneDef scene = law_scene(h);
        const int ball = add_sphere(scene, 0.1, {1, 2, 30});
        const int box = add_box(scene, {0.5, 0.5, 0.5}, {{-5, 0, 30}, Quat(0.5, 0.5, -0.5, 0.5)});
        const Vec3 v0(3, -2, 7), w0(1, 2, 3);
        for (int i : {ball, box}) {
            scene.bodies[i].velocity = v0;
            scene.bodies[i].angular_velocity = w0;
        }
        const double t = 2.0;
        const sim::Snapshot end = run_to(scene, t);
        EXPECT_NEAR(end.time, t, 1e-15);
        double error = 0.0;
        for (int i : {ball, box}) {
            const Vec3 expected = scene.bodies[i].pose.position + t * v0 + 0.5 * t * t * Vec3(0, 0, -g);
            error = std::max(error, (end.bodies[i].position - expected).norm());
            EXPECT_NEAR((end.bodies[i].velocity - v0 - t * Vec3(0, 0, -g)).norm(), 0.0, 1e-11);
            // A cube and a ball have one moment of inertia: the angular velocity stays and the turn is its
            // product.
            EXPECT_NEAR((end.bodies[i].angular_velocity - w0).norm(), 0.0, 1e-11);
            const Quat turn(Eigen::AngleAxisd(w0.norm() * t, w0.normalized()));
            EXPECT_NEAR(end.bodies[i].orientation.angularDistance(turn * scene.bodies[i].pose.orientation),
                        0.0, 1e-9);
        }
        // 2000 additions of 1e-16 of 30 m, all in one direction at the worst.
        EXPECT_LT(error, 1e-11);
        record({"free fall", "position after 2 s [m]", h.value(), error, 1e-11});
    }
}

} // namespace
