#pragma once
/// What a film will cost, measured on a part of it.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <memory>
#include <string>
#include <vector>

namespace cmd {

/// Equal parts of a film at whose ends a pilot looks at the clock.
inline constexpr int pilot_parts = 24;

/// A simulation that has gone as far as it was given time for.
struct SimulationPilot {
    std::vector<double> seconds; ///< [s] wall time from the start to the end of each part that was done
    std::vector<std::shared_ptr<const sim::Snapshot>> states; ///< at the start, and at these ends; with numbers of contacts
    double processors = 1.0;     ///< [-] processor time in a second of wall time

    bool is_whole() const { return seconds.size() == pilot_parts; }
    /// [s] wall time of the whole film, the parts that are missing as long as the longest of the last ones.
    double whole_time() const;
};

/// Throws Error as the simulation does, and interrupted.
SimulationPilot pilot_simulation(const sim::SceneDef& scene, int threads, double most_seconds);

/// Of a frame.
struct PictureCost {
    double wall = 0.0;      ///< [s] with all cores
    double processor = 0.0; ///< [s]
    double bytes = 0.0;     ///< its PNG and its share of the film
};

/// Draws, writes and encodes some of these states, in a folder of its own that it removes. Throws Error.
PictureCost pilot_pictures(const sim::SceneDef& scene, const SimulationPilot& of, bool has_png, bool has_video);

} // namespace cmd
