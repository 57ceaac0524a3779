#pragma once
/// Which simulated instants a film shows: frame k stands at k / fps seconds of the film, which runs faster or slower
/// than the simulation where the scene says so.
#include "sim/model/scene_def.h"

#include <cstdint>

namespace sim {

/// (step + share) h.
struct FrameInstant {
    std::int64_t step = 0;
    double share = 0.0; ///< 0..1, of the step that follows; 0: the state itself
};

/// True if a second of film is a simulated second throughout. Each frame then shows the step nearest to it.
bool is_real_time(const OutputDef& output);

/// Simulated seconds a second of film, at a time [s] of the film.
double speed_at(const OutputDef& output, double film_time);

/// [s] simulated until a time [s] of the film: the integral of the speed.
double simulated_time(const OutputDef& output, double film_time);

/// [s] simulated in the whole film.
double simulated_duration(const OutputDef& output);

/// What frame k >= 0 shows.
FrameInstant frame_instant(const SceneDef& scene, std::int64_t frame);

/// Steps of the whole film: no frame shows a later one.
std::int64_t step_count_of(const SceneDef& scene);

} // namespace sim
