#pragma once
/// Poses and velocities of all bodies over time in an HDF5 file (sole user of hdf5), readable with h5py.
///
///   /step [f]  int64                        /time [f]  [s]
///   /position [f,b,3]  [m]                  /orientation [f,b,4]  w x y z, world_from_body
///   /velocity [f,b,3]  [m/s]                /angular_velocity [f,b,3]  [rad/s], world frame
///   /body/name [b]  text of fixed length         /body/shape [b]  the same: JSON, see shape_to_json
///   /body/mass [b]  [kg], 0: static; every dataset of numbers has an attribute unit
///   If contacts are asked for: /contact_count [f] int64, of those that carry a load; and with all of them
///   /contact/bodies [c,2] int32, indices a, b    /contact/sticking [c,1] int8
///   /contact/point [c,3] [m]    /contact/normal [c,3], b to a    /contact/impulse [c,3] [N s] on a, of one step
///     float32, record after record: those of record k follow the sum of the counts before it
///   /impact_count, /impact/...: the same of the impacts since the record before
///   attributes of /: format_version (1), scene_name, scene_text, overrides [n], program_version; all texts are UTF-8
///
/// All data carry checksums (Fletcher 32), and no time of writing: the same run gives the same bytes.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sim {

class TrajectoryWriter {
public:
    /// Opens path + ".part" and describes the bodies. contacts: what is recorded of them. Throws Error (io).
    TrajectoryWriter(const std::filesystem::path& path, const SceneDef& scene,
                     ContactDetail contacts = ContactDetail::none);
    /// Without finish() the part file is removed.
    ~TrajectoryWriter();
    TrajectoryWriter(TrajectoryWriter&&) noexcept;
    TrajectoryWriter& operator=(TrajectoryWriter&&) noexcept;

    /// Appends one record; steps must ascend, the body count is the scene's: CHECK. The memory used does not
    /// depend on the number of records. Throws Error (io).
    void append(const Snapshot& snapshot);

    /// Closes the file and gives it its name. Throws Error (io).
    void finish();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// What a trajectory says beside its records.
struct TrajectoryInfo {
    std::string scene_name;
    std::string scene_text;                ///< the scene file as it was read
    std::vector<std::string> overrides;    ///< "dotted.key=value", in the order applied
    std::string program_version;
    std::vector<std::string> body_names;   ///< [body_count]
    std::vector<std::string> body_shapes;  ///< [body_count] JSON
    std::vector<double> body_masses;       ///< [body_count] [kg], 0: static
};

/// Throws Error (usage) if the bodies of a trajectory, read from `path`, are not those of its scene.
void require_same_bodies(const TrajectoryInfo& info, const SceneDef& scene, const std::string& path);

class TrajectoryReader {
public:
    /// Throws Error (io) if the file cannot be read, is damaged, or is no trajectory.
    explicit TrajectoryReader(const std::filesystem::path& path);
    ~TrajectoryReader();
    TrajectoryReader(TrajectoryReader&&) noexcept;
    TrajectoryReader& operator=(TrajectoryReader&&) noexcept;

    const TrajectoryInfo& info() const;
    /// Step of each record, ascending.
    const std::vector<std::int64_t>& steps() const;
    /// What it has recorded of contacts.
    ContactDetail contacts() const;
    /// Record 0 .. steps().size() - 1: CHECK. Throws Error (io).
    Snapshot read(std::size_t record) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace sim
