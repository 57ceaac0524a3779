#pragma once
/// States between two that are known, and how wrong they may be.
#include "sim/model/snapshot.h"

#include <vector>

namespace sim {

/// The state at `share` 0..1 of the time from a to b. Centres move on cubic Hermite curves, orientations on the mean of
/// two turns, one on from a and one back from b, weighted so that both ends keep their angular velocities. Contacts are
/// those of a, impacts those of b. A body released in between stands until then.
Snapshot interpolated(const SceneDef& scene, const Snapshot& a, const Snapshot& b, double share);

/// Four records in a row: a and b, between which is interpolated, and their neighbours; null at an end.
struct RecordWindow {
    const Snapshot* before = nullptr;
    const Snapshot* a = nullptr;
    const Snapshot* b = nullptr;
    const Snapshot* after = nullptr;
};

/// [m] How far each body's surface may lie from where interpolated() puts it, at most about: a jump of velocity between a
/// and b, as of an impact, moves the middle by jump * time / 8. A jump is what acceleration from a to b has in common
/// with neither neighbour's. radii: [m], of the balls about the centres that hold the bodies.
std::vector<double> interpolation_errors(const RecordWindow& window, const std::vector<double>& radii);

} // namespace sim
