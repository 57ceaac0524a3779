/// Energy never grows: by the run's own watch, each step, at the settings of the scenes and at rougher ones.
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

namespace {

using namespace laws;

constexpr double largest_gain = 1e-3; // [-] of what the run turned over

void judge(const std::string& name, const sim::SceneDef& scene, double duration) {
    sim::World world(scene);
    double gain = 0.0;
    run(world, scene, duration, [&](const sim::Snapshot&, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        return true;
    });
    record({name, fmt::format("gain of energy in {} s [-]", duration), scene.step.time_step.value(), gain, largest_gain});
    EXPECT_LE(gain, largest_gain) << name;
}

sim::SceneDef film(const std::string& name, const std::vector<std::string>& overrides = {}) {
    return sim::load_scene(std::filesystem::path(TUMBLE_SCENE_DIR) / (name + ".toml"), overrides);
}

TEST(law_energy, no_film_gains_any) {
    judge("film funnel", film("funnel"), 1.4); // the first cubes have met
    judge("film gate", film("gate"), 1.3);     // the load lands on a spring
    judge("film mill", film("mill"), 0.5);     // the motor has its speed, the load has landed
    for (const char* name : {"rubble", "dominoes", "coin", "inclined_blocks", "office_toy", "tippe_top", "galton", "rattleback"}) {
        judge(fmt::format("film {}", name), film(name), 1.0);
    }
}

/// What lands on a pan that a joint holds: no velocity is told beside its impacts that no body ever has, whatever their times.
TEST(law_energy, what_lands_on_a_spring_gains_none_at_neighbouring_steps) {
    for (const auto& [per_second, duration] : {std::pair{1010, 1.6}, std::pair{1020, 1.8}}) {
        sim::SceneDef scene = film("gate");
        scene.step.time_step = {1, per_second};
        judge(fmt::format("film gate, 1/{} s", per_second), scene, duration);
    }
}

/// A body that rolls on a ball with its centre of mass off the ball's gains at long steps only, and then the run says how much. Here it
/// is computed anew from positions and velocities.
TEST(law_energy, what_a_rolling_top_gains_at_long_steps_is_told) {
    for (const int milliseconds : {2, 8}) {
        sim::SceneDef scene = film("tippe_top");
        scene.step.time_step = microseconds(1000 * milliseconds);
        for (sim::BodyDef& body : scene.bodies) {
            if (!body.is_static()) {
                body.velocity = Vec3(0.3, 0, 0);
                body.angular_velocity = Vec3(0, 20, 0);
            }
        }
        sim::World world(scene);
        const double start = energy(scene, world.take_snapshot());
        double lowest = start, told = 0.0, gained = 0.0;
        run(world, scene, 60.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            lowest = std::min(lowest, energy(scene, s));
            gained = std::max(gained, energy(scene, s) - lowest);
            told = std::max(told, report.energy_gain);
            return true;
        });
        record({"a top rolls", "gain of energy in 60 s [-]", 1e-3 * milliseconds, told, milliseconds == 2 ? largest_gain : no_value});
        const double kinetic = 0.5 * scene.bodies[1].mass.mass * 0.3 * 0.3; // and about as much by its rotation
        EXPECT_LT(told, gained / kinetic) << milliseconds;
        EXPECT_GT(told, 0.3 * gained / kinetic) << milliseconds;
        EXPECT_EQ(told > largest_gain, milliseconds > 2) << milliseconds;
    }
}

/// Steps far too long with far too few sweeps leave overlaps, but throw nothing: what a solve has left is neither taken for a
/// guess that makes it worse, nor pushed apart at once.
TEST(law_energy, too_few_sweeps_throw_nothing) {
    struct Case {
        int per_second;
        double tolerance; ///< [m/s]
        int limit;
    };
    for (const auto& [per_second, tolerance, limit] : {Case{60, 0.25, 20}, Case{60, 0.5, 8}, Case{60, 0.5, 4}, Case{61, 0.5, 200}}) {
        sim::SceneDef scene = film("funnel");
        scene.step.time_step = {1, per_second};
        scene.step.tolerance = 1e-2;
        scene.step.velocity_tolerance = tolerance;
        scene.step.iteration_limit = limit;
        sim::World world(scene);
        double fastest = 0.0, gain = 0.0;
        run(world, scene, 1.8, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            for (const sim::BodySnapshot& body : s.bodies) {
                fastest = std::max(fastest, body.velocity.norm());
            }
            gain = std::max(gain, report.energy_gain);
            return true;
        });
        const std::string name = fmt::format("funnel at 1/{} s, {} sweeps", per_second, limit);
        record({name, "fastest cube in 1.8 s, the fall gives 18 [m/s]", 1.0 / per_second, fastest, 25.0});
        record({name, "gain of energy in 1.8 s [-]", 1.0 / per_second, gain, largest_gain});
        EXPECT_LT(fastest, 25.0) << name;
        EXPECT_LE(gain, largest_gain) << name;
    }
}

/// Jams in which the work of a step does not suffice for the tolerance: nothing is thrown, and a few steps later all is well.
/// Sixteen of them have 20 such steps each in the mean, of 700; 10 where extrapolation may overshoot, but then grains in a silo do
/// not come to rest (law_heap.DISABLED_many_grains...).
TEST(law_energy, a_step_whose_work_is_spent_is_made_good) {
    double gain = 0.0;
    int unfinished = 0;
    for (int seed = 1; seed <= 3; ++seed) {
        sim::World world(film("funnel", {"simulation.time_step=1/500", "simulation.velocity_tolerance=0.025",
                                         "simulation.iteration_limit=55", fmt::format("lattice.cube.seed={}", seed)}));
        sim::StepReport report;
        while (world.time() < 1.4) {
            report = world.step();
            gain = std::max(gain, report.energy_gain);
            unfinished += report.is_out_of_work ? 1 : 0;
        }
        for (int later = 0; later < 20 && report.max_penetration > 1e-4; ++later) {
            report = world.step();
        }
        EXPECT_LE(report.max_penetration, 1e-4) << seed;
    }
    record({"funnel at 1/500 s, 55 sweeps", "steps whose work is spent, of 2100 [-]", 1.0 / 500, static_cast<double>(unfinished), 60.0});
    EXPECT_GT(unfinished, 0);
    EXPECT_LE(unfinished, 60);
    EXPECT_LT(gain, 1e-3);
}

/// Four cubes in a row between the edges of two plates that slope, a beam of many times their weight on them: a toggle, tilted less
/// than friction holds, and longer than its room by what may overlap.
struct WedgedRow {
    double overlap;   ///< [m] of each contact
    double tilt;      ///< [rad]
    double density;   ///< [kg/m^3] of the beam
    double friction;  ///< [-]
    double tolerance; ///< [m/s]

    sim::SceneDef scene() const {
        sim::SceneDef scene;
        scene.step.tolerance = 1e-4;
        scene.step.velocity_tolerance = tolerance;
        scene.step.iteration_limit = 200;
        const sim::MaterialDef surface = material(0.48, friction);
        const auto turned = [](double angle) { return Quat(Eigen::AngleAxisd(angle, Vec3::UnitY())); };
        const double room = (4.0 - 5.0 * overlap) / std::cos(tilt);
        const double slope = 0.72; // [rad]
        for (const double side : {-1.0, 1.0}) {
            const Vec3 along(side * std::cos(slope), 0.0, std::sin(slope));
            const Vec3 up(-side * std::sin(slope), 0.0, std::cos(slope));
            const Vec3 edge(0.5 * side * room, 0.0, 0.0);
            add_box(scene, Vec3(4.0, 3.0, 0.25), {edge + 4.0 * along - 0.25 * up, turned(-side * slope)}, surface, 0.0);
        }
        for (int i = 0; i < 4; ++i) {
            const Vec3 place = turned(tilt) * Vec3((i - 1.5) * (1.0 - overlap), 0.0, 0.0);
            add_box(scene, Vec3::Constant(0.5), {place, turned(tilt)}, surface);
        }
        add_box(scene, Vec3(2.0, 0.5, 0.5), {Vec3(0.0, 0.0, 1.08), Quat::Identity()}, surface, density);
        return scene;
    }

    /// What it gains at most in 0.3 s [-], as much as the goal if all is well, and how many of the 300 steps do not converge.
    std::pair<double, int> outcome(double goal) const {
        const sim::SceneDef def = scene();
        sim::World world(def);
        double gain = 0.0;
        int unconverged = 0;
        run(world, def, 0.3, [&](const sim::Snapshot&, const sim::StepReport& report) {
            gain = std::max(gain, report.energy_gain);
            unconverged += report.at_iteration_limit ? 1 : 0;
            return true;
        });
        const std::string name = fmt::format("row of 4, {} m too long each, tilted by {}, {} kg/m^3", overlap, tilt, density);
        record({name, "gain of energy in 0.3 s [-]", 1e-3, gain, goal});
        record({name, "steps not converged, of 300", 1e-3, static_cast<double>(unconverged), no_value});
        return {gain, unconverged};
    }
};

/// Asked to part, it pushes against the plates ever harder, from step to step, and what holds against it then does work.
TEST(law_energy, a_row_wedged_between_plates_gains_nothing) {
    for (const WedgedRow& row : {WedgedRow{8e-5, 0.0144, 1e5, 0.1, 0.05}, WedgedRow{8e-5, 0.0144, 1e6, 0.1, 0.05},
                                 WedgedRow{9e-5, 0.03, 3e5, 0.1, 0.05}, WedgedRow{9e-5, 0.01, 1e6, 0.1, 1e-3}}) {
        const auto [gain, unconverged] = row.outcome(largest_gain);
        EXPECT_LE(gain, largest_gain);
        EXPECT_LE(unconverged, 2);
    }
}

/// Nor are rows thrown whose steps come to no end, and leave overlaps: few gain more than what pushes these apart gives. Which do is
/// chance, as all that a step leaves unsolved; where such steps may make bodies faster, ten do, seven of them most of what they
/// have turned over.
TEST(law_energy, what_does_not_converge_throws_nothing) {
    sim::Random random(1);
    int unconverged = 0; // steps
    int gainers = 0;     // rows
    for (int i = 0; i < 16; ++i) {
        const double overlap = between(random, 9e-5, 9.6e-5);
        const double tilt = between(random, 0.005, 0.035);
        const WedgedRow row{overlap, tilt, std::pow(10.0, between(random, 4.0, 5.0)), 0.3, 0.05};
        const auto [gain, steps] = row.outcome(0.5);
        EXPECT_LE(gain, 0.5);
        gainers += gain > 0.01 ? 1 : 0;
        unconverged += steps;
    }
    EXPECT_LE(gainers, 5);
    EXPECT_GT(unconverged, 100);
}

/// A column that is too long for its room: asked to part, what overlaps would push ever harder, and be thrown as it finds a way.
TEST(law_energy, a_column_wedged_between_floor_and_ceiling_stays_as_it_is) {
    for (const auto& [count, overlap] : {std::pair{4, 8e-5}, std::pair{4, 9e-5}, std::pair{20, 8e-5}}) {
        sim::SceneDef scene;
        const sim::MaterialDef surface = material(0.0, 0.5);
        add_plane(scene, Quat::Identity(), surface);
        add_plane(scene, Quat(Eigen::AngleAxisd(pi, Vec3::UnitX())), surface);
        scene.bodies[1].pose.position.z() = count - (count + 1) * overlap;
        for (int i = 0; i < count; ++i) {
            add_box(scene, Vec3::Constant(0.5), {Vec3(0, 0, i + 0.5 - (i + 1) * overlap), Quat::Identity()}, surface);
        }
        sim::World world(scene);
        double gain = 0.0, speed = 0.0, deepest = 0.0;
        int most_sweeps = 0;
        run(world, scene, 0.3, [&](const sim::Snapshot& snapshot, const sim::StepReport& report) {
            gain = std::max(gain, report.energy_gain);
            deepest = std::max(deepest, report.max_penetration);
            most_sweeps = std::max(most_sweeps, report.contact_iterations);
            for (const sim::BodySnapshot& body : snapshot.bodies) {
                speed = std::max(speed, body.velocity.norm());
            }
            return true;
        });
        const std::string name = fmt::format("{} cubes, {} m too long each", count, overlap);
        record({name, "sweeps of a step [-]", 1e-3, static_cast<double>(most_sweeps), 100.0});
        record({name, "speed [m/s]", 1e-3, speed, 0.01});
        EXPECT_LE(most_sweeps, 100) << name;
        EXPECT_LE(speed, 0.01) << name;
        EXPECT_EQ(gain, 0.0) << name;
        EXPECT_LE(deepest, scene.step.tolerance) << name;
    }
}

/// Steps eight times too long for the tolerance, in many of which the work does not suffice.
TEST(law_energy, DISABLED_a_jam_in_long_steps_gains_none) {
    for (int seed = 1; seed <= 3; ++seed) {
        sim::World world(film("funnel", {"simulation.time_step=1/125", "simulation.velocity_tolerance=0.0125",
                                         fmt::format("lattice.cube.seed={}", seed)}));
        double gain = 0.0, overlap = 0.0;
        while (world.time() < 3.0) {
            const sim::StepReport report = world.step();
            gain = std::max(gain, report.energy_gain);
            overlap = std::max(overlap, report.max_penetration);
        }
        record({fmt::format("funnel at 1/125 s, seed {}", seed), "energy gained in a step [-]", 1.0 / 125, gain, largest_gain});
        record({fmt::format("funnel at 1/125 s, seed {}", seed), "overlap [m]", 1.0 / 125, overlap, 0.1});
        EXPECT_LE(gain, largest_gain) << seed;
        EXPECT_LT(overlap, 0.1) << seed;
    }
}

} // namespace
