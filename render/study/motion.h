#pragma once
/// States at common instants, and how far two such motions are apart.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <vector>

namespace study {

/// Snapshots at equal distances in time, the first one the start.
struct Motion {
    std::vector<sim::Snapshot> states;
    double interval = 0.0; ///< [s] that the scheme advanced by, root mean square over time; 0: not known
};

/// Root mean square [m] of how far the mass of a body is from where another pose puts it: every point of the
/// body counts with its mass, so turning counts by what it moves. Exact for any distribution of mass:
/// |x1 - x2|^2 + tr(D S D^T), D the difference of the rotations, S = (tr(J)/2 - J) / m.
double displacement(const sim::MassProperties& mass, const sim::BodySnapshot& one, const sim::BodySnapshot& other);

struct Difference {
    double rms = 0.0;         ///< [m] over dynamic bodies and instants
    double largest = 0.0;     ///< [m]
    double agree_until = 0.0; ///< [s] the last instant at which every body is within agreement of the other
    double energy = 0.0;      ///< [-] largest difference of the energy, relative to energy_scale
    /// [-] the same from the nearest of the reference's energies at that instant and the two beside it: an impact a little
    /// early is no difference, a bounce of another height is.
    double heights = 0.0;
};

/// Bodies agree while none is displaced by more than this share of its size [-].
inline constexpr double agreement = 0.1;

/// Both have the scene's bodies and the same number of states: CHECK.
Difference difference(const sim::SceneDef& scene, const Motion& motion, const Motion& reference);

/// [J] What energies of a scene are compared with: the largest kinetic energy of the motion, or that of a
/// fall by a tenth of each body's size if nothing moves.
double energy_scale(const sim::SceneDef& scene, const Motion& motion);

/// The pile and the flow of many bodies at one instant.
struct Statistics {
    double throughput = 0.0; ///< [-] share of the bodies below the gate
    double height = 0.0;     ///< [m] mean height of the centres of those
    double spread = 0.0;     ///< [m] root mean square of their horizontal distance from their mean
    double energy = 0.0;     ///< [J] kinetic and potential
};
inline constexpr int statistics_count = 4;
inline constexpr const char* statistics_names[] = {"throughput", "height", "spread", "energy"};

/// In the order of statistics_names.
std::vector<double> values_of(const Statistics& statistics);

/// gate [m]: height below which a body has passed. Throughput counts all bodies; height and spread are those
/// of the bodies that have passed, 0 if none has.
Statistics statistics(const sim::SceneDef& scene, const sim::Snapshot& state, double gate);

} // namespace study
