#pragma once
/// Scenes filled in code, for tests of the pictures: no file is read and nothing is simulated.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace sample {

/// Numbers 0..1, the same everywhere (SplitMix64).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double operator()() {
        state_ += 0x9e3779b97f4a7c15ull;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

inline void show(sim::SceneDef& scene, sim::Shown what) {
    scene.overlay.show[static_cast<std::size_t>(what)] = true;
}

inline sim::BodyDef body(sim::Shape shape, const sim::Pose& pose, const sim::Vec3& color) {
    sim::BodyDef result;
    result.shape = std::move(shape);
    result.pose = pose;
    result.look.color = color;
    return result;
}

inline sim::Quat turn(double angle, const sim::Vec3& axis) {
    return sim::Quat(Eigen::AngleAxisd(angle, axis.normalized()));
}

/// The poses of the scene's start.
inline sim::Snapshot start(const sim::SceneDef& scene, double time = 0.0) {
    sim::Snapshot snapshot;
    snapshot.time = time;
    for (const sim::BodyDef& b : scene.bodies) {
        snapshot.bodies.push_back({b.pose.position, b.pose.orientation, b.velocity, b.angular_velocity});
    }
    return snapshot;
}

/// fov_degrees of a camera whose pictures of width / height `aspect`, narrower than 16:9, open vertically by `degrees`.
inline double fov_for(double degrees, double aspect) {
    constexpr double half = std::numbers::pi / 360.0;
    return std::atan(std::tan(half * degrees) * aspect * 9.0 / 16.0) / half;
}

inline void set_camera(sim::SceneDef& scene, const sim::Vec3& eye, const sim::Vec3& target,
                       double fov_degrees) {
    sim::CameraDef camera;
    camera.fov_degrees = fov_degrees;
    camera.keys = {{0.0, eye, target}};
    scene.cameras = {camera};
}

inline void add_floor(sim::SceneDef& scene) {
    scene.light.to_sun = sim::Vec3(-0.35, -0.75, 0.85).normalized();
    scene.bodies.push_back(body(sim::Plane{}, {}, sim::floor_color));
    scene.bodies.back().look.pattern_color = sim::floor_line_color;
}

/// The funnel of the paper: four plates and a lattice of n x n x n cubes of 1 m above them.
/// spilled: as many again in a heap on the floor.
inline sim::SceneDef funnel(int n, bool spilled = false) {
    sim::SceneDef scene;
    scene.name = "funnel";
    add_floor(scene);
    // Plates from the mouth (half width 9 m, height 16 m) to the throat (2 m, 8 m), 0.5 m thick.
    const double rise = 8.0;
    const double run = 7.0;
    const double length = std::hypot(rise, run);
    for (int side = 0; side < 4; ++side) {
        const sim::Quat around = turn(side * std::numbers::pi / 2, sim::Vec3::UnitZ());
        const sim::Quat tilt = turn(-std::atan2(rise, run), sim::Vec3::UnitY());
        const sim::Vec3 inner(5.5, 0, 12);
        const sim::Vec3 outward = tilt * sim::Vec3(0, 0, -1);
        const sim::Pose pose{around * (inner + 0.25 * outward), around * tilt};
        scene.bodies.push_back(body(sim::Box{{0.5 * length, 9.4, 0.25}}, pose, sim::Vec3(0.45, 0.47, 0.5)));
        scene.bodies.back().look.roughness = 0.35;
    }
    // Okabe & Ito 2008, linear.
    const sim::Vec3 colors[] = {{0.79, 0.35, 0.0}, {0.09, 0.46, 0.81}, {0.0, 0.34, 0.17}, {0.87, 0.78, 0.05},
                                {0.0, 0.17, 0.45}, {0.66, 0.11, 0.0},  {0.6, 0.19, 0.39}};
    Random random(7);
    const auto random_axis = [&random] { return sim::Vec3(random() - 0.5, random() - 0.5, random() - 0.4); };
    for (int i = 0; i < n * n * n; ++i) {
        const sim::Vec3 cell(i % n, (i / n) % n, i / (n * n));
        const sim::Vec3 at =
            1.3 * (cell - sim::Vec3(0.5 * (n - 1), 0.5 * (n - 1), 0)) + sim::Vec3(0, 0, 17.5);
        const double angle = 0.2 * random();
        scene.bodies.push_back(body(sim::Box{}, {at, turn(angle, random_axis())}, colors[i % 7]));
        scene.bodies.back().look.roughness = 0.45;
    }
    for (int i = 0; spilled && i < n * n * n; ++i) {
        const double angle = 2 * std::numbers::pi * random();
        const double radius = 7.0 * std::sqrt(random());
        const double height = 0.5 + std::floor(random() * (7.5 - radius) * 0.6);
        const sim::Vec3 at(radius * std::cos(angle), radius * std::sin(angle), height);
        scene.bodies.push_back(body(sim::Box{}, {at, turn(3 * random(), sim::Vec3::UnitZ())}, colors[i % 7]));
        scene.bodies.back().look.roughness = 0.45;
    }
    set_camera(scene, {26, -36, 24}, {0, 0, 11}, 40);
    return scene;
}

/// Five blocks on an inclined slab.
inline sim::SceneDef incline() {
    sim::SceneDef scene;
    scene.name = "incline";
    add_floor(scene);
    const sim::Quat tilt = turn(0.5, sim::Vec3::UnitY());
    scene.bodies.push_back(body(sim::Box{{4, 2.5, 0.1}},
                                {tilt * sim::Vec3(0, 0, -0.1) + sim::Vec3(0, 0, 2.2), tilt},
                                {0.5, 0.5, 0.5}));
    const sim::Vec3 colors[] = {
        {0.79, 0.35, 0.0}, {0.09, 0.46, 0.81}, {0.0, 0.34, 0.17}, {0.87, 0.78, 0.05}, {0.6, 0.19, 0.39}};
    for (int i = 0; i < 5; ++i) {
        const sim::Vec3 at = tilt * sim::Vec3(-2.0 + 0.7 * i, -1.6 + 0.8 * i, 0.2) + sim::Vec3(0, 0, 2.2);
        scene.bodies.push_back(body(sim::Box{{0.3, 0.2, 0.2}}, {at, tilt}, colors[i]));
    }
    set_camera(scene, {5, -7.5, 4.2}, {0, 0, 1.6}, 40);
    return scene;
}

/// A tippe top of 2 cm radius with stripes, leaning on a floor.
inline sim::SceneDef tippe_top() {
    sim::SceneDef scene;
    scene.name = "tippe_top";
    add_floor(scene);
    const sim::Quat lean = turn(0.35, sim::Vec3(1, 0.4, 0));
    sim::BodyDef top = body(sim::Sphere{0.02}, {{0, 0, 0.02}, lean}, {0.66, 0.11, 0.0});
    top.look.pattern = sim::Pattern::stripes;
    top.look.pattern_color = {0.8, 0.75, 0.6};
    top.look.roughness = 0.25;
    for (int i = 0; i <= 24; ++i) {
        const double angle = 2.15 * i / 24;
        top.look.lathe.emplace_back(0.02 * std::sin(angle), -0.02 * std::cos(angle));
    }
    top.look.lathe.emplace_back(0.004, 0.0115);
    top.look.lathe.emplace_back(0.003, 0.026);
    for (int i = 0; i <= 8; ++i) {
        const double angle = std::numbers::pi / 2 * i / 8;
        top.look.lathe.emplace_back(0.003 * std::cos(angle), 0.026 + 0.003 * std::sin(angle));
    }
    scene.bodies.push_back(top);
    set_camera(scene, {0.07, -0.13, 0.075}, {0, 0, 0.019}, 30);
    return scene;
}

/// Five steel balls on two threads each, the first one raised.
inline sim::SceneDef office_toy() {
    sim::SceneDef scene;
    scene.name = "office_toy";
    add_floor(scene);
    const double r = 0.05;
    const double height = 0.45;
    scene.bodies.push_back(body(sim::Box{{0.32, 0.012, 0.012}},
                                {{0, 0, height + 0.012}, sim::Quat::Identity()}, {0.10, 0.10, 0.11}));
    for (int i = 0; i < 5; ++i) {
        const double angle = i == 0 ? 0.6 : 0.0;
        const sim::Vec3 hook((i - 2) * 2 * r, 0, height);
        const sim::Vec3 at = hook + 0.35 * sim::Vec3(-std::sin(angle), 0, -std::cos(angle));
        sim::BodyDef ball = body(sim::Sphere{r}, {at, sim::Quat::Identity()}, {0.75, 0.76, 0.78});
        ball.look.metallic = 1.0;
        ball.look.roughness = 0.2;
        scene.bodies.push_back(ball);
        sim::JointDef joint;
        joint.body_a = static_cast<int>(scene.bodies.size()) - 1;
        joint.body_b = 1;
        joint.anchor = hook;
        scene.joints.push_back(joint);
    }
    set_camera(scene, {0.55, -1.15, 0.5}, {0, 0, 0.24}, 32);
    return scene;
}

} // namespace sample
