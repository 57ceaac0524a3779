/// The reference of the tippe top, judged by what is known of it: its convergence, its invariants, the closed
/// form of a sliding ball, and how it ends.
#include "tests/laws/tops.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace {

using namespace reference;
using laws::reference_top;
using laws::top_cases;
using laws::top_frictions;

TopResult run(const laws::TopCase& c, double mu, const OdeSettings& settings = {}, double slip_scale = 1e-5) {
    Top top = reference_top(c, mu);
    top.slip_scale = slip_scale;
    return integrate_top(top, tilted_top(top, c.spin, c.tilt), 10.0, true, settings);
}

TEST(top_reference, three_tops_and_three_coefficients_turn_over_and_keep_jellett) {
    for (const laws::TopCase& c : top_cases) {
        double before = TopResult::never;
        for (double mu : top_frictions) {
            const TopResult r = run(c, mu);
            std::printf("%-6s mu %.2f  90 degrees %.5f s  stem %.5f s  Jellett %.1e  slip > %.3f m/s\n",
                        c.name, mu, r.time_to_90_degrees, r.time_to_stem_contact, r.largest_jellett_error,
                        r.smallest_slip);
            EXPECT_LT(r.time_to_90_degrees, r.time_to_stem_contact);
            EXPECT_LT(r.time_to_stem_contact, 5.0);
            EXPECT_LT(r.time_to_stem_contact, before); // more friction, sooner
            before = r.time_to_stem_contact;
            EXPECT_LT(r.largest_jellett_error, 1e-10);
            EXPECT_LT(r.largest_height_error, 1e-10); // the bowl never leaves the floor
        }
    }
}

TEST(top_reference, converges_with_the_tolerance_and_with_the_slip_scale) {
    for (const laws::TopCase& c : top_cases) {
        const TopResult best = run(c, 0.17, {.tolerance = 1e-13});
        // Both times must not move by more than 1e-6 s, a thousandth of the smallest step they judge.
        for (const TopResult& r :
             {run(c, 0.17, {.tolerance = 1e-10}), run(c, 0.17, {.tolerance = 1e-12}),
              run(c, 0.17, {.tolerance = 1e-12}, 1e-4), run(c, 0.17, {.tolerance = 1e-12}, 1e-6)}) {
            EXPECT_NEAR(r.time_to_90_degrees, best.time_to_90_degrees, 1e-6) << c.name;
            EXPECT_NEAR(r.time_to_stem_contact, best.time_to_stem_contact, 1e-6) << c.name;
        }
    }
}

TEST(top_reference, without_friction_all_integrals_hold) {
    for (const laws::TopCase& c : top_cases) {
        const Top top = reference_top(c, 0.0);
        TopState start = tilted_top(top, c.spin, 0.4);
        EXPECT_NEAR((angular_velocity(top, start) - Eigen::Vector3d(0, 0, c.spin)).norm(), 0.0, 1e-12);
        const TopResult r = integrate_top(top, start, 2.0);
        // Energy, vertical and axial angular momentum, horizontal momentum. Two seconds of some 1e5 steps of
        // 1e-12.
        EXPECT_NEAR(energy(top, r.end) / energy(top, start), 1.0, 1e-9);
        EXPECT_NEAR(r.end.angular_momentum().z() / start.angular_momentum().z(), 1.0, 1e-9);
        EXPECT_NEAR(r.end.angular_momentum().dot(r.end.axis()) / start.angular_momentum().dot(start.axis()),
                    1.0, 1e-9);
        EXPECT_NEAR(r.end.velocity().head<2>().norm(), 0.0, 1e-9);
        EXPECT_NEAR(r.end.axis().norm(), 1.0, 1e-9);
    }
}

TEST(top_reference, a_ball_that_slides_begins_to_roll_at_the_closed_form) {
    Top ball;
    ball.mass = 2.0;
    ball.bowl = {0.0, 0.1};
    ball.stem = {0.0, 0.01};
    ball.transverse = ball.axial = 0.4 * ball.mass * 0.01;
    ball.mu = 0.3;
    ball.slip_scale = 1e-5;
    TopState state = tilted_top(ball, 0.0, 0.0);
    state.y[3] = 1.0;
    const double rolling = 2.0 / (7.0 * ball.mu * ball.gravity); // [s]
    const TopResult sliding = integrate_top(ball, state, 0.9 * rolling);
    EXPECT_NEAR(sliding.end.velocity().x(), 1.0 - 0.9 * 2.0 / 7.0, 1e-9);
    // Near zero slip the regularised force is weaker; what is left decays within microseconds.
    const TopResult rolls = integrate_top(ball, state, 1.5 * rolling);
    EXPECT_NEAR(rolls.end.velocity().x(), 5.0 / 7.0, 1e-9);
    EXPECT_NEAR(rolls.end.centre().x(), rolling * (12.0 / 49.0 * 7.0 / 2.0) + 0.5 * rolling * 5.0 / 7.0,
                1e-5);
}

TEST(top_reference, the_stem_takes_over_and_the_top_rises_on_it) {
    const laws::TopCase& c = top_cases[0];
    const Top top = reference_top(c, 0.25);
    const TopState start = tilted_top(top, c.spin, c.tilt);
    const TopResult hit = integrate_top(top, start, 10.0, true);
    EXPECT_TRUE(hit.end.touching[1]);
    const double stem_speed = (hit.end.velocity() + angular_velocity(top, hit.end)
                                                        .cross(top.stem.offset * hit.end.axis() -
                                                               top.stem.radius * Eigen::Vector3d::UnitZ()))
                                  .z();
    EXPECT_NEAR(stem_speed, 0.0, 1e-9); // e = 0
    EXPECT_LT(energy(top, hit.end), energy(top, start));
    const TopResult later = integrate_top(top, start, hit.time_to_stem_contact + 1.0);
    EXPECT_LT(later.smallest_axis_z, -0.9); // nearly upright on its stem
    EXPECT_LT(energy(top, later.end), energy(top, hit.end));
}

TEST(top_reference, the_wrong_shape_or_too_little_spin_never_reaches_the_stem) {
    const laws::TopCase& good = top_cases[0];
    laws::TopCase oblate = good, prolate = good, slow = good;
    oblate.transverse = 0.40 * (1.0 - good.a) * 0.85;  // A/C below 1 - a: turns back
    prolate.transverse = 0.40 * (1.0 + good.a) * 1.15; // A/C above 1 + a: the upright top is stable
    slow.spin = 30.0;
    for (const laws::TopCase& c : {oblate, prolate, slow}) {
        EXPECT_EQ(run(c, 0.17, {.tolerance = 1e-10}, 1e-3).time_to_stem_contact, TopResult::never);
    }
}

} // namespace
