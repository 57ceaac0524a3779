#include "sim/base/file_io.h"
#include "sim/collide/narrow_phase.h"
#include "sim/model/polytope.h"
#include "tests/sim/brute_force.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <numbers>
#include <utility>

using namespace sim;

namespace {

struct Limits {
    double gap = 1e-9;    ///< [m]
    double normal = 1e-6; ///< [rad]
};
/// Of two boxes, edges within 1e-5 rad of parallel take a face's normal, and of two faces that are nearly parallel either
/// gives the normal, so that it stays the same from step to step: box_box.cpp. Where parallel edges overlap by 1e-4 m,
/// the points on a face are 0.3 of that less deep than the edges are between the faces.
constexpr Limits two_boxes{.gap = 3e-5, .normal = 2.0};
/// [m] Coordinates of 1 m are rounded to 1e-16, so at a gap of 1e-6 m a direction to 1e-10 and, with an arm of 0.3 m,
/// its gap to less than this; and of edges and a face that are as near to the largest gap the face is taken: separating_direction.h.
constexpr double equal_gap = 1e-9;

Shape random_hull(std::uint64_t seed, int count) {
    Numbers numbers(seed);
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        points.push_back(numbers.direction().cwiseProduct(Vec3(0.3, 0.25, 0.2)));
    }
    return Hull{std::make_shared<const Polytope>(*convex_hull(points))};
}

Shape prism(int sides) {
    std::vector<Vec3> points;
    for (int i = 0; i < sides; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / sides;
        for (const double z : {-0.15, 0.15}) {
            points.emplace_back(0.25 * std::cos(angle), 0.25 * std::sin(angle), z);
        }
    }
    return Hull{std::make_shared<const Polytope>(*convex_hull(points))};
}

brute::Solid solid_of(const Box& box, const Pose& pose) {
    brute::Solid solid;
    for (int i = 0; i < 8; ++i) {
        const Vec3 sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
        solid.vertices.push_back(pose * sign.cwiseProduct(box.half_extents));
    }
    return solid;
}
brute::Solid solid_of(const Sphere& sphere, const Pose& pose) {
    return {{pose.position}, {}, sphere.radius};
}
brute::Solid solid_of(const Capsule& capsule, const Pose& pose) {
    const Vec3 tip(0, 0, capsule.half_length);
    return {{pose * tip, pose * Vec3(-tip)}, {}, capsule.radius};
}
brute::Solid solid_of(const Cylinder& cylinder, const Pose& pose) {
    brute::Solid solid;
    for (const double end : {1.0, -1.0}) {
        solid.rims.push_back({pose * Vec3(0, 0, end * cylinder.half_length), pose.orientation * Vec3::UnitZ(),
                              pose.orientation * Vec3::UnitX(), cylinder.radius});
    }
    return solid;
}
brute::Solid solid_of(const Hull& hull, const Pose& pose) {
    brute::Solid solid;
    for (const Vec3& vertex : hull.polytope->vertices) {
        solid.vertices.push_back(pose * vertex);
    }
    return solid;
}
brute::Solid solid_of(const Plane&, const Pose&) {
    return {};
}
brute::Solid solid_of(const Compound&, const Pose&) {
    return {};
}
brute::Solid solid_of(const Shape& shape, const Pose& pose) {
    return std::visit([&](const auto& s) { return solid_of(s, pose); }, shape);
}

/// What one pair of kinds has shown, for the table.
struct Row {
    Limits limits;
    int cases = 0;
    double gap_error = 0.0;    ///< [m]
    double normal_error = 0.0; ///< [rad]
};

/// What is found a little before: a is elsewhere by a millimetre, and turned by a hundredth.
std::vector<Contact> contacts_before(const PlacedShape& a, const PlacedShape& b, double margin) {
    const Pose moved{a.pose.position + Vec3(4e-4, -5e-4, 7e-4), turned(a.pose.orientation, Vec3(6e-3, 7e-3, -4e-3))};
    std::vector<FoundContact> found;
    find_contacts({a.shape, moved}, b, margin + 0.01, found);
    return {found.begin(), found.end()};
}

/// The lowest contact, its order exchanged, found anew and near where it was, and the separation against brute force.
void check_pair(const Shape& shape_a, const Pose& a, const Shape& shape_b, const Pose& b, const std::string& what, Row* row = nullptr) {
    const Limits limits = row != nullptr ? row->limits : Limits{};
    SCOPED_TRACE(what);
    const brute::Solid solid_a = solid_of(shape_a, a);
    const brute::Solid solid_b = solid_of(shape_b, b);
    brute::Search expected(solid_a, solid_b);
    for (const unsigned way : {0u, 1u, 2u, 3u}) {
        const bool exchanged = (way & 1u) != 0;
        const bool is_known = (way & 2u) != 0;
        const PlacedShape first = exchanged ? PlacedShape{shape_b, b} : PlacedShape{shape_a, a};
        const PlacedShape second = exchanged ? PlacedShape{shape_a, a} : PlacedShape{shape_b, b};
        std::vector<FoundContact> contacts;
        const double margin = std::max(expected.gap, 0.0) + 1e-3;
        find_contacts(first, second, margin, contacts, is_known ? contacts_before(first, second, margin) : std::vector<Contact>());
        const double separated = separation(first, second);
        if (contacts.empty()) {
            ADD_FAILURE() << "no contact, expected a gap of " << expected.gap << (is_known ? ", near where it was" : "");
            return;
        }
        const FoundContact* lowest = &contacts[0];
        for (const FoundContact& contact : contacts) {
            // Of equal gaps the normal with the largest counts: others may repeat it along a face's normal.
            const double side = exchanged ? -1.0 : 1.0;
            const double difference = contact.at.gap - lowest->at.gap;
            const bool is_lower = std::abs(difference) > 1e-12 ? difference < 0.0
                                                               : expected.gap_along(side * contact.at.n) >
                                                                     expected.gap_along(side * lowest->at.n);
            lowest = is_lower ? &contact : lowest;
        }
        const Vec3 n = exchanged ? Vec3(-lowest->at.n) : lowest->at.n;
        expected.try_one(n); // any direction's gap is a lower bound, so a better one is right
        EXPECT_NEAR(lowest->at.gap, expected.gap, limits.gap) << "exchanged " << exchanged;
        // Two directions may be equally good.
        if (expected.gap_along(n) < expected.gap - equal_gap) {
            EXPECT_LE(n.cross(expected.n).norm(), limits.normal)
                << "exchanged " << exchanged << " gap " << expected.gap << " along n " << expected.gap_along(n);
            EXPECT_GT(n.dot(expected.n), 0.0);
        }
        if (row != nullptr) {
            ++row->cases;
            row->gap_error = std::max(row->gap_error, std::abs(lowest->at.gap - expected.gap));
            if (expected.gap_along(n) < expected.gap - equal_gap) {
                row->normal_error = std::max(row->normal_error, n.cross(expected.n).norm());
            }
        }
        if (expected.gap < 1e-4) {
            EXPECT_NEAR(separated, expected.gap, limits.gap);
        } else {
            EXPECT_LE(separated, expected.gap + limits.gap);
            EXPECT_GT(separated, 0.0);
        }
    }
}

struct Named {
    std::string name;
    Shape shape;
};

std::vector<Named> all_shapes() {
    return {{"sphere", Sphere{0.2}},      {"box", Box{Vec3(0.3, 0.2, 0.15)}}, {"capsule", Capsule{0.1, 0.25}},
            {"cylinder", Cylinder{0.2, 0.15}}, {"hull", random_hull(3, 10)},     {"prism", prism(6)}};
}

bool is_new(const Shape& shape) {
    return !std::holds_alternative<Sphere>(shape) && !std::holds_alternative<Box>(shape);
}

/// Moves a along the direction of the gap until it is about `gap` [m].
Pose at_gap(const Shape& shape_a, Pose a, const Shape& shape_b, const Pose& b, double gap) {
    for (int i = 0; i < 3; ++i) {
        const brute::Solid solid_a = solid_of(shape_a, a);
        const brute::Solid solid_b = solid_of(shape_b, b);
        const brute::Search found(solid_a, solid_b);
        a.position += (gap - found.gap) * found.n;
    }
    return a;
}

constexpr std::array gaps{-0.02, -1e-4, 0.0, 1e-6, 0.05};

} // namespace

TEST(convex_pair, random_poses_agree_with_brute_force) {
    Numbers numbers(11);
    for (const Named& a : all_shapes()) {
        for (const Named& b : all_shapes()) {
            if (!is_new(a.shape) && !is_new(b.shape)) {
                continue;
            }
            for (int i = 0; i < 6; ++i) {
                const Pose pose_b = numbers.pose(1.0);
                Pose pose_a = numbers.pose(0.6);
                pose_a.position += pose_b.position;
                const double gap = gaps[static_cast<std::size_t>(i) % gaps.size()];
                pose_a = at_gap(a.shape, pose_a, b.shape, pose_b, gap);
                check_pair(a.shape, pose_a, b.shape, pose_b,
                           a.name + " " + b.name + " " + std::to_string(i) + " gap " + std::to_string(gap));
            }
        }
    }
}

/// Where the normals of the faces at an edge are far from each other, a rim faces away from one of them.
TEST(convex_pair, sharp_edges_on_rims_agree_with_brute_force) {
    Numbers numbers(5);
    for (int i = 0; i < 200; ++i) {
        const Shape hull = random_hull(static_cast<std::uint64_t>(i), 4);
        const Pose pose_b = numbers.pose(1.0);
        Pose pose_a = numbers.pose(0.6);
        pose_a.position += pose_b.position;
        pose_a = at_gap(Cylinder{0.2, 0.15}, pose_a, hull, pose_b, gaps[static_cast<std::size_t>(i) % gaps.size()]);
        check_pair(Cylinder{0.2, 0.15}, pose_a, hull, pose_b, "cylinder tetrahedron " + std::to_string(i));
    }
}

/// Upon each other, leaning by little to much, one beside the other by up to its radius: two rims cross, or one lies over the
/// other's end.
TEST(convex_pair, rims_of_leaning_cylinders_agree_with_brute_force) {
    Numbers numbers(7);
    const Cylinder can{0.033, 0.0575};
    for (int i = 0; i < 60; ++i) {
        const Pose pose_b = numbers.pose(1.0);
        const double lean = std::pow(10.0, numbers.between(-4.0, -0.5));
        const Vec3 beside(numbers.between(-0.03, 0.03), numbers.between(-0.03, 0.03), 0.13);
        Pose pose_a = pose_b * Pose{beside, turned(Quat::Identity(), lean * numbers.direction())};
        pose_a = at_gap(can, pose_a, can, pose_b, std::array{5e-5, 3e-3}[static_cast<std::size_t>(i) % 2]);
        check_pair(can, pose_a, can, pose_b, "cylinders " + std::to_string(i) + " lean " + std::to_string(lean));
    }
}

TEST(convex_pair, aligned_poses_agree_with_brute_force) {
    // Turns by multiples of 45 degrees about the axes, exactly and off by little; offsets that put faces, edges and
    // corners opposite each other.
    constexpr double quarter = 0.5 * std::numbers::pi;
    for (const Named& a : all_shapes()) {
        for (const Named& b : all_shapes()) {
            if (!is_new(a.shape) && !is_new(b.shape)) {
                continue;
            }
            int k = 0;
            for (const Vec3& turn : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0.5, 0), Vec3(0.5, 0, 0.5)}) {
                for (const Vec3& offset : {Vec3(0.01, 0.02, 0.6), Vec3(0.0, 0.0, 0.6), Vec3(0.25, 0.25, 0.5),
                                           Vec3(0.6, 0.0, 0.05)}) {
                    const double tilt = std::array{0.0, 1e-9, 1e-5, 1e-2}[static_cast<std::size_t>(k) % 4];
                    const double gap = gaps[static_cast<std::size_t>(k / 4) % gaps.size()];
                    k += 3;
                    Pose pose_a{offset, turned(turned(Quat::Identity(), turn * quarter), Vec3(tilt, 0.7 * tilt, 0))};
                    pose_a = at_gap(a.shape, pose_a, b.shape, Pose{}, gap);
                    check_pair(a.shape, pose_a, b.shape, Pose{},
                               a.name + " " + b.name + " case " + std::to_string(k) + " tilt " +
                                   std::to_string(tilt) + " gap " + std::to_string(gap));
                }
            }
        }
    }
}

namespace {

/// Directions, in the body's frame, in which each kind of feature of a shape lies outermost: faces, edges, corners, ends,
/// sides, rims.
std::vector<Vec3> feature_directions(const Shape& shape) {
    std::vector<Vec3> result;
    if (std::holds_alternative<Sphere>(shape)) {
        return {Vec3(0.36, 0.48, 0.8)};
    }
    if (std::holds_alternative<Capsule>(shape)) { // tip, side, between
        return {Vec3::UnitZ(), Vec3::UnitX(), Vec3(0.6, 0, 0.8)};
    }
    if (std::holds_alternative<Cylinder>(shape)) { // end, side, rim
        return {Vec3::UnitZ(), Vec3(0.6, 0.8, 0), Vec3(0.6, 0, 0.8), Vec3(0, 0.8, -0.6)};
    }
    if (std::holds_alternative<Box>(shape)) { // faces, edges, corner
        return {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), Vec3(1, 1, 0).normalized(), Vec3(0, 1, 1).normalized(),
                Vec3(1, 0, -1).normalized(), Vec3(1, 1, 1).normalized()};
    }
    // A hull: normals of faces through its vertices, means of two of them (edges), of three or more (corners).
    const Polytope& hull = *std::get<Hull>(shape).polytope;
    std::vector<Vec3> normals;
    for (const auto& face : hull.faces) {
        normals.push_back(face.normal);
    }
    for (std::size_t i = 0; i < normals.size() && i < 2; ++i) {
        result.push_back(normals[i]);
        double nearest = -1.0;
        Vec3 edge = normals[i];
        for (const Vec3& n : normals) {
            const double cosine = n.dot(normals[i]);
            if (cosine < 1.0 - 1e-9 && cosine > nearest) {
                nearest = cosine;
                edge = (n + normals[i]).normalized();
            }
        }
        result.push_back(edge);
    }
    for (std::size_t i = 0; i < hull.vertices.size() && i < 2; ++i) {
        result.push_back(hull.vertices[i].normalized());
    }
    return result;
}

/// Turns `from`, a unit vector of the body, to `to`, then about `to` by an angle.
Quat turned_to(const Vec3& from, const Vec3& to, double angle) {
    return Quat(Eigen::AngleAxisd(angle, to)) * rotation_between(from, to);
}

} // namespace

// Each kind of feature of one shape against each of the other, at several angles between them, aligned exactly and nearly,
// in both orders. The table of errors goes to out/test/pairs.md.
TEST(convex_pair, every_feature_against_every_feature_agrees_with_brute_force) {
    std::string table = "| pair | cases | largest error of the gap [m] | of the normal [rad] |\n| --- | --- | --- | --- |\n";
    const std::vector<Named> shapes = all_shapes();
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            const Named& a = shapes[i];
            const Named& b = shapes[j];
            const bool are_boxes = a.name == "box" && b.name == "box";
            Row row{.limits = are_boxes ? two_boxes : Limits{}};
            int k = 0;
            for (const Vec3& u : feature_directions(a.shape)) {
                for (const Vec3& v : feature_directions(b.shape)) {
                    for (const double angle : {0.0, 0.3}) {
                        ++k;
                        const double tilt = std::array{0.0, 1e-9, 1e-5, 1e-2}[static_cast<std::size_t>(k) % 4];
                        const double gap = gaps[static_cast<std::size_t>(k / 4) % gaps.size()];
                        if (are_boxes && gap > 1e-3) {
                            continue; // theirs is the gap between planes, a lower bound where corners face each other
                        }
                        const Pose pose_b{Vec3::Zero(), turned_to(v, Vec3::UnitZ(), 0.0)};
                        const Quat facing = turned_to(u, -Vec3::UnitZ(), angle);
                        Pose pose_a{Vec3(0, 0, 0.8), turned(facing, Vec3(tilt, 0.7 * tilt, 0))};
                        pose_a = at_gap(a.shape, pose_a, b.shape, pose_b, gap);
                        check_pair(a.shape, pose_a, b.shape, pose_b, a.name + " " + b.name + " case " + std::to_string(k), &row);
                    }
                }
            }
            std::array<char, 120> line{};
            std::snprintf(line.data(), line.size(), "| %s, %s | %d | %.1e | %.1e |\n", a.name.c_str(), b.name.c_str(), row.cases,
                          row.gap_error, row.normal_error);
            table += line.data();
        }
    }
    const std::filesystem::path folder = std::filesystem::path(TUMBLE_OUT_DIR) / "test";
    std::filesystem::create_directories(folder);
    write_file(folder / "pairs.md", table);
}

namespace {

/// How far a point of the world lies outside a body's surface [m], to first order near it; negative inside.
double outside(const Shape& shape, const Pose& pose, const Vec3& point) {
    const Vec3 x = pose.orientation.conjugate() * (point - pose.position);
    const double around = std::hypot(x.x(), x.y());
    const double along = std::abs(x.z());
    if (const auto* sphere = std::get_if<Sphere>(&shape)) {
        return x.norm() - sphere->radius;
    }
    if (const auto* capsule = std::get_if<Capsule>(&shape)) {
        return std::hypot(around, std::max(along - capsule->half_length, 0.0)) - capsule->radius;
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
        return std::max(around - cylinder->radius, along - cylinder->half_length);
    }
    if (const auto* box = std::get_if<Box>(&shape)) {
        return (x.cwiseAbs() - box->half_extents).maxCoeff();
    }
    const Polytope& hull = *std::get<Hull>(shape).polytope;
    double most = -std::numeric_limits<double>::infinity();
    for (const Polytope::Face& face : hull.faces) {
        most = std::max(most, face.normal.dot(x - hull.vertices[static_cast<std::size_t>(face.loop[0])]));
    }
    return most;
}

} // namespace

// What touches the side of a cylinder touches its rims along the same direction, too, which are elsewhere.
TEST(convex_pair, contacts_of_bodies_that_overlap_a_little_lie_on_both_surfaces) {
    Numbers numbers(17);
    for (const Named& a : all_shapes()) {
        for (const Named& b : all_shapes()) {
            for (int i = 0; i < 40; ++i) {
                const double depth = std::pow(10.0, numbers.between(-9.0, -4.0));
                Pose pose_a = numbers.pose(0.0);
                const Pose pose_b = numbers.pose(0.0);
                const Vec3 apart = numbers.direction();
                double from = 0.0;
                double to = 1.0;
                for (int round = 0; round < 50; ++round) {
                    const double middle = 0.5 * (from + to);
                    pose_a.position = middle * apart;
                    (separation({a.shape, pose_a}, {b.shape, pose_b}) > -depth ? to : from) = middle;
                }
                std::vector<FoundContact> contacts;
                find_contacts({a.shape, pose_a}, {b.shape, pose_b}, 0.0, contacts);
                ASSERT_FALSE(contacts.empty()) << a.name << " " << b.name << " " << i;
                for (const FoundContact& contact : contacts) {
                    EXPECT_NEAR(outside(a.shape, pose_a, contact.at.a), 0.0, 1e-3) << a.name << " on " << b.name << " " << i;
                    EXPECT_NEAR(outside(b.shape, pose_b, contact.at.b()), 0.0, 1e-3) << b.name << " under " << a.name << " " << i;
                }
            }
        }
    }
}

// Which end of a line is the lowest changes with the least turn; where one end alone were held, what rests on it would rock.
TEST(convex_pair, what_lies_along_a_line_touches_at_both_ends_of_it_however_little_it_turns) {
    const Quat lying(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()));
    const Quat on_edge(Eigen::AngleAxisd(0.25 * std::numbers::pi, Vec3::UnitY()));
    Numbers numbers(23);
    for (const double length : {0.4, 1.0, 1.6}) {
        const double end = 0.5 * std::min(length, 1.0);
        const Named rounds[] = {{"cylinder", Cylinder{0.1, 0.5}}, {"capsule", Capsule{0.1, 0.5}}};
        const std::pair<Named, Pose> supports[] = {
            {{"board", Box{Vec3(0.3, 0.5 * length, 0.1)}}, {Vec3(0, 0, -0.1), Quat::Identity()}},
            {{"edge", Box{Vec3(0.1, 0.5 * length, 0.1)}}, {Vec3(0, 0, -0.1 * std::numbers::sqrt2), on_edge}},
            {{"cylinder", Cylinder{0.1, 0.5 * length}}, {Vec3(0, 0, -0.1), lying}},
            {{"capsule", Capsule{0.1, 0.5 * length}}, {Vec3(0, 0, -0.1), lying}}};
        for (const Named& above : rounds) {
            for (const auto& [below, pose] : supports) {
                for (int i = 0; i < 60; ++i) {
                    const Pose world = numbers.pose(1.0);
                    const Vec3 turn = std::pow(10.0, numbers.between(-16.0, -5.5)) * numbers.direction();
                    const Pose turned{Vec3(0, 0, 0.1), Quat(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * lying};
                    std::vector<FoundContact> contacts;
                    find_contacts({above.shape, world * turned}, {below.shape, world * pose}, 1e-3, contacts);
                    const auto is_at = [&](double y) {
                        const auto is_near = [&](const FoundContact& contact) {
                            const Vec3 x = world.orientation.conjugate() * (contact.at.a - world.position);
                            return std::abs(x.y() - y) < 1e-4;
                        };
                        return std::ranges::any_of(contacts, is_near);
                    };
                    EXPECT_TRUE(is_at(end) && is_at(-end)) << above.name << " on " << below.name << " " << length << " " << i;
                }
            }
        }
    }
}

// Faces of more corners than a block holds, at rest: where another corner were kept, or edges taken for a face, as rounding or the
// least turn has it, the load would move from corner to corner in every step, and a stack of coins climb.
TEST(convex_pair, what_lies_flat_keeps_its_corners_however_little_it_turns) {
    const Named above[] = {{"cylinder", Cylinder{0.25, 0.15}}, {"prism", prism(12)}, {"box", Box{Vec3(0.2, 0.22, 0.15)}}};
    const Named below[] = {{"cylinder", Cylinder{0.3, 0.15}}, {"prism", prism(11)}, {"like cylinder", Cylinder{0.25, 0.15}}};
    Numbers numbers(29);
    for (const Named& upper : above) {
        for (const Named& lower : below) {
            for (int i = 0; i < 20; ++i) {
                const Pose world = numbers.pose(1.0);
                const Vec3 aside = 0.1 * (i % 2) * numbers.direction().cwiseProduct(Vec3(1, 1, 0));
                const Quat turned(Eigen::AngleAxisd(numbers.between(0.0, 3.0), Vec3::UnitZ()));
                std::vector<FoundContact> at_first;
                for (int k = 0; k < 10; ++k) {
                    const double scale = k == 0 ? 0.0 : std::pow(10.0, numbers.between(-16.0, -9.5));
                    const Vec3 turn = scale * numbers.direction();
                    const Quat turned_more = Quat(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized())) * turned;
                    const Pose pose{aside + Vec3(0, 0, 0.15) + scale * numbers.direction(), turned_more};
                    std::vector<FoundContact> contacts;
                    find_contacts({upper.shape, world * pose}, {lower.shape, world * Pose{Vec3(0, 0, -0.15), Quat::Identity()}}, 1e-4,
                                  contacts);
                    at_first = k == 0 ? contacts : at_first;
                    const auto was_there = [&](const FoundContact& contact) {
                        return std::ranges::any_of(at_first, [&](const FoundContact& c) { return (c.at.a - contact.at.a).norm() < 1e-5; });
                    };
                    EXPECT_TRUE(contacts.size() == at_first.size() && std::ranges::all_of(contacts, was_there))
                        << upper.name << " on " << lower.name << ' ' << i << " turned by " << scale;
                }
            }
        }
    }
}

// It leaves upwards or sideways, whichever is less; that it lies flat but for the least turn is no proof of either.
TEST(convex_pair, what_hangs_on_by_a_strip_is_as_deep_as_the_strip_is_wide) {
    constexpr double height = 0.3; // [m], of prism(8)
    const double width = 0.5 * std::cos(std::numbers::pi / 8); // between two sides of it
    const Quat to_side(Eigen::AngleAxisd(std::numbers::pi / 8, Vec3::UnitZ()));
    const Shape shape = prism(8);
    Numbers numbers(31);
    for (int i = 0; i < 400; ++i) {
        const Pose world = numbers.pose(0.0);
        const double strip = std::pow(10.0, numbers.between(-9.0, -2.0));
        const double depth = std::pow(10.0, numbers.between(-9.0, -2.0));
        const Vec3 turn = std::pow(10.0, numbers.between(-12.0, -7.0)) * numbers.direction();
        const Quat turned(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
        const Pose upper{Vec3(width - strip, 0, height - depth), turned * to_side};
        const double gap = separation({shape, world * upper}, {shape, world * Pose{Vec3::Zero(), to_side}});
        EXPECT_NEAR(gap, -std::min(strip, depth), 1e-6) << i << ": " << strip << " m wide, " << depth << " m deep";
    }
}

// It leaves by the side or by the end. A polytope that grew to its size would have a million corners.
TEST(convex_pair, a_grain_inside_the_rim_of_a_cylinder_is_as_deep_as_it_is) {
    const Cylinder cylinder{0.15, 0.125};
    Numbers numbers(23);
    for (const double radius : {1e-3, 1e-6, 1e-9}) {
        for (int i = 0; i < 100; ++i) {
            const Pose pose = numbers.pose(0.0);
            const double angle = numbers.between(0.0, 6.0);
            const double below_side = radius * numbers.between(0.1, 1.0);
            const double below_end = radius * numbers.between(0.1, 1.0);
            const double around = cylinder.radius - below_side;
            const Vec3 at = pose * Vec3(around * std::cos(angle), around * std::sin(angle), cylinder.half_length - below_end);
            const double gap = separation({Sphere{radius}, {at, Quat::Identity()}}, {cylinder, pose});
            EXPECT_NEAR(gap, -radius - std::min(below_side, below_end), 1e-15) << radius;
        }
    }
}

// The nearest corner of the prism lies at the far end of an edge of the corner where the search begins.
TEST(convex_pair, a_corner_at_the_far_end_of_an_edge_is_found) {
    const Pose prism_pose{Vec3(-0.01052613049131049, 0.0038209875767794455, 0.55818045466963462),
                          Quat(0.91179658245425332, 0.38246354404238647, -0.053298873558557662, -0.13967054013166325)};
    const Pose capsule_pose{Vec3::Zero(), turned_to(Vec3(0.6, 0.0, 0.8), Vec3::UnitZ(), 0.0)};
    check_pair(prism(6), prism_pose, Capsule{0.1, 0.25}, capsule_pose, "prism capsule");
}

/// Of the edge that leads there the nearest point lies beyond its end, and the end itself is no better than the corner before.
TEST(convex_pair, a_corner_behind_a_ridge_is_found) {
    const std::array corners{Vec3(0.065, -0.13, -0.145), Vec3(0.06, -0.14, -0.22),  Vec3(0.075, -0.115, -0.44),
                             Vec3(0.03, -0.06, -0.19),   Vec3(0.125, 0.13, -0.38), Vec3(-0.03, 0.125, -0.335)};
    const Shape splinter = Hull{std::make_shared<const Polytope>(*convex_hull(corners))};
    check_pair(splinter, Pose{}, Capsule{0.085, 0.13}, Pose{}, "splinter capsule");
}

// A body lies on the base of a bowl, far from its middle: from there it is beside the base, and the way out of it
// downwards, through the base, is a local maximum of the gap.
TEST(convex_pair, what_lies_on_a_wide_plate_is_found_on_its_near_side) {
    std::vector<Vec3> corners;
    for (int i = 0; i < 8; ++i) {
        const double angle = std::numbers::pi / 4 * (i + 0.5);
        const Vec3 outwards(std::cos(angle), std::sin(angle), 0.0);
        corners.push_back(1.42 * outwards);
        corners.push_back(1.3 * outwards + Vec3(0, 0, 0.12));
    }
    const Shape plate = Hull{std::make_shared<const Polytope>(*convex_hull(corners))};
    const auto check = [&](const Shape& shape, const Pose& pose, const std::string& name) {
        std::vector<FoundContact> contacts;
        find_contacts({plate, Pose{}}, {shape, pose}, 1e-3, contacts);
        ASSERT_FALSE(contacts.empty()) << name;
        EXPECT_NEAR(contacts[0].at.n.z(), -1.0, 1e-12) << name;
        EXPECT_NEAR(separation({plate, Pose{}}, {shape, pose}), bounds(shape, pose).lower.z() - 0.12, 1e-12) << name;
    };
    const Shape box = Box{Vec3(0.13, 0.13, 0.13)};
    check(box, {Vec3(-0.22807574082154350, 0.14427400765577444, 0.304201316498732),
                Quat(0.020513131982242964, 0.96707624393791203, -0.030343578682479437, -0.25183728290298812)},
          "a box that was taken for one below the plate");
    Numbers numbers(5);
    for (const Shape& shape : {Shape(Capsule{0.09, 0.11}), box}) {
        for (int k = 0; k < 400; ++k) {
            const double r = 0.3 + 0.001 * ((7919 * k) % 700);
            Pose pose = numbers.pose(0.0);
            pose.position = Vec3(r * std::cos(2.4 * k), r * std::sin(2.4 * k), 0.1203 - bounds(shape, pose).lower.z());
            check(shape, pose, "case " + std::to_string(k));
        }
    }
}
