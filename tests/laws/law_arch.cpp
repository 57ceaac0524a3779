/// Arches of stones without mortar, at the default settings. A semicircular one of constant thickness t and mean radius R stands as long
/// as a line of thrust has room in it, from t / R = 0.1075 on, if it cannot slide: M. Milankovitch 1907, "Theorie der Druckkurven",
/// Zeitschrift fuer Mathematik und Physik 55.
#include "sim/model/polytope.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using namespace laws;

constexpr double milankovitch = 0.1075; ///< [-] t / R

/// Of so many stones, with R = 1 m, on the ground.
sim::SceneDef arch(int stones, double thickness) {
    sim::SceneDef scene;
    const sim::MaterialDef surface = material(0.0, 0.8);
    add_plane(scene, Quat::Identity(), surface);
    for (int i = 0; i < stones; ++i) {
        std::vector<Vec3> corners;
        for (const double angle : {pi * i / stones, pi * (i + 1) / stones}) {
            for (const double radius : {1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness}) {
                for (const double y : {-0.15, 0.15}) {
                    corners.emplace_back(radius * std::cos(angle), y, radius * std::sin(angle));
                }
            }
        }
        const sim::Shape hull = sim::Hull{std::make_shared<const sim::Polytope>(sim::convex_hull(corners).value())};
        sim::BodyDef stone;
        stone.name = fmt::format("stone_{}", i);
        stone.mass = sim::mass_properties(hull, 2000.0);
        stone.pose.position = std::exchange(stone.mass.centre_of_mass, Vec3::Zero());
        stone.shape = sim::shifted(hull, stone.pose.position);
        stone.material = surface;
        scene.bodies.push_back(stone);
    }
    return scene;
}

struct Outcome {
    double moved = 0.0;  ///< [m] farthest of a stone
    double sweeps = 0.0; ///< [-] a step
    int unconverged = 0; ///< steps
};

/// Until a stone has moved by 0.05 m.
Outcome outcome_of(const sim::SceneDef& scene, double duration) {
    Outcome outcome;
    int steps = 0;
    double sweeps = 0.0;
    sim::World world(scene);
    run(world, scene, duration, [&](const sim::Snapshot& snapshot, const sim::StepReport& report) {
        for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
            outcome.moved = std::max(outcome.moved, (snapshot.bodies[i].position - scene.bodies[i].pose.position).norm());
        }
        outcome.unconverged += report.at_iteration_limit ? 1 : 0;
        sweeps += report.contact_iterations;
        outcome.sweeps = sweeps / ++steps;
        return outcome.moved < 0.05;
    });
    return outcome;
}

TEST(law_arch, stands_from_milankovitchs_thickness_on) {
    for (const int stones : {16, 24, 32}) {
        for (const double share : {0.99, 1.01}) {
            const Outcome outcome = outcome_of(arch(stones, share * milankovitch), 1.5);
            const std::string name = fmt::format("arch of {} stones, {} of Milankovitch's thickness", stones, share);
            record({name, "way of a stone in 1.5 s, at most to 0.05 [m]", 1e-3, outcome.moved, share > 1.0 ? 1e-4 : no_value});
            EXPECT_EQ(outcome.moved < 1e-4, share > 1.0) << name;
            EXPECT_EQ(outcome.moved >= 0.05, share < 1.0) << name;
            EXPECT_EQ(outcome.unconverged, 0) << name;
        }
    }
}

/// Newton's method finds what bears, and what does not: sweeps alone leave some millimetres a second.
TEST(law_arch, stands_still_from_the_first_step) {
    for (const auto& [stones, thickness] : {std::pair{40, 0.2}, {40, 0.12}, {60, 0.12}}) {
        const Outcome outcome = outcome_of(arch(stones, thickness), 0.3);
        const std::string name = fmt::format("arch of {} stones, {} m thick", stones, thickness);
        record({name, "way of a stone in 0.3 s [m]", 1e-3, outcome.moved, 1e-6});
        record({name, "sweeps a step", 1e-3, outcome.sweeps, 2.0});
        EXPECT_LE(outcome.moved, 1e-6) << name;
        EXPECT_LE(outcome.sweeps, 2.0) << name;
    }
}

} // namespace
