#include "sim/collide/narrow_phase.h"
#include "sim/solve/contact_solver.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace sim;

namespace sim {
double rest_kernel_baseline(const RestWork& work);
#if defined(TUMBLE_X86_KERNELS)
double rest_kernel_avx2(const RestWork& work);
double rest_kernel_avx512(const RestWork& work);
#endif
} // namespace sim

namespace {

constexpr double h = 1e-3; ///< [s]

/// Pairs of boxes far from each other: so many that they are solved in lanes.
constexpr int pair_count = 90;

/// Solves end with velocities right to 1e-12 m/s, impulses of 1000 N s to 1e-9 N s.
constexpr double rounding = 1e-8;

/// Least distance of two contact points [m].
double nearest_points(const std::vector<Contact>& contacts) {
    double least = 1.0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            least = std::min(least, (contacts[i].at.a - contacts[j].at.a).norm());
        }
    }
    return least;
}

/// A box that falls on another, face to face, tilted, with crossing edges or with a corner; half of those below are
/// static.
struct Pairs {
    Bodies bodies;
    std::vector<PairContacts> pairs;
    StepSettings settings{.gravity = Vec3(0, 0, -10), .velocity_tolerance = 1e-12};

    /// frictionless: none has friction, and points may nearly coincide.
    explicit Pairs(Numbers& numbers, bool frictionless = false) {
        settings.iteration_limit = 10000;
        for (int i = 0; i < pair_count; ++i) {
            const Quat level = turned(Quat::Identity(), Vec3(0, 0, numbers.between(-1.0, 1.0)));
            const Quat edge_down = turned(Quat::Identity(), Vec3(0.25 * M_PI, 0, 0));
            const Quat edge_up = turned(edge_down, Vec3(0, 0, numbers.between(0.5, 2.5)));
            const Quat turns[] = {level, turned(level, numbers.vector(3e-4)), edge_down, numbers.orientation()};
            const Vec3 place(5.0 * i, 0, 0);
            add_body(bodies, make_props(Box{}, i % 2 == 0 ? 0.0 : 800.0, 0.0, 0.3),
                     {place, i % 4 == 2 ? edge_up : Quat::Identity()}, {0.02 * numbers.vector(1.0), 0.02 * numbers.vector(1.0)});
            add_body(bodies, make_props(Box{Vec3(0.4, 0.5, 0.6)}, 1000.0, 0.0, frictionless || i % 3 == 0 ? 0.0 : 0.3),
                     {place + Vec3(0.1, 0.05, 1.6), turns[i % 4]},
                     {0.2 * numbers.vector(1.0), 0.2 * numbers.vector(1.0)});
            const auto below = bodies.pose.size() - 2;
            const auto above = below + 1;
            if (bodies.props[below].is_static()) {
                bodies.velocity[below] = {};
            }
            for (int step = 0; step < 50; ++step) { // down to a gap of a few tolerances at most
                const double gap = separation(bodies.props[below].shape, bodies.pose[below], bodies.props[above].shape,
                                              bodies.pose[above]);
                bodies.pose[above].position.z() -= gap - numbers.between(-0.2, 2.0) * settings.tolerance;
            }
            PairContacts& pair = pairs.emplace_back();
            pair.manifold.body_a = static_cast<int>(below);
            pair.manifold.body_b = static_cast<int>(above);
            pair.material = pair_material(bodies.props[below], bodies.props[above]);
            find_contacts(bodies.props[below].shape, bodies.pose[below], bodies.props[above].shape, bodies.pose[above], 1e-3,
                          pair.manifold.contacts);
            match_memory(pair, 0.0);
            // Where points nearly coincide their load can be shared in many ways, and rounding decides.
            if (!frictionless && nearest_points(pair.manifold.contacts) < 0.05) {
                pairs.pop_back();
            }
        }
    }
};

void expect_near(const ContactMemory& found, const ContactMemory& expected, const std::string& where) {
    EXPECT_NEAR(found.p_n, expected.p_n, rounding) << where;
    EXPECT_LE((found.p_t - expected.p_t).norm(), rounding) << where;
    EXPECT_NEAR(found.interval, expected.interval, 1e-15) << where;
    EXPECT_NEAR(found.force_share, expected.force_share, rounding) << where;
    EXPECT_EQ(found.last_interval, expected.last_interval) << where;
    EXPECT_NEAR(found.approach_speed, expected.approach_speed, rounding) << where;
    EXPECT_NEAR(found.energy_taken, expected.energy_taken, rounding) << where;
    EXPECT_EQ(found.is_sticking(), expected.is_sticking()) << where;
    EXPECT_LE((found.slip - expected.slip).norm(), h * rounding) << where;
    EXPECT_LE((found.sliding - expected.sliding).norm(), rounding) << where;
}

/// One pair alone, in readable form, against the solve of all in lanes: velocities and poses.
void expect_same_motion(const ContactSolver& lanes, const ContactSolver& alone, const Manifold& pair, double difference,
                        const std::string& where) {
    for (const int body : {pair.body_a, pair.body_b}) {
        const auto k = static_cast<std::size_t>(body);
        EXPECT_LE((lanes.velocity()[k].v - alone.velocity()[k].v).norm(), difference) << where;
        EXPECT_LE((lanes.velocity()[k].w - alone.velocity()[k].w).norm(), difference) << where;
        EXPECT_LE((lanes.predicted()[k].position - alone.predicted()[k].position).norm(), h * difference) << where;
    }
}

/// Every pair alone, in readable form, against all of them in lanes: velocities, poses, and what is remembered.
void expect_same(const Pairs& start, Pairs& in_lanes) {
    ContactSolver lanes;
    lanes.prepare(in_lanes.bodies, in_lanes.pairs, {}, {}, in_lanes.settings, h);
    EXPECT_TRUE(lanes.solve(in_lanes.bodies, in_lanes.pairs, {}).converged);
    lanes.remember(in_lanes.bodies, in_lanes.pairs, {});
    const std::vector<Velocity> at_node = lanes.velocity_at_node(in_lanes.bodies);
    for (std::size_t i = 0; i < start.pairs.size(); ++i) {
        const std::string where = "pair " + std::to_string(i);
        std::vector<PairContacts> pair{start.pairs[i]};
        ContactSolver alone;
        alone.prepare(start.bodies, pair, {}, {}, start.settings, h);
        EXPECT_TRUE(alone.solve(start.bodies, pair, {}).converged);
        alone.remember(start.bodies, pair, {});
        expect_same_motion(lanes, alone, pair[0].manifold, rounding, where);
        const std::vector<Velocity> expected_at_node = alone.velocity_at_node(start.bodies);
        for (const int body : {pair[0].manifold.body_a, pair[0].manifold.body_b}) {
            const auto k = static_cast<std::size_t>(body);
            EXPECT_LE((at_node[k].v - expected_at_node[k].v).norm(), rounding) << where;
        }
        for (std::size_t k = 0; k < pair[0].memory.size(); ++k) {
            expect_near(in_lanes.pairs[i].memory[k], pair[0].memory[k], where + " contact " + std::to_string(k));
        }
    }
}

} // namespace

TEST(contact_lanes, lanes_find_and_remember_what_blocks_do) {
    Numbers numbers(3);
    Pairs pairs(numbers);
    for (int interval = 0; interval < 3; ++interval) { // the first from nothing, then from what is remembered
        const Pairs start = pairs;
        expect_same(start, pairs);
        int loaded = 0;
        int sticking = 0;
        for (PairContacts& pair : pairs.pairs) {
            loaded += std::ranges::any_of(pair.memory, [](const ContactMemory& memory) { return memory.p_n > 0.0; }) ? 1 : 0;
            for (ContactMemory& memory : pair.memory) {
                sticking += memory.is_sticking() ? 1 : 0;
                memory.last_interval = loaded % 5 == 0 ? 0.0 : memory.last_interval; // an impact ended the force
                memory.slip += pair.material.mu_d > 0.0 ? Vec3(1e-6 * numbers.vector(1.0)) : Vec3(Vec3::Zero());
            }
        }
        EXPECT_GT(loaded, pair_count / 5);
        EXPECT_GT(sticking, 0);
    }
}

/// Of a box that leans on another the edges cross beside the corners of a face, and nearly where a corner of the face
/// lies: without friction the motion is the same however they share the load.
TEST(contact_lanes, boxes_that_lean_on_each_other_move_as_in_blocks) {
    Numbers numbers(5);
    Pairs pairs(numbers, true);
    int leaning = 0;
    for (const PairContacts& pair : pairs.pairs) {
        const std::vector<Contact>& contacts = pair.manifold.contacts;
        leaning += contacts.size() > 1 && contacts.front().feature.kind != contacts.back().feature.kind &&
                           contacts.back().feature.kind == FeatureKind::edges
                       ? 1
                       : 0;
    }
    EXPECT_GT(leaning, 10);
    pairs.settings.tolerance =
        1e-10; // gaps that are not linear are solved for again, in all lanes while one asks for it
    ContactSolver lanes;
    lanes.prepare(pairs.bodies, pairs.pairs, {}, {}, pairs.settings, h);
    EXPECT_TRUE(lanes.solve(pairs.bodies, pairs.pairs, {}).converged);
    for (std::size_t i = 0; i < pairs.pairs.size(); ++i) {
        std::vector<PairContacts> pair{pairs.pairs[i]};
        ContactSolver alone;
        alone.prepare(pairs.bodies, pair, {}, {}, pairs.settings, h);
        EXPECT_TRUE(alone.solve(pairs.bodies, pair, {}).converged);
        expect_same_motion(lanes, alone, pair[0].manifold, pairs.settings.tolerance / h, "pair " + std::to_string(i));
    }
}

TEST(contact_lanes, contacts_dropped_and_added_leave_the_others_as_they_are) {
    Numbers numbers(4);
    Pairs pairs(numbers);
    ContactSolver solver;
    solver.prepare(pairs.bodies, pairs.pairs, {}, {}, pairs.settings, h);
    EXPECT_TRUE(solver.solve(pairs.bodies, pairs.pairs, {}).converged);
    const std::vector<Velocity> before(solver.velocity().begin(), solver.velocity().end());
    solver.drop_contacts(pairs.bodies, pairs.pairs, 5);
    const auto above = static_cast<std::size_t>(pairs.pairs[5].manifold.body_b);
    EXPECT_LE((solver.velocity()[above].v - pairs.bodies.velocity[above].v).norm(), rounding);
    solver.add_contacts(pairs.bodies, pairs.pairs, 5, pairs.bodies.velocity);
    EXPECT_TRUE(solver.solve(pairs.bodies, pairs.pairs, {}).converged);
    for (std::size_t i = 0; i < before.size(); ++i) {
        // Gaps are measured once more, and were right to half the tolerance before: 0.05 m/s.
        EXPECT_LE((solver.velocity()[i].v - before[i].v).norm(), 2e-3) << i;
        EXPECT_LE((solver.velocity()[i].w - before[i].w).norm(), 2e-3) << i;
    }
}

/// A tower of more blocks than are swept together, put down without forces: each block carries what is above it. Sweeps
/// that are not carried on need 32 000.
TEST(contact_lanes, high_towers_converge_by_momentum) {
    constexpr int count = 80;
    constexpr double mass = 500.0;
    StepSettings settings{.gravity = Vec3(0, 0, -10), .velocity_tolerance = 1e-9};
    settings.iteration_limit = 4000;
    Bodies bodies;
    std::vector<PairContacts> pairs;
    add_body(bodies, make_props(Box{Vec3(0.5, 0.5, 0.5)}, 0.0, 0.0, 0.3), {Vec3::Zero(), Quat::Identity()}, {});
    for (int i = 1; i <= count; ++i) {
        add_body(bodies, make_props(Box{Vec3(0.5, 0.5, 0.5)}, mass, 0.0, 0.3), {Vec3(0, 0, i), Quat::Identity()}, {});
        PairContacts& pair = pairs.emplace_back();
        pair.manifold.body_a = i - 1;
        pair.manifold.body_b = i;
        pair.material = pair_material(bodies.props[1], bodies.props[1]);
        find_contacts(Box{Vec3(0.5, 0.5, 0.5)}, {Vec3(0, 0, i - 1), Quat::Identity()}, Box{Vec3(0.5, 0.5, 0.5)},
                      {Vec3(0, 0, i), Quat::Identity()}, 1e-3, pair.manifold.contacts);
        match_memory(pair, 0.0);
    }
    ContactSolver solver;
    solver.prepare(bodies, pairs, {}, {}, settings, h);
    const ContactSolveReport report = solver.solve(bodies, pairs, {});
    EXPECT_TRUE(report.converged);
    EXPECT_LT(report.iterations, 1000);
    solver.remember(bodies, pairs, {});
    for (int i = 0; i < count; ++i) {
        double force = 0.0;
        for (const ContactMemory& memory : pairs[static_cast<std::size_t>(i)].memory) {
            force += memory.p_n / memory.interval;
        }
        EXPECT_NEAR(force / (mass * 10.0), count - i, 1e-3) << i;
    }
}

namespace {

/// Two batches with contacts and memory of any numbers, and what a kernel makes of them.
struct AnyBatches {
    std::vector<BlockBatch> batches = std::vector<BlockBatch>(2);
    std::vector<RestBlock> blocks = std::vector<RestBlock>(2);
    std::vector<BatchPoint> points = std::vector<BatchPoint>(5);
    std::vector<RestPoint> rest = std::vector<RestPoint>(5);
    std::vector<BodyRows> begin = std::vector<BodyRows>(4 * lane_count);
    std::vector<BodyRows> end = std::vector<BodyRows>(4 * lane_count);
    std::vector<Velocity> before = std::vector<Velocity>(4 * lane_count);
    std::vector<Velocity> velocity;
    std::vector<ContactGeometry> geometry = std::vector<ContactGeometry>(5 * lane_count);
    std::vector<ContactMemory> memory = std::vector<ContactMemory>(5 * lane_count);
    double worst = 0.0;

    explicit AnyBatches(double (*kernel)(const RestWork&)) {
        Numbers numbers(17);
        for (std::size_t i = 0; i < begin.size(); ++i) {
            const Mat3 turn = turned(Quat::Identity(), numbers.vector(0.01)).toRotationMatrix();
            begin[i] = {{numbers.between(-1, 1), numbers.between(-1, 1), numbers.between(-1, 1), 0.001, 0.006, 0, 0, 0.006, 0, 0.006}};
            std::copy_n(Mat3(turn.transpose()).data(), 9, end[i].x);
            std::copy_n(begin[i].x, 3, end[i].x + 9);
            before[i] = {numbers.vector(0.3), numbers.vector(0.3)};
        }
        velocity = before;
        for (std::size_t i = 0; i < geometry.size(); ++i) {
            const Vec3 a = numbers.vector(0.5);
            geometry[i] = {numbers.between(-1e-4, 3e-4), Vec3::UnitZ(), a, a};
            memory[i].p_n = std::max(numbers.between(-1, 1), 0.0);
            memory[i].p_t = 0.1 * numbers.vector(1.0);
            memory[i].interval = memory[i].last_interval = h;
            memory[i].force_share = 0.7;
            memory[i].slip = 1e-5 * numbers.vector(1.0);
        }
        int body = 0;
        for (std::size_t i = 0; i < 2; ++i) {
            BlockBatch& batch = batches[i];
            batch.first = i == 0 ? 0 : 4;
            batch.count = i == 0 ? 4 : 1;
            batch.moves_a = batch.moves_b = 0xff;
            batch.face_of_a = 0x55;
            blocks[i].plain = 0xff;
            blocks[i].edges = i == 0 ? 0x30 : 0x0f;
            for (std::size_t lane = 0; lane < lane_count; ++lane) {
                batch.a[lane] = body++;
                batch.b[lane] = body++;
                batch.mu.x[lane] = 0.1 * static_cast<double>(lane);
                blocks[i].reach.x[lane] = 0.02;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    blocks[i].edge_a[axis].x[lane] = axis == 0 ? 1.0 : 0.0;
                    blocks[i].edge_b[axis].x[lane] = axis == 1 ? 1.0 : 0.0;
                }
            }
        }
        for (std::size_t k = 0; k < rest.size(); ++k) {
            rest[k].there = k == 3 ? 0x3f : 0xff;
            rest[k].edges = k == 3 ? 0x30 : k == 4 ? 0x0f : 0; // beside points at a face, and alone
            for (std::size_t lane = 0; lane < lane_count; ++lane) {
                rest[k].at[lane] = &geometry[k * lane_count + lane].gap;
                rest[k].memory[lane] = &memory[k * lane_count + lane].p_n;
            }
        }
        const RestRules rules{.h = h, .tolerance = 1e-4, .band = 5e-5, .relaxation = 0.1, .velocity_tolerance = 0.05,
                              .largest_stretch = 100.0, .largest_growth = 2.0, .limit = 1.0 - 1e-9, .slip_tolerance = 5e-5,
                              .gravity = {0, 0, -10}};
        for (const RestPhase phase : {RestPhase::start, RestPhase::apply, RestPhase::measure, RestPhase::remember}) {
            worst = std::max(worst, kernel({phase, batches.data(), 2, blocks.data(), points.data(), rest.data(), begin.data(), end.data(),
                                            before[0].v.data(), velocity[0].v.data(), nullptr, &rules}));
        }
    }
};

} // namespace

TEST(contact_lanes, instruction_sets_agree_to_the_last_bit) {
    std::vector<double (*)(const RestWork&)> kernels{rest_kernel_baseline};
#if defined(TUMBLE_X86_KERNELS)
    if (__builtin_cpu_supports("avx2")) {
        kernels.push_back(rest_kernel_avx2);
    }
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
        kernels.push_back(rest_kernel_avx512);
    }
#endif
    const AnyBatches expected(kernels[0]);
    EXPECT_GT(expected.worst, 0.0);
    for (const auto kernel : kernels) {
        const AnyBatches found(kernel);
        EXPECT_EQ(found.worst, expected.worst);
        for (std::size_t i = 0; i < found.velocity.size(); ++i) {
            EXPECT_EQ(found.velocity[i].v, expected.velocity[i].v);
            EXPECT_EQ(found.velocity[i].w, expected.velocity[i].w);
        }
        for (std::size_t i = 0; i < found.memory.size(); ++i) {
            EXPECT_EQ(found.memory[i].p_n, expected.memory[i].p_n);
            EXPECT_EQ(found.memory[i].p_t, expected.memory[i].p_t);
            EXPECT_EQ(found.memory[i].slip, expected.memory[i].slip);
            EXPECT_EQ(found.memory[i].sliding, expected.memory[i].sliding);
            EXPECT_EQ(found.memory[i].energy_taken, expected.memory[i].energy_taken);
            EXPECT_EQ(found.memory[i].mark, expected.memory[i].mark);
        }
        for (std::size_t k = 0; k < found.points.size(); ++k) {
            for (std::size_t lane = 0; lane < lane_count; ++lane) {
                EXPECT_EQ(found.points[k].u_n_target.x[lane], expected.points[k].u_n_target.x[lane]);
                EXPECT_EQ(found.points[k].u_t_target[0].x[lane], expected.points[k].u_t_target[0].x[lane]);
                EXPECT_EQ(found.points[k].u_t_target[1].x[lane], expected.points[k].u_t_target[1].x[lane]);
            }
        }
    }
}
