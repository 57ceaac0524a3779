#pragma once
/// Camera and light of two pictures, as the files beside them tell.
#include "render/compare/bodies.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace diff {

/// View and light from PICTURE.bodies.json, if it has them. Throws nlohmann::json::exception if it is damaged.
void read_scene(const nlohmann::json& json, BodyImage& image);

/// "the camera moved by 10 mm; the sun is 5 % brighter"; empty if both are as they were, or not known.
std::string scene_change(const BodyImage& reference, const BodyImage& candidate);

} // namespace diff
