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

    friend bool operator==(const View&, const View&) = default;
};

/// The snapshot after the time dt [s], either way, in which all bodies keep their velocities.
sim::Snapshot moved(const sim::Snapshot& snapshot, double dt);

/// The camera called `name`; the first one if name is empty. Throws Error (usage) if there is none.
const sim::CameraDef& find_camera(const sim::SceneDef& scene, const std::string& name);

/// Distance of the eye from its target at the start [m]: the length scale of the picture, constant in time.
double view_scale(const sim::CameraDef& camera);

/// Vertical opening [degrees] of a picture of width / height `aspect`: fov_degrees if it is 16:9 or wider; else so much
/// that it is as wide as one of 16:9.
double opening_degrees(double fov_degrees, double aspect);

/// The camera at the snapshot's time, for a picture of width / height `aspect`. Keys are joined by a curve that
/// passes through each key, at rest at the first and the last and where a key's easing says so.
View camera_view(const sim::CameraDef& camera, const sim::Snapshot& snapshot, double aspect);

} // namespace render
