/// Extremes of structure: many bodies, many contacts, joints that say too much, exact alignment, many steps.
#include "sim/model/polytope.h"
#include "tests/laws/extreme_row.h"

namespace laws {
namespace {

const sim::MaterialDef rough = material(0.0, 0.8);

ExtremeCase tower(int count, long long steps) {
    sim::SceneDef scene = usual_scene();
    add_plane(scene, Quat::Identity(), rough);
    for (int i = 0; i < count; ++i) {
        add_box(scene, Vec3::Constant(0.5), {{0, 0, 0.5 + i}, Quat::Identity()}, rough);
    }
    return {.scene = scene, .steps = steps, .check_every = 50, .law = stays(1e-2)};
}

/// Two cards that lean against each other above (x, z), 15 degrees from the vertical.
void add_pair_of_cards(sim::SceneDef& scene, const Vec3& half, double x, double z) {
    const double angle = pi / 12;
    for (const double side : {-1.0, 1.0}) {
        // The upper edge that leans is at x, the lower one at z.
        const Quat turn(Eigen::AngleAxisd(-side * angle, Vec3::UnitY()));
        const double reach = half.x() * std::cos(angle) + half.z() * std::sin(angle);
        const double height = half.z() * std::cos(angle) + half.x() * std::sin(angle);
        add_box(scene, half, {{x + side * reach, 0, z + height}, turn}, rough);
    }
}

ExtremeCase card_house() {
    sim::SceneDef scene = usual_scene();
    add_plane(scene, Quat::Identity(), rough);
    const Vec3 half(0.005, 0.3, 0.5);
    const double storey = 2 * (half.z() * std::cos(pi / 12) + half.x() * std::sin(pi / 12));
    add_pair_of_cards(scene, half, -0.3, 0.0);
    add_pair_of_cards(scene, half, 0.3, 0.0);
    add_box(scene, Vec3(0.5, 0.3, 0.005), {{0, 0, storey + 0.005}, Quat::Identity()}, rough);
    add_pair_of_cards(scene, half, 0.0, storey + 0.01);
    return {.scene = scene, .steps = 3000, .law = stays(1e-3)};
}

/// The hull of points given in the world, at rest.
void add_hull(sim::SceneDef& scene, const std::vector<Vec3>& points) {
    const sim::Polytope hull = *sim::convex_hull(points);
    const Vec3 centre = sim::volume_moments(hull).centroid;
    sim::BodyDef body;
    body.name = "hull_" + std::to_string(scene.bodies.size());
    body.shape = sim::Hull{std::make_shared<sim::Polytope>(sim::moved(hull, -centre))};
    body.mass = sim::mass_properties(body.shape, 1000.0);
    body.mass.centre_of_mass = Vec3::Zero();
    body.pose.position = centre;
    body.material = rough;
    scene.bodies.push_back(body);
}

/// Half a ring of wedges on the floor, without mortar. It stands if its thickness is more than 0.1075 of the mean
/// radius (Milankovitch 1907); here it is a third of it.
ExtremeCase arch(int wedges) {
    sim::SceneDef scene = usual_scene();
    add_plane(scene, Quat::Identity(), rough);
    const double inner = 1.0, outer = 1.4, depth = 0.4;
    for (int i = 0; i < wedges; ++i) {
        std::vector<Vec3> points;
        for (const double angle : {pi * i / wedges, pi * (i + 1) / wedges}) {
            for (const double radius : {inner, outer}) {
                for (const double side : {-0.5, 0.5}) {
                    points.emplace_back(radius * std::cos(angle), side * depth, radius * std::sin(angle));
                }
            }
        }
        add_hull(scene, points);
    }
    return {.scene = scene, .steps = 3000, .law = stays(1e-3)};
}

/// The first of a row of dominoes is tipped; the last one has to fall.
ExtremeCase dominoes(int count) {
    sim::SceneDef scene = usual_scene();
    const sim::MaterialDef surface = material(0.1, 0.3);
    add_plane(scene, Quat::Identity(), surface);
    for (int i = 0; i < count; ++i) {
        add_box(scene, Vec3(0.01, 0.03, 0.06), {{0.06 * i, 0, 0.06}, Quat::Identity()}, surface);
    }
    scene.bodies[1].velocity = Vec3(0.18, 0, 0.03); // it turns about its lower edge
    scene.bodies[1].angular_velocity = Vec3(0, 3, 0);
    return {.scene = scene,
            .steps = 500 + 50LL * count,
            .check_every = 50,
            .law = [](const auto&, const auto& last) {
                const Vec3 up = last.bodies.back().orientation * Vec3::UnitZ();
                return std::vector<Finding>{{"the last one's axis, upward part", up.z(), 0.7}};
            }};
}

/// A plate on n x n fixed balls.
ExtremeCase plate_on_balls(int n) {
    sim::SceneDef scene = usual_scene();
    const double size = 0.1 * n;
    add_box(scene, Vec3(0.5 * size, 0.5 * size, 0.05), {{0, 0, 0.1}, Quat::Identity()}, rough);
    for (int i = 0; i < n * n; ++i) {
        const double x = 0.1 * (i % n) + 0.05 - 0.5 * size;
        const double y = 0.1 * (i / n) + 0.05 - 0.5 * size;
        scene.bodies[add_sphere(scene, 0.05, {x, y, 0}, rough)].mass = {};
    }
    return {.scene = scene, .steps = 100, .check_every = 20, .law = stays(1e-4)};
}

/// A door held by three hinges where one is enough, swinging about a level axis.
ExtremeCase three_hinges() {
    sim::SceneDef scene = usual_scene();
    const int frame = add_sphere(scene, 0.01, {0, 0, 1000});
    scene.bodies[frame].mass = {};
    const int door = add_box(scene, Vec3(0.4, 0.8, 0.02), {{0.5, 0, 0}, Quat::Identity()});
    for (const double y : {-0.6, 0.0, 0.6}) {
        add_joint(scene, sim::JointKind::hinge, {door, frame}, {0, y, 0}, Vec3::UnitY());
    }
    return {.scene = scene, .steps = 3000, .energy_gain = 1e-5};
}

/// Four bars in a ring of hinges, hung by two: a plane mechanism, over-constrained in space.
ExtremeCase ring_of_bars() {
    sim::SceneDef scene = usual_scene();
    const int frame = add_sphere(scene, 0.01, {0, 0, 1000});
    scene.bodies[frame].mass = {};
    const Vec3 upright(0.05, 0.05, 0.5), level(0.5, 0.05, 0.05);
    const int left = add_box(scene, upright, {{-0.5, 0, 0}, Quat::Identity()});
    const int right = add_box(scene, upright, {{0.5, 0, 0}, Quat::Identity()});
    const int bottom = add_box(scene, level, {{0, 0, -0.5}, Quat::Identity()});
    add_joint(scene, sim::JointKind::hinge, {left, frame}, {-0.5, 0, 0.5});
    add_joint(scene, sim::JointKind::hinge, {right, frame}, {0.5, 0, 0.5});
    add_joint(scene, sim::JointKind::hinge, {bottom, left}, {-0.5, 0, -0.5});
    add_joint(scene, sim::JointKind::hinge, {bottom, right}, {0.5, 0, -0.5});
    for (const int body : {left, right}) {
        scene.bodies[body].angular_velocity = Vec3(0, 2, 0);
        scene.bodies[body].velocity = Vec3(-1, 0, 0);
    }
    scene.bodies[bottom].velocity = Vec3(-2, 0, 0);
    return {.scene = scene, .steps = 3000, .energy_gain = 1e-5};
}

/// A block of n x n x n cubes, face on face and edge on edge.
ExtremeCase aligned_cubes(int n) {
    sim::SceneDef scene = usual_scene();
    add_plane(scene, Quat::Identity(), rough);
    for (int i = 0; i < n * n * n; ++i) {
        add_box(scene, Vec3::Constant(0.5),
                {{i % n + 0.0, i / n % n + 0.0, 0.5 + i / n / n}, Quat::Identity()}, rough);
    }
    return {.scene = scene, .steps = 1000, .law = stays(1e-4)};
}

/// A bar falls with its edge exactly along the edge of another that cannot move.
ExtremeCase parallel_edges() {
    sim::SceneDef scene = usual_scene();
    scene.bodies.clear();
    const Quat turn(Eigen::AngleAxisd(pi / 4, Vec3::UnitX()));
    const double reach = std::sqrt(0.5);
    const int lower = add_box(scene, Vec3(2, 0.5, 0.5), {{0, 0, 0}, turn}, rough);
    scene.bodies[lower].mass = {};
    add_box(scene, Vec3(1, 0.5, 0.5), {{0, 0, 2 * reach + 0.1}, turn}, rough);
    add_plane(scene, Quat::Identity(), rough);
    scene.bodies.back().pose.position.z() = -3;
    return {.scene = scene, .steps = 2000};
}

/// A cube on the floor for a very long time.
ExtremeCase long_rest(long long steps) {
    sim::SceneDef scene = usual_scene();
    add_plane(scene, Quat::Identity(), rough);
    add_box(scene, Vec3::Constant(0.5), {{0, 0, 0.5}, Quat::Identity()}, rough);
    return {.scene = scene, .steps = steps, .check_every = 1000, .law = stays(1e-6)};
}

} // namespace

void add_structure_rows(std::vector<ExtremeRow>& rows) {
    using enum Promise;
    rows.push_back({"tower_of_100", kept, true, 60, [] { return tower(100, 1000); }});
    rows.push_back({"card_house", kept, true, 20, card_house});
    rows.push_back({"arch_of_9_wedges", kept, true, 60, [] { return arch(9); }});
    rows.push_back({"dominoes_200", kept, false, 1200, [] { return dominoes(200); }});
    rows.push_back({"dominoes_10", kept, true, 20, [] { return dominoes(10); }});
    rows.push_back({"contacts_10000_on_one_body", kept, false, 60, [] { return plate_on_balls(100); }});
    rows.push_back({"contacts_100_on_one_body", kept, true, 20, [] { return plate_on_balls(10); }});
    rows.push_back({"joints_three_hinges_on_one_axis", kept, true, 20, three_hinges});
    rows.push_back({"joints_ring_of_bars", kept, true, 20, ring_of_bars});
    rows.push_back({"aligned_cubes", kept, true, 20, [] { return aligned_cubes(3); }});
    rows.push_back({"parallel_edges", kept, true, 20, parallel_edges});
    rows.push_back({"rest_of_1e4_steps", kept, true, 20, [] { return long_rest(10000); }});
    rows.push_back({"rest_of_1e7_steps", kept, false, 300, [] { return long_rest(10000000); }});
}

} // namespace laws
