/// Extremes of motion: spins, speeds, and quantities near the ends of the range of numbers.
#include "tests/laws/extreme_row.h"

#include <fmt/format.h>

#include <limits>

namespace laws {
namespace {

/// A brick turning freely: energy and angular momentum are kept.
ExtremeCase free_spin(double spin) {
    sim::SceneDef scene = usual_scene();
    scene.step.gravity = Vec3::Zero();
    const int box = add_box(scene, Vec3(0.3, 0.2, 0.1), {});
    scene.bodies[box].angular_velocity = spin * Vec3(0.01, 1.0, 0.02).normalized();
    return {
        .scene = scene, .steps = 1000, .energy_gain = 1e-9, .law = [=](const auto& first, const auto& last) {
            const Vec3 before = angular_momentum(scene, first), after = angular_momentum(scene, last);
            return std::vector<Finding>{
                {"change of angular momentum [-]", (after - before).norm() / before.norm(), 1e-9}};
        }};
}

/// A cube that spins on the floor about the vertical, and a ball.
ExtremeCase spin_in_contact(double spin) {
    sim::SceneDef scene = usual_scene();
    const sim::MaterialDef surface = material(0.0, 0.3);
    add_plane(scene, Quat::Identity(), surface);
    const int box = add_box(scene, Vec3::Constant(0.05), {{0, 0, 0.05}, Quat::Identity()}, surface);
    const int ball = add_sphere(scene, 0.05, {1, 0, 0.05}, surface);
    scene.bodies[box].angular_velocity = Vec3(0, 0, spin);
    scene.bodies[ball].angular_velocity = Vec3(0, 0, spin);
    // The four corners carry a quarter each: m s^2 / 6 dw/dt = mu m g s / sqrt(2).
    const double rate = 0.3 * g * 6.0 / (std::sqrt(2.0) * 0.1);
    return {.scene = scene, .steps = 100, .energy_gain = 1e-9, .law = [=](const auto&, const auto& last) {
                const double turns = last.bodies[box].angular_velocity.z();
                return std::vector<Finding>{{"error of the cube's loss of spin [-]",
                                             std::abs(1.0 - (spin - turns) / (0.1 * rate)), 1e-3}};
            }};
}

/// A ball or a cube of 0.2 m meets a wall of 0.1 m at 1000 m/s: it would be through in a tenth of a step.
ExtremeCase bullet(bool is_ball, double restitution, sim::ImpactHandling impacts) {
    sim::SceneDef scene = usual_scene();
    scene.step.gravity = Vec3::Zero();
    scene.step.impacts = impacts;
    const sim::MaterialDef surface = material(restitution, 0.0);
    const int wall = add_box(scene, Vec3(0.05, 5, 5), {}, surface);
    scene.bodies[wall].mass = {};
    const Vec3 start(-20.3, 0, 0);
    const int body = is_ball ? add_sphere(scene, 0.1, start, surface)
                             : add_box(scene, Vec3::Constant(0.1), {start, Quat::Identity()}, surface);
    scene.bodies[body].velocity = Vec3(1000, 0, 0);
    return {
        .scene = scene, .steps = 50, .check_every = 1, .law = [=](const auto&, const auto& last) {
            const sim::BodySnapshot& end = last.bodies[body];
            return std::vector<Finding>{
                {"place behind the wall's face [m]", end.position.x() + 0.15, 1e-4},
                {"error of the speed after [m/s]", std::abs(end.velocity.x() + restitution * 1000.0), 1e-6}};
        }};
}

/// Two equal balls whose centres would coincide exactly at the end of a step exchange their speeds.
ExtremeCase meeting_centres() {
    sim::SceneDef scene = usual_scene();
    scene.step.gravity = Vec3::Zero();
    const int left = add_sphere(scene, 0.125, {-0.5, 0, 0}, material(1.0, 0.0));
    const int right = add_sphere(scene, 0.125, {0.5, 0, 0}, material(1.0, 0.0));
    scene.bodies[left].velocity = Vec3(500, 0, 0);
    scene.bodies[right].velocity = Vec3(-500, 0, 0);
    return {.scene = scene, .steps = 5, .check_every = 1, .law = [=](const auto&, const auto& last) {
                return std::vector<Finding>{{"error of the speeds [m/s]",
                                             std::max(std::abs(last.bodies[left].velocity.x() + 500),
                                                      std::abs(last.bodies[right].velocity.x() - 500)),
                                             1e-6}};
            }};
}

} // namespace

void add_motion_rows(std::vector<ExtremeRow>& rows) {
    rows.push_back({"spin_1e4_free", Promise::kept, true, 20, [] { return free_spin(1e4); }});
    for (const double spin : {1e4, 1e5, 1e7}) {
        rows.push_back({"spin_" + power(spin) + "_in_contact", Promise::kept_or_refused, true, 20,
                        [=] { return spin_in_contact(spin); }});
    }
    using enum sim::ImpactHandling;
    for (const auto impacts : {ahead, stop}) {
        for (const bool is_ball : {true, false}) {
            for (const double restitution : {0.0, 1.0}) {
                rows.push_back(
                    {fmt::format("{}_at_1000_m_s_restitution_{:.0f}_impacts_{}", is_ball ? "ball" : "cube",
                                 restitution, impacts == ahead ? "ahead" : "stop"),
                     Promise::kept, true, 20, [=] { return bullet(is_ball, restitution, impacts); }});
            }
        }
    }
    rows.push_back({"centres_coincident_within_a_step", Promise::kept, true, 20, meeting_centres});
}

namespace {

using Change = std::function<void(sim::SceneDef&)>;

/// A cube let fall onto the floor, changed.
ExtremeRow number_row(const std::string& name, const Change& change) {
    return {name, Promise::kept_or_refused, true, 20, [=] {
                sim::SceneDef scene = usual_scene();
                add_plane(scene, Quat::Identity(), material(0.5, 0.5));
                add_box(scene, Vec3::Constant(0.5), {{0, 0, 0.55}, Quat::Identity()}, material(0.5, 0.5));
                change(scene);
                return ExtremeCase{.scene = scene, .steps = 300};
            }};
}

} // namespace

void add_number_rows(std::vector<ExtremeRow>& rows) {
    constexpr double tiny = std::numeric_limits<double>::denorm_min(), huge = 1e300;
    const auto body = [](sim::SceneDef& scene) -> sim::BodyDef& { return scene.bodies[1]; };
    for (const double value : {tiny, huge}) {
        const std::string end = value < 1.0 ? "denormal" : "1e300";
        rows.push_back(number_row("mass_" + end, [=](sim::SceneDef& scene) {
            body(scene).mass = {value, Vec3::Zero(), value / 6.0 * sim::Mat3::Identity()};
        }));
        rows.push_back(number_row("size_" + end, [=](sim::SceneDef& scene) {
            body(scene).shape = sim::Box{Vec3::Constant(value)};
            body(scene).pose.position.z() = value;
        }));
        rows.push_back(
            number_row("tolerance_" + end, [=](sim::SceneDef& scene) { scene.step.tolerance = value; }));
        rows.push_back(number_row("velocity_tolerance_" + end,
                                  [=](sim::SceneDef& scene) { scene.step.velocity_tolerance = value; }));
        rows.push_back(number_row("resting_distance_" + end,
                                  [=](sim::SceneDef& scene) { scene.step.resting_distance = value; }));
        rows.push_back(
            number_row("velocity_" + end, [=](sim::SceneDef& scene) { body(scene).velocity.x() = value; }));
        rows.push_back(number_row("spin_" + end,
                                  [=](sim::SceneDef& scene) { body(scene).angular_velocity.z() = value; }));
        rows.push_back(
            number_row("gravity_" + end, [=](sim::SceneDef& scene) { scene.step.gravity.z() = -value; }));
        rows.push_back(number_row("friction_" + end, [=](sim::SceneDef& scene) {
            body(scene).velocity.x() = 1.0;
            body(scene).material = scene.bodies[0].material = material(0.0, value);
        }));
        rows.push_back(
            number_row("place_" + end, [=](sim::SceneDef& scene) { body(scene).pose.position.x() = value; }));
    }
    rows.push_back(number_row("step_1e12th_of_a_second", [](sim::SceneDef& scene) {
        scene.step.time_step = sim::make_rational(1, 1000000000000);
    }));
    rows.push_back(number_row("deep_overlap_at_the_start",
                              [=](sim::SceneDef& scene) { body(scene).pose.position.z() = -0.3; }));
    rows.push_back(number_row("centres_coincident_at_the_start", [](sim::SceneDef& scene) {
        add_sphere(scene, 0.2, {0, 0, 0.5}, material(0.0, 0.5));
    }));
}

} // namespace laws
