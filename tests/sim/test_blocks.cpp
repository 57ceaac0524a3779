// One visit of a block, judged against the equations of its points as they stand in the paper; and how blocks share bodies.
#include "sim/block/blocks.h"
#include "sim/collide/narrow_phase.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

using namespace sim;

namespace {

/// Rounding of one block's solve on velocities of about 1 m/s [m/s].
constexpr double block_rounding = 1e-13;

/// Two bodies, their contacts, and the blocks of these.
struct Pair {
    Bodies bodies;
    std::vector<Contact> contacts;
    Blocks loop;

    void arrange(double margin, double mu) {
        std::vector<FoundContact> found;
        find_contacts({bodies.props[0].shape, bodies.pose[0]}, {bodies.props[1].shape, bodies.pose[1]}, margin, found);
        contacts = {found.begin(), found.end()};
        arrange(mu);
    }
    /// The contacts that are there.
    void arrange(double mu) {
        for (const Contact& contact : contacts) {
            loop.contacts.push_back(&contact);
        }
        Block like;
        like.a = 0;
        like.b = 1;
        like.mu_s = like.mu_d = mu;
        loop.add(0, like);
        loop.arrange(bodies, 0, bodies.velocity);
    }
    /// One visit of all blocks; returns the largest change of a velocity [m/s].
    double sweep() {
        loop.wake();
        return loop.sweep(bodies.velocity, -1.0, 0.0);
    }
    LaneFrame frame(std::size_t block = 0) { return {loop.batch_of(loop.blocks[block]), Blocks::lane_of(loop.blocks[block])}; }
    std::vector<LanePoint> points(std::size_t block = 0) {
        const Block& of = loop.blocks[block];
        std::vector<LanePoint> points;
        for (const BatchPoint& point : loop.points_of(loop.batch_of(of)).first(static_cast<std::size_t>(of.count))) {
            points.emplace_back(point, Blocks::lane_of(of));
        }
        return points;
    }
    void set_target(double u_n) {
        for (std::size_t i = 0; i < loop.blocks.size(); ++i) {
            const Block& of = loop.blocks[i];
            for (BatchPoint& point : loop.points_of(loop.batch_of(of)).first(static_cast<std::size_t>(of.count))) {
                point.u_n_target.x[Blocks::lane_of(of)] = u_n;
            }
        }
    }
    double load() {
        double sum = 0.0;
        for (const LanePoint& point : points()) {
            sum += point.p_n;
        }
        return sum;
    }
};

/// A cube of side 1 m and mass 1000 kg on a plane.
struct CubeOnPlane : Pair {
    explicit CubeOnPlane(const Velocity& velocity, double mu = 0.0) {
        add_body(bodies, make_props(Box{}, 1000.0), {Vec3(0.3, -0.2, 0.5), Quat::Identity()}, velocity);
        add_body(bodies, make_props(Plane{}, 0.0), Pose{});
        arrange(0.1, mu);
    }
};

/// K_xy of a body (sec. 3.1) [1/kg].
Mat3 response(double inverse_mass, const Mat3& inverse_inertia, const Vec3& r_x, const Vec3& r_y) {
    return inverse_mass * Mat3::Identity() - cross_matrix(r_x) * inverse_inertia * cross_matrix(r_y);
}

/// A point-by-point solve of frictionless targets with eq. 1-3 as they stand, to convergence.
std::vector<Velocity> iterate_points(const Pair& pair, const LaneFrame& block, const std::vector<LanePoint>& points,
                                     double u_n_target) {
    const Bodies& bodies = pair.bodies;
    std::vector<Velocity> velocity = bodies.velocity;
    std::vector<double> sum(points.size(), 0.0);
    const Vec3 n = block.frame.col(2);
    double change = 1.0;
    for (int round = 0; round < 200000 && change > 1e-15; ++round) {
        change = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3 arm = block.frame.col(0) * points[i].x + block.frame.col(1) * points[i].y;
            const Vec3 r[2] = {block.r_a + arm, block.r_b + arm};
            Mat3 k = Mat3::Zero();
            for (const std::size_t body : {0, 1}) {
                k += response(bodies.props[body].inverse_mass, bodies.inverse_inertia[body], r[body], r[body]);
            }
            const double u_n = n.dot(velocity[0].at(r[0]) - velocity[1].at(r[1]));
            const double next = std::max(sum[i] + (u_n_target - u_n) / n.dot(k * n), 0.0); // eq. 1, then 2 and 3
            const Vec3 p = (next - sum[i]) * n;
            change = std::max(change, std::abs(next - sum[i]) * bodies.props[0].inverse_mass);
            sum[i] = next;
            for (const std::size_t body : {0, 1}) {
                const double sign = body == 0 ? 1.0 : -1.0;
                velocity[body].v += sign * bodies.props[body].inverse_mass * p;
                velocity[body].w += sign * bodies.inverse_inertia[body] * r[body].cross(p);
            }
        }
    }
    return velocity;
}

} // namespace

TEST(blocks, flat_cube_stops_in_one_visit_with_equal_corner_impulses) {
    CubeOnPlane cube({Vec3(0, 0, -1), Vec3::Zero()});
    ASSERT_EQ(cube.loop.blocks.size(), 1u);
    ASSERT_EQ(cube.loop.blocks[0].count, 4);
    EXPECT_NEAR(cube.sweep(), 1.0, block_rounding);
    EXPECT_LE(cube.bodies.velocity[0].v.norm(), block_rounding);
    EXPECT_LE(cube.bodies.velocity[0].w.norm(), block_rounding);
    for (const LanePoint& point : cube.points()) {
        EXPECT_NEAR(point.p_n, 250.0, 1000.0 * block_rounding); // m u / 4
    }
    EXPECT_EQ(cube.bodies.velocity[1].v, Vec3::Zero());
    EXPECT_LE(cube.sweep(), block_rounding);
}

TEST(blocks, contacts_push_and_never_pull) {
    CubeOnPlane leaving({Vec3(0, 0, 1), Vec3::Zero()});
    EXPECT_EQ(leaving.sweep(), 0.0);
    EXPECT_EQ(leaving.bodies.velocity[0].v, Vec3(0, 0, 1));

    // Rocking about y: two corners approach, two leave, and stay free.
    CubeOnPlane rocking({Vec3::Zero(), Vec3(0, 1, 0)});
    rocking.sweep();
    const Vec6 twist = rocking.frame().relative_twist(rocking.bodies.velocity);
    int loaded = 0;
    for (const LanePoint& point : rocking.points()) {
        EXPECT_GE(point.p_n, 0.0);
        EXPECT_GE(point.normal_velocity(twist), -block_rounding);
        EXPECT_LE(point.p_n * std::abs(point.normal_velocity(twist)), 1000.0 * block_rounding);
        loaded += point.p_n > 0.0;
    }
    EXPECT_EQ(loaded, 2);
}

TEST(blocks, impulses_given_too_much_come_down_again) {
    CubeOnPlane cube({Vec3(0, 0, -1), Vec3::Zero()});
    cube.sweep();
    cube.set_target(-0.5);
    cube.sweep();
    EXPECT_NEAR(cube.bodies.velocity[0].v.z(), -0.5, block_rounding);
    EXPECT_NEAR(cube.load(), 500.0, 1000.0 * block_rounding);
}

/// A corner of a face and the crossing of edges there may ask for different velocities. The mean of both, which is the least error,
/// leaves one of them overlapping however short the step is.
TEST(blocks, of_two_points_at_one_place_the_one_that_asks_for_more_is_met) {
    for (const bool has_fourth : {true, false}) {
        CubeOnPlane cube({Vec3(0, 0, -1), Vec3::Zero()});
        const Block& block = cube.loop.blocks[0];
        const std::size_t lane = Blocks::lane_of(block);
        const std::span<BatchPoint> points = cube.loop.points_of(cube.loop.batch_of(block));
        points[1].x.x[lane] = points[0].x.x[lane];
        points[1].y.x[lane] = points[0].y.x[lane];
        cube.set_target(-100.0);
        points[0].u_n_target.x[lane] = 0.0;
        points[1].u_n_target.x[lane] = 0.25;
        if (!has_fourth) { // a block of three in a batch with room for four
            points[3].there &= ~(1u << lane);
            points[3].u_n_target.x[lane] = no_point;
        }
        cube.sweep();
        const Vec6 twist = cube.frame().relative_twist(cube.bodies.velocity);
        EXPECT_NEAR(cube.points()[0].normal_velocity(twist), 0.25, block_rounding) << has_fourth;
        EXPECT_EQ(cube.points()[0].p_n, 0.0) << has_fourth;
        EXPECT_GT(cube.points()[1].p_n, 0.0) << has_fourth;
    }
}

/// The block's closed form against the loop over its points: the velocities are unique, so they agree. Boxes face to face,
/// on an edge and on a corner; several visits, since a block has one normal each.
TEST(blocks, a_visit_equals_iterating_its_points) {
    Numbers numbers(1);
    int compared = 0;
    for (int i = 0; i < 200; ++i) {
        Pair pair;
        const double tilt = i % 2 == 0 ? 0.0 : 0.3;
        const double spin = numbers.between(-1.0, 1.0);
        const Quat turn =
            Quat(1.0, tilt * numbers.between(-1.0, 1.0), tilt * numbers.between(-1.0, 1.0), spin).normalized();
        add_body(pair.bodies, make_props(Box{}, 700.0), {Vec3(0, 0.2, 0.9), turn},
                 {numbers.vector(1.0) - Vec3(0, 0, 1), numbers.vector(2.0)});
        add_body(pair.bodies, make_props(Box{Vec3(0.6, 0.7, 0.5)}, 1000.0), Pose{});
        pair.arrange(0.3, 0.0);
        if (pair.loop.blocks.size() != 1) {
            continue;
        }
        pair.set_target(0.3); // one target for the face: a rigid motion reaches it
        const std::vector<Velocity> expected = iterate_points(pair, pair.frame(), pair.points(), 0.3);
        pair.sweep();
        for (const std::size_t body : {0, 1}) {
            EXPECT_LE((pair.bodies.velocity[body].v - expected[body].v).norm(), 1e-10) << i; // the loop's end
            EXPECT_LE((pair.bodies.velocity[body].w - expected[body].w).norm(), 1e-10) << i;
        }
        ++compared;
    }
    EXPECT_GT(compared, 100);
}

TEST(blocks, friction_stops_a_small_slip) {
    CubeOnPlane cube({Vec3(0.3, -0.2, -1), Vec3::Zero()}, 0.5);
    for (int i = 0; i < 200; ++i) {
        cube.sweep();
    }
    const Vec6 twist = cube.frame().relative_twist(cube.bodies.velocity);
    for (const LanePoint& point : cube.points()) {
        EXPECT_LE(point.tangential_velocity(twist).norm(), 1e-10);
        EXPECT_LE(point.p_t.norm(), 0.5 * point.p_n * (1.0 + block_rounding)); // the cone
    }
}

TEST(blocks, sliding_friction_lies_on_the_cone_against_the_slip) {
    CubeOnPlane cube({Vec3(30, -40, -1), Vec3::Zero()}, 0.5);
    for (int i = 0; i < 2000; ++i) {
        cube.sweep();
    }
    const Vec6 twist = cube.frame().relative_twist(cube.bodies.velocity);
    for (const LanePoint& point : cube.points()) {
        const Vec2 u_t = point.tangential_velocity(twist);
        EXPECT_GT(u_t.norm(), 10.0);
        EXPECT_NEAR(point.p_t.norm(), 0.5 * point.p_n, 1e-10 * cube.load()); // eq. 4
        EXPECT_NEAR(point.p_t.dot(u_t), -point.p_t.norm() * u_t.norm(), 1e-9 * cube.load() * u_t.norm());
    }
}

/// Load that moves from one point to another, all of it or a part, takes its friction with it; else two points a hair apart that
/// take turns keep a heap in motion for ever.
TEST(blocks, load_that_moves_to_another_point_keeps_its_friction) {
    for (const double moved : {1.0, 0.5}) {
        CubeOnPlane cube({Vec3(1.05, 0.0, -1.0), Vec3::Zero()}, 0.4); // friction nearly stops it
        const Vec3 middle(0.3, -0.2, 0.0);
        for (Contact& contact : cube.contacts) {
            contact.at.a = middle + 1e-4 * (contact.at.a - middle);
        }
        cube.loop.fill_batch(0, cube.bodies, cube.bodies.velocity);
        for (int visit = 0; visit < 200; ++visit) {
            for (BatchPoint& point : cube.loop.points) {
                point.u_n_target.x[0] = point.y.x[0] > 0.0 ? 1e-3 : -1e-3; // two of the four points carry the load
            }
            cube.sweep();
        }
        const double load = cube.load();
        const Vec6 twist = cube.frame().relative_twist(cube.bodies.velocity);
        for (BatchPoint& point : cube.loop.points) {
            const bool has_carried = point.p_n.x[0] > 0.0;
            point.u_n_target.x[0] = LanePoint(point, 0).normal_velocity(twist);
            point.p_n.x[0] = 0.5 * load * (has_carried ? 1.0 - moved : moved);
        }
        cube.sweep();
        Vec2 friction = Vec2::Zero();
        for (const LanePoint& point : cube.points()) {
            friction += point.p_t;
        }
        EXPECT_GT(friction.norm(), 0.85 * 0.4 * cube.load()) << moved; // it slides; without, half of what has moved is lost
        EXPECT_LT(friction.norm(), 0.4 * cube.load() * (1.0 + 1e-6));
    }
}

/// Three points of the end of a cylinder that turns, and on whose rim another body presses: the normal impulses ask for another
/// friction, and that for other normal impulses.
TEST(blocks, normal_impulses_and_friction_that_take_turns_come_to_an_end) {
    Pair pair;
    add_body(pair.bodies, make_props(Plane{}, 0.0), Pose{});
    add_body(pair.bodies, make_props(Cylinder{0.15, 0.125}, 1000.0), {Vec3(0, 0, 0.1255), Quat::Identity()});
    for (const Vec3& place : {Vec3(0.1124, 0.0987, 0), Vec3(0.1395, 0.0541, 0), Vec3(0.06, 0.137, 0)}) {
        Contact& contact = pair.contacts.emplace_back();
        contact.at.n = -Vec3::UnitZ();
        contact.at.a = place;
    }
    pair.arrange(0.4);
    BlockBatch& batch = pair.loop.batch_of(pair.loop.blocks[0]);
    const std::size_t lane = Blocks::lane_of(pair.loop.blocks[0]);
    batch.node_weight.x[lane] = 0.0;
    batch.before[0].x[lane] = 0.148;
    batch.before[1].x[lane] = 0.206;
    batch.before[2].x[lane] = -1.6;
    const std::span<BatchPoint> points = pair.loop.points_of(batch);
    for (std::size_t k = 0; k < 3; ++k) {
        points[k].u_n_target.x[lane] = 4.9e-3;
        points[k].p_n.x[lane] = std::array{4.79, 6.8, 6.13}[k];
        points[k].p_t[0].x[lane] = std::array{-0.215, -0.29, -0.612}[k];
        points[k].p_t[1].x[lane] = std::array{-1.16, -2.7, -2.37}[k];
    }
    pair.bodies.velocity[1] = {Vec3(0.1846, 0.2076, -0.0011), Vec3(0.072, -0.5976, -1.913)};
    pair.loop.wake();
    double change = 0.0;
    for (int i = 0; i < 200; ++i) {
        change = pair.loop.sweep(pair.bodies.velocity, 1e-9, 0.05, 1e-3);
    }
    EXPECT_LE(change, 1e-8); // 0.1 m/s in every sweep where visits that take turns are not taken by half
}

/// A rod of 1 m that leans by an angle [rad], slips and hits the ground `arm` [m] from its centre: what the last of so many sweeps
/// changes [m/s].
double change_of_rod(int sweeps, double angle, double arm, double slip) {
    Pair pair;
    const Quat turn(Eigen::AngleAxisd(angle, Vec3::UnitY()));
    const Vec3 end = turn * Vec3(0, 0, -arm);
    add_body(pair.bodies, make_props(Box{Vec3(0.01, 0.01, 0.5)}, 1000.0), {-end, turn}, {Vec3(slip, 0, -1), Vec3::Zero()});
    add_body(pair.bodies, make_props(Plane{}, 0.0), Pose{});
    Contact& contact = pair.contacts.emplace_back();
    contact.at.n = Vec3::UnitZ();
    pair.arrange(2.0);
    pair.loop.wake();
    double change = 0.0;
    for (int i = 0; i < sweeps; ++i) {
        change = pair.loop.sweep(pair.bodies.velocity, 1e-9, 1e-7);
    }
    return change;
}

/// Friction beyond a load lifts its end, and then there is no load. Extrapolated without end, the two take turns for ever, also
/// where visits are taken by half.
TEST(blocks, a_rod_whose_friction_lifts_it_comes_to_an_end) {
    for (const double slip : {-5.0, 5.0}) {
        EXPECT_LE(change_of_rod(400, 0.25 * std::numbers::pi, 0.5, slip), 1e-8) << slip; // 3 m/s in every sweep where they do
    }
}

/// With light arms, which reach beyond it, friction lifts it five times as fast as its load does.
TEST(blocks, one_contact_whose_friction_lifts_it_by_more_than_its_load_does_is_solved) {
    EXPECT_LE(change_of_rod(40, std::asin(0.2), 1.5, 5.0), 1e-8); // 0.1 m/s where all of what a visit finds is taken
}

TEST(blocks, without_friction_the_slip_is_kept) {
    CubeOnPlane cube({Vec3(0.3, -0.2, -1), Vec3::Zero()});
    cube.sweep();
    EXPECT_LE((cube.bodies.velocity[0].v - Vec3(0.3, -0.2, 0)).norm(), block_rounding);
}

TEST(blocks, impulses_are_equal_and_opposite_and_a_dropped_block_gives_them_back) {
    Pair pair;
    add_body(pair.bodies, make_props(Box{}, 1000.0), {Vec3(0.2, 0.1, 1), Quat::Identity()},
             {Vec3(0.1, 0, -1), Vec3(0.1, 0.2, 0)});
    add_body(pair.bodies, make_props(Box{}, 500.0), Pose{});
    const std::vector<Velocity> before = pair.bodies.velocity;
    pair.arrange(0.1, 0.3);
    for (int i = 0; i < 100; ++i) {
        pair.sweep();
    }
    const std::vector<Velocity>& velocity = pair.bodies.velocity;
    EXPECT_LE((1000.0 * velocity[0].v + 500.0 * velocity[1].v - 1000.0 * before[0].v).norm(), 1000.0 * block_rounding);
    EXPECT_GT(velocity[1].v.norm(), 0.1);
    pair.loop.drop(pair.loop.blocks[0], pair.bodies, pair.bodies.velocity);
    for (const std::size_t body : {0, 1}) {
        EXPECT_LE((velocity[body].v - before[body].v).norm(), 10.0 * block_rounding);
        EXPECT_LE((velocity[body].w - before[body].w).norm(), 100.0 * block_rounding);
    }
    EXPECT_EQ(pair.sweep(), 0.0); // nothing is left to solve
}

TEST(blocks, a_new_block_begins_where_the_normal_changes) {
    std::vector<Contact> contacts(3);
    contacts[2].at.n = Vec3::UnitX();
    EXPECT_EQ(block_count(contacts), 2u);
    Pair pair;
    add_body(pair.bodies, make_props(Sphere{0.5}, 1000.0), Pose{});
    add_body(pair.bodies, make_props(Plane{}, 0.0), Pose{});
    for (int i = 0; i < 3; ++i) {
        pair.loop.contacts.push_back(&contacts[static_cast<std::size_t>(i)]);
    }
    Block like;
    like.a = 0;
    like.b = 1;
    pair.loop.add(0, like);
    pair.loop.arrange(pair.bodies, 0, pair.bodies.velocity);
    EXPECT_EQ(pair.loop.blocks[0].count, 2);
    EXPECT_EQ(pair.loop.blocks[1].first, 2);
    EXPECT_LE((pair.frame(1).frame.col(2) - Vec3::UnitX()).norm(), block_rounding);
    EXPECT_NEAR(pair.frame(0).frame.determinant(), 1.0, block_rounding);
}

TEST(blocks, sweep_passes_over_what_has_settled_until_loaded_again) {
    CubeOnPlane cube({Vec3(0, 0, -1), Vec3::Zero()});
    const auto sweep = [&] { return cube.loop.sweep(cube.bodies.velocity, 1e-9, 0.0); };
    cube.loop.wake();
    EXPECT_NEAR(sweep(), 1.0, block_rounding);
    EXPECT_LE(sweep(), block_rounding);
    cube.bodies.velocity[0].v.z() -= 1e-10; // from outside
    EXPECT_EQ(sweep(), 0.0);
    cube.loop.wake();
    EXPECT_NEAR(sweep(), 1e-10, block_rounding);
    cube.bodies.velocity[0].v.z() = -1.0;
    EXPECT_NEAR(sweep(), 1.0, block_rounding);
}

/// A splinter that a stone presses to the floor, along which it slides: half of what a visit finds of friction at its limit is less than
/// the limit, and would seem to stick.
TEST(blocks, newtons_method_holds_no_friction_that_slides) {
    Bodies bodies;
    add_body(bodies, make_props(Plane{}, 0.0), Pose{});
    add_body(bodies, make_props(Sphere{}, 1.0), {Vec3(0.094, 0.029, 0.059), Quat::Identity()},
             {Vec3(-0.58, -0.02, 0.83), Vec3(-1.35, -9.98, -0.55)});
    bodies.props[1].inverse_mass = 0.348;
    bodies.inverse_inertia[1] << 206, 49, 0, 49, 63, 0, 0, 0, 48;
    add_body(bodies, make_props(Sphere{}, 1.0), {Vec3(0.016, -0.024, 0.321), Quat::Identity()},
             {Vec3(-0.96, -1.92, -3.37), Vec3(-29.8, 28.4, 2.28)});
    bodies.props[2].inverse_mass = 0.0206;
    bodies.inverse_inertia[2] = 0.95 * Mat3::Identity();
    std::vector<Contact> contacts(2);
    contacts[0].at.n = -Vec3::UnitZ();
    contacts[1].at.n = Vec3(0.0856, 0.271, -0.959).normalized();
    contacts[1].at.a = Vec3(-0.005, -0.016, 0.113);
    Blocks loop;
    for (const int i : {0, 1}) {
        loop.contacts.push_back(&contacts[static_cast<std::size_t>(i)]);
        Block& block = loop.blocks.emplace_back();
        block = {.a = i, .b = i + 1, .first = i, .count = 1, .mu_s = 0.23, .mu_d = 0.23};
    }
    loop.arrange(bodies, 0, bodies.velocity);
    for (const Block& block : loop.blocks) {
        loop.points_of(loop.batch_of(block))[0].u_n_target.x[Blocks::lane_of(block)] = 0.0;
    }
    loop.wake(10000);
    double change = 1.0;
    while (loop.sweeps() < 300 && change > 1e-6) {
        change = loop.sweep(bodies.velocity, 1e-9, 1e-7);
    }
    EXPECT_LE(change, 1e-6); // 0.04 m/s in every sweep
}

/// A column of thirty balls that falls. A round costs one and a half sweeps.
TEST(blocks, a_step_of_newtons_method_counts_as_sweeps_and_is_taken_where_they_are_left) {
    for (const int budget : {100, 13}) {
        Bodies bodies;
        Blocks loop;
        const Contact contact = [] {
            Contact up;
            up.at.n = Vec3::UnitZ();
            return up;
        }();
        add_body(bodies, make_props(Plane{}, 0.0), Pose{});
        for (int i = 0; i < 30; ++i) {
            add_body(bodies, make_props(Sphere{}, 1.0), {Vec3(0, 0, i + 0.5), Quat::Identity()}, {Vec3(0, 0, -1e-2), Vec3::Zero()});
            for (const int below : {i, std::max(i - 1, 0)}) { // each bears two: products of their equations are more than blocks
                Block& block = loop.blocks.emplace_back();
                block.a = i + 1;
                block.b = below;
                block.first = static_cast<int>(loop.contacts.size());
                block.count = 1;
                loop.contacts.push_back(&contact);
            }
        }
        loop.arrange(bodies, 0, bodies.velocity);
        for (const Block& block : loop.blocks) {
            loop.points_of(loop.batch_of(block))[0].u_n_target.x[Blocks::lane_of(block)] = 0.0;
        }
        loop.wake(budget);
        double change = 1.0;
        while (loop.spent() < budget && change > 1e-9) {
            change = loop.sweep(bodies.velocity, 1e-10, 0.0);
        }
        if (budget == 100) {
            EXPECT_LE(change, 1e-9);
            EXPECT_GE(loop.spent(), loop.sweeps() + 1);
        } else {
            EXPECT_EQ(loop.spent(), loop.sweeps());
            EXPECT_EQ(loop.sweeps(), budget);
        }
    }
}

TEST(blocks, no_two_lanes_of_a_batch_move_the_same_body) {
    Bodies bodies;
    Blocks loop;
    add_body(bodies, make_props(Sphere{}, 0.0), Pose{});
    const Contact contact;
    const auto add = [&](int a, int b) {
        Block& block = loop.blocks.emplace_back();
        block.a = a;
        block.b = b;
        block.first = static_cast<int>(loop.contacts.size());
        block.count = 1;
        loop.contacts.push_back(&contact);
    };
    for (int i = 1; i < 120; ++i) {
        add_body(bodies, make_props(Sphere{}, 1.0), Pose{});
        add(0, i); // all on the same static body
        if (i > 1) {
            add(1, i); // and on one that moves: more than there are colours
        }
    }
    loop.arrange(bodies, 0, bodies.velocity);
    std::vector<int> seen(loop.blocks.size(), 0);
    for (const BlockBatch& batch : loop.batches) {
        std::vector<int> moved;
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            if (batch.block[lane] < 0) {
                continue;
            }
            ++seen[static_cast<std::size_t>(batch.block[lane])];
            for (const int body : {batch.a[lane], batch.b[lane]}) {
                if (body != 0) {
                    EXPECT_EQ(std::ranges::count(moved, body), 0);
                    moved.push_back(body);
                }
            }
        }
    }
    EXPECT_EQ(std::ranges::count(seen, 1), static_cast<std::ptrdiff_t>(seen.size()));
}

TEST(blocks, material_of_a_pair_is_the_geometric_mean_or_the_partners) {
    BodyProps a;
    BodyProps b;
    a.mu_s = 0.4;
    b.mu_s = 0.9;
    a.restitution = 0.5;
    const PairMaterial material = pair_material(a, b);
    EXPECT_NEAR(material.mu_s, 0.6, block_rounding);
    EXPECT_EQ(material.restitution, 0.5); // only a has one
    EXPECT_EQ(material.mu_d, 0.0);        // none has
    EXPECT_EQ(pair_material(b, a).restitution, 0.5);
}
