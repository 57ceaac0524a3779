#include "sim/narrow_phase.h"
#include "sim/polytope.h"
#include "tests/sim/brute_force.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <array>

using namespace sim;

namespace {

constexpr double largest_gap_error = 1e-9;    // [m]
constexpr double largest_normal_error = 1e-6; // [rad]
/// [m] Coordinates of 1 m are rounded to 1e-16, so at a gap of 1e-6 m a direction to 1e-10 and, with an arm of 0.3 m,
/// its gap to less than this.
constexpr double same_gap = 1e-10;

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

/// The lowest contact, its order exchanged, and the separation against brute force. Returns the normal.
Vec3 check_pair(const Shape& shape_a, const Pose& a, const Shape& shape_b, const Pose& b, const std::string& what) {
    SCOPED_TRACE(what);
    const brute::Solid solid_a = solid_of(shape_a, a);
    const brute::Solid solid_b = solid_of(shape_b, b);
    brute::Search expected(solid_a, solid_b);
    for (const bool exchanged : {false, true}) {
        std::vector<Contact> contacts;
        const double margin = std::max(expected.gap, 0.0) + 1e-3;
        double separated = 0.0;
        if (exchanged) {
            find_contacts(shape_b, b, shape_a, a, margin, contacts);
            separated = separation(shape_b, b, shape_a, a);
        } else {
            find_contacts(shape_a, a, shape_b, b, margin, contacts);
            separated = separation(shape_a, a, shape_b, b);
        }
        if (contacts.empty()) {
            ADD_FAILURE() << "no contact, expected a gap of " << expected.gap;
            return Vec3::Zero();
        }
        const Contact* lowest = &contacts[0];
        for (const Contact& contact : contacts) {
            // Of equal gaps the normal with the largest counts: others may repeat it along a face's normal.
            const double side = exchanged ? -1.0 : 1.0;
            const double difference = contact.at.gap - lowest->at.gap;
            const bool is_lower = std::abs(difference) > 1e-12 ? difference < 0.0
                                                               : expected.gap_along(side * contact.at.n) >
                                                                     expected.gap_along(side * lowest->at.n);
            lowest = is_lower ? &contact : lowest;
            EXPECT_LE((contact.at.a - contact.at.b - contact.at.gap * contact.at.n).norm(), 1e-12);
        }
        const Vec3 n = exchanged ? Vec3(-lowest->at.n) : lowest->at.n;
        expected.try_one(n); // any direction's gap is a lower bound, so a better one is right
        EXPECT_NEAR(lowest->at.gap, expected.gap, largest_gap_error) << "exchanged " << exchanged;
        // Two directions may be equally good.
        if (expected.gap_along(n) < expected.gap - same_gap) {
            EXPECT_LE(n.cross(expected.n).norm(), largest_normal_error)
                << "exchanged " << exchanged << " gap " << expected.gap << " along n " << expected.gap_along(n);
            EXPECT_GT(n.dot(expected.n), 0.0);
        }
        if (expected.gap < 1e-4) {
            EXPECT_NEAR(separated, expected.gap, largest_gap_error);
        } else {
            EXPECT_LE(separated, expected.gap + largest_gap_error);
            EXPECT_GT(separated, 0.0);
        }
    }
    return expected.n;
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
