/// The physical pendulum at large amplitude against the elliptic integral, on a ball and on a hinge joint.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

namespace {

using namespace laws;

const Vec3 rod_half_extents(0.05, 0.05, 0.5); // [m]
constexpr double arm = 0.4;                   // [m] from the joint to the centre of mass
constexpr double amplitude = 2.5;             // [rad] from hanging

sim::SceneDef pendulum_scene(Rational h, sim::JointKind kind) {
    sim::SceneDef scene = law_scene(h);
    const int frame = add_frame(scene);
    const Quat turn(Eigen::AngleAxisd(amplitude, Vec3::UnitY()));
    const int rod = add_box(scene, rod_half_extents, {turn * Vec3(0, 0, -arm), turn});
    add_joint(scene, kind, {rod, frame}, Vec3::Zero());
    return scene;
}

/// Period [s] = 4 sqrt(I / (m g d)) K(sin(amplitude / 2)), I about the joint.
double exact_period(const sim::SceneDef& scene) {
    const sim::MassProperties& mass = scene.bodies[1].mass;
    const double inertia = mass.inertia(1, 1) + mass.mass * arm * arm;
    return 4.0 * std::sqrt(inertia / (mass.mass * g * arm)) * std::comp_ellint_1(std::sin(amplitude / 2));
}

struct Swing {
    double period = 0.0;      ///< [s] over the first 8 half periods
    double joint_gap = 0.0;   ///< [m]
    double oscillation = 0.0; ///< [-] of the energy, relative to the greatest kinetic energy
    double drift = 0.0;       ///< [-] of the energy between two passages of the same kind
};

/// Zero of x in [0, h] by the cubic through values and slopes.
double crossing(double x0, double v0, double x1, double v1, double h) {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 60; ++i) {
        const double s = 0.5 * (low + high), r = 1.0 - s;
        const double x =
            r * r * (1 + 2 * s) * x0 + s * r * r * h * v0 + s * s * (3 - 2 * s) * x1 - s * s * r * h * v1;
        ((x > 0.0) == (x0 > 0.0) ? low : high) = s;
    }
    return high * h;
}

Swing swing(Rational h, sim::JointKind kind, double duration) {
    const sim::SceneDef scene = pendulum_scene(h, kind);
    sim::World world(scene);
    sim::Snapshot before = world.take_snapshot();
    const double start = energy(scene, before);
    const double lowest = -scene.bodies[1].mass.mass * g * arm;
    Swing found;
    std::vector<double> times, energies;
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport&) {
        const double x0 = before.bodies[1].position.x(), x1 = s.bodies[1].position.x();
        const double z = s.bodies[1].position.z();
        if ((x0 > 0.0) != (x1 > 0.0) && z < 0.0) {
            times.push_back(before.time + crossing(x0, before.bodies[1].velocity.x(), x1,
                                                   s.bodies[1].velocity.x(), h.value()));
            energies.push_back(energy(scene, s));
        }
        found.oscillation =
            std::max(found.oscillation, std::abs(energy(scene, s) - start) / (start - lowest));
        found.joint_gap = std::max(found.joint_gap, largest_joint_gap(scene, s));
        before = s;
        return true;
    });
    found.period = times.size() > 8 ? (times[8] - times[0]) / 4.0 : 0.0;
    found.drift = std::abs(energies.back() - energies[energies.size() % 2 == 1 ? 0 : 1]) / (start - lowest);
    return found;
}

TEST(law_pendulum, period_at_large_amplitude_is_the_elliptic_integral) {
    for (const auto kind : {sim::JointKind::ball, sim::JointKind::hinge}) {
        const std::string name = kind == sim::JointKind::ball ? "pendulum, ball joint" : "pendulum, hinge";
        const double exact = exact_period(pendulum_scene(microseconds(1000), kind));
        const Convergence c =
            converge(name, "period, relative", 3e-6,
                     {microseconds(8000), microseconds(4000), microseconds(2000), microseconds(1000)},
                     [&](Rational h) { return std::abs(swing(h, kind, 12.0).period / exact - 1.0); });
        // Leapfrog at angular speed w <= 8 rad/s: (w h)^2 / 24 = 3e-6 at the fastest, less on the average.
        EXPECT_LT(c.errors.back(), 3e-6);
        EXPECT_TRUE(c.is_second_order(1e-12)) << "order " << c.order();
    }
}

TEST(law_pendulum, energy_does_not_drift_and_the_joint_stays_closed) {
    for (const auto kind : {sim::JointKind::ball, sim::JointKind::hinge}) {
        const std::string name = kind == sim::JointKind::ball ? "pendulum, ball joint" : "pendulum, hinge";
        std::vector<double> oscillation;
        for (const Rational h : {microseconds(4000), microseconds(2000), microseconds(1000)}) {
            const Swing s = swing(h, kind, 60.0);
            record({name, "oscillation of energy in 60 s, relative", h.value(), s.oscillation, no_value});
            record({name, "drift of energy in 60 s, relative", h.value(), s.drift, no_value});
            record({name, "joint gap [m]", h.value(), s.joint_gap, 1e-9});
            oscillation.push_back(s.oscillation);
            EXPECT_LT(s.joint_gap, 1e-9);
            // Passages fall on any phase of a step: the same oscillation bounds what two of them differ by.
            EXPECT_LE(s.drift, s.oscillation);
        }
        EXPECT_LT(oscillation.back(), 1e-5);
        EXPECT_GT(std::log2(oscillation[0] / oscillation[2]) / 2, 1.8);
    }
}

} // namespace
