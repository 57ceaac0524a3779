#include "sim/world/repair.h"

#include "sim/collide/narrow_phase.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

using namespace sim;

namespace {

/// Gap of a contact of a face or of crossing edges [m] as the solver measures it (solve/rest_kernel.cpp): the points, which are the
/// gap apart along n, or the edges' normal, and the face's n go with their bodies from the poses `now`.
double measured_gap(const FoundContact& contact, const std::array<Pose, 2>& now, const std::array<Pose, 2>& planned) {
    const auto carried = [&](std::size_t body, const Vec3& x) {
        return Vec3(planned[body] * (now[body].orientation.conjugate() * (x - now[body].position)));
    };
    if (contact.feature.kind == FeatureKind::edges) {
        const Vec3 apart = contact.at.gap * contact_geometry(contact.feature, now[0], now[1]).n;
        return contact_geometry(contact.feature, planned[0], planned[1])
            .n.dot(carried(0, contact.at.a) - carried(1, contact.at.a - apart));
    }
    const std::size_t face = contact.feature.kind == FeatureKind::face_a ? 0 : 1;
    const Vec3 n = planned[face].orientation * (now[face].orientation.conjugate() * contact.at.n);
    return n.dot(carried(0, contact.at.a) - carried(1, contact.at.a - contact.at.gap * contact.at.n));
}

} // namespace

TEST(repair, what_is_found_is_measured_as_it_was_found) {
    const Shape cube = Box{Vec3::Constant(0.1)};
    const double h = 1e-3;
    Numbers numbers(1);
    int faces = 0;
    int edges = 0;
    for (int trial = 0; trial < 1000; ++trial) {
        const std::array planned{numbers.pose(0.15), numbers.pose(0.15)};
        std::array<Pose, 2> now;
        for (std::size_t i = 0; i < 2; ++i) {
            now[i] = {planned[i].position - h * numbers.vector(5.0), turned(planned[i].orientation, h * numbers.vector(20.0))};
        }
        std::vector<FoundContact> contacts;
        find_contacts({cube, planned[0]}, {cube, planned[1]}, 0.0, contacts);
        for (const FoundContact& found : contacts) {
            const bool is_edges = found.feature.kind == FeatureKind::edges;
            FoundContact before = found;
            before.at = moved_back(found, planned[0], planned[1], now[0], now[1]);
            // Normals of a face agree to 1e-9; those of edges, now and then, to the square of what the bodies turn.
            EXPECT_NEAR(measured_gap(before, now, planned), found.at.gap, is_edges ? 3e-3 * std::abs(before.at.gap) : 2e-7) << trial;
            ++(is_edges ? edges : faces);
        }
    }
    EXPECT_GT(faces, 100);
    EXPECT_GT(edges, 20);
}
