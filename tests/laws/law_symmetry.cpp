/// A set-up with a plane of symmetry keeps it, within ten times the tolerance of the solve.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

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

} // namespace
