#pragma once
/// Reads trajectory.h5 by its documented layout, through HDF5 itself and not through sim/trajectory.
#include "tests/laws/reference/overlap.h"

#include <string>
#include <vector>

namespace reference {

class TrajectoryFile {
public:
    /// Throws std::runtime_error naming the file and what is missing or of the wrong size.
    explicit TrajectoryFile(const std::string& path);
    ~TrajectoryFile();
    TrajectoryFile(const TrajectoryFile&) = delete;
    TrajectoryFile& operator=(const TrajectoryFile&) = delete;

    std::size_t record_count() const { return time_.size(); }
    const std::vector<double>& time() const { return time_; }        ///< [s], [record_count]
    const std::vector<std::string>& names() const { return names_; } ///< [body_count]
    const std::vector<Solid>& solids() const { return solids_; }     ///< [body_count]
    /// Poses of all bodies at one record; reads only that record.
    std::vector<Placement> placements(std::size_t record) const;

private:
    long file_ = -1; // hid_t
    std::string path_;
    std::vector<double> time_;
    std::vector<std::string> names_;
    std::vector<Solid> solids_;
};

/// A solid from the JSON text of /body/shape. Throws std::runtime_error for an unknown kind.
Solid solid_from_json(const std::string& text, bool is_static);

} // namespace reference
