#include "sim/collide/manifold.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

using namespace sim;

namespace {

/// Rounding of some tens of operations on lengths of about 1 m [m].
constexpr double manifold_rounding = 1e-14;

ContactFeature feature_of(FeatureKind kind) {
    ContactFeature feature;
    feature.kind = kind;
    return feature;
}

/// The same contact with the bodies' names exchanged.
ContactFeature exchanged(ContactFeature feature) {
    std::swap(feature.core_a, feature.core_b);
    std::swap(feature.radius_a, feature.radius_b);
    std::swap(feature.direction_a, feature.direction_b);
    switch (feature.kind) {
    case FeatureKind::face_a:
        feature.kind = FeatureKind::face_b;
        break;
    case FeatureKind::face_b:
        feature.kind = FeatureKind::face_a;
        break;
    case FeatureKind::line_a:
        feature.kind = FeatureKind::line_b;
        break;
    case FeatureKind::line_b:
        feature.kind = FeatureKind::line_a;
        break;
    case FeatureKind::rim_on_face_a:
        feature.kind = FeatureKind::rim_on_face_b;
        break;
    case FeatureKind::rim_on_face_b:
        feature.kind = FeatureKind::rim_on_face_a;
        break;
    case FeatureKind::cores:
    case FeatureKind::edges: // edge_a x edge_b and the direction of n both change sign
        break;
    }
    return feature;
}

void expect_same(const ContactGeometry& x, const ContactGeometry& y) {
    EXPECT_NEAR(x.gap, y.gap, manifold_rounding);
    EXPECT_LE((x.n - y.n).norm(), manifold_rounding);
    EXPECT_LE((x.a - y.a).norm(), manifold_rounding);
}

/// Features of all kinds whose cores, edges and faces are anywhere.
std::vector<ContactFeature> features_of_all_kinds(Numbers& numbers) {
    std::vector<ContactFeature> features;
    for (const FeatureKind kind : {FeatureKind::face_a, FeatureKind::face_b, FeatureKind::cores,
                                   FeatureKind::line_a, FeatureKind::line_b, FeatureKind::edges,
                                   FeatureKind::rim_on_face_a, FeatureKind::rim_on_face_b}) {
        for (const double allowance : {0.0, 1e-3}) {
            ContactFeature feature = feature_of(kind);
            feature.core_a = numbers.vector(0.5);
            feature.core_b = numbers.vector(0.5);
            feature.direction_a = numbers.direction();
            feature.direction_b = numbers.direction();
            feature.radius_a = kind == FeatureKind::edges ? 0.0 : 0.2;
            feature.radius_b = kind == FeatureKind::edges ? 0.0 : 0.1;
            feature.allowance = allowance;
            features.push_back(feature);
        }
    }
    return features;
}

} // namespace

TEST(manifold, ball_above_a_face_of_b_has_the_faces_normal) {
    ContactFeature feature = feature_of(FeatureKind::face_b);
    feature.radius_a = 0.25;
    feature.direction_b = Vec3::UnitZ();
    const ContactGeometry g = contact_geometry(feature, {Vec3(3, 4, 1), Quat::Identity()}, Pose{});
    EXPECT_EQ(g.gap, 0.75);
    EXPECT_EQ(g.n, Vec3(0, 0, 1));
    EXPECT_EQ(g.a, Vec3(3, 4, 0.75));
    EXPECT_EQ(g.b(), Vec3(3, 4, 0));
}

TEST(manifold, point_under_a_face_of_a_penetrates_against_its_normal) {
    ContactFeature feature = feature_of(FeatureKind::face_a);
    feature.direction_a = -Vec3::UnitZ(); // a lies on b
    const ContactGeometry g = contact_geometry(feature, Pose{}, {Vec3(1, 2, 0.125), Quat::Identity()});
    EXPECT_EQ(g.gap, -0.125);
    EXPECT_EQ(g.n, Vec3(0, 0, 1));
    EXPECT_EQ(g.b(), Vec3(1, 2, 0.125));
    EXPECT_EQ(g.a, Vec3(1, 2, 0));
}

TEST(manifold, two_balls_touch_between_their_centres) {
    ContactFeature feature = feature_of(FeatureKind::cores);
    feature.radius_a = 1.0;
    feature.radius_b = 0.5;
    const ContactGeometry g = contact_geometry(feature, {Vec3(0, 3, 0), Quat::Identity()}, Pose{});
    EXPECT_EQ(g.gap, 1.5);
    EXPECT_EQ(g.n, Vec3(0, 1, 0));
    EXPECT_EQ(g.a, Vec3(0, 2, 0));
    EXPECT_EQ(g.b(), Vec3(0, 0.5, 0));
}

TEST(manifold, equal_centres_give_a_unit_normal_and_the_sum_of_the_radii_as_depth) {
    ContactFeature feature = feature_of(FeatureKind::cores);
    feature.radius_a = feature.radius_b = 0.5;
    const ContactGeometry g = contact_geometry(feature, Pose{}, Pose{});
    EXPECT_EQ(g.gap, -1.0);
    EXPECT_EQ(g.n.norm(), 1.0);
}

TEST(manifold, ball_beside_an_edge_is_measured_across_it) {
    ContactFeature feature = feature_of(FeatureKind::line_b);
    feature.radius_a = 1.0;
    feature.direction_b = Vec3::UnitX();
    const ContactGeometry g = contact_geometry(feature, {Vec3(7, 3, 4), Quat::Identity()}, Pose{});
    EXPECT_NEAR(g.gap, 4.0, manifold_rounding); // 3-4-5 triangle
    EXPECT_LE((g.n - Vec3(0, 0.6, 0.8)).norm(), manifold_rounding);
    EXPECT_LE((g.b() - Vec3(7, 0, 0)).norm(), manifold_rounding);
}

TEST(manifold, crossing_edges_touch_at_their_closest_points) {
    ContactFeature feature = feature_of(FeatureKind::edges);
    feature.core_a = Vec3(5, 0, 0);
    feature.core_b = Vec3(0, 7, 0);
    feature.direction_b = Vec3::UnitY();
    for (const double side : {1.0, -1.0}) {
        feature.direction_a = side * Vec3::UnitX();
        const ContactGeometry g = contact_geometry(feature, {Vec3(0, 0, 2), Quat::Identity()}, Pose{});
        EXPECT_EQ(g.gap, 2.0 * side);
        EXPECT_EQ(g.n, Vec3(0, 0, side));
        EXPECT_EQ(g.a, Vec3(0, 0, 2));
        EXPECT_EQ(g.b(), Vec3(0, 0, 0));
    }
}

TEST(manifold, exchanged_bodies_negate_the_normal_and_keep_the_gap_for_every_kind) {
    Numbers numbers(2);
    for (ContactFeature feature : features_of_all_kinds(numbers)) {
        feature.allowance = 0.0; // a's point carries it: no mirror image
        const Pose a = numbers.pose(1.0);
        const Pose b = numbers.pose(1.0);
        const ContactGeometry g = contact_geometry(feature, a, b);
        EXPECT_NEAR(g.n.norm(), 1.0, manifold_rounding);
        const ContactGeometry mirrored = contact_geometry(exchanged(feature), b, a);
        expect_same(mirrored, {g.gap, -g.n, g.b()});
    }
}

TEST(manifold, a_common_rigid_motion_moves_the_geometry_with_it_for_every_kind) {
    Numbers numbers(3);
    for (const ContactFeature& feature : features_of_all_kinds(numbers)) {
        const Pose a = numbers.pose(1.0);
        const Pose b = numbers.pose(1.0);
        const Pose motion = numbers.pose(1.0);
        const ContactGeometry g = contact_geometry(feature, a, b);
        expect_same(contact_geometry(feature, motion * a, motion * b),
                    {g.gap, motion.orientation * g.n, motion * g.a});
    }
}

/// Those of points at faces are not kept: geometry and poses tell them.
TEST(manifold, features_are_told_again_as_they_were_found) {
    Numbers numbers(5);
    const Pose a = numbers.pose(1.0);
    const Pose b = numbers.pose(1.0);
    std::vector<FoundContact> found;
    for (const ContactFeature& feature : features_of_all_kinds(numbers)) {
        FoundContact& contact = found.emplace_back();
        contact.feature = feature;
        contact.feature.id = found.size();
        if (feature.kind == FeatureKind::face_a || feature.kind == FeatureKind::face_b) {
            contact.feature.radius_a = contact.feature.radius_b = contact.feature.allowance = 0.0;
        }
        contact.at = contact_geometry(contact.feature, a, b);
    }
    Manifold manifold;
    manifold.contacts = {found.begin(), found.end()};
    manifold.keep_features(found);
    EXPECT_EQ(manifold.features.size(), found.size() - 4);
    const Pose later_a = numbers.pose(1.0);
    const Pose later_b = numbers.pose(1.0);
    for (std::size_t i = 0; i < found.size(); ++i) {
        const FoundContact again = manifold.found(manifold.contacts[i], a, b);
        EXPECT_EQ(again.feature.id, i + 1);
        EXPECT_TRUE(again.feature.kind == found[i].feature.kind);
        expect_same(contact_geometry(again.feature, later_a, later_b), contact_geometry(found[i].feature, later_a, later_b));
    }
}

TEST(manifold, rim_above_a_face_touches_with_its_lowest_point) {
    ContactFeature feature = feature_of(FeatureKind::rim_on_face_b);
    feature.direction_a = Vec3::UnitZ();
    feature.radius_a = 0.5;
    feature.direction_b = Vec3::UnitZ();
    for (const double tilt : {0.0, 0.1, 1.0, 1.5}) {
        const Pose a{Vec3(1, 2, 3), Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()))};
        const ContactGeometry g = contact_geometry(feature, a, Pose{});
        EXPECT_NEAR(g.gap, 3.0 - 0.5 * std::sin(tilt), manifold_rounding);
        EXPECT_EQ(g.n, Vec3(0, 0, 1));
        if (tilt > 0.0) {
            EXPECT_LE((g.a - (a * Vec3(0.5, 0, 0))).norm(), manifold_rounding);
        }
    }
    EXPECT_TRUE(is_curved(feature));
}
