#pragma once
/// What a picture shows of the time before it: curves of the plots, trails and contact paths.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace render {

/// A quantity at one time.
struct CurvePoint {
    double time = 0.0; ///< [s]
    double value = 0.0;
};
using Curve = std::vector<CurvePoint>;

/// Where a point was at one time.
struct PathPoint {
    double time = 0.0;                ///< [s]
    sim::Vec3 at = sim::Vec3::Zero(); ///< [m]
};
/// Without a gap.
using Path = std::vector<PathPoint>;

/// Where a body was touched: of several contacts the one with the largest normal impulse.
struct ContactPath {
    int body = -1;             ///< index into bodies
    std::vector<Path> on_body; ///< in the body frame
    std::vector<Path> in_world;
};

/// Whether two pieces of a contact path on the body belong together: the body hopped. Not if the contact went to
/// another part of it, nearer its centre or farther away, where a line between them would leave the body.
bool is_hop(const Path& from, const Path& to);

/// Whether pieces i - 1 and i belong together in the world too: not if the body's next contact is across the circle in
/// which it rolls.
bool is_hop_in_world(const ContactPath& path, std::size_t i);

/// What is remembered at one instant. A path ends at that instant.
struct Notes {
    std::vector<std::vector<Curve>> plots; ///< [plots] curves of each, as plot_values has them
    std::vector<Path> trails;              ///< of OverlayDef's bodies
    std::vector<ContactPath> contact_paths;
};

/// Kinetic, potential (from the overlay's zero height) and both [J].
struct Energies {
    double kinetic = 0.0;
    double potential = 0.0;
    double total() const { return kinetic + potential; }
};
Energies energies(const sim::SceneDef& scene, const sim::Snapshot& snapshot);

/// What a plot shows at one instant, one value a curve: kinetic, potential, total energy, or one a body.
std::vector<double> plot_values(const sim::SceneDef& scene, const sim::PlotDef& plot,
                                const sim::Snapshot& snapshot);

/// Bodies with trails and contact paths.
std::vector<int> path_bodies(const sim::SceneDef& scene);

/// Sees all states of a film in order, those between frames too. Its memory grows with the length of the
/// paths, not with the number of states.
class NoteTaker {
public:
    /// `scene` must outlive it.
    explicit NoteTaker(const sim::SceneDef& scene);

    /// False if the pictures show nothing of the past.
    bool is_needed() const { return has_plots_ || has_trails_ || has_contact_paths_; }

    /// A state already seen is passed over.
    void observe(const sim::Snapshot& snapshot);

    /// What is remembered up to the state seen last.
    std::shared_ptr<const Notes> notes() const;

private:
    void observe_contacts(const sim::Snapshot& snapshot, ContactPath& path) const;

    const sim::SceneDef& scene_;
    bool has_plots_;
    bool has_trails_;
    bool has_contact_paths_;
    std::vector<int> bodies_;
    double time_spacing_; ///< [s] between points of a curve
    double spacing_;      ///< [m] between points of a path in the world
    std::int64_t last_step_ = -1;
    Notes notes_;
};

} // namespace render
