#pragma once
/// One body of a scene file: shape, mass, placement, surface and look.
#include "sim/model/scene_def.h"
#include "sim/scene/section.h"

namespace sim {

/// Keys restitution, friction, mu_s, mu_d.
MaterialDef read_material(Section& section);

/// Keys color, pattern, pattern_color, roughness, metallic, visible.
LookDef read_look(Section& section);

/// The keys that [[body]] and [lattice.body] share. The result is in the frame its shape was given in, with
/// its centre of mass in mass.centre_of_mass and its pose at the origin: place it, then call settle.
/// index: of the body in its pattern, see read_shape.
BodyDef read_body_template(Section& section, std::int64_t index, bool has_keys = false);

/// A whole [[body]], settled.
BodyDef read_body(const TextSource& source, const TreeNode& node, const std::string& title);

/// Key `release`, for a body that its template gave.
double read_release(Section& section, const BodyDef& body);

/// Moves the body frame's origin into the centre of mass: shape, lathe profile and pose follow.
void settle(BodyDef& body);

} // namespace sim
