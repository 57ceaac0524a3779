#include "sim/block/contact_block.h"
#include "sim/collide/narrow_phase.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace sim;

namespace {

/// Rounding of one block's solve on velocities of about 1 m/s [m/s].
constexpr double rounding = 1e-13;

/// A cube of side 1 m and mass 1000 kg on a plane, and its blocks.
struct CubeOnPlane {
    Bodies bodies;
    ContactBlocks loop;

    explicit CubeOnPlane(const Velocity& velocity, double mu = 0.0) {
        const Pose pose{Vec3(0.3, -0.2, 0.5), Quat::Identity()};
        add_body(bodies, make_props(Box{}, 1000.0), pose, velocity);
        add_body(bodies, make_props(Plane{}, 0.0), Pose{});
        std::vector<Contact> contacts;
        find_contacts(Box{}, pose, Plane{}, Pose{}, 0.1, contacts);
        std::vector<ContactGeometry> geometry;
        for (const Contact& contact : contacts) {
            geometry.push_back(contact.at);
        }
        loop.append(bodies, 0, 1, geometry, {0.0, mu, mu});
        block().twist_before = tangential_part(relative_twist(block(), bodies.velocity));
    }
    ContactBlock& block() { return loop.blocks.front(); }
    double solve() {
        return solve_block(block(), block_response(block(), loop.points, bodies), loop.points, bodies, bodies.velocity);
    }
    double load() const {
        double sum = 0.0;
        for (const ContactPoint& point : loop.points) {
            sum += point.p_n;
        }
        return sum;
    }
};

/// A point-by-point solve of frictionless targets with eq. 1-3 as they stand, to convergence.
std::vector<Velocity> iterate_points(const Bodies& bodies, const ContactBlock& block,
                                     std::span<const ContactPoint> points) {
    std::vector<Velocity> velocity = bodies.velocity;
    std::vector<double> sum(points.size(), 0.0);
    const auto a = static_cast<std::size_t>(block.a);
    const auto b = static_cast<std::size_t>(block.b);
    const Vec3 n = block.frame.col(2);
    double change = 1.0;
    for (int round = 0; round < 200000 && change > 1e-15; ++round) {
        change = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3 arm = block.frame.col(0) * points[i].x + block.frame.col(1) * points[i].y;
            const Vec3 r_a = block.r_a + arm;
            const Vec3 r_b = block.r_b + arm;
            const double m_a = bodies.props[a].inverse_mass;
            const double m_b = bodies.props[b].inverse_mass;
            const Mat3 k = response(m_a, bodies.inverse_inertia[a], r_a, r_a) +
                           response(m_b, bodies.inverse_inertia[b], r_b, r_b);
            const double u_n = n.dot(velocity[a].at(r_a) - velocity[b].at(r_b));
            const double next = clamped_sum(sum[i], normal_impulse(u_n, points[i].u_n_target, n.dot(k * n)));
            const Vec3 p = (next - sum[i]) * n;
            change = std::max(change, std::abs(next - sum[i]) * m_a);
            sum[i] = next;
            apply_impulse(velocity[a], m_a, bodies.inverse_inertia[a], r_a, p);
            apply_impulse(velocity[b], m_b, bodies.inverse_inertia[b], r_b, -p);
        }
    }
    return velocity;
}

} // namespace

TEST(contact_block, flat_cube_stops_in_one_solve_with_equal_corner_impulses) {
    CubeOnPlane cube({Vec3(0, 0, -1), Vec3::Zero()});
    ASSERT_EQ(cube.loop.blocks.size(), 1u);
    ASSERT_EQ(cube.loop.points.size(), 4u);
    EXPECT_NEAR(cube.solve(), 1.0, rounding);
    EXPECT_LE(cube.bodies.velocity[0].v.norm(), rounding);
    EXPECT_LE(cube.bodies.velocity[0].w.norm(), rounding);
    for (const ContactPoint& point : cube.loop.points) {
        EXPECT_NEAR(point.p_n, 250.0, 1000.0 * rounding); // m u / 4
    }
    EXPECT_EQ(cube.bodies.velocity[1].v, Vec3::Zero());
    EXPECT_LE(cube.solve(), rounding);
}

TEST(contact_block, contacts_push_and_never_pull) {
    CubeOnPlane leaving({Vec3(0, 0, 1), Vec3::Zero()});
    EXPECT_EQ(leaving.solve(), 0.0);
    EXPECT_EQ(leaving.bodies.velocity[0].v, Vec3(0, 0, 1));

    // Rocking about y: two corners approach, two leave, and stay free.
    CubeOnPlane rocking({Vec3::Zero(), Vec3(0, 1, 0)});
    rocking.solve();
    const Vec6 twist = relative_twist(rocking.block(), rocking.bodies.velocity);
    int loaded = 0;
    for (const ContactPoint& point : rocking.loop.points) {
        EXPECT_GE(point.p_n, 0.0);
        EXPECT_GE(normal_velocity(point, twist), -rounding);
        EXPECT_LE(point.p_n * std::abs(normal_velocity(point, twist)), 1000.0 * rounding);
        loaded += point.p_n > 0.0;
    }
    EXPECT_EQ(loaded, 2);
}

TEST(contact_block, impulses_given_too_much_come_down_again) {
    CubeOnPlane cube({Vec3(0, 0, -1), Vec3::Zero()});
    cube.solve();
    for (ContactPoint& point : cube.loop.points) {
        point.u_n_target = -0.5;
    }
    cube.solve();
    EXPECT_NEAR(cube.bodies.velocity[0].v.z(), -0.5, rounding);
    EXPECT_NEAR(cube.load(), 500.0, 1000.0 * rounding);
}

/// The block's closed form against the loop over its points: the velocities are unique, so they agree.
TEST(contact_block, solving_a_block_equals_iterating_its_points) {
    Numbers numbers(1);
    for (int i = 0; i < 50; ++i) {
        const Vec3 v = numbers.vector(1.0);
        CubeOnPlane cube({v, numbers.vector(2.0)});
        for (ContactPoint& point : cube.loop.points) {
            point.u_n_target = 0.3; // one target for the face: a rigid motion reaches it
        }
        const std::vector<Velocity> expected = iterate_points(cube.bodies, cube.block(), cube.loop.points);
        cube.solve();
        EXPECT_LE((cube.bodies.velocity[0].v - expected[0].v).norm(), 1e-11); // the loop's end
        EXPECT_LE((cube.bodies.velocity[0].w - expected[0].w).norm(), 1e-11);
    }
}

TEST(contact_block, friction_stops_a_small_slip) {
    CubeOnPlane cube({Vec3(0.3, -0.2, -1), Vec3::Zero()}, 0.5);
    for (int i = 0; i < 200; ++i) {
        cube.solve();
    }
    const Vec6 twist = relative_twist(cube.block(), cube.bodies.velocity);
    for (const ContactPoint& point : cube.loop.points) {
        EXPECT_LE(tangential_velocity(point, twist).norm(), 1e-10);
        EXPECT_LE(point.p_t.norm(), 0.5 * point.p_n * (1.0 + rounding)); // eq. 6
    }
}

TEST(contact_block, sliding_friction_lies_on_the_cone_against_the_slip) {
    CubeOnPlane cube({Vec3(30, -40, -1), Vec3::Zero()}, 0.5);
    for (int i = 0; i < 2000; ++i) {
        cube.solve();
    }
    const Vec6 twist = relative_twist(cube.block(), cube.bodies.velocity);
    for (const ContactPoint& point : cube.loop.points) {
        const Vec2 u_t = tangential_velocity(point, twist);
        EXPECT_GT(u_t.norm(), 10.0);
        EXPECT_NEAR(point.p_t.norm(), 0.5 * point.p_n, 1e-10 * cube.load());
        EXPECT_NEAR(point.p_t.dot(u_t), -point.p_t.norm() * u_t.norm(), 1e-9 * cube.load() * u_t.norm());
    }
}

TEST(contact_block, without_friction_the_slip_is_kept) {
    CubeOnPlane cube({Vec3(0.3, -0.2, -1), Vec3::Zero()});
    cube.solve();
    EXPECT_LE((cube.bodies.velocity[0].v - Vec3(0.3, -0.2, 0)).norm(), rounding);
    EXPECT_FALSE(cube.block().has_friction());
}

/// Two cubes, the upper falling on the lower.
TEST(contact_block, impulses_are_equal_and_opposite_and_a_held_body_does_not_move) {
    for (const bool hold : {false, true}) {
        Bodies bodies;
        add_body(bodies, make_props(Box{}, 1000.0), {Vec3(0.2, 0.1, 1), Quat::Identity()},
                 {Vec3(0.1, 0, -1), Vec3(0.1, 0.2, 0)});
        add_body(bodies, make_props(Box{}, 500.0), Pose{});
        std::vector<Contact> contacts;
        find_contacts(Box{}, bodies.pose[0], Box{}, bodies.pose[1], 0.1, contacts);
        std::vector<ContactGeometry> geometry;
        for (const Contact& contact : contacts) {
            geometry.push_back(contact.at);
        }
        ContactBlocks loop;
        loop.append(bodies, 0, 1, geometry, {0.0, 0.3, 0.3});
        const Vec3 momentum = 1000.0 * bodies.velocity[0].v;
        std::vector<Velocity> velocity = bodies.velocity;
        for (int i = 0; i < 100; ++i) {
            solve_block(loop.blocks[0], block_response(loop.blocks[0], loop.points, bodies, false, hold), loop.points,
                        bodies, velocity, most_projections, false, hold);
        }
        const Vec6 twist = relative_twist(loop.blocks[0], velocity);
        for (const ContactPoint& point : loop.points) {
            EXPECT_GE(normal_velocity(point, twist), -1e-10);
        }
        if (hold) {
            EXPECT_EQ(velocity[1].v, Vec3::Zero());
            EXPECT_EQ(velocity[1].w, Vec3::Zero());
        } else {
            EXPECT_LE((1000.0 * velocity[0].v + 500.0 * velocity[1].v - momentum).norm(), 1000.0 * rounding);
            EXPECT_GT(velocity[1].v.norm(), 0.1);
        }
    }
}

TEST(contact_block, wrench_of_the_points_is_what_their_impulses_do) {
    CubeOnPlane cube({Vec3(0.3, -0.2, -1), Vec3(0.2, 0.3, 0.5)}, 0.5);
    const Velocity before = cube.bodies.velocity[0];
    for (int i = 0; i < 5; ++i) {
        cube.solve();
    }
    std::vector<Velocity> replayed{before, {}};
    apply_wrench(cube.block(), wrench_of(cube.loop.points), cube.bodies.props, cube.bodies.inverse_inertia,
                 replayed);
    EXPECT_LE((replayed[0].v - cube.bodies.velocity[0].v).norm(), rounding);
    EXPECT_LE((replayed[0].w - cube.bodies.velocity[0].w).norm(), 10.0 * rounding);
}

TEST(contact_block, a_new_block_begins_where_the_normal_changes) {
    Bodies bodies;
    add_body(bodies, make_props(Sphere{0.5}, 1000.0), Pose{});
    add_body(bodies, make_props(Plane{}, 0.0), Pose{});
    std::vector<ContactGeometry> geometry(3);
    geometry[2].n = Vec3::UnitX();
    ContactBlocks loop;
    loop.append(bodies, 0, 1, geometry, {});
    ASSERT_EQ(loop.blocks.size(), 2u);
    EXPECT_EQ(loop.blocks[0].count, 2);
    EXPECT_EQ(loop.blocks[1].first, 2);
    EXPECT_LE((loop.blocks[1].frame.col(2) - Vec3::UnitX()).norm(), rounding);
    EXPECT_NEAR(loop.blocks[0].frame.determinant(), 1.0, rounding);
}

TEST(contact_block, sweep_passes_over_what_has_settled_until_loaded_again) {
    CubeOnPlane cube({Vec3(0, 0, -1), Vec3::Zero()});
    const auto sweep = [&] { return cube.loop.sweep(cube.bodies.velocity, 1e-9, 0.0, most_projections); };
    cube.loop.arrange(cube.bodies);
    cube.loop.load_batches(cube.bodies);
    EXPECT_NEAR(sweep(), 1.0, rounding);
    EXPECT_LE(sweep(), rounding);
    cube.bodies.velocity[0].v.z() = -1.0; // from outside, unseen
    EXPECT_EQ(sweep(), 0.0);
    cube.loop.load_batches(cube.bodies);
    EXPECT_NEAR(sweep(), 1.0, rounding);
}

TEST(contact_block, material_of_a_pair_is_the_geometric_mean_or_the_partners) {
    BodyProps a;
    BodyProps b;
    a.mu_s = 0.4;
    b.mu_s = 0.9;
    a.restitution = 0.5;
    const PairMaterial material = pair_material(a, b);
    EXPECT_NEAR(material.mu_s, 0.6, rounding);
    EXPECT_EQ(material.restitution, 0.5); // only a has one
    EXPECT_EQ(material.mu_d, 0.0);        // none has
    EXPECT_EQ(pair_material(b, a).restitution, 0.5);
}
