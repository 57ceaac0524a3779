#pragma once
/// Adaptive Runge-Kutta integration (Dormand & Prince 1980, order 5 with an embedded order 4), for
/// references.
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace reference {

struct OdeSettings {
    double tolerance = 1e-12;     ///< [-] error of one step, relative to 1 + |y|
    double first_step = 1e-6;     ///< [s]
    double largest_step = 1e-3;   ///< [s]
    double smallest_step = 1e-14; ///< [s]; a step that would have to be smaller throws
};

/// One step of length s and the estimate of its error, relative to 1 + |y|.
template <int N>
struct OdeStep {
    Eigen::Matrix<double, N, 1> y;
    double error = 0.0; ///< [-]
};

/// f(y) -> dy/dt, autonomous.
template <int N, class Rate>
OdeStep<N> dormand_prince(const Rate& f, const Eigen::Matrix<double, N, 1>& y, double s) {
    using State = Eigen::Matrix<double, N, 1>;
    const State k1 = f(y);
    const State k2 = f(y + s * (1.0 / 5) * k1);
    const State k3 = f(y + s * (3.0 / 40 * k1 + 9.0 / 40 * k2));
    const State k4 = f(y + s * (44.0 / 45 * k1 - 56.0 / 15 * k2 + 32.0 / 9 * k3));
    const State k5 =
        f(y + s * (19372.0 / 6561 * k1 - 25360.0 / 2187 * k2 + 64448.0 / 6561 * k3 - 212.0 / 729 * k4));
    const State k6 = f(y + s * (9017.0 / 3168 * k1 - 355.0 / 33 * k2 + 46732.0 / 5247 * k3 + 49.0 / 176 * k4 -
                                5103.0 / 18656 * k5));
    OdeStep<N> step;
    step.y = y + s * (35.0 / 384 * k1 + 500.0 / 1113 * k3 + 125.0 / 192 * k4 - 2187.0 / 6784 * k5 +
                      11.0 / 84 * k6);
    const State k7 = f(step.y);
    const State error = s * (71.0 / 57600 * k1 - 71.0 / 16695 * k3 + 71.0 / 1920 * k4 -
                             17253.0 / 339200 * k5 + 22.0 / 525 * k6 - 1.0 / 40 * k7);
    step.error = (error.array().abs() / (1.0 + y.array().abs())).maxCoeff();
    return step;
}

/// Integrates from t = 0 until `duration` or until `event(y)` falls from > 0 to <= 0 within a step; the state
/// at the event is found by bisecting the length of that step. Calls visit(t, y) after each accepted step.
/// Returns the time reached [s]; y is the state there. An event that is <= 0 at the start is ignored until it
/// has been > 0.
template <int N, class Rate, class Event, class Visit>
double integrate(const Rate& f, Eigen::Matrix<double, N, 1>& y, double duration, const OdeSettings& settings,
                 const Event& event, const Visit& visit) {
    double t = 0.0, s = settings.first_step;
    while (t < duration) {
        s = std::min({s, settings.largest_step, duration - t});
        const OdeStep<N> step = dormand_prince<N>(f, y, s);
        const double ratio = step.error / settings.tolerance;
        if (!(ratio <= 1.0)) {
            s *= std::isfinite(ratio) ? std::max(0.2, 0.9 * std::pow(ratio, -0.2)) : 0.1;
            if (s < settings.smallest_step) {
                throw std::runtime_error("the reference integration cannot hold its tolerance");
            }
            continue;
        }
        if (event(y) > 0.0 && event(step.y) <= 0.0) {
            double before = 0.0, after = s;
            while (after - before > 1e-15 * (1.0 + t)) {
                const double middle = 0.5 * (before + after);
                if (middle <= before || middle >= after) {
                    break;
                }
                (event(dormand_prince<N>(f, y, middle).y) > 0.0 ? before : after) = middle;
            }
            y = dormand_prince<N>(f, y, after).y;
            visit(t + after, y);
            return t + after;
        }
        t = duration - t <= s ? duration : t + s;
        y = step.y;
        visit(t, y);
        s *= std::min(5.0, 0.9 * std::pow(std::max(ratio, 1e-10), -0.2));
    }
    return t;
}

} // namespace reference
