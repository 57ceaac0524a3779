#include "render/study/law.h"

#include "sim/base/error.h"
#include "sim/scene/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace study {

namespace {

using sim::BodyDef;
using sim::BodySnapshot;
using sim::Quat;
using sim::Vec3;

/// The state of one moving body at a time [s].
using Path = std::function<BodySnapshot(double)>;

[[noreturn]] void refuse(const sim::SceneDef& scene, const char* expected) {
    throw sim::Error(sim::ExitCode::usage, fmt::format("{}: study.law does not fit the scene, expected {}",
                                                       scene.name, expected));
}

double mean_of(const std::optional<double>& a, const std::optional<double>& b) {
    return a && b ? std::sqrt(*a * *b) : a.value_or(b.value_or(0.0));
}

/// The one plane and the one moving body that most laws speak of.
struct OnPlane {
    const BodyDef* plane = nullptr;
    const BodyDef* body = nullptr;
    int moving = 0;

    Vec3 normal() const { return plane->pose.orientation * Vec3::UnitZ(); }
    double mu_s() const { return mean_of(plane->material.mu_s, body->material.mu_s); }
    double mu_d() const { return mean_of(plane->material.mu_d, body->material.mu_d); }
    double restitution() const { return mean_of(plane->material.restitution, body->material.restitution); }
};

OnPlane find_bodies(const sim::SceneDef& scene) {
    OnPlane found;
    for (const BodyDef& body : scene.bodies) {
        if (!body.is_static()) {
            found.body = &body;
            ++found.moving;
        } else if (std::holds_alternative<sim::Plane>(body.shape)) {
            found.plane = &body;
        }
    }
    return found;
}

BodySnapshot start_of(const BodyDef& body) {
    return {body.pose.position, body.pose.orientation, body.velocity, body.angular_velocity};
}

constexpr double slack = 1e-9; // [-] of what rounding leaves of a right angle or of a closed gap

Path sliding_block(const sim::SceneDef& scene) {
    const OnPlane on = find_bodies(scene);
    const char* expected = "one plane and one box on it that slides along the line of greatest slope";
    if (on.plane == nullptr || on.moving != 1 || !std::holds_alternative<sim::Box>(on.body->shape)) {
        refuse(scene, expected);
    }
    const Vec3 n = on.normal(), g = scene.step.gravity, v = on.body->velocity;
    const double g_n = -g.dot(n), speed = v.norm();
    const Vec3 along = speed > 0.0 ? Vec3(v / speed) : Vec3(g + g_n * n).normalized();
    const Vec3 g_t = g + g_n * n;
    if (std::abs(v.dot(n)) > slack * speed || (g_t - g_t.dot(along) * along).norm() > slack * g_n) {
        refuse(scene, expected);
    }
    const double a = g_t.dot(along) - on.mu_d() * g_n; // [m/s^2], < 0: it stops
    const double stop = a < 0.0 ? speed / -a : INFINITY;
    if (std::isfinite(stop) && g_t.norm() > on.mu_s() * g_n) {
        refuse(scene, "static friction that holds the block where it stops");
    }
    return [start = start_of(*on.body), along, speed, a, stop](double t) {
        BodySnapshot state = start;
        const double slid = std::min(t, stop);
        state.position += (speed * slid + 0.5 * a * slid * slid) * along;
        state.velocity = t < stop ? Vec3((speed + a * t) * along) : Vec3(Vec3::Zero());
        return state;
    };
}

/// Height and speed along the normal of a ball let fall from `height` [m] with `speed` upward, after t [s].
std::pair<double, double> bounce(double height, double speed, double g, double e, double t) {
    constexpr double rest = 1e-9; // [m/s] rebounds below it are over in no time
    for (;;) {
        const double impact = std::sqrt(speed * speed + 2.0 * g * height);
        const double duration = (speed + impact) / g;
        if (t < duration) {
            return {height + speed * t - 0.5 * g * t * t, speed - g * t};
        }
        t -= duration;
        height = 0.0;
        speed = e * impact;
        if (speed < rest) {
            return {0.0, 0.0};
        }
    }
}

Path bouncing_ball(const sim::SceneDef& scene) {
    const OnPlane on = find_bodies(scene);
    if (on.plane == nullptr || on.moving != 1 || !std::holds_alternative<sim::Sphere>(on.body->shape) ||
        on.mu_d() > 0.0) {
        refuse(scene, "one level plane and one ball above it, without friction");
    }
    const Vec3 n = on.normal(), g = scene.step.gravity;
    if ((g - g.dot(n) * n).norm() > slack * g.norm() || g.dot(n) >= 0.0) {
        refuse(scene, "a level plane");
    }
    const double radius = std::get<sim::Sphere>(on.body->shape).radius;
    const double height = (on.body->pose.position - on.plane->pose.position).dot(n) - radius;
    const double speed = on.body->velocity.dot(n), e = on.restitution(), g_n = -g.dot(n);
    return [=, start = start_of(*on.body)](double t) {
        BodySnapshot state = start;
        const auto [z, v] = bounce(height, speed, g_n, e, t);
        const Vec3 level = start.velocity - speed * n;
        state.position += t * level + (z - height) * n;
        state.velocity = level + v * n;
        const Vec3& w = start.angular_velocity;
        state.orientation = Quat(Eigen::AngleAxisd(w.norm() * t, w.normalized())) * start.orientation;
        return state;
    };
}

Path rolling_ball(const sim::SceneDef& scene) {
    const OnPlane on = find_bodies(scene);
    const char* expected = "one level plane and one ball on it that turns about one axis across its way";
    if (on.plane == nullptr || on.moving != 1 || !std::holds_alternative<sim::Sphere>(on.body->shape)) {
        refuse(scene, expected);
    }
    const Vec3 n = on.normal(), g = scene.step.gravity, w = on.body->angular_velocity;
    const double radius = std::get<sim::Sphere>(on.body->shape).radius;
    const Vec3 slip = on.body->velocity - radius * w.cross(n);
    const Vec3 along = slip.norm() > 0.0 ? Vec3(slip.normalized()) : Vec3(on.body->velocity.normalized());
    const Vec3 axis = n.cross(along); // turning about it rolls along `along`
    if ((g + g.norm() * n).norm() > slack * g.norm() || (w - w.dot(axis) * axis).norm() > slack * w.norm() ||
        on.body->velocity.cross(along).norm() > slack * on.body->velocity.norm()) {
        refuse(scene, expected);
    }
    const double moment = on.body->mass.inertia(0, 0);
    const double a = on.mu_d() * g.norm();                             // [m/s^2]
    const double alpha = a * on.body->mass.mass * radius / moment;     // [rad/s^2]
    const double end = slip.norm() > 0.0 ? slip.norm() / (a + radius * alpha) : 0.0;
    return [=, start = start_of(*on.body)](double t) {
        BodySnapshot state = start;
        const double s = std::min(t, end), after = t - s;
        const double v = start.velocity.dot(along) - a * s, spin = w.dot(axis) + alpha * s;
        state.position += (start.velocity.dot(along) * s - 0.5 * a * s * s + v * after) * along;
        const double angle = w.dot(axis) * s + 0.5 * alpha * s * s + spin * after;
        state.orientation = Quat(Eigen::AngleAxisd(angle, axis)) * start.orientation;
        state.velocity = v * along;
        state.angular_velocity = spin * axis;
        return state;
    };
}

/// Angular velocity in the body's axes and orientation, and their derivatives.
struct Turning {
    Vec3 w;
    Eigen::Vector4d q; ///< w x y z
};

Turning rate(const sim::Mat3& inertia, const sim::Mat3& inverse, const Turning& at) {
    const Quat q(at.q[0], at.q[1], at.q[2], at.q[3]);
    const Quat half = q * Quat(0.0, 0.5 * at.w.x(), 0.5 * at.w.y(), 0.5 * at.w.z());
    return {inverse * -at.w.cross(inertia * at.w), {half.w(), half.x(), half.y(), half.z()}};
}

/// Runge-Kutta of the fourth order.
void advance(const sim::Mat3& inertia, const sim::Mat3& inverse, double h, Turning& at) {
    const auto moved = [&at](const Turning& d, double t) { return Turning{at.w + t * d.w, at.q + t * d.q}; };
    const Turning k1 = rate(inertia, inverse, at), k2 = rate(inertia, inverse, moved(k1, 0.5 * h)),
                  k3 = rate(inertia, inverse, moved(k2, 0.5 * h)), k4 = rate(inertia, inverse, moved(k3, h));
    at.w += h / 6.0 * (k1.w + 2.0 * k2.w + 2.0 * k3.w + k4.w);
    at.q += h / 6.0 * (k1.q + 2.0 * k2.q + 2.0 * k3.q + k4.q);
    at.q.normalize();
}

constexpr int turning_steps = 200000; // of the whole duration

/// Called with ascending times.
Path free_rotation(const sim::SceneDef& scene, double duration) {
    const OnPlane on = find_bodies(scene);
    if (on.moving != 1 || scene.step.gravity.norm() > 0.0 || on.plane != nullptr) {
        refuse(scene, "one body that touches nothing, without gravity");
    }
    const sim::Mat3 inertia = on.body->mass.inertia, inverse = inertia.inverse();
    const BodySnapshot start = start_of(*on.body);
    const Quat& q = start.orientation;
    Turning turning{q.conjugate() * start.angular_velocity, {q.w(), q.x(), q.y(), q.z()}};
    return [=, at = turning, now = 0.0](double t) mutable {
        const int steps = static_cast<int>(std::ceil((t - now) / duration * turning_steps));
        for (int i = 0; i < steps; ++i) {
            advance(inertia, inverse, (t - now) / steps, at);
        }
        now = t;
        BodySnapshot state = start;
        state.position += t * start.velocity;
        state.orientation = Quat(at.q[0], at.q[1], at.q[2], at.q[3]);
        state.angular_velocity = state.orientation * at.w;
        return state;
    };
}

Path tower(const sim::SceneDef& scene) {
    for (const BodyDef& body : scene.bodies) {
        if (body.velocity.norm() > 0.0 || body.angular_velocity.norm() > 0.0) {
            refuse(scene, "bodies that rest");
        }
    }
    return {};
}

Path path_of(const sim::SceneDef& scene, sim::Law law, double duration) {
    switch (law) {
    case sim::Law::sliding_block:
        return sliding_block(scene);
    case sim::Law::bouncing_ball:
        return bouncing_ball(scene);
    case sim::Law::rolling_ball:
        return rolling_ball(scene);
    case sim::Law::free_rotation:
        return free_rotation(scene, duration);
    case sim::Law::tower:
        return tower(scene);
    case sim::Law::none:
        break;
    }
    refuse(scene, "a law");
}

} // namespace

Motion law_motion(const sim::SceneDef& scene, sim::Law law, std::span<const double> times) {
    const Path path = path_of(scene, law, times.empty() ? 0.0 : times.back());
    Motion motion;
    for (const double time : times) {
        sim::Snapshot state;
        state.time = time;
        for (const BodyDef& body : scene.bodies) {
            state.bodies.push_back(path && !body.is_static() ? path(state.time) : start_of(body));
        }
        motion.states.push_back(std::move(state));
    }
    return motion;
}

void require_study(const sim::SceneDef& scene) {
    const sim::StudyDef def = sim::study_of(scene);
    if (def.law != sim::Law::none) {
        law_motion(scene, def.law, std::array{0.0});
    }
    if (!def.seed_key.empty()) {
        std::vector<std::string> overrides = scene.overrides;
        overrides.push_back(def.seed_key + "=1");
        sim::parse_scene(scene.text, scene.name + ".toml", overrides);
    }
}

} // namespace study
