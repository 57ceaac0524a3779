/// The tippe top against its independent integration.
#include "tests/laws/law_scene.h"
#include "tests/laws/tops.h"

#include <gtest/gtest.h>

namespace {

using namespace laws;

/// Body 1 is the top.
sim::SceneDef top_scene(const TopCase& c, double mu, Rational h) {
    sim::SceneDef scene = law_scene(h);
    add_plane(scene, Quat::Identity(), material(0.0, mu));
    const Quat turn(Eigen::AngleAxisd(c.tilt, Vec3::UnitY()));
    sim::BodyDef body;
    body.name = "top";
    body.shape = sim::Compound{{{sim::Sphere{c.radius}, {Vec3(0, 0, c.a * c.radius), Quat::Identity()}},
                                {sim::Sphere{c.stem_radius}, {Vec3(0, 0, c.stem_end), Quat::Identity()}}}};
    body.mass.mass = c.mass;
    body.mass.inertia =
        (c.mass * c.radius * c.radius * Vec3(c.transverse, c.transverse, c.axial)).asDiagonal();
    body.pose = {Vec3(0, 0, c.radius) - turn * Vec3(0, 0, c.a * c.radius), turn};
    body.angular_velocity = Vec3(0, 0, c.spin);
    body.material = material(0.0, mu);
    scene.bodies.push_back(body);
    return scene;
}

Vec3 axis_of(const sim::Snapshot& s) {
    return s.bodies[1].orientation * Vec3::UnitZ();
}

/// From the centre of mass to the bowl's lowest point [m].
Vec3 lowest_point(const TopCase& c, const sim::Snapshot& s) {
    return c.a * c.radius * axis_of(s) - Vec3(0, 0, c.radius);
}

double jellett(const TopCase& c, const sim::SceneDef& scene, const sim::Snapshot& s) {
    const sim::Mat3 rotation = s.bodies[1].orientation.toRotationMatrix();
    const Vec3 L =
        rotation * scene.bodies[1].mass.inertia * rotation.transpose() * s.bodies[1].angular_velocity;
    return -L.dot(lowest_point(c, s));
}

struct TopRun {
    double time_to_90_degrees = reference::TopResult::never;   ///< [s]
    double time_to_stem_contact = reference::TopResult::never; ///< [s]
    double jellett_error = 0.0;                                ///< [-] up to the stem's contact
    double largest_gap = 0.0;                                  ///< [m] of the bowl, either sign, up to there
};

TopRun run_top(const TopCase& c, double mu, Rational h, double duration) {
    const sim::SceneDef scene = top_scene(c, mu, h);
    sim::World world(scene);
    sim::Snapshot before = world.take_snapshot();
    const double jellett_0 = jellett(c, scene, before);
    TopRun found;
    const auto stem_height = [&](const sim::Snapshot& s) {
        return s.bodies[1].position.z() + c.stem_end * axis_of(s).z() - c.stem_radius;
    };
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport&) {
        const double z0 = axis_of(before).z(), z1 = axis_of(s).z();
        if (z0 > 0.0 && z1 <= 0.0 && found.time_to_90_degrees == reference::TopResult::never) {
            found.time_to_90_degrees = before.time + h.value() * z0 / (z0 - z1);
        }
        if (stem_height(s) < 1e-6) {
            found.time_to_stem_contact = s.time;
            return false;
        }
        found.jellett_error = std::max(found.jellett_error, std::abs(jellett(c, scene, s) / jellett_0 - 1.0));
        found.largest_gap =
            std::max(found.largest_gap, std::abs(s.bodies[1].position.z() + lowest_point(c, s).z()));
        before = s;
        return true;
    });
    return found;
}

TEST(law_top, three_tops_and_three_coefficients_turn_over_at_the_time_of_the_reference) {
    for (const TopCase& c : top_cases) {
        double before = reference::TopResult::never;
        for (const double mu : top_frictions) {
            const reference::Top top = reference_top(c, mu);
            const reference::TopResult exact =
                reference::integrate_top(top, reference::tilted_top(top, c.spin, c.tilt), 10.0, true);
            const TopRun found = run_top(c, mu, microseconds(1000), exact.time_to_stem_contact * 1.2);
            const double bound_90 = std::max(0.01 * exact.time_to_90_degrees, 0.03);
            const double bound_stem = std::max(0.01 * exact.time_to_stem_contact, 0.03);
            const std::string name =
                std::string("tippe top ") + c.name + ", mu " + std::to_string(mu).substr(0, 4);
            record({name, "time to 90 degrees [s]", 1e-3,
                    std::abs(found.time_to_90_degrees - exact.time_to_90_degrees), bound_90});
            record({name, "time to the stem's contact [s]", 1e-3,
                    std::abs(found.time_to_stem_contact - exact.time_to_stem_contact), bound_stem});
            record({name, "Jellett's invariant, relative", 1e-3, found.jellett_error, 1e-4});
            EXPECT_NEAR(found.time_to_90_degrees, exact.time_to_90_degrees, bound_90) << name;
            EXPECT_NEAR(found.time_to_stem_contact, exact.time_to_stem_contact, bound_stem) << name;
            EXPECT_LT(found.jellett_error, 1e-4) << name;
            EXPECT_LT(found.time_to_stem_contact, before) << name; // more friction, sooner
            before = found.time_to_stem_contact;
        }
    }
}

TEST(law_top, the_time_of_turning_converges_with_the_step) {
    const TopCase& c = top_cases[0];
    const reference::Top top = reference_top(c, 0.25);
    const reference::TopResult exact =
        reference::integrate_top(top, reference::tilted_top(top, c.spin, c.tilt), 10.0, true);
    const Convergence time = converge(
        "tippe top, mu 0.25", "time to 90 degrees [s]", no_value,
        {microseconds(200), microseconds(100), microseconds(50), microseconds(25)}, [&](Rational h) {
            return std::abs(run_top(c, 0.25, h, exact.time_to_stem_contact * 1.2).time_to_90_degrees -
                            exact.time_to_90_degrees);
        });
    EXPECT_TRUE(time.is_second_order(1e-7)) << "order " << time.order();
}

/// The sliding top at a fixed time, far from any change of contact: the whole state, not only a time.
TEST(law_top, the_sliding_top_is_second_order) {
    const TopCase& c = top_cases[0];
    const double mu = 0.25, t = 0.2;
    reference::Top top = reference_top(c, mu);
    const reference::TopState exact =
        reference::integrate_top(top, reference::tilted_top(top, c.spin, c.tilt), t).end;
    const Convergence axis = converge(
        "tippe top, sliding 0.2 s", "axis, position [R], velocity [R spin]", no_value,
        {microseconds(200), microseconds(100), microseconds(50), microseconds(25)}, [&](Rational h) {
            const sim::SceneDef scene = top_scene(c, mu, h);
            const sim::Snapshot s = run_to(scene, t);
            const double turned = (axis_of(s) - exact.axis()).norm();
            const Vec3 start(scene.bodies[1].pose.position.x(), 0, 0); // the reference starts at x = 0
            const double moved = (s.bodies[1].position - start - exact.centre()).norm() / c.radius;
            const double speed = (s.bodies[1].velocity - exact.velocity()).norm() / (c.radius * c.spin);
            return std::max({turned, moved, speed});
        });
    EXPECT_TRUE(axis.is_second_order(1e-9)) << "order " << axis.order();
}

TEST(law_top, the_wrong_shape_or_too_little_spin_never_reaches_the_stem) {
    TopCase oblate = top_cases[0], prolate = oblate, slow = oblate;
    oblate.transverse = oblate.axial * (1.0 - oblate.a) * 0.85;
    prolate.transverse = prolate.axial * (1.0 + prolate.a) * 1.15;
    slow.spin = 30.0;
    oblate.name = "A/C below 1 - a";
    prolate.name = "A/C above 1 + a";
    slow.name = "30 rad/s";
    for (const TopCase& c : {oblate, prolate, slow}) {
        const double time = run_top(c, 0.17, microseconds(1000), 5.0).time_to_stem_contact;
        record({std::string("tippe top, ") + c.name, "stem's contacts in 5 s", 1e-3,
                time == reference::TopResult::never ? 0.0 : 1.0, 0.0});
        EXPECT_EQ(time, reference::TopResult::never) << c.name;
    }
}

/// Started rolling, slowly enough that friction can hold it, it must go on rolling: what slips must vanish with h. From a
/// twentieth of the speed at which the contact point moves over the surface on it is said to slip.
TEST(law_top, a_top_that_starts_rolling_goes_on_rolling) {
    constexpr double speed_of_contact = 0.08; // [m/s]
    TopCase c = top_cases[0];
    c.spin = 20.0;
    double last = 0.0, rolls_below = 0.0;
    for (const int step : {64000, 32000, 16000, 8000, 4000, 2000, 1000, 500}) {
        const Rational h = microseconds(step);
        sim::SceneDef scene = top_scene(c, 0.3, h);
        const Vec3 arm = scene.bodies[1].pose.orientation * Vec3(0, 0, c.a * c.radius) - Vec3(0, 0, c.radius);
        scene.bodies[1].velocity = -scene.bodies[1].angular_velocity.cross(arm);
        sim::World world(scene);
        double largest = 0.0;
        run(world, scene, 1.0, [&](const sim::Snapshot& s, const sim::StepReport&) {
            const Vec3 u = s.bodies[1].velocity + s.bodies[1].angular_velocity.cross(lowest_point(c, s));
            largest = std::max(largest, u.norm());
            return true;
        });
        record({"tippe top, started rolling", "largest slip in 1 s [m/s]", h.value(), largest, no_value});
        rolls_below = rolls_below == 0.0 && largest < 0.05 * speed_of_contact ? h.value() : rolls_below;
        if (step <= 2000) {
            EXPECT_LT(largest, 0.3 * last) << "h " << h.value(); // second order
        }
        last = largest;
    }
    record({"tippe top, started rolling", "rolls on at steps up to [s]", no_value, rolls_below, no_value});
    EXPECT_GE(rolls_below, 0.03);
}

} // namespace
