#include "sim/collide/narrow_phase.h"
#include "sim/solve/contact_solver.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

using namespace sim;

namespace {

constexpr double time_step = 1e-3; ///< [s]
constexpr double gravity = 10.0; ///< [m/s^2]

/// Cubes of side 1 m and mass 1000 kg stacked with gaps of `gap` [m] on a plane.
struct Stack {
    Bodies bodies;
    std::vector<PairContacts> pairs;
    StepSettings settings{.gravity = Vec3(0, 0, -gravity), .tolerance = 1e-7};
    ContactSolver solver;
    ContactSolveReport report;

    explicit Stack(int count, double gap = 0.0) {
        for (int i = 0; i < count; ++i) {
            add_body(bodies, make_props(Box{}, 1000.0),
                     {Vec3(0, 0, 0.5 + gap + i * (1.0 + gap)), Quat::Identity()});
        }
        add_body(bodies, make_props(Plane{}, 0.0), Pose{});
        for (int i = 0; i < count; ++i) {
            i == 0 ? pair(0, count) : pair(i - 1, i);
        }
    }
    void pair(int a, int b) {
        PairContacts& found = pairs.emplace_back();
        found.manifold.body_a = a;
        found.manifold.body_b = b;
        const auto ia = static_cast<std::size_t>(a);
        const auto ib = static_cast<std::size_t>(b);
        std::vector<FoundContact> contacts;
        find_contacts({bodies.props[ia].shape, bodies.pose[ia]}, {bodies.props[ib].shape, bodies.pose[ib]}, 1e-3, contacts);
        replace_contacts(found, contacts);
    }
    /// Returns what store_impulses() does.
    std::vector<int> solve() {
        solver.prepare(bodies, pairs, {}, settings, time_step);
        report = solver.solve(bodies, pairs, {});
        return solver.store_impulses(bodies, pairs, {});
    }
    double load(std::size_t pair) const {
        double sum = 0.0;
        for (const Contact& contact : pairs[pair].manifold.contacts) {
            sum += contact.memory.p_n;
        }
        return sum;
    }
};

} // namespace

TEST(contact_solver, gaps_at_the_end_of_the_step_are_closed) {
    Stack stack(3);
    stack.solve();
    EXPECT_TRUE(stack.report.converged);
    EXPECT_LE(stack.report.residual, stack.settings.tolerance);
    EXPECT_EQ(stack.solver.contact_count(), 12);
    for (std::size_t i = 0; i < 3; ++i) {
        // Each of up to three gaps below is within the tolerance.
        EXPECT_NEAR(stack.solver.predicted()[i].position.z(), 0.5 + static_cast<double>(i),
                    3.0 * stack.settings.tolerance);
    }
    EXPECT_EQ(stack.solver.velocity()[3].v, Vec3::Zero());
}

/// From rest, closed gaps stay closed with m g h / 2: the impulse acts at t0, gravity over the step.
TEST(contact_solver, a_floor_carries_the_weight_of_all_above_it) {
    Stack stack(3);
    stack.solve();
    const double unit = 1000.0 * gravity * time_step / 2.0;
    const double error = 3.0 * 1000.0 * stack.settings.tolerance / time_step; // gap errors of three bodies over h
    EXPECT_NEAR(stack.load(0), 3.0 * unit, error);
    EXPECT_NEAR(stack.load(1), 2.0 * unit, error);
    EXPECT_NEAR(stack.load(2), 1.0 * unit, error);
}

TEST(contact_solver, corners_of_a_resting_face_carry_equal_shares) {
    Stack stack(1);
    stack.solve();
    for (const Contact& contact : stack.pairs[0].manifold.contacts) {
        EXPECT_NEAR(contact.memory.p_n, 1000.0 * gravity * time_step / 8.0, 1e-9);
        EXPECT_EQ(contact.memory.p_t.norm(), 0.0);
    }
}

TEST(contact_solver, a_body_that_leaves_is_not_held) {
    Stack stack(1);
    stack.bodies.velocity[0].v.z() = 1.0;
    stack.solve();
    EXPECT_EQ(stack.load(0), 0.0);
    EXPECT_EQ(stack.solver.velocity()[0].v, Vec3(0, 0, 1));
}

TEST(contact_solver, dropped_contacts_give_their_impulses_back) {
    Stack stack(1);
    stack.solve();
    EXPECT_GT(stack.solver.velocity()[0].v.z(), 0.0);
    stack.solver.drop_contacts(stack.bodies, stack.pairs, 0);
    EXPECT_NEAR(stack.solver.velocity()[0].v.z(), 0.0, 1e-15);
}

TEST(contact_solver, contacts_that_take_the_place_of_others_start_from_their_impulses) {
    Stack stack(1);
    stack.solver.prepare(stack.bodies, stack.pairs, {}, stack.settings, time_step);
    stack.solver.solve(stack.bodies, stack.pairs, {});
    const double held = stack.solver.velocity()[0].v.z();
    EXPECT_GT(held, 0.0);
    stack.solver.drop_contacts(stack.bodies, stack.pairs, 0);
    stack.solver.add_contacts(stack.bodies, stack.pairs, std::vector<int>{0}, stack.bodies.velocity);
    EXPECT_NEAR(stack.solver.velocity()[0].v.z(), held, 1e-15);
}

namespace {

/// A floor, cubes side by side on it, each an island of its own, as many as make a group, and `others` more; then those of a tower.
Stack row_and_tower(int others, int tower) {
    Stack row(0);
    const auto add_cube = [&](double x, double z) {
        add_body(row.bodies, make_props(Box{}, 1000.0), {Vec3(x, 0, z), Quat::Identity()});
    };
    const int count = 256 + others;
    for (int i = 0; i < count; ++i) {
        add_cube(i, 0.5);
        row.pair(0, i + 1);
    }
    for (int i = 0; i < tower; ++i) {
        add_cube(-10.0, 0.5 + i);
        row.pair(i == 0 ? 0 : count + i, count + i + 1);
    }
    return row;
}

} // namespace

TEST(contact_solver, loads_connect_bodies_that_move) {
    Stack stack(3);
    add_body(stack.bodies, make_props(Box{}, 1000.0), {Vec3(5, 0, 0.5), Quat::Identity()});
    stack.pair(3, 4);
    EXPECT_EQ(stack.solve(), (std::vector<int>{0, 0, 0, 3, 4}));
}

TEST(contact_solver, an_impact_that_is_waited_for_bears_nothing) {
    Stack stack(1, 5e-4);
    stack.settings.impacts = ImpactHandling::stop;
    stack.bodies.velocity[0].v.z() = -1.0;
    for (Contact& contact : stack.pairs[0].manifold.contacts) {
        contact.memory = {.p_n = 1.0, .signed_interval = time_step, .last_interval = time_step};
    }
    stack.solve();
    EXPECT_EQ(stack.solver.contact_count(), 0);
    EXPECT_EQ(stack.load(0), 0.0);
}

/// Both start from impulses of a shorter interval, of which those of the row are far too large.
TEST(contact_solver, a_group_is_solved_as_if_it_were_alone) {
    Stack alone(10);
    Stack both = row_and_tower(0, 10);
    for (Stack* stack : {&alone, &both}) {
        stack->solver.prepare(stack->bodies, stack->pairs, {}, stack->settings, 0.5 * time_step);
        stack->solver.solve(stack->bodies, stack->pairs, {});
        stack->solver.store_impulses(stack->bodies, stack->pairs, {});
    }
    for (std::size_t i = 0; i < 256; ++i) {
        for (Contact& contact : both.pairs[i].manifold.contacts) {
            contact.memory.p_n *= 3.0;
        }
    }
    alone.solve();
    both.solve();
    for (std::size_t i = 0; i < 10; ++i) {
        EXPECT_EQ(both.solver.velocity()[257 + i].v.z(), alone.solver.velocity()[i].v.z());
        EXPECT_EQ(both.solver.predicted()[257 + i].position.z(), alone.solver.predicted()[i].position.z());
    }
}

TEST(contact_solver, groups_that_a_contact_connects_become_one) {
    Stack row = row_and_tower(10, 0);
    const std::size_t last = 256; // of the first group; the next cube touches it
    row.bodies.velocity[last].v.x() = 0.1;
    row.solver.prepare(row.bodies, row.pairs, {}, row.settings, time_step);
    row.solver.solve(row.bodies, row.pairs, {});
    const std::vector<Velocity> before(row.solver.velocity().begin(), row.solver.velocity().end());
    EXPECT_NEAR(before[last].v.x(), 0.1, 1e-12);
    row.pair(256, 257);
    row.solver.add_contacts(row.bodies, row.pairs, std::vector<int>{static_cast<int>(row.pairs.size()) - 1},
                            row.bodies.velocity);
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_NEAR((row.solver.velocity()[i].v - before[i].v).norm(), 0.0, 1e-15);
    }
    row.solver.solve(row.bodies, row.pairs, {});
    row.solver.store_impulses(row.bodies, row.pairs, {});
    EXPECT_GE(row.solver.predicted()[257].position.x() - row.solver.predicted()[256].position.x(),
              1.0 - row.settings.tolerance);
    EXPECT_NEAR(row.solver.velocity()[257].v.x(), 0.05, 1e-6);
    for (std::size_t i = 0; i + 1 < row.pairs.size(); ++i) {
        EXPECT_NEAR(row.load(i), 1000.0 * gravity * time_step / 2.0, 1000.0 * row.settings.tolerance / time_step);
    }
}

/// An impulse of a shorter interval, taken as a force, would turn the cube once about itself: how far its corners are from the
/// floor then does not tell that it is too much.
TEST(contact_solver, a_guess_that_throws_is_not_taken) {
    Stack stack(1);
    stack.settings.iteration_limit = 5;
    const double shorter = 0.01 * time_step;
    stack.solver.prepare(stack.bodies, stack.pairs, {}, stack.settings, shorter);
    stack.solver.solve(stack.bodies, stack.pairs, {});
    stack.solver.store_impulses(stack.bodies, stack.pairs, {});
    const BodyProps& cube = stack.bodies.props[0];
    const double turn = 2.0 * std::numbers::pi / time_step; // [rad/s]
    stack.pairs[0].manifold.contacts[0].memory.p_n = 0.01 * turn / (6.0 * cube.inverse_mass * std::sqrt(0.5)); // at a corner
    stack.solve();
    EXPECT_LT(stack.solver.velocity()[0].v.norm(), 0.1);
}

/// A cube that bore 1500 N s at one corner bears it at two as another one lands on it: still it was a force, and only what is
/// beyond it answers the impact. Contact by contact 1065 N s would be a force, and a row wedged in a funnel is thrown by the rest.
TEST(contact_solver, a_force_that_moves_to_other_points_of_its_block_stays_one) {
    Stack stack(2);
    stack.bodies.pose[1].position.z() += 1e-4;
    stack.bodies.velocity = {{Vec3(0, 0, -1), Vec3::Zero()}, {Vec3(0, 0, -1.2), Vec3::Zero()}, {}};
    stack.pairs.pop_back();
    stack.pair(0, 1);
    for (Contact& contact : stack.pairs[0].manifold.contacts) {
        contact.memory.signed_interval = contact.memory.last_interval = time_step;
    }
    stack.pairs[0].manifold.contacts[0].memory.p_n = 1500.0;
    stack.solve();
    double force = 0.0;
    for (const Contact& contact : stack.pairs[0].manifold.contacts) {
        force += contact.memory.force_share * contact.memory.p_n;
    }
    EXPECT_GT(stack.load(0), 2000.0);
    EXPECT_NEAR(force, 1500.0, 1e-9);
}

/// Of a tall box that falls on two corners the other two would land within the step, were it not for the impulses at the first:
/// an impact, and what is beyond the force of the last step answers it.
TEST(contact_solver, an_impact_that_another_point_of_the_block_prevents_is_one) {
    Stack stack(1);
    stack.bodies.props[0] = make_props(Box{Vec3(0.5, 0.5, 1.5)}, 1000.0);
    const double tilt = 3e-4; // [rad]
    stack.bodies.pose[0] = {Vec3(0, 0, 1.5 + 0.5 * tilt), Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()))};
    stack.bodies.inverse_inertia[0] = stack.bodies.props[0].inverse_principal_inertia.asDiagonal();
    stack.bodies.velocity[0].v.z() = -0.5;
    stack.pairs.clear();
    stack.pair(0, 1);
    for (std::size_t i = 0; i < 4; ++i) {
        const bool touches = stack.pairs[0].manifold.contacts[i].at.gap < 0.5 * tilt;
        stack.pairs[0].manifold.contacts[i].memory = {
            .p_n = touches ? 5.0 : 0.0, .signed_interval = time_step, .last_interval = touches ? time_step : 0.0};
    }
    stack.solve();
    double force = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
        const ContactMemory& memory = stack.pairs[0].manifold.contacts[i].memory;
        EXPECT_EQ(memory.p_n > 0.0, stack.pairs[0].manifold.contacts[i].at.gap < 0.5 * tilt);
        force += memory.force_share * memory.p_n;
    }
    EXPECT_GT(stack.load(0), 300.0);
    EXPECT_NEAR(force, 3000.0 * gravity * time_step, 1e-9); // no more than the weight
}

/// A contact that repair found may overlap now by more than the pair does, which it parts no more slowly for.
TEST(contact_solver, what_overlaps_parts_as_slowly_as_the_pair_overlaps) {
    const auto overlap_left = [](double of_pair) {
        Stack stack(1, -4e-4);
        stack.settings.tolerance = 1e-4;
        stack.pairs[0].least_gap = -of_pair;
        stack.solve();
        return 0.5 - stack.solver.predicted()[0].position.z();
    };
    EXPECT_NEAR(overlap_left(4e-4), 3e-4, 1e-9);
    EXPECT_NEAR(overlap_left(1e-4), 5e-5, 1e-9);
}

/// Impulses of a plan that falls short give no energy, but what moves gives some, and without anything that stands they keep momentum.
TEST(contact_solver, a_plan_that_falls_short_makes_no_body_faster) {
    const auto pushed = [](bool falls_short, double floor, bool has_floor) {
        Stack stack(2, -4e-4);
        stack.settings.tolerance = 1e-4;
        stack.bodies.velocity[2].v.z() = floor;
        if (!has_floor) {
            stack.pairs.erase(stack.pairs.begin());
        }
        stack.solver.prepare(stack.bodies, stack.pairs, {}, stack.settings, time_step);
        stack.solver.solve(stack.bodies, stack.pairs, {});
        stack.solver.store_impulses(stack.bodies, stack.pairs, {}, falls_short);
        return stack.solver.velocity()[1].v.z();
    };
    EXPECT_GT(pushed(false, 0.0, true), 0.1); // the overlaps part
    EXPECT_EQ(pushed(true, 0.0, true), 0.0);
    EXPECT_EQ(pushed(true, 0.5, true), pushed(false, 0.5, true));
    EXPECT_EQ(pushed(true, 0.0, false), pushed(false, 0.0, false));
    EXPECT_GT(pushed(false, 0.0, false), 0.1);
}

/// A cube that overlaps the floor parts from it, another beside it is stopped: slowed down together, they are told together, the one as
/// it is after the impulses, the other not as it was before.
TEST(contact_solver, of_a_plan_that_falls_short_no_energy_is_told) {
    Stack stack(1, -1.5e-5);
    stack.settings.tolerance = 1e-5;
    const int other = add_body(stack.bodies, make_props(Box{}, 1000.0), {Vec3(3, 0, 0.5), Quat::Identity()},
                               {Vec3(0, 0, -2e-3), Vec3::Zero()});
    stack.pair(other, 1);
    for (PairContacts& pair : stack.pairs) {
        for (Contact& contact : pair.manifold.contacts) {
            contact.memory.p_n = 1.0; // a load
            contact.memory.last_interval = contact.memory.signed_interval = time_step;
        }
    }
    stack.solver.prepare(stack.bodies, stack.pairs, {}, stack.settings, time_step);
    stack.solver.solve(stack.bodies, stack.pairs, {});
    stack.solver.store_impulses(stack.bodies, stack.pairs, {}, true);
    double told = 0.0; // [m^2/s^2]
    for (const Velocity& at_node : stack.solver.velocity_at_node()) {
        told += at_node.v.squaredNorm();
    }
    EXPECT_NEAR(told, 4e-6, 1e-12); // 5.9e-6 where each is told alone
}

/// A column that is too long for its room: what overlaps cannot part, and sweeps that ask for it push ever harder, to the limit.
TEST(contact_solver, a_column_wedged_between_floor_and_ceiling_stays_as_it_is) {
    const double gap = -8e-5;
    Stack stack(4, gap);
    stack.settings.tolerance = 1e-4;
    stack.settings.velocity_tolerance = 1e-3;
    stack.settings.iteration_limit = 200;
    add_body(stack.bodies, make_props(Plane{}, 0.0),
             {Vec3(0, 0, 4.0 + 5.0 * gap), Quat(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()))});
    stack.pair(3, 5);
    // Beside it one that can part, and overlaps by more: it goes on to.
    add_body(stack.bodies, make_props(Box{}, 1000.0), {Vec3(5.0, 0.0, 0.5 - 4e-4), Quat::Identity()});
    stack.pair(4, 6);
    stack.pairs.back().least_gap = -4e-4;
    stack.solve();
    EXPECT_TRUE(stack.report.converged);
    EXPECT_LE(stack.report.iterations, 150);
    EXPECT_NEAR(stack.solver.predicted()[6].position.z(), 0.5 - 3e-4, 1e-6);
    for (int i = 0; i < 4; ++i) {
        EXPECT_LT(stack.solver.velocity()[static_cast<std::size_t>(i)].v.norm(), 0.1);
    }
}

TEST(contact_solver, without_contacts_bodies_move_freely) {
    Stack stack(1, 1.0);
    stack.bodies.velocity[0] = {Vec3(1, 2, 3), Vec3(0.1, 0.2, 0.3)};
    stack.solve();
    const Pose free = free_motion(stack.bodies.props[0], stack.bodies.pose[0], stack.bodies.velocity[0],
                                  stack.settings.gravity, time_step);
    EXPECT_EQ(stack.solver.predicted()[0].position, free.position);
    EXPECT_EQ(stack.solver.contact_count(), 0);
}

TEST(contact_solver, memory_is_matched_by_id_and_else_by_the_nearest_core) {
    Stack stack(1);
    PairContacts old = stack.pairs[0];
    std::vector<FoundContact> contacts;
    for (const Contact& contact : old.manifold.contacts) {
        contacts.push_back(old.manifold.found(contact, stack.bodies.pose[0], stack.bodies.pose[1]));
    }
    for (std::size_t i = 0; i < 4; ++i) {
        old.manifold.contacts[i].memory.p_n = static_cast<double>(i + 1);
    }
    std::ranges::reverse(old.manifold.contacts);
    PairContacts pair = old;
    replace_contacts(pair, contacts);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(pair.manifold.contacts[i].memory.p_n, static_cast<double>(i + 1));
        EXPECT_EQ(pair.manifold.contacts[i].id, contacts[i].feature.id);
    }
    for (Contact& contact : old.manifold.contacts) {
        contact.id += 1000; // other features, 1 mm away
        contact.core_a.x() += 1e-3f;
    }
    pair = old;
    replace_contacts(pair, contacts);
    EXPECT_EQ(pair.manifold.contacts[2].memory.p_n, 3.0);
    old.manifold.contacts.resize(1); // contacts[3]
    pair = old;
    replace_contacts(pair, std::span(contacts).first(1)); // far away, but there is no other
    EXPECT_EQ(pair.manifold.contacts[0].memory.p_n, old.manifold.contacts[0].memory.p_n);
}

// Its half kick has acted already: what is not owed any more would be missing from the motion.
TEST(contact_solver, what_a_lost_contact_bore_acts_on_at_those_left) {
    Stack stack(1);
    PairContacts pair = stack.pairs[0];
    const Vec3 normal = pair.manifold.contacts[0].at.n;
    const auto sums = [&] { // of normal impulses: force, moment about the origin
        std::pair<double, Vec3> sum{0.0, Vec3::Zero()};
        for (const Contact& contact : pair.manifold.contacts) {
            sum.first += contact.memory.p_n;
            sum.second += contact.at.a.cross(contact.memory.p_n * normal);
        }
        return sum;
    };
    std::vector<FoundContact> contacts;
    for (std::size_t i = 0; i < 4; ++i) {
        Contact& contact = pair.manifold.contacts[i];
        contacts.push_back(pair.manifold.found(contact, stack.bodies.pose[0], stack.bodies.pose[1]));
        contact.memory = {.p_n = 2.0 - 0.3 * static_cast<double>(i), .p_t = Vec3(0.1, 0.2, 0.0), .signed_interval = time_step};
    }
    auto before = sums();
    replace_contacts(pair, std::span(contacts).first(3));
    EXPECT_NEAR(sums().first, before.first, 1e-12);
    EXPECT_NEAR((sums().second - before.second).norm(), 0.0, 1e-6);
    EXPECT_NEAR(pair.manifold.contacts[0].memory.p_t.x() + pair.manifold.contacts[1].memory.p_t.x() + pair.manifold.contacts[2].memory.p_t.x(),
                0.4, 1e-12);
    before = sums();
    replace_contacts(pair, std::span(contacts).first(1)); // no moment any more
    EXPECT_NEAR(sums().first, before.first, 1e-12);
}
