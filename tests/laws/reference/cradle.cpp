#include "tests/laws/reference/cradle.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace reference {
namespace {

constexpr double longest_step = 2e-5;         // [s] Runge and Kutta's error at 4 rad/s: 1e-20 a step
constexpr double touching_gap = 1e-14;    // [m]
constexpr double approaching = 1e-10; // [m/s] less is rounding
constexpr int bisections = 60;

/// What two balls do to each other along the line of their centres.
struct Meeting {
    double gap = 0.0;      ///< [m]
    double approach = 0.0; ///< [m/s]
    double arm = 0.0;      ///< [m] of the line about the first hinge
    double next_arm = 0.0; ///< [m] about the second
};

Meeting meeting(const Cradle& c, const CradleState& s, std::size_t i) {
    const double sine = std::sin(s.angle[i]), next_sine = std::sin(s.angle[i + 1]);
    const double cosine = std::cos(s.angle[i]), next_cosine = std::cos(s.angle[i + 1]);
    const double dx = c.spacing + c.length * (next_sine - sine);
    const double dz = c.length * (cosine - next_cosine);
    const double distance = std::hypot(dx, dz);
    Meeting m;
    m.gap = distance - 2 * c.radius;
    m.arm = c.length * (dx * cosine + dz * sine) / distance;
    m.next_arm = c.length * (dx * next_cosine + dz * next_sine) / distance;
    m.approach = s.rate[i] * m.arm - s.rate[i + 1] * m.next_arm;
    return m;
}

/// One step of Runge and Kutta for each ball.
CradleState moved(const Cradle& c, CradleState s, double h) {
    const double square = c.gravity * c.length / (c.length * c.length + 0.4 * c.radius * c.radius); // [1/s^2]
    for (std::size_t i = 0; i < s.angle.size(); ++i) {
        const double q = s.angle[i], w = s.rate[i];
        const double w2 = w - 0.5 * h * square * std::sin(q);
        const double a2 = -square * std::sin(q + 0.5 * h * w);
        const double w3 = w + 0.5 * h * a2;
        const double a3 = -square * std::sin(q + 0.5 * h * w2);
        const double w4 = w + h * a3;
        const double a4 = -square * std::sin(q + h * w3);
        s.angle[i] = q + h / 6 * (w + 2 * w2 + 2 * w3 + w4);
        s.rate[i] = w + h / 6 * (-square * std::sin(q) + 2 * a2 + 2 * a3 + a4);
    }
    return s;
}

/// Do two balls overlap that come nearer?
bool any_passed(const Cradle& c, const CradleState& s) {
    for (std::size_t i = 0; i + 1 < s.angle.size(); ++i) {
        const Meeting m = meeting(c, s, i);
        if (m.gap < -touching_gap && m.approach > approaching) {
            return true;
        }
    }
    return false;
}

/// Impacts of all that touch, pair by pair, until none comes nearer.
void collide(const Cradle& c, CradleState& s) {
    for (bool again = true; again;) {
        again = false;
        for (std::size_t i = 0; i + 1 < s.angle.size(); ++i) {
            const Meeting m = meeting(c, s, i);
            if (m.gap <= touching_gap && m.approach > approaching) {
                const double impulse = 2 * m.approach / (m.arm * m.arm + m.next_arm * m.next_arm); // over I
                s.rate[i] -= impulse * m.arm;
                s.rate[i + 1] += impulse * m.next_arm;
                ++s.impacts;
                again = true;
            }
        }
    }
}

} // namespace

double cradle_gap(const Cradle& cradle, const CradleState& state, int i) {
    return meeting(cradle, state, static_cast<std::size_t>(i)).gap;
}

void integrate_cradle(const Cradle& cradle, CradleState& state, double duration) {
    collide(cradle, state);
    for (double t = 0.0; t < duration;) {
        double h = std::min(longest_step, duration - t);
        CradleState next = moved(cradle, state, h);
        if (any_passed(cradle, next)) {
            double early = 0.0;
            for (int i = 0; i < bisections; ++i) {
                const double middle = 0.5 * (early + h);
                (any_passed(cradle, moved(cradle, state, middle)) ? h : early) = middle;
            }
            // Just past the touch, where `collide` sees it.
            next = moved(cradle, state, h);
        }
        t = duration - t <= h ? duration : t + h;
        state = std::move(next);
        collide(cradle, state);
    }
}

} // namespace reference
