#pragma once
/// Depths of a picture, for what is drawn over it.
#include <glm/glm.hpp>

#include <vector>

namespace render {

/// How far the bodies in a picture are, and where points of the world lie in it.
struct DepthPicture {
    int width = 0;            ///< [px]
    int height = 0;           ///< [px]
    std::vector<float> depth; ///< [height * width] lowest row first, as CameraBlock has it
    glm::mat4 clip_from_world{1.0f};
};

} // namespace render
