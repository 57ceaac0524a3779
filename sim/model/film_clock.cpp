#include "sim/model/film_clock.h"

#include <algorithm>
#include <cmath>

namespace sim {

namespace {

/// A frame this near to a step, in steps, shows the step itself: it has only been rounded away from it.
constexpr double same_step = 1e-6;

} // namespace

bool is_real_time(const OutputDef& output) {
    return output.speed == 1.0 && output.speed_keys.empty();
}

double speed_at(const OutputDef& output, double film_time) {
    const std::vector<SpeedKey>& keys = output.speed_keys;
    if (keys.empty()) {
        return output.speed;
    }
    if (film_time <= keys.front().time) {
        return keys.front().speed;
    }
    for (std::size_t i = 1; i < keys.size(); ++i) {
        if (film_time < keys[i].time) {
            const double share = (film_time - keys[i - 1].time) / (keys[i].time - keys[i - 1].time);
            return keys[i - 1].speed + share * (keys[i].speed - keys[i - 1].speed);
        }
    }
    return keys.back().speed;
}

double simulated_time(const OutputDef& output, double film_time) {
    // The speed is straight between the keys: trapezoids are exact.
    double sum = 0.0;
    double from = 0.0;
    const auto advance = [&](double to) {
        sum += 0.5 * (speed_at(output, from) + speed_at(output, to)) * (to - from);
        from = to;
    };
    for (const SpeedKey& key : output.speed_keys) {
        if (key.time > from && key.time < film_time) {
            advance(key.time);
        }
    }
    advance(film_time);
    return sum;
}

double simulated_duration(const OutputDef& output) {
    const double duration = output.duration.value();
    return is_real_time(output) ? duration : simulated_time(output, duration);
}

FrameInstant frame_instant(const SceneDef& scene, std::int64_t frame) {
    const OutputDef& output = scene.output;
    if (is_real_time(output)) {
        return {step_of_frame(frame, output.fps, scene.step.time_step), 0.0};
    }
    const double steps =
        simulated_time(output, static_cast<double>(frame) / output.fps.value()) / scene.step.time_step.value();
    const double nearest = std::round(steps);
    if (std::abs(steps - nearest) < same_step) {
        return {static_cast<std::int64_t>(nearest), 0.0};
    }
    return {static_cast<std::int64_t>(std::floor(steps)), steps - std::floor(steps)};
}

std::int64_t step_count_of(const SceneDef& scene) {
    if (is_real_time(scene.output)) {
        return step_count(scene.output.duration, scene.step.time_step);
    }
    const double steps = simulated_duration(scene.output) / scene.step.time_step.value();
    return static_cast<std::int64_t>(std::ceil(steps - same_step));
}

} // namespace sim
