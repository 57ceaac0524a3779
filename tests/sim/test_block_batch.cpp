#include "sim/block/contact_block.h"
#include "sim/collide/narrow_phase.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace sim;

namespace sim {
double block_kernel_baseline(const BatchSweep& sweep);
#if defined(TUMBLE_X86_KERNELS)
double block_kernel_avx2(const BatchSweep& sweep);
double block_kernel_avx512(const BatchSweep& sweep);
#endif
} // namespace sim

namespace {

/// Both forms of the same equations on velocities of about 1 m/s and impulses of about 1000 N s.
constexpr double rounding = 1e-10;

/// Least distance of two contact points [m].
double nearest_points(const std::vector<ContactGeometry>& geometry) {
    double least = 1.0;
    for (std::size_t i = 0; i < geometry.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            least = std::min(least, (geometry[i].a - geometry[j].a).norm());
        }
    }
    return least;
}

/// `count` pairs of boxes pressed together face to face, on an edge or on a corner, each pair with its own bodies.
struct Pairs {
    Bodies bodies;
    ContactBlocks loop;

    Pairs(int count, double mu, Numbers& numbers) {
        for (int i = 0; i < count; ++i) {
            const double tilt = i % 3 == 0 ? 0.0 : 0.3;
            const Quat turn = Quat(1.0, tilt * numbers.between(-1.0, 1.0), tilt * numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0)).normalized();
            add_body(bodies, make_props(Box{}, 700.0), {Vec3(5.0 * i, 0.2, 0.9), turn},
                     {numbers.vector(1.0) - Vec3(0, 0, 1), numbers.vector(1.0)});
            add_body(bodies, make_props(Box{Vec3(0.6, 0.7, 0.5)}, 1000.0), {Vec3(5.0 * i, 0.0, 0.0), Quat::Identity()});
            const auto a = bodies.pose.size() - 2;
            std::vector<Contact> contacts;
            find_contacts(bodies.props[a].shape, bodies.pose[a], bodies.props[a + 1].shape, bodies.pose[a + 1], 0.3, contacts);
            std::vector<ContactGeometry> geometry;
            for (const Contact& contact : contacts) {
                geometry.push_back(contact.at);
            }
            // Where points nearly coincide solve_block iterates, and only comes near the answer.
            if (nearest_points(geometry) < 0.05) {
                continue;
            }
            loop.append(bodies, static_cast<int>(a), static_cast<int>(a) + 1, geometry, {0.0, mu, 0.8 * mu});
        }
        for (ContactBlock& block : loop.blocks) {
            block.twist_before = tangential_part(relative_twist(block, bodies.velocity));
            block.node_weight = 0.5 + 0.4 * numbers.between(-1.0, 1.0);
            block.is_sticking = numbers.between(-1.0, 1.0) > 0.0;
        }
        for (ContactPoint& point : loop.points) {
            point.u_t_target = 0.01 * Vec2(numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0));
        }
    }
};

} // namespace

/// The fast form against the readable one, contact by contact, for one visit: where a load can be shared in
/// many ways, rounding decides from there on.
TEST(block_batch, lanes_solve_what_solve_block_solves) {
    Numbers numbers(7);
    int projections = 0;
    for (const double mu : {0.0, 0.1, 0.1, 0.3, 0.5, 1.0, 2.0}) {
        projections = 1 + projections % most_projections;
        Pairs pairs(60, mu, numbers);
        ContactBlocks one_by_one = pairs.loop;
        std::vector<Velocity> velocity = pairs.bodies.velocity;
        std::vector<Velocity> expected = pairs.bodies.velocity;
        pairs.loop.arrange(pairs.bodies);
        pairs.loop.load_batches(pairs.bodies);
        double largest = 0.0;
        for (const ContactBlock& block : one_by_one.blocks) {
            const auto points = one_by_one.points_of(block);
            const BlockResponse response = block_response(block, points, pairs.bodies);
            largest = std::max(largest, solve_block(block, response, points, pairs.bodies, expected, projections));
        }
        EXPECT_NEAR(pairs.loop.sweep(velocity, -1.0, 0.0, projections), largest, rounding);
        pairs.loop.store_impulses();
        for (std::size_t k = 0; k < pairs.loop.points.size(); ++k) {
            EXPECT_NEAR(pairs.loop.points[k].p_n, one_by_one.points[k].p_n, 1000.0 * rounding) << "mu " << mu;
            EXPECT_LE((pairs.loop.points[k].p_t - one_by_one.points[k].p_t).norm(), 1000.0 * rounding) << "mu " << mu;
        }
        for (std::size_t i = 0; i < velocity.size(); ++i) {
            EXPECT_LE((velocity[i].v - expected[i].v).norm(), rounding);
            EXPECT_LE((velocity[i].w - expected[i].w).norm(), rounding);
        }
    }
}

TEST(block_batch, responses_are_those_of_block_response) {
    Numbers numbers(5);
    Pairs pairs(60, 0.3, numbers);
    pairs.loop.arrange(pairs.bodies);
    for (const BlockBatch& batch : pairs.loop.batches) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            if (batch.block[lane] < 0) {
                continue;
            }
            const ContactBlock& block = pairs.loop.blocks[static_cast<std::size_t>(batch.block[lane])];
            const BlockResponse expected = block_response(block, pairs.loop.points_of(block), pairs.bodies);
            const double scale = rounding * expected.twist.norm();
            EXPECT_NEAR(batch.k_t.x[lane], expected.k_t, scale);
            for (int i = 0; i < 6; ++i) {
                for (int j = 0; j <= i; ++j) {
                    EXPECT_NEAR(batch.response[i * (i + 1) / 2 + j].x[lane], expected.twist(i, j), scale);
                }
            }
        }
    }
}

/// Gaps that are linear in the velocities: the error left is h times what the velocities miss.
TEST(block_batch, errors_left_are_those_of_the_points) {
    constexpr double h = 1e-3;
    Numbers numbers(3);
    Pairs pairs(60, 0.3, numbers);
    std::vector<double> radius;
    for (const BodyProps& props : pairs.bodies.props) {
        radius.push_back(props.bounding_radius);
    }
    for (std::size_t k = 0; k < pairs.loop.blocks.size(); ++k) {
        pairs.loop.blocks[k].is_flat = k % 7 != 0;
    }
    for (ContactPoint& point : pairs.loop.points) {
        point.u_n_target = numbers.between(-1.0, 1.0);
        point.p_n = std::max(numbers.between(-1.0, 1.0), 0.0);
    }
    pairs.loop.arrange(pairs.bodies);
    pairs.loop.load_batches(pairs.bodies);
    std::vector<Velocity> velocity = pairs.bodies.velocity;
    velocity[0].w += Vec3(0.0, 0.0, 5.0); // this body bends its gaps
    double expected = 0.0;
    std::vector<bool> looked_at;
    for (const ContactBlock& block : pairs.loop.blocks) {
        looked_at.push_back(block.is_flat && block.a != 0);
        for (const ContactPoint& point : pairs.loop.points_of(block)) {
            const double missing = h * (point.u_n_target - normal_velocity(point, relative_twist(block, velocity)));
            expected = looked_at.back() ? std::max(expected, point.p_n > 0.0 ? std::abs(missing) : missing) : expected;
        }
    }
    std::vector<unsigned> unsure(pairs.loop.batches.size());
    EXPECT_NEAR(check_batches({pairs.loop.batches.data(), pairs.loop.batches.size(), pairs.loop.batch_points.data(),
                               velocity.front().v.data(), pairs.bodies.velocity.front().v.data(), radius.data(), h,
                               1e-7, unsure.data()}),
                expected, rounding);
    for (std::size_t i = 0; i < unsure.size(); ++i) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            const int block = pairs.loop.batches[i].block[lane];
            EXPECT_EQ(unsure[i] >> lane & 1u, block >= 0 && !looked_at[static_cast<std::size_t>(block)]);
        }
    }
}

TEST(block_batch, instruction_sets_agree_to_the_last_bit) {
    std::vector<double (*)(const BatchSweep&)> kernels{block_kernel_baseline};
#if defined(TUMBLE_X86_KERNELS)
    if (__builtin_cpu_supports("avx2")) {
        kernels.push_back(block_kernel_avx2);
    }
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
        kernels.push_back(block_kernel_avx512);
    }
#endif
    std::vector<std::vector<Velocity>> results;
    for (const auto kernel : kernels) {
        Numbers numbers(11);
        Pairs pairs(40, 0.3, numbers);
        pairs.loop.arrange(pairs.bodies);
        pairs.loop.load_batches(pairs.bodies);
        std::vector<Velocity>& velocity = results.emplace_back(pairs.bodies.velocity);
        ContactBlocks& loop = pairs.loop;
        for (int i = 0; i < 3; ++i) {
            kernel({loop.batches.data(), loop.batches.size(), loop.batch_points.data(), velocity[0].v.data(),
                    loop.activity.data(), -1.0, 1e-9});
        }
        for (std::size_t i = 0; i < velocity.size(); ++i) {
            EXPECT_EQ(velocity[i].v, results[0][i].v);
            EXPECT_EQ(velocity[i].w, results[0][i].w);
        }
    }
}

TEST(block_batch, no_two_lanes_of_a_batch_move_the_same_body) {
    Bodies bodies;
    ContactBlocks loop;
    add_body(bodies, make_props(Sphere{}, 0.0), Pose{});
    const std::vector<ContactGeometry> contact(1);
    for (int i = 1; i < 120; ++i) {
        add_body(bodies, make_props(Sphere{}, 1.0), Pose{});
        loop.append(bodies, 0, i, contact, {}); // all on the same static body
        if (i > 1) {
            loop.append(bodies, 1, i, contact, {}); // and on one that moves: more than there are colours
        }
    }
    loop.arrange(bodies);
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
