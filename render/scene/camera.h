#pragma once
/// Where a scene's camera stands at one instant.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <string>

namespace render {

/// A view: looks from eye to target, z is up.
struct View {
    sim::Vec3 eye = sim::Vec3::Zero();    ///< [m]
    sim::Vec3 target = sim::Vec3::Zero(); ///< [m]
    double fov_degrees = 40.0;            ///< vertical
};

/// The snapshot after the time dt [s], either way, in which all bodies keep their velocities.
sim::Snapshot moved(const sim::Snapshot& snapshot, double dt);

/// The camera called `name`; the first one if name is empty. Throws Error (usage) if there is none.
const sim::CameraDef& find_camera(const sim::SceneDef& scene, const std::string& name);

/// The camera at the snapshot's time. Keys are joined by a curve with continuous velocity that passes through
/// each key, at rest at the first and the last.
View camera_view(const sim::CameraDef& camera, const sim::Snapshot& snapshot);

} // namespace render
