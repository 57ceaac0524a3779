/// The office toy: any k balls in, k out, touching or with gaps, on a line and on hinges; its energy over a
/// minute.
#include "tests/laws/law_scene.h"
#include "tests/laws/reference/cradle.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <utility>

namespace {

using namespace laws;

constexpr double ball_radius = 0.1, length = 1.0; // [m] of a ball and of its hanging

/// n weightless balls in a row along x, `gap` [m] apart; the first k fly at 1 m/s, `approach` [m] before the
/// rest.
sim::SceneDef row_scene(int n, int k, double gap, double approach) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step.gravity = Vec3::Zero();
    for (int i = 0; i < n; ++i) {
        const double x = i * (2 * ball_radius + gap) - (i < k ? approach : 0.0);
        add_sphere(scene, ball_radius, {x, 0, 0}, material(1.0, 0.0));
        scene.bodies[i].velocity = Vec3(i < k ? 1.0 : 0.0, 0, 0);
    }
    return scene;
}

/// Largest deviation from "the last k fly at 1 m/s, the others rest" after all have met [m/s].
double row_error(int n, int k, double gap) {
    const sim::Snapshot end = run_to(row_scene(n, k, gap, 0.05), 1.0);
    double error = 0.0;
    for (int i = 0; i < n; ++i) {
        error = std::max(error, (end.bodies[i].velocity - Vec3(i >= n - k ? 1.0 : 0.0, 0, 0)).norm());
    }
    return error;
}

TEST(law_cradle, any_k_of_a_free_row_in_and_k_out) {
    for (const int n : {2, 5, 7}) {
        for (int k = 1; k < n; ++k) {
            for (const double gap : {0.0, 1e-5, 0.01}) {
                const double error = row_error(n, k, gap);
                EXPECT_LT(error, 1e-9) << n << " balls, " << k << " in, gap " << gap;
                if (n == 5) {
                    record({fmt::format("office toy, free row, k = {}, gap {:g} m", k, gap),
                            "velocities after, relative", 1e-3, error, 1e-9});
                }
            }
        }
    }
}

/// n balls on hinges, the first k raised by `angle` [rad]; body 0 is the frame, body 1 + i the i-th ball.
sim::SceneDef cradle_scene(Rational h, int n, int k, double angle, double gap) {
    sim::SceneDef scene = law_scene(h);
    const int frame = add_frame(scene);
    for (int i = 0; i < n; ++i) {
        const double x = i * (2 * ball_radius + gap), a = i < k ? angle : 0.0;
        const Quat turn(Eigen::AngleAxisd(a, Vec3::UnitY())); // raises towards -x
        const Vec3 anchor(x, 0, length);
        const int ball = add_sphere(scene, ball_radius, anchor + turn * Vec3(0, 0, -length), material(1.0, 0.0));
        scene.bodies[ball].pose.orientation = turn;
        add_joint(scene, sim::JointKind::hinge, {ball, frame}, anchor);
    }
    return scene;
}

/// What the reference has of the same start.
reference::CradleState reference_start(const sim::SceneDef& scene) {
    reference::CradleState state;
    for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
        const Vec3 arm = scene.bodies[i].pose.orientation * -Vec3::UnitZ();
        state.angle.push_back(std::atan2(arm.x(), -arm.z()));
        state.rate.push_back(-scene.bodies[i].angular_velocity.y());
    }
    return state;
}

struct Exchange {
    double error = 0.0; ///< [-] largest of a ball's rate against the reference, relative to the incoming one
    int impacts = 0;    ///< of two balls, in the reference
};

/// All rates at the first instant at which all k (n - k) impacts of the exchange are over.
Exchange exchange(const sim::SceneDef& scene, int k, double gap) {
    const reference::Cradle cradle{length, ball_radius, 2 * ball_radius + gap, g};
    reference::CradleState exact = reference_start(scene);
    const int n = static_cast<int>(exact.angle.size());
    sim::World world(scene);
    Exchange found;
    double incoming = 0.0;
    run(world, scene, 1.5, [&](const sim::Snapshot& s, const sim::StepReport&) {
        for (const double rate : exact.rate) {
            incoming = exact.impacts == 0 ? std::max(incoming, rate) : incoming;
        }
        reference::integrate_cradle(cradle, exact, scene.step.time_step.value());
        if (exact.impacts < k * (n - k)) {
            return true;
        }
        for (int i = 0; i < n; ++i) {
            const auto ball = static_cast<std::size_t>(i);
            const double rate = -s.bodies[ball + 1].angular_velocity.y();
            found.error = std::max(found.error, std::abs(rate - exact.rate[ball]) / incoming);
        }
        found.impacts = exact.impacts;
        return false;
    });
    return found;
}

/// k balls fly with `rate` [rad/s] and come to the bottom `phase` steps after the start: what is seen is the exchange, not
/// the swing before it.
sim::SceneDef meeting_scene(Rational h, int n, int k, double gap, double phase) {
    const double rate = 2.0;
    sim::SceneDef scene = cradle_scene(h, n, k, phase * h.value() * rate, gap);
    for (int i = 1; i <= k; ++i) {
        sim::BodyDef& ball = scene.bodies[static_cast<std::size_t>(i)];
        ball.angular_velocity = Vec3(0, -rate, 0);
        ball.velocity = ball.pose.orientation * Vec3(rate * length, 0, 0);
    }
    return scene;
}

TEST(law_cradle, balls_that_touch_exchange_their_velocities_at_the_instant) {
    for (const int n : {2, 3, 5, 8}) {
        for (int k = 1; k < n; ++k) {
            const sim::SceneDef scene = meeting_scene(microseconds(1000), n, k, 0.0, 0.0);
            const sim::Snapshot s = sim::World(scene).take_snapshot();
            double error = 0.0;
            for (int i = 0; i < n; ++i) {
                const Vec3 expected(i >= n - k ? 2.0 * length : 0.0, 0, 0);
                error = std::max(error, (s.bodies[static_cast<std::size_t>(i) + 1].velocity - expected).norm() / 2.0);
            }
            EXPECT_LT(error, 1e-9) << n << " balls, " << k << " in";
            if (n == 5) {
                record({fmt::format("office toy on hinges, k = {}, touching", k), "velocities right after, relative",
                        1e-3, error, 1e-9});
            }
        }
    }
}

/// Between the impacts the balls swing: a chord a step for an arc, (w h)^2 / 12 of their speed.
TEST(law_cradle, balls_with_gaps_exchange_their_velocities_as_the_reference_says) {
    for (const int k : {1, 2, 3, 4}) {
        for (const double gap : {1e-5, 1e-4, 1e-3}) {
            const Convergence c = converge(
                fmt::format("office toy on hinges, k = {}, gap {:g} m", k, gap), "velocities right after, relative",
                4e-7, {microseconds(1000), microseconds(200), microseconds(50)}, [&](Rational h) {
                    const Exchange found = exchange(meeting_scene(h, 5, k, gap, 0.5), k, gap);
                    EXPECT_EQ(found.impacts, k * (5 - k)) << k << " in, gap " << gap;
                    return found.error;
                });
            for (std::size_t i = 0; i < c.steps.size(); ++i) {
                EXPECT_LT(c.errors[i], 1.2 * std::pow(2.0 * c.steps[i], 2) / 12 + 1e-10) << k << " in, gap " << gap;
            }
            EXPECT_LT(c.errors.back(), 1e-9);
        }
    }
}

/// From a raise the error is that of the swing down, and falls as h^2.
TEST(law_cradle, balls_let_go_from_a_height_exchange_with_second_order) {
    for (const double gap : {0.0, 1e-4}) {
        for (const int k : {1, 2, 4}) {
            const Convergence c =
                converge(fmt::format("office toy, let go at 0.5 rad, k = {}, gap {:g} m", k, gap),
                         "velocities after the exchange, relative", 1e-5,
                         {microseconds(4000), microseconds(2000), microseconds(1000), microseconds(500)},
                         [&](Rational h) { return exchange(cradle_scene(h, 5, k, 0.5, gap), k, gap).error; });
            // Verlet's swing: (w h)^2 / 24 with w = 3.1 rad/s at the most, and the time of the touch with it.
            EXPECT_LT(c.errors[2], 1e-5) << k << " in, gap " << gap;
            EXPECT_TRUE(c.is_second_order(1e-9)) << "order " << c.order();
        }
    }
}

struct EnergyRecord {
    double drift = 0.0;       ///< [-] mean of the last tenth minus mean of the first tenth
    double oscillation = 0.0; ///< [-] largest deviation from the mean
    double joint_gap = 0.0;   ///< [m]
};

/// Energy above the lowest point, relative to its start.
EnergyRecord energy_record(const sim::SceneDef& scene, double duration) {
    sim::World world(scene);
    const double start =
        energy(scene, world.take_snapshot()); // zero where all hang: z is measured from there
    std::vector<double> values;
    EnergyRecord record;
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport&) {
        values.push_back(energy(scene, s) / start);
        record.joint_gap = std::max(record.joint_gap, largest_joint_gap(scene, s));
        return true;
    });
    const std::size_t tenth = values.size() / 10;
    double first = 0.0, last = 0.0, mean = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        mean += values[i] / static_cast<double>(values.size());
        first += i < tenth ? values[i] / static_cast<double>(tenth) : 0.0;
        last += i >= values.size() - tenth ? values[i] / static_cast<double>(tenth) : 0.0;
    }
    for (double value : values) {
        record.oscillation = std::max(record.oscillation, std::abs(value - mean));
    }
    record.drift = std::abs(last - first);
    return record;
}

TEST(law_cradle, energy_neither_drifts_nor_oscillates_in_a_minute) {
    std::vector<double> oscillation;
    for (const Rational h : {microseconds(2000), microseconds(1000)}) {
        sim::SceneDef scene = cradle_scene(h, 5, 2, 0.5, 0.0);
        const EnergyRecord found = energy_record(scene, 60.0);
        oscillation.push_back(found.oscillation);
        const bool at_goal = h.value() == 1e-3;
        record({"office toy, 60 s", "drift of energy, relative", h.value(), found.drift,
                at_goal ? 1e-6 : no_value});
        record({"office toy, 60 s", "oscillation of energy, relative", h.value(), found.oscillation,
                at_goal ? 1e-5 : no_value});
        record({"office toy, 60 s", "joint gap [m]", h.value(), found.joint_gap, 1e-9});
        EXPECT_LT(found.joint_gap, 1e-9);
        if (at_goal) {
            EXPECT_LT(found.drift, 1e-6);
            EXPECT_LT(found.oscillation, 1e-5);
        }
    }
    // Falls as h^2 while above rounding.
    if (oscillation[0] > 1e-10) {
        EXPECT_GT(std::log2(oscillation[0] / oscillation[1]), 1.8);
    }
}

/// At the default settings, with touching balls and with gaps that a step spans and that it does not.
TEST(law_cradle, energy_of_elastic_rows_never_grows) {
    double largest = 0.0;
    for (const auto& [n, k] : {std::pair(5, 2), std::pair(5, 3), std::pair(7, 4)}) {
        for (const double gap : {0.0, 1e-5, 1e-4, 2e-3}) {
            const sim::SceneDef scene = cradle_scene(microseconds(1000), n, k, 0.5, gap);
            const EnergyRecord found = energy_record(scene, 3.0);
            largest = std::max(largest, found.oscillation);
            EXPECT_LT(found.oscillation, 1e-3) << n << " balls, " << k << " in, gap " << gap;
        }
    }
    record({"elastic rows of 5 and 7 on hinges, default settings, 3 s", "change of energy, relative", 1e-3, largest, 1e-3});
}

} // namespace
