#pragma once
/// States that the frames of a film show, of a trajectory: its records, and states between them.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"
#include "sim/record/trajectory.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace cmd {

class RecordedFrames {
public:
    /// `trajectory` and `scene` must outlive it; path: in messages. Throws Error (usage) if a frame shows what is not
    /// recorded, or lies between two records so far apart that it would be drawn wrong by more than a pixel.
    RecordedFrames(const sim::TrajectoryReader& trajectory, const std::string& path, const sim::SceneDef& scene);

    std::int64_t count() const { return static_cast<std::int64_t>(places_.size()); }
    /// The last record that is not later than what the frame shows.
    std::size_t record_before(std::int64_t frame) const { return place(frame).before; }
    /// What the frame shows. Throws Error (io).
    std::shared_ptr<const sim::Snapshot> state(std::int64_t frame) const;

private:
    /// Between record `before` and the next.
    struct Place {
        std::size_t before = 0;
        double share = 0.0; ///< 0: the record itself
    };

    const Place& place(std::int64_t frame) const { return places_[static_cast<std::size_t>(frame)]; }
    /// Throws Error (usage) for a frame between two records that is wrong by more than a pixel.
    void check_between(std::int64_t frame) const;
    std::shared_ptr<const sim::Snapshot> record(std::size_t index) const;

    const sim::TrajectoryReader& trajectory_;
    const std::string path_;
    const sim::SceneDef& scene_;
    std::vector<double> radii_; ///< [m] of the balls that hold the bodies
    std::vector<Place> places_; ///< [frames]
    /// Records read last, newest first: frames that follow each other ask for the same.
    mutable std::vector<std::pair<std::size_t, std::shared_ptr<const sim::Snapshot>>> read_;
};

} // namespace cmd
