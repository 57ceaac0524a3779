#include "sim/base/disjoint_sets.h"
#include "sim/solve/half_kicks.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

using namespace sim;

namespace {

/// Boxes of 1 kg, each 1 m above the one before, the first fixed.
struct Column {
    Bodies bodies;
    std::vector<PairContacts> pairs;

    explicit Column(std::initializer_list<double> rises) {
        const Vec3 half = Vec3::Constant(0.5);
        add_body(bodies, BodyProps{}, {}, {});
        for (const double rise : rises) {
            const double z = static_cast<double>(bodies.props.size());
            add_body(bodies, make_props(Box{half}, 1.0, 0.0), {Vec3(0, 0, z), Quat::Identity()}, {Vec3(0, 0, rise), Vec3::Zero()});
        }
    }
    /// A body and the next one owe each other this impulse [N s], up on that.
    void owe(int body, double impulse) {
        PairContacts& pair = pairs.emplace_back();
        pair.manifold.body_a = body;
        pair.manifold.body_b = body + 1;
        pair.owed_impulse = Vec3(0, 0, -impulse);
    }
    double mass(std::size_t i) const { return 1.0 / bodies.props[i].inverse_mass; }
    /// All that owe each other something, or `also`.
    std::vector<int> connected(const std::vector<int>& also = {}) const {
        std::vector<int> connected = sets_of_one(bodies.props.size());
        for (const PairContacts& pair : pairs) {
            if (pair.manifold.body_a > 0) {
                unite(connected, pair.manifold.body_a, pair.manifold.body_b);
            }
        }
        for (const int body : also) {
            unite(connected, body, body + 1);
        }
        find_firsts(connected);
        return connected;
    }
    /// Of each body [m/s], where half kicks have made these of their velocities, and all impulses those.
    std::vector<double> cut(std::vector<double> at_node, const std::vector<double>& after, const std::vector<int>& loaded) const {
        std::vector<Velocity> velocity = bodies.velocity;
        std::vector<Velocity> of_all = bodies.velocity;
        std::vector<std::size_t> own;
        for (std::size_t i = 1; i < velocity.size(); ++i) {
            own.push_back(i);
            velocity[i].v.z() = at_node[i - 1];
            of_all[i].v.z() = after[i - 1];
        }
        cut_half_kicks(bodies, own, connected(loaded), of_all, velocity);
        for (std::size_t i = 1; i < velocity.size(); ++i) {
            at_node[i - 1] = velocity[i].v.z();
        }
        return at_node;
    }
    /// Of each body, upwards [m/s].
    std::vector<double> kicked() {
        std::vector<Velocity> velocity = bodies.velocity;
        JointSolver none;
        apply_half_kicks(bodies, connected(), pairs, none, velocity);
        std::vector<double> rises;
        for (const Velocity& of : velocity) {
            rises.push_back(of.v.z());
        }
        return rises;
    }
};

} // namespace

TEST(half_kicks, a_force_has_all_of_it) {
    Column column({-0.02});
    column.owe(0, 0.02 * column.mass(1));
    EXPECT_NEAR(column.kicked()[1], 0.0, 1e-15);
    EXPECT_NEAR(column.pairs[0].owed_impulse.norm(), 0.02 * column.mass(1), 1e-15);
}

/// What has left is not pushed again, and what more than turns round only turns round.
TEST(half_kicks, a_push_has_none_that_gives_energy) {
    Column column({0.5});
    column.owe(0, 0.02 * column.mass(1));
    EXPECT_EQ(column.kicked()[1], 0.5);
    EXPECT_EQ(column.pairs[0].owed_impulse, Vec3::Zero());
    Column turned({-0.5});
    turned.owe(0, 3.0 * turned.mass(1));
    EXPECT_NEAR(turned.kicked()[1], 0.5, 1e-15);
}

/// The upper one's half kick pushes the lower one down, which alone would give energy; the floor's makes up for it.
TEST(half_kicks, bodies_that_loads_connect_are_judged_together) {
    Column column({-0.02, -0.02});
    column.owe(0, 0.04 * column.mass(1));
    column.owe(1, 0.02 * column.mass(2));
    EXPECT_NEAR(column.kicked()[1], 0.0, 1e-15);
    Column apart({0.5, 0.0, -0.02});
    apart.owe(0, 0.1 * apart.mass(1));
    apart.owe(2, 0.01 * apart.mass(3));
    EXPECT_EQ(apart.kicked(), (std::vector<double>{0.0, 0.5, -0.01, -0.01}));
}

/// Half of what turns a body round leaves it at rest; what is half of it for one and nothing for the other is as good.
TEST(half_kicks, an_instant_between_velocities_has_all_of_them) {
    const std::vector<double> half{0.0, -0.01};
    EXPECT_EQ(Column({-0.01, -0.01}).cut(half, {0.01, 0.01}, {1}), half);
}

/// Three times that, for what holds against it has borne nothing before, would throw both.
TEST(half_kicks, an_instant_has_no_more_energy_than_before_and_after_it) {
    const std::vector<double> rises = Column({-0.01, 0.0}).cut({0.03, 0.01}, {0.01, 0.005}, {1});
    EXPECT_NEAR(rises[0] * rises[0] + rises[1] * rises[1], 0.01 * 0.01 + 0.005 * 0.005, 1e-18);
    EXPECT_NEAR((rises[0] + 0.01) / rises[1], 4.0, 1e-12);
    const std::vector<double> apart = Column({-0.01, 0.0}).cut({0.0, 0.01}, {0.01, 0.005}, {});
    EXPECT_EQ(apart[0], 0.0);
    EXPECT_NEAR(apart[1], 0.005, 1e-15);
}
