/// The rattleback of the film against rolling without slipping, integrated here: its spin as it turns round, and that it does
/// so one way only.
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"
#include "tests/laws/reference/ode.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace {

using namespace laws;
using sim::Mat3;

/// Place of the centre of mass [m], orientation (w, x, y, z) and angular velocity [rad/s] in the world.
using RollingState = Eigen::Matrix<double, 10, 1>;

/// A capsule that rolls on a ball.
struct Rattleback {
    double mass = 0.0; ///< [kg]
    Mat3 inertia;      ///< [kg m^2]
    Vec3 middle;       ///< of the capsule [m]; with `axis` in the body's frame
    Vec3 axis;
    double radius = 0.0; ///< [m] of the capsule
    Vec3 ball;           ///< its centre [m]

    struct Touch {
        Vec3 arm;      ///< r, from the centre of mass [m]
        Vec3 arm_rate; ///< dr/dt: the place of touch wanders over both bodies [m/s]
    };

    /// Where it rolls, it does not move.
    Touch touch(const Vec3& position, const Quat& turn, const Vec3& w) const {
        const Vec3 a = turn * axis, p = position + turn * middle;
        const double s = (ball - p).dot(a);
        const Vec3 d = p + s * a - ball; // from the ball's centre to the capsule's nearest point within
        const Vec3 n = d.normalized();
        const Vec3 to_touch = ball + d - radius * n - position;
        const Vec3 v = -w.cross(to_touch);
        const Vec3 p_rate = v + w.cross(turn * middle), a_rate = w.cross(a);
        const Vec3 d_rate = p_rate + ((ball - p).dot(a_rate) - p_rate.dot(a)) * a + s * a_rate;
        return {to_touch, d_rate - radius / d.norm() * (d_rate - n.dot(d_rate) * n) - v};
    }

    /// m dv/dt = F + m g, dL/dt = r x F and v = -w x r, so that F falls out.
    RollingState rate(const RollingState& y) const {
        const Quat turn = Quat(y[3], y[4], y[5], y[6]).normalized();
        const Vec3 w = y.tail<3>();
        const Touch at = touch(y.head<3>(), turn, w);
        const Vec3& r = at.arm;
        const Mat3 inertia_world = turn.toRotationMatrix() * inertia * turn.toRotationMatrix().transpose();
        const Mat3 about_touch = inertia_world + mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
        const Vec3 torque = -mass * r.cross(w.cross(at.arm_rate) + Vec3(0, 0, -g)) - w.cross(inertia_world * w);
        const Quat turning = Quat(0, w.x(), w.y(), w.z()) * turn;
        RollingState result;
        result << -w.cross(r), 0.5 * turning.w(), 0.5 * turning.vec(), about_touch.ldlt().solve(torque);
        return result;
    }
};

struct RattlebackFilm {
    sim::SceneDef scene;
    Rattleback model;
    std::size_t body = 2;

    RattlebackFilm(Rational h, double spin) : scene(sim::load_scene(std::filesystem::path(TUMBLE_SCENE_DIR) / "rattleback.toml")) {
        scene.step.time_step = h;
        sim::BodyDef& def = scene.bodies[body];
        const sim::CompoundPart& part = std::get<sim::Compound>(def.shape).parts[0];
        model = {def.mass.mass, def.mass.inertia, part.body_from_part.position, part.body_from_part.orientation * Vec3::UnitZ(),
                 std::get<sim::Capsule>(part.shape).radius, scene.bodies[1].pose.position};
        def.angular_velocity = Vec3(0, 0, spin);
        def.velocity = -def.angular_velocity.cross(model.touch(def.pose.position, def.pose.orientation, def.angular_velocity).arm);
    }

    RollingState start() const {
        const sim::BodyDef& def = scene.bodies[body];
        RollingState y;
        y << def.pose.position, def.pose.orientation.w(), def.pose.orientation.vec(), def.angular_velocity;
        return y;
    }
};

TEST(law_rattleback, it_turns_round_as_one_that_rolls_without_slipping) {
    const double duration = 6.0, look = 0.5; // [s]
    const RattlebackFilm film(microseconds(1000), -3.0);
    std::vector<double> spins;
    RollingState y = film.start();
    for (int i = 0; i < static_cast<int>(duration / look); ++i) {
        reference::integrate<10>([&](const RollingState& at) { return film.model.rate(at); }, y, look, {.tolerance = 1e-9},
                                 [](const RollingState&) { return 1.0; }, [](double, const RollingState&) {});
        spins.push_back(y[9]);
    }
    EXPECT_GT(spins.back(), 0.5); // it began with -3
    const Convergence c = converge("rattleback", "spin, worst of 6 s [rad/s]", 1e-3,
                                   {microseconds(1000), microseconds(500), microseconds(250)}, [&](Rational h) {
        const RattlebackFilm ours(h, -3.0);
        sim::World world(ours.scene);
        double worst = 0.0;
        std::size_t next = 0;
        run(world, ours.scene, duration, [&](const sim::Snapshot& s, const sim::StepReport&) {
            if (s.time > look * static_cast<double>(next + 1) - 1e-9 && next < spins.size()) {
                worst = std::max(worst, std::abs(s.bodies[ours.body].angular_velocity.z() - spins[next++]));
            }
            return true;
        });
        return worst;
    });
    EXPECT_LT(c.errors.front(), 1e-3); // friction of its points is not the model's rolling: nearer it does not come
}

TEST(law_rattleback, the_other_way_it_goes_on) {
    const RattlebackFilm film(microseconds(500), 3.0);
    sim::World world(film.scene);
    double least = 3.0;
    run(world, film.scene, 6.0, [&](const sim::Snapshot& s, const sim::StepReport&) {
        least = std::min(least, s.bodies[film.body].angular_velocity.z());
        return true;
    });
    EXPECT_GT(least, 2.9);
}

} // namespace
