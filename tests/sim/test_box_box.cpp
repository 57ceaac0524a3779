#include "sim/collide/box_box.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>

using namespace sim;

namespace {

/// Rounding of some tens of operations on lengths of about 1 m [m].
constexpr double box_rounding = 1e-14;

PlacedBox at(const Vec3& half_extents, const Pose& pose) {
    return {box_row(Box{half_extents}, pose), pose, Pose{}};
}

PlacedBox cube_at(const Vec3& position, const Quat& orientation = Quat::Identity()) {
    return at(Vec3::Constant(0.5), {position, orientation});
}

std::vector<FoundContact> contacts_of(const PlacedBox& a, const PlacedBox& b, double margin = 0.1) {
    std::vector<FoundContact> contacts;
    box_box_contacts(a, b, box_box_axes(a, b), {margin, 0, contacts});
    return contacts;
}

std::vector<std::uint64_t> ids_of(const std::vector<FoundContact>& contacts) {
    std::vector<std::uint64_t> ids;
    for (const FoundContact& contact : contacts) {
        ids.push_back(contact.feature.id);
    }
    std::ranges::sort(ids);
    return ids;
}

Quat about(const Vec3& axis, double angle) {
    return turned(Quat::Identity(), axis.normalized() * angle);
}

/// Largest separation over directions: of the fifteen axes' own formula, and for comparison of any n the gap
/// between the boxes' shadows on it.
double shadow_gap(const PlacedBox& a, const PlacedBox& b, const Vec3& n) {
    const auto reach = [&](const PlacedBox& box) {
        return (axes_of(box.row).transpose() * n).cwiseAbs().dot(half_of(box.row));
    };
    return std::abs(n.dot(centre_of(a.row) - centre_of(b.row))) - reach(a) - reach(b);
}

/// The corners of the overlap of two boxes' faces in the plane, seen from above.
Vec3 lowest(const std::vector<FoundContact>& contacts) {
    Vec3 lower = contacts.front().at.a;
    for (const FoundContact& contact : contacts) {
        lower = lower.cwiseMin(contact.at.a);
    }
    return lower;
}
Vec3 highest(const std::vector<FoundContact>& contacts) {
    Vec3 upper = contacts.front().at.a;
    for (const FoundContact& contact : contacts) {
        upper = upper.cwiseMax(contact.at.a);
    }
    return upper;
}

} // namespace

TEST(box_box, cube_on_cube_has_its_four_corners_as_contacts) {
    for (const double gap : {0.05, 0.0, -0.05}) {
        const auto contacts = contacts_of(cube_at(Vec3(0, 0, 1.0 + gap)), cube_at(Vec3::Zero()));
        ASSERT_EQ(contacts.size(), 4u);
        for (const FoundContact& contact : contacts) {
            EXPECT_NEAR(contact.at.gap, gap, box_rounding);
            EXPECT_EQ(contact.at.n, Vec3(0, 0, 1)); // from b, below, to a
            EXPECT_NEAR(contact.at.a.z(), 0.5 + gap, box_rounding);
            EXPECT_NEAR(contact.at.b().z(), 0.5, box_rounding);
        }
        EXPECT_LE((lowest(contacts).head<2>() + Vec3::Constant(0.5).head<2>()).norm(), box_rounding);
        EXPECT_LE((highest(contacts).head<2>() - Vec3::Constant(0.5).head<2>()).norm(), box_rounding);
    }
}

TEST(box_box, shifted_faces_touch_in_their_common_rectangle) {
    const auto contacts = contacts_of(cube_at(Vec3(0.75, 0.25, 1.01)), cube_at(Vec3::Zero()));
    ASSERT_EQ(contacts.size(), 4u);
    // [0.25, 0.5] x [-0.25, 0.5]
    EXPECT_LE((lowest(contacts) - Vec3(0.25, -0.25, 0.51)).norm(), 1e-6);
    EXPECT_LE((highest(contacts) - Vec3(0.5, 0.5, 0.51)).norm(), 1e-6);
}

TEST(box_box, face_turned_by_45_degrees_touches_in_an_octagon) {
    const auto contacts = contacts_of(cube_at(Vec3(0, 0, 1.0), about(Vec3::UnitZ(), std::numbers::pi / 4)),
                                      cube_at(Vec3::Zero()));
    ASSERT_EQ(contacts.size(), 8u);
    // |x| + |y| = sqrt(1/2) meets |x| = 1/2; corners count as inside up to 1e-6 of the half width.
    const double cut = std::sqrt(0.5) - 0.5;
    for (const FoundContact& contact : contacts) {
        const Vec3 x = contact.at.a.cwiseAbs();
        EXPECT_NEAR(std::max(x.x(), x.y()), 0.5, 1e-6);
        EXPECT_NEAR(std::min(x.x(), x.y()), cut, 1e-6);
    }
}

TEST(box_box, crossing_edges_touch_in_one_point) {
    // Each cube stands on an edge of the other: a's lower edge along x, b's upper edge along y.
    const double half_diagonal = std::sqrt(0.5);
    const double gap = 0.01;
    const auto a =
        cube_at(Vec3(0.1, -0.2, 2.0 * half_diagonal + gap), about(Vec3::UnitX(), std::numbers::pi / 4));
    const auto b = cube_at(Vec3::Zero(), about(Vec3::UnitY(), std::numbers::pi / 4));
    const auto contacts = contacts_of(a, b);
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_EQ(contacts[0].feature.kind, FeatureKind::edges);
    EXPECT_NEAR(contacts[0].at.gap, gap, box_rounding);
    EXPECT_LE((contacts[0].at.n - Vec3(0, 0, 1)).norm(), box_rounding);
    EXPECT_LE((contacts[0].at.a - Vec3(0, -0.2, half_diagonal + gap)).norm(), box_rounding);
    EXPECT_LE((contacts[0].at.b() - Vec3(0, -0.2, half_diagonal)).norm(), box_rounding);
}

TEST(box_box, cubes_that_lean_against_each_other_as_mirror_images_push_along_the_mirrors_normal) {
    for (const double tilt : {1e-4, 0.02, 0.3}) {
        const double half_width = 0.5 * (std::cos(tilt) + std::sin(tilt)); // of a tilted cube, to its upper edge
        const PlacedBox left = cube_at({-half_width - 5e-4, 0, 0}, about(Vec3::UnitY(), tilt));
        const PlacedBox right = cube_at({half_width + 5e-4, 0, 0}, about(Vec3::UnitY(), -tilt));
        const std::vector<FoundContact> contacts = contacts_of(left, right, 2e-3);
        ASSERT_GE(contacts.size(), 2u) << tilt;
        double least = 1.0;
        for (const FoundContact& contact : contacts) {
            EXPECT_LE((contact.at.n + Vec3::UnitX()).norm(), box_rounding) << tilt;
            least = std::min(least, contact.at.gap);
        }
        // The points lie inside both faces as seen along a's normal: up to tan^2 of the gap from the edges, or
        // 5e-7 m beyond them, where corners that stick out so little count as inside.
        const double tan_squared = std::tan(tilt) * std::tan(tilt);
        EXPECT_LE(least, 1e-3 / (1 - tan_squared) + box_rounding) << tilt;
        EXPECT_GE(least, 1e-3 - 5e-7) << tilt;
    }
}

TEST(box_box, corner_over_a_face_touches_there) {
    // A cube on its corner: the diagonal is vertical.
    const Quat on_corner = rotation_between(Vec3(1, 1, 1), Vec3::UnitZ());
    const auto contacts = contacts_of(cube_at(Vec3(0.1, 0.2, 0.5 + std::sqrt(0.75) + 0.001), on_corner),
                                      cube_at(Vec3::Zero()), 0.01);
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_NEAR(contacts[0].at.gap, 0.001, box_rounding);
    EXPECT_LE((contacts[0].at.b() - Vec3(0.1, 0.2, 0.5)).norm(), box_rounding);
}

TEST(box_box, contacts_beyond_the_margin_are_left_out) {
    const auto below = cube_at(Vec3::Zero());
    EXPECT_EQ(contacts_of(cube_at(Vec3(0, 0, 1.009)), below, 0.01).size(), 4u);
    EXPECT_TRUE(contacts_of(cube_at(Vec3(0, 0, 1.011)), below, 0.01).empty());
    // Tilted by 0.02 rad about y: two corners within, two 0.02 m higher.
    const auto tilted = cube_at(Vec3(0, 0, 1.012), about(Vec3::UnitY(), 0.02));
    EXPECT_EQ(contacts_of(tilted, below, 0.01).size(), 2u);
}

TEST(box_box, exchanged_boxes_negate_the_normals_and_keep_the_gaps) {
    Numbers numbers(1);
    int touching = 0;
    for (int i = 0; i < 2000; ++i) {
        const PlacedBox a = at(Vec3(0.5, 0.3, 0.2), numbers.pose(0.6));
        const PlacedBox b = at(Vec3(0.2, 0.4, 0.6), numbers.pose(0.6));
        const auto forward = contacts_of(a, b);
        auto backward = contacts_of(b, a);
        ASSERT_EQ(forward.size(), backward.size());
        for (const FoundContact& contact : forward) {
            // Its partner: the nearest one; the crossing of edges is the only one of its kind.
            const bool is_edges = contact.feature.kind == FeatureKind::edges;
            const auto nearest = std::ranges::min_element(backward, {}, [&](const FoundContact& other) {
                const double other_kind = (other.feature.kind == FeatureKind::edges) == is_edges ? 0.0 : 10.0;
                return (other.at.b() - contact.at.a).norm() + (other.at.a - contact.at.b()).norm() + other_kind;
            });
            EXPECT_NEAR(nearest->at.gap, contact.at.gap, 1e-12); // 1 / sin^2 of the edges' angle is below 100
            EXPECT_LE((nearest->at.n + contact.at.n).norm(), 1e-12);
            ++touching;
        }
    }
    EXPECT_GT(touching, 1000);
}

TEST(box_box, geometry_of_the_feature_is_that_of_the_contact) {
    Numbers numbers(2);
    for (int i = 0; i < 2000; ++i) {
        const PlacedBox a = at(Vec3(0.5, 0.3, 0.2), numbers.pose(0.6));
        const PlacedBox b = at(Vec3(0.2, 0.4, 0.6), numbers.pose(0.6));
        for (const FoundContact& contact : contacts_of(a, b)) {
            const ContactGeometry g = contact_geometry(contact.feature, a.world_from_body, b.world_from_body);
            EXPECT_NEAR(g.gap, contact.at.gap, 1e-12);
            // Crossing edges that leave the faces nearly parallel take the face's normal: it is off theirs by
            // an angle whose cosine is at least 0.998, the chord below.
            const double chord =
                contact.feature.kind == FeatureKind::edges ? std::sqrt(2.0 * (1.0 - 0.998)) : 0.0;
            EXPECT_LE((contact.at.n - g.n).norm(), 1e-12 + chord);
        }
    }
}

TEST(box_box, aligned_boxes_keep_their_features_through_tiny_motions) {
    const auto below = cube_at(Vec3::Zero());
    const auto ids = ids_of(contacts_of(cube_at(Vec3(0, 0, 1)), below));
    ASSERT_EQ(ids.size(), 4u);
    EXPECT_EQ(std::ranges::adjacent_find(ids), ids.end()) << "ids are not unique";
    Numbers numbers(3);
    for (int i = 0; i < 200; ++i) {
        // 1e-8 m and rad: well below the 1e-7 by which a face is preferred and 1e-6 for clipping.
        const Pose moved{Vec3(0, 0, 1) + numbers.vector(1e-8), about(numbers.direction(), 1e-8)};
        EXPECT_EQ(ids_of(contacts_of(at(Vec3::Constant(0.5), moved), below)), ids);
    }
}

TEST(box_box, ids_are_unique_within_a_manifold) {
    Numbers numbers(4);
    for (int i = 0; i < 2000; ++i) {
        const PlacedBox a = at(Vec3(0.5, 0.3, 0.2), numbers.pose(0.5));
        const auto ids = ids_of(contacts_of(a, at(Vec3(0.2, 0.4, 0.6), numbers.pose(0.5))));
        EXPECT_EQ(std::ranges::adjacent_find(ids), ids.end());
    }
}

/// No direction separates the boxes more than the fifteen axes when they overlap (separating axis theorem),
/// and the normal of the contacts attains that separation.
TEST(box_box, separation_of_overlapping_boxes_is_the_least_depth_over_all_directions) {
    Numbers numbers(5);
    int overlapping = 0;
    for (int i = 0; i < 300; ++i) {
        const PlacedBox a = at(Vec3(0.5, 0.3, 0.2), numbers.pose(0.4));
        const PlacedBox b = at(Vec3(0.2, 0.4, 0.6), numbers.pose(0.4));
        const double s = box_box_axes(a, b).separation();
        if (s >= 0.0) {
            continue;
        }
        ++overlapping;
        for (int k = 0; k < 200; ++k) {
            EXPECT_LE(shadow_gap(a, b, numbers.direction()), s + box_rounding);
        }
        const auto contacts = contacts_of(a, b);
        ASSERT_FALSE(contacts.empty());
        // The feature's own normal attains it; a face is preferred by 1e-7 of 0.6 m.
        const ContactGeometry last =
            contact_geometry(contacts.back().feature, a.world_from_body, b.world_from_body);
        EXPECT_NEAR(shadow_gap(a, b, last.n), s, 1e-7);
        double deepest = 0.0;
        for (const FoundContact& contact : contacts) {
            deepest = std::min(deepest, contact.at.gap);
        }
        EXPECT_NEAR(deepest, s, 1e-7);
    }
    EXPECT_GT(overlapping, 100);
}

TEST(box_box, id_base_and_body_frames_of_parts_are_kept) {
    // The same cube as a part that sits 2 m along x in its body, which is turned.
    const Quat turn = about(Vec3::UnitZ(), 0.3);
    PlacedBox a = cube_at(Vec3(0, 0, 1.01));
    a.body_from_box = {Vec3(2, 0, 0), turn};
    a.world_from_body = {Vec3(0, 0, 1.01) - turn.conjugate() * Vec3(2, 0, 0), turn.conjugate()};
    const PlacedBox b = cube_at(Vec3::Zero());
    std::vector<FoundContact> contacts;
    const std::uint64_t id_base = std::uint64_t{5} << 32;
    box_box_contacts(a, b, box_box_axes(a, b), {0.1, id_base, contacts});
    ASSERT_EQ(contacts.size(), 4u);
    for (const FoundContact& contact : contacts) {
        EXPECT_EQ(contact.feature.id >> 32, 5u);
        EXPECT_NEAR(contact_geometry(contact.feature, a.world_from_body, b.world_from_body).gap, 0.01,
                    box_rounding);
    }
}

namespace {

/// What is left of a polygon on the side of a plane where n.x <= limit (Sutherland and Hodgman 1974).
std::vector<Vec3> cut(const std::vector<Vec3>& polygon, const Vec3& n, double limit) {
    std::vector<Vec3> left;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3& p = polygon[i];
        const Vec3& q = polygon[(i + 1) % polygon.size()];
        const double from = n.dot(p) - limit;
        const double to = n.dot(q) - limit;
        if (from <= 0.0) {
            left.push_back(p);
        }
        if (from * to < 0.0) {
            left.push_back(p + (q - p) * (from / (from - to)));
        }
    }
    return left;
}

/// Corners of the bottom face of a box over the top face of the other, both seen along z, in its frame.
std::vector<Vec3> common_corners(const PlacedBox& above, const PlacedBox& below) {
    const Vec3 half = half_of(above.row);
    std::vector<Vec3> polygon;
    for (const auto& [u, v] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
        polygon.push_back(above.world_from_body * Vec3(u * half.x(), v * half.y(), -half.z()));
    }
    for (const Vec3& n : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)}) {
        polygon = cut(polygon, n, half_of(below.row).dot(n.cwiseAbs()) * (1.0 + 1e-6));
    }
    return polygon;
}

} // namespace

/// Faces that tilt a little, turn by any angle, exactly by quarters too, and lie anywhere over each other.
TEST(box_box, faces_touch_where_one_polygon_cut_by_the_other_has_its_corners) {
    Numbers numbers(7);
    const PlacedBox below = at(Vec3(0.5, 0.3, 0.2), Pose{});
    std::array<int, 9> counts{};
    for (int i = 0; i < 20000; ++i) {
        const double angle = i % 5 == 0 ? 0.5 * std::numbers::pi * (i % 4) : 10.0 * numbers.vector(1.0).x();
        const Vec3 shift = i % 7 == 0 ? Vec3(Vec3::Zero()) : numbers.vector(0.8);
        const Quat tilt = i % 3 == 0 ? Quat::Identity() : about(numbers.direction(), 1e-3);
        const PlacedBox above = at(Vec3(0.4, 0.45, 0.1), {Vec3(shift.x(), shift.y(), 0.3), tilt * about(Vec3::UnitZ(), angle)});
        const BoxAxes axes = box_box_axes(below, above);
        if (axes.face_a().index != 2 || axes.face_a().separation != axes.separation()) {
            continue;
        }
        const auto contacts = contacts_of(below, above);
        const std::vector<Vec3> corners = common_corners(above, below);
        EXPECT_EQ(contacts.size(), corners.size());
        ++counts.at(contacts.size());
        for (const FoundContact& contact : contacts) {
            const Vec3 on_above = contact.at.b();
            const auto distance = [&](const Vec3& corner) { return (corner - on_above).norm(); };
            EXPECT_LT(distance(std::ranges::min(corners, {}, distance)), 1e-13);
            EXPECT_NEAR(contact.at.gap, on_above.z() - 0.2, 1e-14);
            const ContactGeometry at = contact_geometry(contact.feature, below.world_from_body, above.world_from_body);
            EXPECT_LT((at.b() - on_above).norm(), 1e-13);
        }
    }
    for (const std::size_t corners : {3u, 4u, 5u, 6u, 7u, 8u}) {
        EXPECT_GT(counts[corners], 10) << corners;
    }
}

TEST(box_box, axes_of_many_pairs_are_those_of_each) {
    Numbers numbers(5);
    std::vector<PlacedBox> boxes;
    std::vector<PlacedBoxRow> rows;
    for (int i = 0; i < 43; ++i) {
        const Pose pose = i % 4 == 0 ? Pose{numbers.vector(1.0), Quat::Identity()} : numbers.pose(1.0);
        boxes.push_back(at(Vec3(0.4, 0.5, 0.6), pose));
        rows.push_back(boxes.back().row);
    }
    for (int first = 1; first < 43; first += lane_count) { // of the last eight pairs two
        AxesSearch search{.boxes = rows.data(), .count = std::min(lane_count, 43 - first)};
        std::array<BoxAxes, lane_count> found;
        for (int lane = 0; lane < search.count; ++lane) {
            search.a[lane] = first + lane;
            search.b[lane] = (first + lane) / 2;
            search.axes[lane] = &found[static_cast<std::size_t>(lane)];
        }
        find_axes(search);
        for (int lane = 0; lane < search.count; ++lane) {
            const auto a = static_cast<std::size_t>(search.a[lane]);
            const BoxAxes expected = box_box_axes(boxes[a], boxes[a / 2]);
            for (int kind = 0; kind < 3; ++kind) {
                const AxisChoice choice = search.axes[lane]->of_kind(kind);
                EXPECT_EQ(choice.separation, expected.of_kind(kind).separation);
                EXPECT_EQ(choice.index, expected.of_kind(kind).index);
                EXPECT_EQ(choice.side, expected.of_kind(kind).side);
            }
        }
    }
}
