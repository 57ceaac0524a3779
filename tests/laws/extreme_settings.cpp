/// Extremes of what a scene sets: mass ratios, steps, surfaces, gravity, sizes, distance from the origin.
#include "tests/laws/extreme_row.h"

#include <fmt/format.h>

namespace laws {

std::vector<ExtremeRow> extreme_rows() {
    std::vector<ExtremeRow> rows;
    add_settings_rows(rows);
    add_motion_rows(rows);
    add_structure_rows(rows);
    add_number_rows(rows);
    return rows;
}

namespace {

/// Three cubes of edge `size` [m] on the floor at x = `place` [m]; the middle one is `ratio` times as
/// heavy as the others.
sim::SceneDef stack(Rational h, double size, double ratio, double place = 0.0) {
    sim::SceneDef scene = usual_scene(h);
    scene.step.tolerance = std::min(1e-4, 1e-3 * size);
    add_plane(scene, Quat::Identity(), material(0.0, 0.5));
    for (int i = 0; i < 3; ++i) {
        add_box(scene, Vec3::Constant(0.5 * size), {{place, 0, (0.5 + i) * size}, Quat::Identity()},
                material(0.0, 0.5), i == 1 ? 1000.0 * ratio : 1000.0);
    }
    return scene;
}

/// Gaps of one tolerance at an edge of a cube tilt what stands on it: three cubes up, it leans by three tolerances.
ExtremeCase resting(const sim::SceneDef& scene, long long steps) {
    const double bound = 3.0 * scene.step.tolerance;
    return {.scene = scene, .steps = steps, .law = stays(bound)};
}

/// Ten balls on a rope let go horizontally; the last one is `ratio` times as heavy as the others.
ExtremeCase chain(double ratio, double place = 0.0) {
    sim::SceneDef scene = usual_scene();
    sim::BodyDef frame;
    frame.name = "frame";
    frame.shape = sim::Sphere{0.01};
    frame.pose.position = Vec3(place, 0, 10);
    scene.bodies.push_back(frame);
    for (int i = 1; i <= 10; ++i) {
        add_sphere(scene, 0.05, {place + 0.2 * i, 0, 10}, {}, i == 10 ? 1000.0 * ratio : 1000.0);
        add_joint(scene, sim::JointKind::ball, {i, i - 1}, {place + 0.2 * (i - 1), 0, 10});
    }
    return {.scene = scene, .steps = 1000, .energy_gain = 1e-4, .law = [=](const auto& first, const auto& last) {
                const double start = energy(scene, first), end = energy(scene, last);
                double mass = 0.0;
                for (const sim::BodyDef& body : scene.bodies) {
                    mass += body.mass.mass;
                }
                return std::vector<Finding>{{"loss of energy, of a fall by 1 m [-]", (start - end) / (mass * g), 1e-2}};
            }};
}

void add_mass_rows(std::vector<ExtremeRow>& rows) {
    for (const double ratio : {1e-4, 1e-2, 1e2, 1e4, 1e-9, 1e9}) {
        const Promise promise = ratio < 1e-4 || ratio > 1e4 ? Promise::kept_or_refused : Promise::kept;
        rows.push_back({"mass_ratio_" + power(ratio) + "_in_a_stack", promise, promise == Promise::kept, 20,
                        [=] { return resting(stack(microseconds(1000), 1.0, ratio), 1000); }});
        rows.push_back({"mass_ratio_" + power(ratio) + "_in_a_chain", promise,
                        promise == Promise::kept, 60, [=] { return chain(ratio); }});
    }
}

/// A cube and a ball let fall, a cube that slides: on the floor at z = 0.
sim::SceneDef falling(Rational h, double size, double restitution, double friction, double height) {
    sim::SceneDef scene = usual_scene(h);
    scene.step.tolerance = std::min(1e-4, 1e-3 * size);
    const sim::MaterialDef surface = material(restitution, friction);
    add_plane(scene, Quat::Identity(), surface);
    const Quat turn(Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()));
    add_box(scene, Vec3::Constant(0.5 * size), {{0, 0, 0.9 * size + height}, turn}, surface);
    const int ball = add_sphere(scene, 0.5 * size, {3 * size, 0, 0.5 * size + height}, surface);
    const int slider =
        add_box(scene, Vec3::Constant(0.5 * size), {{0, 4 * size, 0.5 * size}, Quat::Identity()}, surface);
    const double speed = std::sqrt(g * size);
    scene.bodies[ball].velocity = Vec3(speed, 0, 0);
    scene.bodies[ball].angular_velocity = Vec3(0, 0, speed / size);
    scene.bodies[slider].velocity = Vec3(0, speed, 0);
    return scene;
}

void add_step_rows(std::vector<ExtremeRow>& rows) {
    for (const std::int64_t us : {1, 10, 100, 1000, 10000, 40000, 100000}) {
        const Promise promise = us > 40000 ? Promise::kept_or_refused : Promise::kept;
        const long long steps = us < 1000 ? 20000 : 4000000 / us;
        rows.push_back({fmt::format("step_{}_us_stack", us), promise, true, 20,
                        [=] { return resting(stack(microseconds(us), 1.0, 1.0), steps); }});
        rows.push_back({fmt::format("step_{}_us_falling", us), promise, true, 20, [=] {
                            return ExtremeCase{
                                .scene = falling(microseconds(us), 1.0, 0.3, 0.4, us < 1000 ? 1e-3 : 0.1),
                                .steps = steps};
                        }});
    }
}

/// loss: bound on that of energy where there should be none. An impact held ahead acts at the end of a step,
/// up to h late: the speed v after a fall is off by up to g h, the energy by 2 g h / v, 6e-3, in each.
ExtremeCase bouncing(double restitution, double friction, double loss) {
    const sim::SceneDef scene = falling(microseconds(1000), 1.0, restitution, friction, 0.5);
    const bool is_elastic = restitution == 1.0 && friction == 0.0;
    return {.scene = scene, .steps = 3000, .law = [=](const auto& first, const auto& last) {
                const double before = energy(scene, first), after = energy(scene, last);
                return is_elastic
                           ? std::vector<Finding>{{"loss of energy [-]", (before - after) / before, loss}}
                           : std::vector<Finding>{};
            }};
}

void add_surface_rows(std::vector<ExtremeRow>& rows) {
    rows.push_back({"restitution_1_impacts_stop", Promise::kept, true, 20, [] {
                        ExtremeCase extreme = bouncing(1.0, 0.0, 1e-6);
                        extreme.scene.step.impacts = sim::ImpactHandling::stop;
                        return extreme;
                    }});
    for (const double restitution : {0.0, 1.0}) {
        for (const double friction : {0.0, 0.5}) {
            rows.push_back(
                {fmt::format("restitution_{:.0f}_friction_{}", restitution, friction > 0.0 ? "half" : "0"),
                 Promise::kept, true, 20, [=] { return bouncing(restitution, friction, 1e-3); }});
        }
    }
    for (const double mu : {0.0, 1e-6, 10.0, 1e6}) {
        rows.push_back(
            {"friction_" + (mu == 0.0 ? "0" : power(mu)) + "_on_an_incline",
             mu > 10.0 ? Promise::kept_or_refused : Promise::kept, true, 20, [=] {
                 sim::SceneDef scene = usual_scene();
                 const Quat turn(Eigen::AngleAxisd(pi / 6, Vec3::UnitY()));
                 add_plane(scene, turn, material(0.0, mu));
                 add_box(scene, Vec3(0.5, 0.5, 0.25), {turn * Vec3(0, 0, 0.25), turn}, material(0.0, mu));
                 const double slope = std::max(0.0, std::sin(pi / 6) - mu * std::cos(pi / 6));
                 return ExtremeCase{
                     .scene = scene, .steps = 1000, .law = [=](const auto& first, const auto& last) {
                         return std::vector<Finding>{{"error of the distance [m]",
                                                      std::abs(drift(first, last) - 0.5 * g * slope), 1e-6}};
                     }};
             }});
    }
}

void add_gravity_rows(std::vector<ExtremeRow>& rows) {
    for (const double gravity : {0.0, 1e3, 1e4}) {
        const Promise promise = gravity > 1e3 ? Promise::kept_or_refused : Promise::kept;
        const std::string name = "gravity_" + (gravity == 0.0 ? std::string("0") : power(gravity));
        rows.push_back({name + "_stack", promise, true, 20, [=] {
                            sim::SceneDef scene = stack(microseconds(1000), 1.0, 1.0);
                            scene.step.gravity = Vec3(0, 0, -gravity);
                            return resting(scene, 1000);
                        }});
        rows.push_back({name + "_falling", promise, true, 20, [=] {
                            sim::SceneDef scene = falling(microseconds(1000), 1.0, 0.3, 0.4, 0.5);
                            scene.step.gravity = Vec3(0, 0, -gravity);
                            return ExtremeCase{.scene = scene, .steps = 2000};
                        }});
    }
}

void add_size_rows(std::vector<ExtremeRow>& rows) {
    for (const double size : {1e-4, 1e3, 1e-6, 1e6}) {
        const Promise promise = size < 1e-4 || size > 1e3 ? Promise::kept_or_refused : Promise::kept;
        rows.push_back({"bodies_of_" + power(size) + "_m_stack", promise, true, 20,
                        [=] { return resting(stack(microseconds(1000), size, 1.0), 1000); }});
        rows.push_back({"bodies_of_" + power(size) + "_m_falling", promise, true, 20, [=] {
                            const Rational h = size < 1e-2 ? microseconds(100) : microseconds(1000);
                            return ExtremeCase{.scene = falling(h, size, 0.3, 0.4, 0.1 * size),
                                               .steps = 2000};
                        }});
    }
    rows.push_back({"bodies_of_1em4_m_at_tolerance_1em4_m", Promise::kept_or_refused, true, 20, [] {
                        sim::SceneDef scene = stack(microseconds(1000), 1e-4, 1.0);
                        scene.step.tolerance = 1e-4;
                        return resting(scene, 1000);
                    }});
    rows.push_back(
        {"bodies_of_1em4_m_and_1e3_m", Promise::kept, true, 20, [] {
             sim::SceneDef scene = stack(microseconds(1000), 1e3, 1.0);
             scene.step.tolerance = 1e-7;
             const sim::MaterialDef surface = material(0.0, 0.5);
             add_box(scene, Vec3::Constant(0.5e-4), {{0, 0, 3e3 + 0.5e-4}, Quat::Identity()}, surface);
             add_box(scene, Vec3::Constant(0.5e-4), {{0, 2e3, 0.5e-4}, Quat::Identity()}, surface);
             return ExtremeCase{.scene = scene, .steps = 1000, .law = stays(1e-7)};
         }});
}

void add_place_rows(std::vector<ExtremeRow>& rows) {
    for (const double place : {1e5, 1e7}) {
        const Promise promise = place > 1e5 ? Promise::kept_or_refused : Promise::kept;
        rows.push_back({"stack_" + power(place) + "_m_from_the_origin", promise, true, 20,
                        [=] { return resting(stack(microseconds(1000), 1.0, 1.0, place), 1000); }});
        rows.push_back({"chain_" + power(place) + "_m_from_the_origin", promise, true, 20,
                        [=] { return chain(1.0, place); }});
        rows.push_back({"falling_" + power(place) + "_m_from_the_origin", promise, true, 20, [=] {
                            sim::SceneDef scene = falling(microseconds(1000), 1.0, 0.3, 0.4, 0.5);
                            for (sim::BodyDef& body : scene.bodies) {
                                body.pose.position.x() += place;
                            }
                            return ExtremeCase{.scene = scene, .steps = 2000};
                        }});
    }
}

/// Five plates of edge 1 m let fall on each other, and a tilted one.
ExtremeCase plates(double thickness, double tolerance) {
    const double half = 0.5 * thickness;
    sim::SceneDef scene = usual_scene();
    scene.step.tolerance = tolerance;
    const sim::MaterialDef surface = material(0.2, 0.4);
    add_plane(scene, Quat::Identity(), surface);
    for (int i = 0; i < 5; ++i) {
        add_box(scene, Vec3(0.5, 0.5, half), {{0.01 * i, 0, half + (2 * half + 0.01) * i}, Quat::Identity()}, surface);
    }
    const Quat turn(Eigen::AngleAxisd(0.5, Vec3(1, 1, 0).normalized()));
    add_box(scene, Vec3(0.5, 0.5, half), {{2, 0, 0.5}, turn}, surface);
    return {.scene = scene, .steps = 2000};
}

void add_plate_rows(std::vector<ExtremeRow>& rows) {
    using enum Promise;
    rows.push_back({"plates_of_thickness_1em3", kept, false, 20, [] { return plates(1e-3, 1e-4); }});
    rows.push_back({"plates_of_thickness_1em5", kept_or_refused, true, 20, [] { return plates(1e-5, 1e-4); }});
    rows.push_back({"plates_of_thickness_1em5_at_tolerance_1em6_m", kept_or_refused, false, 60,
                    [] { return plates(1e-5, 1e-6); }});
}

} // namespace

void add_settings_rows(std::vector<ExtremeRow>& rows) {
    add_mass_rows(rows);
    add_step_rows(rows);
    add_surface_rows(rows);
    add_gravity_rows(rows);
    add_size_rows(rows);
    add_place_rows(rows);
    add_plate_rows(rows);
}

} // namespace laws
