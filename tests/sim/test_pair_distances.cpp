#include "sim/collide/narrow_phase.h"
#include "sim/model/polytope.h"
#include "sim/world/pair_distances.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

using namespace sim;

namespace {

constexpr double enough = 1e-3;           // [m]
constexpr double search_rounding = 1e-12; // [m] of two searches for the same depth

/// Two bodies near each other, which move on by a little each step.
struct MovingPair {
    Bodies bodies;
    StepSettings settings{.gravity = Vec3::Zero(), .tolerance = enough};
    Workers workers{1};
    Numbers numbers;

    MovingPair(const Shape& a, const Shape& b, std::uint64_t seed) : numbers(seed) {
        for (const Shape* shape : {&a, &b}) {
            const bool is_plane = std::holds_alternative<Plane>(*shape);
            add_body(bodies, make_props(*shape, is_plane ? 0.0 : 1000.0), {Vec3::Zero(), numbers.orientation()});
        }
        const Vec3 n = std::holds_alternative<Plane>(b) ? Vec3(bodies.pose[1].orientation * Vec3::UnitZ()) : numbers.direction();
        bodies.pose[0].position = 2.0 * n;
        bodies.pose[0].position -= (exact_at(bodies.pose) - 1e-3) * n;
    }

    double exact_at(std::span<const Pose> poses) const {
        return separation({bodies.props[0].shape, poses[0]}, {bodies.props[1].shape, poses[1]});
    }
    std::vector<Pose> moved(double size) {
        std::vector<Pose> to = bodies.pose;
        for (Pose& pose : to) {
            pose.position += numbers.vector(size);
            pose.orientation = turned(pose.orientation, numbers.vector(size));
        }
        if (bodies.props[1].is_static()) {
            to[1] = bodies.pose[1];
        }
        return to;
    }
};

std::vector<Shape> shapes() {
    const std::vector<Vec3> corners{{0.3, 0, 0}, {-0.2, 0.3, 0}, {-0.1, -0.3, 0.1}, {0, 0.1, 0.4}, {0.1, 0, -0.3}};
    return {Box{Vec3(0.3, 0.2, 0.4)}, Sphere{0.25}, Capsule{0.1, 0.2}, Cylinder{0.2, 0.15},
            Hull{std::make_shared<const Polytope>(*convex_hull(corners))}, Plane{}};
}

} // namespace

/// What is known from earlier looks is never too little; of a depth that matters, and where it is asked for, it is the depth.
TEST(pair_distances, depths_are_bounded_and_exact_where_they_matter) {
    int deep = 0;
    int shallow = 0;
    for (const Shape& a : shapes()) {
        for (const Shape& b : shapes()) {
            if (std::holds_alternative<Plane>(a)) {
                continue;
            }
            MovingPair pair(a, b, 7);
            Candidates candidates(pair.bodies, 2, pair.settings, {});
            PairDistances distances(pair.bodies, 2, pair.workers);
            for (int step = 0; step < 60; ++step) {
                candidates.find();
                for (const std::uint32_t near : distances.find_near(candidates)) {
                    std::vector<FoundContact> contacts;
                    find_contacts({a, pair.bodies.pose[0]}, {b, pair.bodies.pose[1]}, enough, contacts);
                    if (!candidates.all()[near].are_boxes) {
                        distances.set_found(candidates.all()[near], contacts);
                    }
                }
                const std::vector<Pose> planned = pair.moved(step % 3 == 0 ? 2e-3 : 1e-5);
                distances.check(candidates, planned, enough, true);
                ASSERT_EQ(candidates.all().size(), 1u);
                const double exact = std::max(-pair.exact_at(planned), 0.0); // apart, any bound will do
                const double bound = distances.penetration(candidates.all()[0], planned, enough);
                EXPECT_GE(std::max(bound, 0.0), exact - search_rounding) << a.index() << " " << b.index() << " step " << step;
                if (bound > 0.0) {
                    (bound > enough ? deep : shallow) += 1;
                    const double asked = bound > enough ? bound : distances.penetration(candidates.all()[0], planned, 0.0);
                    EXPECT_NEAR(std::max(asked, 0.0), exact, search_rounding) << a.index() << " " << b.index() << " step " << step;
                }
                pair.bodies.pose = planned;
            }
        }
    }
    EXPECT_GT(deep, 100);
    EXPECT_GT(shallow, 100);
}
