#pragma once
/// What polished bodies show of their surroundings: spheres and boxes, told so that a ray soon finds them.
#include "render/scene/parts.h"

#include <array>
#include <span>

namespace render {

/// The uniform block `Mirrored` of shaders/common_mirror.glsl, std140.
struct MirroredBlock {
    static constexpr int most = 32;
    std::array<glm::vec4, most> spheres{}; ///< centre and radius [m]
    /// Three rows a box: a point's coordinates in the box, -1..1 inside, are dot(row, (x, y, z, 1)).
    std::array<glm::vec4, 3 * most> boxes{};
    std::array<glm::vec4, most> looks{}; ///< of the spheres, then of the boxes: linear RGB, share of metal
};

struct Mirrored {
    int spheres = 0;
    int boxes = 0;
    MirroredBlock block;

    bool is_empty() const { return spheres + boxes == 0; }
};

/// Is it a round body of metal so smooth that it shows what is around it?
bool is_polished(const Part& part);

/// Nothing unless a round body is polished, and if the scene holds too much to follow rays to.
Mirrored find_mirrored(const Parts& parts, const sim::SceneDef& scene);

} // namespace render
