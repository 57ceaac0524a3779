/// The judge of overlaps, judged on pairs whose depth is known.
#include "sim/record/trajectory.h"
#include "tests/laws/reference/overlap.h"
#include "tests/laws/reference/trajectory_file.h"
#include "tests/support/out_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

namespace {

using namespace reference;

// Coordinates of order 1 in double precision: a few roundings of 1e-16 each.
constexpr double rounding = 1e-14; // [m]

Matrix turn(double angle, const Vector& axis) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

OrientedBox cube(const Vector& centre, const Matrix& axes = Matrix::Identity()) {
    return {centre, axes, Vector::Constant(0.5)};
}

/// A turn that takes the direction (1, 1, 1) to z, so that a cube stands on its corner.
Matrix corner_up() {
    return Eigen::AngleAxisd(std::acos(1.0 / std::sqrt(3.0)), Vector(1, -1, 0).normalized()).toRotationMatrix();
}

TEST(overlap, aligned_cubes_overlap_by_the_shortest_way_out) {
    EXPECT_NEAR(gap(cube({0, 0, 0}), cube({0.9, 0.3, -0.2})), -0.1, rounding);
    EXPECT_NEAR(gap(cube({0, 0, 0}), cube({0.1, 0.2, 1.25})), 0.25, rounding);
    EXPECT_NEAR(gap(cube({0, 0, 0}), cube({0, 0, 0})), -1.0, rounding);
}

TEST(overlap, corner_in_a_face) {
    const double reach = std::sqrt(3.0) / 2;
    EXPECT_NEAR(gap(cube({0, 0, 0}), cube({0.1, -0.1, 0.5 + reach - 0.01}, corner_up())), -0.01, rounding);
    EXPECT_NEAR(gap(cube({0, 0, reach - 0.02}, corner_up()), HalfSpace{}), -0.02, rounding);
    EXPECT_NEAR(gap(cube({0, 0, reach + 0.02}, corner_up()), HalfSpace{}), 0.02, rounding);
}

TEST(overlap, crossing_edges_are_found_by_the_edge_axis_only) {
    const double reach = std::sqrt(0.5); // from the centre of a unit cube to the middle of an edge
    const double quarter = std::acos(-1.0) / 4;
    const OrientedBox lower = cube({0, 0, 0}, turn(quarter, Vector::UnitX()));
    const OrientedBox upper = cube({0.1, 0.2, 2 * reach - 0.03}, turn(quarter, Vector::UnitY()));
    EXPECT_NEAR(gap(lower, upper), -0.03, rounding);
    EXPECT_NEAR(gap(upper, lower), -0.03, rounding);
}

TEST(overlap, nearly_parallel_edges_do_not_change_the_depth) {
    for (double angle : {0.0, 1e-16, 1e-14, 1e-13, 3e-13, 1e-12, 3e-12, 1e-11, 1e-9}) {
        for (const Vector& axis : {Vector(0, 0, 1), Vector(1, 0, 0), Vector(1, 2, 3).normalized()}) {
            const double depth = -gap(cube({0, 0, 0}), cube({0.2, 0.1, 0.95}, turn(angle, axis)));
            // The corner moves by at most the angle times the half diagonal of the cube.
            EXPECT_NEAR(depth, 0.05, angle * std::sqrt(0.75) + rounding) << "angle " << angle;
        }
    }
}

/// Depth of two boxes along one direction: how far they must move apart along it.
double depth_along(const OrientedBox& a, const OrientedBox& b, const Vector& d) {
    return (a.axes.transpose() * d).cwiseAbs().dot(a.half_extents) +
           (b.axes.transpose() * d).cwiseAbs().dot(b.half_extents) - std::abs((a.centre - b.centre).dot(d));
}

/// Smallest depth over all directions by sampling and a shrinking random search: slow and without any axes.
double smallest_depth(const OrientedBox& a, const OrientedBox& b, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const auto direction = [&] { return Vector(normal(random), normal(random), normal(random)); };
    Vector best = Vector::UnitX();
    for (int i = 0; i < 20000; ++i) {
        const Vector d = direction().normalized();
        best = depth_along(a, b, d) < depth_along(a, b, best) ? d : best;
    }
    for (double width = 0.1; width > 1e-9; width *= 0.9) {
        for (int i = 0; i < 40; ++i) {
            const Vector d = (best + width * direction()).normalized();
            best = depth_along(a, b, d) < depth_along(a, b, best) ? d : best;
        }
    }
    return depth_along(a, b, best);
}

TEST(overlap, random_boxes_agree_with_a_search_over_all_directions) {
    std::mt19937_64 random(20261120);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    int overlapping = 0;
    for (int i = 0; i < 60; ++i) {
        const auto box = [&](double spread) {
            const Eigen::Quaterniond q(uniform(random), uniform(random), uniform(random), uniform(random));
            const Vector centre(uniform(random), uniform(random), uniform(random));
            const Vector size(0.6 + 0.4 * uniform(random), 0.6 + 0.4 * uniform(random),
                              0.6 + 0.4 * uniform(random));
            return OrientedBox{spread * centre, q.normalized().toRotationMatrix(), size};
        };
        const OrientedBox a = box(0.0), b = box(1.0);
        const double exact = -gap(a, b), searched = smallest_depth(a, b, random);
        if (exact <= 0.0) {
            EXPECT_LE(searched, exact + 1e-6); // apart: the axes give a lower bound of the distance
            continue;
        }
        ++overlapping;
        EXPECT_LE(exact, searched + rounding); // no direction may be shorter
        EXPECT_NEAR(exact, searched, 1e-6);    // and the search reaches it, to its own precision
    }
    EXPECT_GT(overlapping, 20);
}

TEST(overlap, balls) {
    EXPECT_NEAR(gap(Ball{{0, 0, 0}, 1.0}, Ball{{3, 4, 0}, 3.9}), 0.1, rounding);
    EXPECT_NEAR(gap(Ball{{0, 0, 0.3}, 0.5}, HalfSpace{}), -0.2, rounding);
    EXPECT_NEAR(gap(Ball{{0.8, 0.9, 0.2}, 0.4}, cube({0, 0, 0})), 0.1, rounding);  // nearest an edge
    EXPECT_NEAR(gap(Ball{{0.1, 0.1, 0.7}, 0.4}, cube({0, 0, 0})), -0.2, rounding); // nearest a face
    EXPECT_NEAR(gap(Ball{{0.1, 0.1, 0.4}, 0.4}, cube({0, 0, 0})), -0.5, rounding); // centre inside
}

/// A cylinder's hull of 2 n corners on its rims, for comparison: short of it by at most r (1 - cos(pi / n)).
Polyhedron prism(const Rod& rod, int n) {
    Polyhedron solid;
    const Vector x = rod.axis.unitOrthogonal(), y = rod.axis.cross(x);
    const auto corner = [&](double i) -> Vector {
        const double angle = 2 * std::acos(-1.0) * i / n;
        return std::cos(angle) * x + std::sin(angle) * y;
    };
    for (int i = 0; i < n; ++i) {
        for (const double side : {-1.0, 1.0}) {
            solid.vertices.push_back(rod.centre + rod.radius * corner(i) + side * rod.half_length * rod.axis);
        }
        solid.normals.push_back(corner(i + 0.5));
        solid.edges.push_back(rod.axis.cross(corner(i + 0.5)));
    }
    solid.normals.push_back(rod.axis);
    solid.normals.push_back(-rod.axis);
    solid.edges.push_back(rod.axis);
    return solid;
}

TEST(overlap, cylinders_and_capsules_of_known_depth) {
    constexpr double searched = 1e-9; // [m] the last turn of the search, 1e-10 rad, times lengths of some metres
    const Vector x = Vector::UnitX(), z = Vector::UnitZ();
    const Rod upright{{0, 0, 0}, z, 0.5, 0.3, 0.0};
    EXPECT_NEAR(gap(upright, Rod{{0.1, 0.2, 0.9}, z, 0.5, 0.2, 0.0}), -0.1, searched);       // end on end
    EXPECT_NEAR(gap(upright, Rod{{0.3, 0.4, 0.1}, z, 0.5, 0.1, 0.0}), 0.1, searched);        // side by side
    EXPECT_NEAR(gap(upright, Rod{{0, 0.45, 0.1}, x, 0.5, 0.2, 0.0}), -0.05, searched);       // crossed
    EXPECT_NEAR(gap(upright, Rod{{0.9, 0, 0.2}, x, 0.5, 0.0, 0.15}), -0.05, searched);       // a capsule's end
    EXPECT_NEAR(gap(upright, Ball{{0.6, 0, 0.9}, 0.4}), 0.1, searched);                      // on the rim
    EXPECT_NEAR(gap(upright, OrientedBox{{0, 0, 0.95}, Matrix::Identity(), {1, 1, 0.5}}), -0.05, searched);
    const Matrix diagonal = turn(std::acos(-1.0) / 4, z);
    EXPECT_NEAR(gap(upright, OrientedBox{{1.0, 0, 0}, diagonal, {0.5, 0.5, 2}}), 0.7 - std::sqrt(0.5), searched);
    const Rod lying{{0, 0, 0.5}, x, 1.0, 0.0, 0.1}; // a capsule on an edge across it
    EXPECT_NEAR(gap(lying, OrientedBox{{0, 0, -0.3}, turn(std::acos(-1.0) / 4, x), {3, 0.5, 0.5}}),
                0.7 - std::sqrt(0.5), searched);
}

TEST(overlap, random_cylinders_agree_with_prisms_of_many_sides) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto vector = [&] { return Vector(uniform(random), uniform(random), uniform(random)); };
    constexpr int sides = 48;
    int overlaps = 0;
    for (int i = 0; i < 60; ++i) {
        const Rod a{vector(), vector().normalized(), 0.6, 0.5, 0.0};
        const Rod b{vector(), vector().normalized(), 0.4, 0.3, 0.0};
        const OrientedBox box{vector(), turn(uniform(random) * 3, vector().normalized()), {0.3, 0.5, 0.2}};
        const double short_by = 0.5 * (1 - std::cos(std::acos(-1.0) / sides)) * 2;
        for (const auto& [rods, prisms] : {std::pair(gap(a, b), gap(prism(a, sides), prism(b, sides))),
                                           std::pair(gap(a, box), gap(prism(a, sides), box))}) {
            overlaps += rods < 0.0;
            // Apart, the prisms' value is that of the best of their axes: a bound from below.
            EXPECT_LE(prisms, (prisms > 0.0 ? rods : rods + short_by) + short_by) << i;
            if (prisms < 0.0) {
                EXPECT_LE(rods, prisms + 1e-9) << i;
                EXPECT_GE(rods, prisms - short_by) << i;
            }
        }
    }
    EXPECT_GT(overlaps, 20);
}

TEST(overlap, sweep_finds_the_pairs_of_a_full_search) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> uniform(-3.0, 3.0);
    std::vector<Solid> solids{{{{HalfSpace{}}}, true}};
    std::vector<Placement> placements{{}};
    for (int i = 0; i < 150; ++i) {
        Solid solid;
        if (i % 3 == 0) {
            solid.pieces = {{Ball{{0.2, 0, 0}, 0.4}}, {OrientedBox{{0, 0.3, 0}, turn(0.4, Vector::UnitX())}}};
        } else {
            solid.pieces = {{OrientedBox{}}};
        }
        solid.is_static = i % 10 == 0;
        solids.push_back(solid);
        const Eigen::Quaterniond q(uniform(random), uniform(random), uniform(random), uniform(random));
        placements.push_back({{uniform(random), uniform(random), uniform(random)}, q.normalized()});
    }
    const std::vector<PairGap> swept = near_pairs(solids, placements, 0.05, {{3, 5}});
    std::size_t found = 0;
    for (int a = 0; a < static_cast<int>(solids.size()); ++a) {
        for (int b = a + 1; b < static_cast<int>(solids.size()); ++b) {
            const double g = pair_gap(solids[a], placements[a], solids[b], placements[b]);
            if (g > 0.05 || (solids[a].is_static && solids[b].is_static) || (a == 3 && b == 5)) {
                continue;
            }
            ASSERT_LT(found, swept.size());
            EXPECT_EQ(std::pair(swept[found].a, swept[found].b), std::pair(a, b));
            EXPECT_EQ(swept[found++].gap, g);
        }
    }
    EXPECT_EQ(found, swept.size());
    EXPECT_GT(found, 100u);
}

TEST(overlap, a_body_that_jumps_through_a_wall_is_named) {
    const OrientedBox wall{{0, 0, 0}, turn(0.5, Vector::UnitZ()), {0.1, 5, 5}};
    const std::vector<Solid> solids{{{{wall}}, true}, {{{OrientedBox{}}}, false}, {{{HalfSpace{}}}, true}};
    const auto at = [](const Vector& p) {
        return std::vector<Placement>{{}, {p, Eigen::Quaterniond(1, 0, 0, 0)}, {}};
    };
    EXPECT_EQ(passed_through(solids, at({-1, 0, 1}), at({1, 0, 1})), std::vector<int>{1});
    EXPECT_EQ(passed_through(solids, at({-1, 0, 1}), at({-1, 1, 1})), std::vector<int>{});
    EXPECT_EQ(passed_through(solids, at({-1, 0, 6}), at({1, 0, 6})), std::vector<int>{}); // over the top
    EXPECT_EQ(passed_through(solids, at({-2, 0, 1}), at({-2, 0, -1})),
              std::vector<int>{1}); // through the floor
}

TEST(overlap, statistics_use_the_nearest_rank) {
    OverlapStatistics statistics;
    EXPECT_EQ(statistics.largest(), 0.0);
    EXPECT_EQ(statistics.share_above(0.0), 0.0);
    std::vector<PairGap> pairs{{0, 1, 0.5}}; // apart: not an overlap
    for (int i = 1; i <= 200; ++i) {
        pairs.push_back({0, i, -i * 1e-6});
    }
    statistics.add(pairs);
    EXPECT_EQ(statistics.count(), 200u);
    EXPECT_NEAR(statistics.quantile(0.5), 100e-6, 1e-18);
    EXPECT_NEAR(statistics.quantile(0.99), 198e-6, 1e-18);
    EXPECT_NEAR(statistics.largest(), 200e-6, 1e-18);
    EXPECT_EQ(statistics.count_above(150.5e-6), 50u);
    EXPECT_NEAR(statistics.share_above(150.5e-6), 0.25, rounding);
}

TEST(overlap, solids_are_read_from_the_text_of_a_trajectory) {
    const Solid top = solid_from_json(R"({"kind":"compound","parts":[
        {"kind":"sphere","radius":0.3,"position":[0,0,0.1],"orientation":[1,0,0,0]},
        {"kind":"box","half_extents":[1,2,3],"position":[1,0,0],"orientation":[0,0,0,1]}]})",
                                      false);
    ASSERT_EQ(top.pieces.size(), 2u);
    EXPECT_EQ(std::get<Ball>(top.pieces[0].shape).centre.z(), 0.1);
    EXPECT_NEAR((std::get<OrientedBox>(top.pieces[1].shape).axes.col(0) + Vector::UnitX()).norm(), 0.0,
                rounding);
    EXPECT_TRUE(solid_from_json(R"({"kind":"plane"})", true).is_static);
    EXPECT_THROW(solid_from_json(R"({"kind":"cone"})", true), std::runtime_error);
    EXPECT_THROW(TrajectoryFile("no such file"), std::runtime_error);
}

TEST(overlap, a_written_trajectory_is_read_without_the_code_that_wrote_it) {
    sim::SceneDef scene;
    sim::BodyDef floor, top;
    floor.name = "floor";
    floor.shape = sim::Plane{};
    top.name = "top";
    top.mass.mass = 2.0;
    top.shape = sim::Compound{{{sim::Sphere{0.3}, {{0, 0, 0.1}, sim::Quat(1, 0, 0, 0)}},
                               {sim::Box{{0.1, 0.2, 0.3}}, {{1, 0, 0}, sim::Quat(0.5, 0.5, 0.5, 0.5)}}}};
    scene.bodies = {floor, top};
    std::filesystem::create_directories(test::out_folder(""));
    const std::filesystem::path path = test::out_folder("overlap.h5");
    sim::TrajectoryWriter writer(path, scene);
    for (int record = 0; record < 3; ++record) {
        sim::Snapshot snapshot;
        snapshot.step = 10 * record;
        snapshot.time = 0.01 * record;
        snapshot.bodies.resize(2);
        snapshot.bodies[1].position = {0.1 * record, 0, 0.1};
        snapshot.bodies[1].orientation = sim::Quat(0.5, -0.5, 0.5, 0.5);
        writer.append(snapshot);
    }
    writer.finish();
    const TrajectoryFile file(path.string());
    ASSERT_EQ(file.record_count(), 3u);
    EXPECT_EQ(file.time(), (std::vector<double>{0.0, 0.01, 0.02}));
    EXPECT_EQ(file.names(), (std::vector<std::string>{"floor", "top"}));
    ASSERT_EQ(file.solids().size(), 2u);
    EXPECT_TRUE(file.solids()[0].is_static);
    EXPECT_FALSE(file.solids()[1].is_static);
    ASSERT_EQ(file.solids()[1].pieces.size(), 2u);
    EXPECT_EQ(std::get<OrientedBox>(file.solids()[1].pieces[1].shape).half_extents, Vector(0.1, 0.2, 0.3));
    const std::vector<Placement> placed = file.placements(2);
    EXPECT_EQ(placed[1].position, Vector(0.2, 0, 0.1));
    EXPECT_EQ(placed[1].orientation.coeffs(), Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5).coeffs());
    // The turn takes the ball's centre (0, 0, 0.1) to (-0.1 .. 0.1, ...): its depth below the floor is exact.
    const std::vector<PairGap> pairs = near_pairs(file.solids(), placed, 0.0);
    ASSERT_EQ(pairs.size(), 1u);
    const Vector centre = placed[1].orientation * Vector(0, 0, 0.1) + placed[1].position;
    EXPECT_LE(pairs[0].gap, centre.z() - 0.3 + rounding);
    std::filesystem::remove(path);
}

} // namespace
