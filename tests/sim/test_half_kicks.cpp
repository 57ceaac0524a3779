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
    std::vector<int> connected() const { return connected_by_loads(bodies, pairs); }
    /// Of each body, upwards [m/s].
    std::vector<double> kicked() {
        std::vector<Velocity> velocity = bodies.velocity;
        apply_half_kicks(bodies, connected(), pairs, velocity);
        std::vector<double> rises;
        for (const Velocity& of : velocity) {
            rises.push_back(of.v.z());
        }
        return rises;
    }
};

} // namespace

TEST(half_kicks, loads_connect_bodies_that_move) {
    Column column({0, 0, 0, 0});
    column.owe(3, 1.0);
    column.owe(0, 1.0);
    column.owe(1, 0.0);
    column.owe(2, 1.0);
    EXPECT_EQ(column.connected(), (std::vector<int>{0, 1, 2, 2, 2}));
}

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
