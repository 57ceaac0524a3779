#include "sim/base/random.h"
#include "sim/collide/narrow_phase.h"
#include "sim/model/polytope.h"
#include "sim/model/shape.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace sim;

namespace {

const Quat some_turn = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));

/// Rounding of some tens of operations.
constexpr double relative_rounding = 1e-13;

void expect_near(const Mat3& found, const Mat3& expected) {
    EXPECT_LE((found - expected).norm(), relative_rounding * expected.norm()) << found << "\n\n" << expected;
}

/// Largest coordinates of points spread over a primitive's surface, in the world.
struct Sampled {
    Vec3 lower = Vec3::Constant(1e300);
    Vec3 upper = Vec3::Constant(-1e300);
    void add(const Vec3& x) {
        lower = lower.cwiseMin(x);
        upper = upper.cwiseMax(x);
    }
};

void sample(const Box& box, const Pose& pose, Sampled& sampled) {
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        sampled.add(pose * sign.cwiseProduct(box.half_extents));
    }
}

void sample(const Sphere& sphere, const Pose& pose, Sampled& sampled) {
    // 400 x 800 directions: the farthest of them misses the pole by at most r (pi/800)^2.
    for (int i = 0; i <= 400; ++i) {
        for (int j = 0; j < 800; ++j) {
            const double polar = std::numbers::pi * i / 400;
            const double azimuth = 2 * std::numbers::pi * j / 800;
            sampled.add(pose * (sphere.radius * Vec3(std::sin(polar) * std::cos(azimuth),
                                                     std::sin(polar) * std::sin(azimuth), std::cos(polar))));
        }
    }
}

Compound example_compound() {
    return {{{Sphere{0.5}, {Vec3(0.1, -0.2, 0.3), Quat::Identity()}},
             {Box{Vec3(0.2, 0.3, 0.9)}, {Vec3(-0.4, 0.1, 0.7), some_turn}}}};
}

} // namespace

TEST(shape, box_inertia_has_the_closed_form) {
    const MassProperties p = mass_properties(Box{Vec3(0.5, 1.0, 2.0)}, 3.0);
    EXPECT_DOUBLE_EQ(p.mass, 3.0 * 1 * 2 * 4);
    EXPECT_EQ(p.centre_of_mass, Vec3::Zero());
    // m/12 (b^2 + c^2) with full edges 1, 2, 4
    expect_near(p.inertia, (p.mass / 12 * Vec3(4 + 16, 1 + 16, 1 + 4)).asDiagonal().toDenseMatrix());
}

TEST(shape, sphere_inertia_has_the_closed_form) {
    const MassProperties p = mass_properties(Sphere{0.3}, 1000.0);
    EXPECT_DOUBLE_EQ(p.mass, 1000.0 * 4.0 / 3.0 * std::numbers::pi * 0.027);
    expect_near(p.inertia, Mat3::Identity() * 0.4 * p.mass * 0.09);
}

TEST(shape, two_half_boxes_are_one_box) {
    // A box of 2 x 1 x 1 cut in the middle, put together again off the origin and turned.
    const Vec3 place(3, -2, 5);
    Compound halves;
    for (const double x : {-0.5, 0.5}) {
        halves.parts.push_back({Box{Vec3(0.5, 0.5, 0.5)}, {place + some_turn * Vec3(x, 0, 0), some_turn}});
    }
    const MassProperties whole = mass_properties(Box{Vec3(1, 0.5, 0.5)}, 7.0);
    const MassProperties p = mass_properties(halves, 7.0);
    EXPECT_NEAR(p.mass, whole.mass, 1e-12);
    EXPECT_LE((p.centre_of_mass - place).norm(), 1e-14 * place.norm() * 10);
    const Mat3 r = some_turn.toRotationMatrix();
    expect_near(p.inertia, r * whole.inertia * r.transpose());
}

TEST(shape, two_spheres_follow_the_parallel_axis_theorem) {
    const double r = 0.1;
    const double distance = 0.8;
    const Compound dumbbell{{{Sphere{r}, {Vec3(0, 0, 0), Quat::Identity()}},
                             {Sphere{r}, {Vec3(0, 0, distance), Quat::Identity()}}}};
    const MassProperties p = mass_properties(dumbbell, 2000.0);
    const double m = p.mass / 2;
    EXPECT_NEAR(p.centre_of_mass.z(), distance / 2, 1e-15);
    EXPECT_NEAR(p.inertia(0, 0), 2 * (0.4 * m * r * r + m * distance * distance / 4),
                1e-12 * p.inertia(0, 0));
    EXPECT_NEAR(p.inertia(2, 2), 2 * 0.4 * m * r * r, 1e-12 * p.inertia(2, 2));
}

/// Corners at the origin and at 1 on each axis.
Shape tetrahedron() {
    const std::vector<Vec3> points{Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    return Hull{std::make_shared<const Polytope>(*convex_hull(points))};
}

TEST(shape, cylinder_and_capsule_inertia_have_the_closed_form) {
    const MassProperties cylinder = mass_properties(Cylinder{0.5, 1.0}, 100.0);
    const double m = 100.0 * std::numbers::pi * 0.25 * 2.0;
    EXPECT_DOUBLE_EQ(cylinder.mass, m);
    EXPECT_DOUBLE_EQ(cylinder.inertia(2, 2), m * 0.125);
    EXPECT_DOUBLE_EQ(cylinder.inertia(0, 0), m * (3.0 * 0.25 + 4.0) / 12.0);

    // A capsule without length is a ball; a long one is cut into slices of discs: Simpson's rule is exact for the
    // polynomials in z that the half balls are.
    const MassProperties ball = mass_properties(Capsule{0.3, 1e-16}, 100.0);
    expect_near(ball.inertia, mass_properties(Sphere{0.3}, 100.0).inertia);
    const double r = 0.3;
    const double l = 0.8;
    const MassProperties capsule = mass_properties(Capsule{r, l}, 100.0);
    const auto slices = [&](auto f) {
        double sum = 0.0;
        constexpr int n = 1000;
        for (int i = 0; i <= n; ++i) {
            const double s = r * i / n;
            sum += (i == 0 || i == n ? 1.0 : i % 2 == 0 ? 2.0 : 4.0) * f(r * r - s * s, l + s) * r / n / 3.0;
        }
        return 2.0 * 100.0 * std::numbers::pi * sum;
    };
    const double cylinder_mass = 100.0 * std::numbers::pi * r * r * 2.0 * l;
    EXPECT_NEAR(capsule.mass, cylinder_mass + slices([](double r2, double) { return r2; }), 1e-9);
    EXPECT_NEAR(capsule.inertia(2, 2),
                0.5 * cylinder_mass * r * r + slices([](double r2, double) { return 0.5 * r2 * r2; }), 1e-9);
    EXPECT_NEAR(capsule.inertia(0, 0),
                cylinder_mass * (r * r / 4.0 + l * l / 3.0) +
                    slices([](double r2, double z) { return r2 * (0.25 * r2 + z * z); }),
                1e-9);
}

TEST(shape, tetrahedron_and_cube_of_points_have_the_closed_form) {
    const MassProperties corner = mass_properties(tetrahedron(), 600.0);
    EXPECT_DOUBLE_EQ(corner.mass, 100.0);
    EXPECT_LE((corner.centre_of_mass - Vec3::Constant(0.25)).norm(), 1e-15);
    EXPECT_NEAR(corner.inertia(0, 0), 100.0 * 3.0 / 40.0, 1e-12);
    EXPECT_NEAR(corner.inertia(0, 1), 100.0 / 80.0, 1e-12);

    // A box whose corners come in any order, with points on its faces, edges and inside.
    std::vector<Vec3> points;
    for (int i = 0; i < 125; ++i) {
        const int k = i * 52 % 125;
        points.emplace_back(0.25 * (k % 5), 0.5 * (k / 5 % 5), 0.75 * (k / 25) + 3.0);
    }
    const Polytope box = *convex_hull(points);
    EXPECT_EQ(box.vertices.size(), 8u);
    EXPECT_EQ(box.edges.size(), 12u);
    EXPECT_EQ(box.faces.size(), 6u);
    const MassProperties of_points = mass_properties(Hull{std::make_shared<const Polytope>(box)}, 10.0);
    const MassProperties expected = mass_properties(Box{Vec3(0.5, 1.0, 1.5)}, 10.0);
    EXPECT_DOUBLE_EQ(of_points.mass, expected.mass);
    EXPECT_LE((of_points.centre_of_mass - Vec3(0.5, 1.0, 4.5)).norm(), 1e-14);
    expect_near(of_points.inertia, expected.inertia);
}

TEST(shape, hull_of_random_points_holds_them_all_and_is_closed) {
    Random random(5);
    for (const int count : {4, 5, 20, 200}) {
        std::vector<Vec3> points;
        for (int i = 0; i < count; ++i) {
            points.push_back(random.direction() * random.uniform());
        }
        const Polytope hull = *convex_hull(points);
        EXPECT_EQ(hull.vertices.size() + hull.faces.size(), hull.edges.size() + 2); // Euler
        for (const Polytope::Face& face : hull.faces) {
            const Vec3& on_face = hull.vertices[static_cast<std::size_t>(face.loop[0])];
            for (const Vec3& point : points) {
                EXPECT_LE(face.normal.dot(point - on_face), 1e-12);
            }
        }
    }
    EXPECT_FALSE(convex_hull(std::vector<Vec3>(9, Vec3(1, 2, 3))));
    EXPECT_FALSE(convex_hull(std::vector<Vec3>{Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(2, 2, 2), Vec3(3, 3, 3)}));
}

TEST(shape, shifted_to_its_centre_of_mass_has_it_at_the_origin) {
    const Shape shape = example_compound();
    const MassProperties before = mass_properties(shape, 500.0);
    const MassProperties after = mass_properties(shifted(shape, before.centre_of_mass), 500.0);
    EXPECT_LE(after.centre_of_mass.norm(), 1e-15);
    expect_near(after.inertia, before.inertia);
}

TEST(shape, shifting_keeps_the_place_in_the_world) {
    const Vec3 origin(0.3, -0.1, 0.2);
    for (const Shape& shape : {Shape(Box{Vec3(1, 2, 3)}), Shape(Sphere{0.7}), Shape(example_compound()),
                               Shape(Cylinder{0.4, 0.9}), Shape(Capsule{0.2, 0.5}), tetrahedron()}) {
        const Pose pose{Vec3(4, 5, 6), some_turn};
        const Pose moved{pose * origin, some_turn};
        const Bounds a = bounds(shape, pose);
        const Bounds b = bounds(shifted(shape, origin), moved);
        EXPECT_LE((a.lower - b.lower).norm(), 1e-14);
        EXPECT_LE((a.upper - b.upper).norm(), 1e-14);
        EXPECT_EQ(shifted(shape, Vec3::Zero()).index(), shape.index());
    }
}

TEST(shape, bounds_are_those_of_sampled_surfaces) {
    const Pose pose{Vec3(-1, 2, 0.5), some_turn};
    const Box box{Vec3(0.5, 1.0, 0.25)};
    const Sphere sphere{0.4};
    const Compound compound = example_compound();

    Sampled of_box;
    sample(box, pose, of_box);
    EXPECT_LE((bounds(box, pose).lower - of_box.lower).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LE((bounds(box, pose).upper - of_box.upper).cwiseAbs().maxCoeff(), 1e-14);

    // Spheres: the samples miss the extreme point by r (pi/800)^2 = 1.5e-5 r at most.
    Sampled of_sphere;
    sample(sphere, pose, of_sphere);
    EXPECT_LE((bounds(sphere, pose).lower - of_sphere.lower).cwiseAbs().maxCoeff(), 1.6e-5 * sphere.radius);
    EXPECT_LE((bounds(sphere, pose).upper - of_sphere.upper).cwiseAbs().maxCoeff(), 1.6e-5 * sphere.radius);

    Sampled of_compound;
    for (const CompoundPart& part : compound.parts) {
        const Pose world_from_part{pose * part.body_from_part.position,
                                   pose.orientation * part.body_from_part.orientation};
        if (const Box* part_box = std::get_if<Box>(&part.shape)) {
            sample(*part_box, world_from_part, of_compound);
        } else {
            sample(std::get<Sphere>(part.shape), world_from_part, of_compound);
        }
    }
    EXPECT_LE((bounds(compound, pose).lower - of_compound.lower).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_LE((bounds(compound, pose).upper - of_compound.upper).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(shape, bounds_of_cylinder_capsule_and_hull_are_how_far_they_reach) {
    const Pose pose{Vec3(-1, 2, 0.5), some_turn};
    for (const Shape& shape : {Shape(Cylinder{0.4, 0.9}), Shape(Capsule{0.2, 0.5}), tetrahedron()}) {
        const Bounds b = bounds(shape, pose);
        for (int axis = 0; axis < 3; ++axis) {
            // A plane at the bound touches the shape.
            const Vec3 n = Vec3::Unit(axis);
            EXPECT_NEAR(separation({shape, pose}, {Plane{}, {b.lower, rotation_between(Vec3::UnitZ(), n)}}),
                        0.0, 1e-14);
            EXPECT_NEAR(separation({shape, pose}, {Plane{}, {b.upper, rotation_between(Vec3::UnitZ(), -n)}}),
                        0.0, 1e-14);
        }
    }
}

TEST(shape, plane_is_unbounded) {
    const Bounds b = bounds(Plane{}, Pose{});
    EXPECT_TRUE((b.lower.array() == -std::numeric_limits<double>::infinity()).all());
    EXPECT_TRUE((b.upper.array() == std::numeric_limits<double>::infinity()).all());
}

TEST(shape, json_reads_back_to_the_same_doubles) {
    EXPECT_EQ(shape_to_json(Plane{}), R"({"kind":"plane"})");
    EXPECT_EQ(shape_to_json(Sphere{0.1}), R"({"kind":"sphere","radius":0.1})");
    EXPECT_EQ(shape_to_json(Cylinder{0.5, 2}), R"({"kind":"cylinder","radius":0.5,"half_length":2})");
    EXPECT_EQ(shape_to_json(Capsule{0.5, 2}), R"({"kind":"capsule","radius":0.5,"half_length":2})");
    const nlohmann::json hull = nlohmann::json::parse(shape_to_json(tetrahedron()));
    EXPECT_EQ(hull["points"], nlohmann::json::parse("[[0,0,0],[1,0,0],[0,1,0],[0,0,1]]"));
    EXPECT_EQ(hull["faces"].size(), 4u);
    EXPECT_EQ(shape_to_json(Box{Vec3(0.5, 1, 2)}), R"({"kind":"box","half_extents":[0.5,1,2]})");

    const Compound compound = example_compound();
    const nlohmann::json json = nlohmann::json::parse(shape_to_json(compound));
    EXPECT_EQ(json["kind"], "compound");
    ASSERT_EQ(json["parts"].size(), 2u);
    const nlohmann::json& part = json["parts"][1];
    EXPECT_EQ(part["kind"], "box");
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(part["position"][i].get<double>(), compound.parts[1].body_from_part.position[i]);
    }
    EXPECT_EQ(part["orientation"][0].get<double>(), some_turn.w());
    EXPECT_EQ(part["orientation"][3].get<double>(), some_turn.z());
}
