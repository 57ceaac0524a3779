#pragma once
/// What of a scene is the same in all its pictures: outlines, hulls, light, the floor's lines.
#include "render/scene/draw_types.h"
#include "render/scene/mesh.h"
#include "sim/model/scene_def.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace render {

inline glm::vec3 to_glm(const sim::Vec3& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
inline glm::vec4 to_glm(const sim::Quat& q) {
    return {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
            static_cast<float>(q.w())};
}

/// A visitor of several lambdas.
template <class... Fs>
struct Overload : Fs... {
    using Fs::operator()...;
};
template <class... Fs>
Overload(Fs...) -> Overload<Fs...>;

struct SceneGeometry {
    std::vector<std::vector<glm::vec2>> profiles; ///< lathe surfaces, each once: (radius, z) [m]
    std::vector<int> profile_of_body;             ///< [body_count], -1: drawn as its shape
    std::vector<std::vector<HullFace>> hulls;     ///< each once [m]
    /// [body_count][parts] mesh of a cylinder, capsule or hull; -1: the part's kind has one for all.
    std::vector<std::vector<int>> mesh_of_part;
    std::vector<std::uint32_t> group_count; ///< [mesh_id] surface groups of a mesh, each with its own id
    float occlusion_cell = 0.0f;            ///< [m] of the occlusion volume
    LightBlock light;
    float floor_extent = 0.0f;   ///< [m] a floor has faded into the sky at this distance from the eye
    float grid_spacing = 1.0f;   ///< [m] of the fine lines; every tenth is a strong one
    glm::vec4 floor_plane{0.0f}; ///< of the first floor: normal and its product with a point on it
    glm::vec3 floor_color{0.0f}; ///< linear RGB
};
SceneGeometry make_scene_geometry(const sim::SceneDef& scene, const sim::CameraDef& camera);

} // namespace render
