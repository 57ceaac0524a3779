#include "tests/laws/reference/top.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace reference {
namespace {

using Vector = Eigen::Vector3d;

const Vector up = Vector::UnitZ();

const TopContact& contact(const Top& top, int j) {
    return j == 0 ? top.bowl : top.stem;
}

Vector lowest_point(const Top& top, const TopVector& y, int j) {
    return contact(top, j).offset * y.segment<3>(6) - contact(top, j).radius * up;
}

double height(const Top& top, const TopVector& y, int j) {
    return y[2] + contact(top, j).offset * y[8] - contact(top, j).radius;
}

Vector turning(const Top& top, const TopVector& y) {
    const Vector k = y.segment<3>(6), L = y.segment<3>(9);
    return L / top.transverse + L.dot(k) * (1.0 / top.axial - 1.0 / top.transverse) * k;
}

/// Velocity of the material point at the lowest point of contact j [m/s].
Vector point_velocity(const Top& top, const TopVector& y, int j) {
    return y.segment<3>(3) + turning(top, y).cross(lowest_point(top, y, j));
}

/// Force of contact j for a unit normal force [-].
Vector unit_force(const Top& top, const TopVector& y, int j) {
    const Vector u = point_velocity(top, y, j);
    const double slip = std::hypot(u.x(), u.y(), top.slip_scale);
    return up - top.mu * Vector(u.x(), u.y(), 0.0) / slip;
}

/// Vertical acceleration of the sphere's centre of contact i from a force at contact j [1/kg].
double response(const Top& top, const TopVector& y, int i, int j, const Vector& force) {
    const Vector torque = lowest_point(top, y, j).cross(force);
    return force.z() / top.mass +
           contact(top, i).offset * torque.cross(Vector(y.segment<3>(6))).z() / top.transverse;
}

/// The same without contact forces [m/s^2].
double free_response(const Top& top, const TopVector& y, int i) {
    const Vector k = y.segment<3>(6), L = y.segment<3>(9);
    return -top.gravity +
           contact(top, i).offset * L.cross(L.cross(k)).z() / (top.transverse * top.transverse);
}

/// Normal forces [N] that keep the touching contacts at their height; 0 for the others.
Eigen::Vector2d normal_forces(const Top& top, const TopVector& y, const std::array<bool, 2>& touching) {
    Eigen::Matrix2d m = Eigen::Matrix2d::Identity();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (int i = 0; i < 2; ++i) {
        if (!touching[i]) {
            continue;
        }
        b[i] = -free_response(top, y, i);
        for (int j = 0; j < 2; ++j) {
            m(i, j) = touching[j] ? response(top, y, i, j, unit_force(top, y, j)) : 0.0;
        }
    }
    return m.partialPivLu().solve(b);
}

/// dy/dt under given normal forces [N].
TopVector rate(const Top& top, const TopVector& y, const Eigen::Vector2d& normal) {
    TopVector dy = TopVector::Zero();
    dy.segment<3>(0) = y.segment<3>(3);
    dy.segment<3>(3) = -top.gravity * up;
    dy.segment<3>(6) = Vector(y.segment<3>(9)).cross(Vector(y.segment<3>(6))) / top.transverse;
    for (int j = 0; j < 2; ++j) {
        if (normal[j] != 0.0) {
            const Vector force = normal[j] * unit_force(top, y, j);
            dy.segment<3>(3) += force / top.mass;
            dy.segment<3>(9) += lowest_point(top, y, j).cross(force);
        }
    }
    return dy;
}

/// Impact without rebound (e = 0) of contact `hit`, in the manner of Darboux and Keller: the velocities are
/// followed while the normal impulse of the hit grows, friction against the slip of the moment, until the
/// approach has stopped. The other contact, if it touches, gives what keeps it from going in.
void resolve_impact(const Top& top, TopState& state, int hit, const OdeSettings& settings) {
    const int other = 1 - hit;
    const auto impulse_rate = [&](const TopVector& y) {
        Eigen::Vector2d normal = Eigen::Vector2d::Zero();
        normal[hit] = 1.0;
        if (state.touching[other] && point_velocity(top, y, other).z() <= 1e-12) {
            const double push = response(top, y, other, hit, unit_force(top, y, hit));
            normal[other] = std::max(0.0, -push / response(top, y, other, other, unit_force(top, y, other)));
        }
        TopVector dy = rate(top, y, normal);
        dy.segment<3>(0).setZero();
        dy.segment<3>(3) += top.gravity * up; // no time passes: no gravity, no motion
        dy.segment<3>(6).setZero();
        return dy;
    };
    // The approach speed in units of the impulse that stops it bounds the length of the integration.
    const double approach = -point_velocity(top, state.y, hit).z();
    OdeSettings fine = settings;
    fine.first_step = fine.largest_step = 1e-3 * top.mass * approach;
    fine.smallest_step = 1e-12 * top.mass * approach;
    fine.tolerance = std::max(settings.tolerance, 1e-10);
    integrate<12>(
        impulse_rate, state.y, 1e3 * top.mass * approach, fine,
        [&](const TopVector& y) { return -point_velocity(top, y, hit).z(); },
        [](double, const TopVector&) {});
    state.touching[hit] = true;
    if (point_velocity(top, state.y, other).z() > 1e-9) {
        state.touching[other] = false;
    }
}

/// Drops contacts whose normal force would pull.
void release(const Top& top, TopState& state) {
    for (int round = 0; round < 2; ++round) {
        const Eigen::Vector2d normal = normal_forces(top, state.y, state.touching);
        const int worst = normal[0] < normal[1] ? 0 : 1;
        if (normal[worst] >= 0.0) {
            return;
        }
        state.touching[worst] = false;
    }
}

/// Smallest of what must stay positive until the set of contacts changes: the height of a contact that is
/// away, and the force of one that touches, both made comparable by the radius and the weight.
double change_of_contacts(const Top& top, const TopVector& y, const std::array<bool, 2>& touching) {
    const Eigen::Vector2d normal = normal_forces(top, y, touching);
    double smallest = 1.0;
    for (int j = 0; j < 2; ++j) {
        const double value =
            touching[j] ? normal[j] / (top.mass * top.gravity) : height(top, y, j) / top.bowl.radius;
        smallest = std::min(smallest, value);
    }
    return smallest;
}

/// Records what one accepted step shows.
struct Recorder {
    const Top& top;
    TopResult& result;
    double jellett_at_start;
    TopState before;
    double time_before = 0.0;

    void step(double time, const TopState& now, bool stem_has_touched) {
        result.smallest_axis_z = std::min(result.smallest_axis_z, now.y[8]);
        if (result.time_to_90_degrees == TopResult::never && before.y[8] > 0.0 && now.y[8] <= 0.0) {
            locate_horizontal(time, now);
        }
        if (!stem_has_touched) {
            const double error = std::abs(jellett(top, now) / jellett_at_start - 1.0);
            result.largest_jellett_error = std::max(result.largest_jellett_error, error);
            result.largest_height_error =
                std::max(result.largest_height_error, std::abs(height(top, now.y, 0)));
            const Vector u = point_velocity(top, now.y, 0);
            result.smallest_slip = std::min(result.smallest_slip, std::hypot(u.x(), u.y()));
        }
        before = now;
        time_before = time;
    }

    /// The axis' height over the last step as a cubic through its ends' values and slopes.
    void locate_horizontal(double time, const TopState& now) {
        const auto slope = [&](const TopState& s) {
            return s.angular_momentum().cross(s.axis()).z() / top.transverse;
        };
        const double h = time - time_before, m0 = h * slope(before), m1 = h * slope(now);
        const double y0 = before.y[8], y1 = now.y[8];
        double low = 0.0, high = 1.0;
        for (int i = 0; i < 60; ++i) {
            const double s = 0.5 * (low + high), r = 1.0 - s;
            const double value =
                r * r * (1 + 2 * s) * y0 + s * r * r * m0 + s * s * (3 - 2 * s) * y1 - s * s * r * m1;
            (value > 0.0 ? low : high) = s;
        }
        result.time_to_90_degrees = time_before + high * h;
    }
};

} // namespace

TopState tilted_top(const Top& top, double spin, double tilt) {
    TopState state;
    const Vector k(std::sin(tilt), 0.0, std::cos(tilt));
    const Vector w(0.0, 0.0, spin);
    state.y.segment<3>(6) = k;
    state.y.segment<3>(9) = top.transverse * w + (top.axial - top.transverse) * w.dot(k) * k;
    state.y[2] = top.bowl.radius - top.bowl.offset * k.z();
    return state;
}

double jellett(const Top& top, const TopState& state) {
    return -state.angular_momentum().dot(lowest_point(top, state.y, 0));
}

Eigen::Vector3d angular_velocity(const Top& top, const TopState& state) {
    return turning(top, state.y);
}

double energy(const Top& top, const TopState& state) {
    return 0.5 * top.mass * state.velocity().squaredNorm() +
           0.5 * state.angular_momentum().dot(turning(top, state.y)) + top.mass * top.gravity * state.y[2];
}

TopResult integrate_top(const Top& top, TopState state, double duration, bool until_stem,
                        const OdeSettings& settings) {
    TopResult result;
    Recorder recorder{top, result, jellett(top, state), state};
    bool stem_has_touched = false;
    double time = 0.0;
    while (time < duration) {
        const std::array<bool, 2> touching = state.touching;
        const double start = time;
        time +=
            integrate<12>([&](const TopVector& y) { return rate(top, y, normal_forces(top, y, touching)); },
                          state.y, duration - time, settings,
                          [&](const TopVector& y) { return change_of_contacts(top, y, touching); },
                          [&](double t, const TopVector& y) {
                              recorder.step(start + t, {y, touching}, stem_has_touched);
                          });
        if (time >= duration) {
            break;
        }
        for (int j = 0; j < 2; ++j) {
            if (!touching[j] && height(top, state.y, j) <= 0.0) {
                if (j == 1 && !stem_has_touched) {
                    stem_has_touched = true;
                    result.time_to_stem_contact = time;
                }
                resolve_impact(top, state, j, settings);
            }
        }
        release(top, state);
        if (stem_has_touched && !state.touching[0] && touching[0]) {
            result.time_bowl_leaves = std::min(result.time_bowl_leaves, time);
        }
        if (until_stem && stem_has_touched) {
            break;
        }
        recorder.before.y = state.y;
        recorder.time_before = time;
    }
    result.end = state;
    return result;
}

} // namespace reference
