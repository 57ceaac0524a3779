#include "render/study/accuracy.h"

#include "render/study/engine.h"
#include "render/study/preset.h"
#include "sim/base/error.h"
#include "sim/model/film_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace study {

namespace {

using sim::Rational;

/// The first run's step is a frame's time or a part of it: at most so long [s], or of many bodies, for which a tolerance that
/// is too small for the step costs more than shorter steps, so many of the scene's own.
constexpr double longest_step = 1.0 / 50.0;
constexpr double own_steps = 4.0;

/// Instants [-] at which motions are compared: enough to see every swing of a film.
constexpr int compared_instants = 200;

/// The gap tolerance begins with so many times [-] the scene's or this share [-] of what is asked, and falls with the step to
/// the least one.
constexpr double loose = 10.0;
constexpr double first_tolerance = 0.5;
constexpr double least_tolerance = 1.0 / 64.0;

/// A difference of more than this many times [-] what is asked takes more than one halving of a step of order 2.
constexpr double far_away = 64.0;

/// Three motions that show this order [-] are good enough where the estimate of what is left is this many times [-] smaller
/// than what is asked, even if the last two differ by more.
constexpr double sure_order = 1.5;
constexpr double sure_share = 2.0;

/// The next step is at most this share [-] of the last run's intervals: where they are nearly the same, the difference of two
/// motions tells little.
constexpr double shorter = 0.7;

/// Parts [-] of the first step beyond which none is divided.
constexpr std::int64_t most_parts = 1 << 14;

/// Halvings of the bracket of an order: to nine digits.
constexpr int halvings = 30;

/// Two motions part whatever the step where the time up to which they agree grows by less than this factor [-] as it is
/// halved, twice: where motion converges with order p it grows as 2^p or more.
constexpr double least_growth = 1.3;

/// Divides the time of a frame.
Rational first_step(const sim::SceneDef& scene) {
    const Rational& fps = scene.output.fps;
    const double own = scene.step.time_step.value();
    const double longest = std::max(own, has_few_bodies(scene) ? longest_step : std::min(own_steps * own, longest_step));
    const auto parts = static_cast<std::int64_t>(std::ceil(1.0 / (fps.value() * longest) * (1.0 - 1e-12)));
    return sim::make_rational(fps.den, fps.num * parts);
}

sim::Vec3 mean_position(const sim::SceneDef& scene, const sim::Snapshot& state) {
    sim::Vec3 sum = sim::Vec3::Zero();
    double mass = 0.0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (!scene.bodies[i].is_static()) {
            sum += scene.bodies[i].mass.mass * state.bodies[i].position;
            mass += scene.bodies[i].mass.mass;
        }
    }
    return mass > 0.0 ? sim::Vec3(sum / mass) : sum;
}

} // namespace

AccuracySearch::AccuracySearch(const sim::SceneDef& scene, double asked)
    : scene_(scene), asked_(asked), longest_(first_step(scene)) {
    const double duration = sim::simulated_duration(scene.output);
    const auto steps = static_cast<std::int64_t>(duration / longest_.value() * (1.0 + 1e-12));
    const std::int64_t between = std::max<std::int64_t>(1, steps / compared_instants);
    spacing_ = sim::make_rational(longest_.num * between, longest_.den);
    instants_ = 1 + static_cast<int>(steps / between);
}

Rational AccuracySearch::step_of(std::int64_t parts) const {
    return sim::make_rational(longest_.num, longest_.den * parts);
}

double AccuracySearch::tolerance_of(std::int64_t parts) const {
    const double first = std::min(loose * scene_.step.tolerance, first_tolerance * asked_);
    return std::max(first / static_cast<double>(parts), std::min(first, least_tolerance * asked_));
}

std::int64_t AccuracySearch::steps_between() const {
    return sim::step_count(spacing_, step_of(parts_));
}

std::vector<std::string> AccuracySearch::overrides() const {
    if (end_ == AccuracyEnd::chaotic) {
        return {fmt::format("simulation.tolerance={}", std::min(scene_.step.tolerance, asked_)),
                fmt::format("simulation.velocity_tolerance={}",
                            std::min(scene_.step.velocity_tolerance, 0.5 * asked_ / scene_.step.time_step.value()))};
    }
    const Rational h = step_of(parts_);
    const double tolerance = tolerance_of(parts_);
    // What drifts that slowly stays within the tolerance over the film.
    const double drift = tolerance / sim::simulated_duration(scene_.output);
    std::vector<std::string> overrides{
        fmt::format("simulation.time_step=\"{}\"", fraction_text(h)), fmt::format("simulation.tolerance={}", tolerance),
        fmt::format("simulation.velocity_tolerance={}", std::min(drift, 0.5 * tolerance / h.value()))};
    if (has_few_bodies(scene_)) {
        overrides.emplace_back("simulation.impacts=\"stop\"");
    }
    return overrides;
}

void AccuracySearch::compare(const Motion& motion, AccuracyRun& run) const {
    run.difference = difference(scene_, motion, before_).rms;
    bool agrees = true;
    for (std::size_t k = 0; k < motion.states.size(); ++k) {
        const sim::Snapshot& now = motion.states[k];
        const sim::Snapshot& then = before_.states[k];
        for (std::size_t i = 0; agrees && i < scene_.bodies.size(); ++i) {
            agrees = scene_.bodies[i].is_static() ||
                     displacement(scene_.bodies[i].mass, now.bodies[i], then.bodies[i]) <= asked_;
        }
        run.determined_until = agrees ? static_cast<double>(k) * spacing_.value() : run.determined_until;
        run.mean_difference =
            std::max(run.mean_difference, (mean_position(scene_, now) - mean_position(scene_, then)).norm());
    }
}

/// The order that the last differences show, and what the last run leaves. With one difference alone order 1 is certain.
void AccuracySearch::find_estimate() {
    std::vector<const AccuracyRun*> last; // the three last with a motion, the latest first
    for (auto run = runs_.rbegin(); run != runs_.rend() && last.size() < 3; ++run) {
        if (run->stopped.empty()) {
            last.push_back(&*run);
        }
    }
    const auto power = [&](std::size_t k, double p) { return std::pow(last[k]->interval, p); };
    order_ = 1.0;
    if (last.size() == 3 && std::isfinite(last[1]->difference) && last[1]->difference > 0.0) {
        const double ratio = last[0]->difference / last[1]->difference;
        const auto expected = [&](double p) { return (power(1, p) - power(0, p)) / (power(2, p) - power(1, p)); };
        double low = 1.0;
        double high = 2.0;
        for (int i = 0; i < halvings; ++i) { // the greater p, the smaller what is expected
            const double middle = 0.5 * (low + high);
            (expected(middle) > ratio ? low : high) = middle;
        }
        order_ = low;
    }
    estimate_ = last[0]->difference * power(0, order_) / (power(1, order_) - power(0, order_));
    if (last.size() == 3 && std::isfinite(last[1]->difference)) {
        // Where the last two agree by chance (an event that falls on the same instant), what the two before tell.
        estimate_ = std::max(estimate_, last[1]->difference * power(0, 2.0) / (power(2, 2.0) - power(1, 2.0)));
    }
}

bool AccuracySearch::is_chaotic() const {
    int stuck = 0;
    for (std::size_t k = runs_.size(); k-- > 2 && stuck < 2;) {
        const double now = runs_[k].determined_until;
        const double then = runs_[k - 1].determined_until;
        const double times = std::log2(runs_[k - 1].interval / runs_[k].interval);
        if (then <= 0.0 || now > then * std::pow(least_growth, times) || !runs_[k].stopped.empty()) {
            return false;
        }
        ++stuck;
    }
    return stuck == 2;
}

bool AccuracySearch::add(Motion motion) {
    if (end_ == AccuracyEnd::chaotic) {
        return true;
    }
    AccuracyRun run{.time_step = step_of(parts_),
                    .tolerance = tolerance_of(parts_),
                    .interval = motion.interval,
                    .difference = std::numeric_limits<double>::infinity()};
    const bool is_first = before_.states.empty();
    if (!is_first) {
        compare(motion, run);
    }
    runs_.push_back(run);
    before_ = std::move(motion);
    if (is_first) {
        shorten(2);
        return false;
    }
    find_estimate();
    const bool has_order = order_ >= sure_order && sure_share * estimate_ <= asked_;
    if (estimate_ <= asked_ && (run.difference <= asked_ || has_order)) {
        return true;
    }
    if (is_chaotic()) {
        end_ = AccuracyEnd::chaotic;
        return false;
    }
    if (parts_ == most_parts) {
        end_ = AccuracyEnd::missed;
        return true;
    }
    shorten(run.difference > far_away * asked_ ? 4 : 2);
    return false;
}

/// factor: of the next run's step, at least.
void AccuracySearch::shorten(std::int64_t factor) {
    parts_ *= factor;
    while (parts_ < most_parts && step_of(parts_).value() > shorter * runs_.back().interval) {
        parts_ *= 2;
    }
    parts_ = std::min(parts_, most_parts);
}

bool AccuracySearch::add_stopped(const std::string& message) {
    if (end_ == AccuracyEnd::chaotic || step_of(parts_).value() <= scene_.step.time_step.value() || parts_ == most_parts) {
        return false;
    }
    runs_.push_back({.time_step = step_of(parts_), .stopped = message});
    parts_ *= 2;
    return true;
}

} // namespace study
