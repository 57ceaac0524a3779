#include "render/scene/changed.h"

#include "render/scene/floor_region.h"

#include <glm/gtc/matrix_access.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace render {

namespace {

/// Distance over which the occlusion volume tells of a body [cells]: that of its farthest sample, and what the largest
/// cells blur.
constexpr float occlusion_reach_cells = 12.0f;
/// Half width of a shadow's edge [texels of the shadow map].
constexpr float shadow_edge_texels = 3.0f;
/// Smooth edges see one pixel around, and the outermost of a part of a picture are not kept.
constexpr int kept_border = 4;

/// Corners of a regular octagon are this many times as far from its middle as its sides.
constexpr float octagon = 1.0823922f;

/// A circle of a radius about z at height z.
void visit_ring(float radius, float z, const auto& visit) {
    const float far = radius * octagon;
    const float near = far * std::numbers::sqrt2_v<float> * 0.5f;
    for (const glm::vec2& p : {glm::vec2(far, 0), glm::vec2(0, far), glm::vec2(near, near), glm::vec2(near, -near)}) {
        visit(glm::vec3(p, z));
        visit(glm::vec3(-p, z));
    }
}

/// Calls visit(point) for points in the instance's frame [m] whose convex hull holds the part.
void visit_points(const Part& part, const SceneGeometry& geometry, const auto& visit) {
    const glm::vec3& scale = part.instance.scale;
    const auto own = static_cast<std::size_t>(part.mesh - mesh_id::lathe_first);
    if (part.mesh < 0 || part.mesh == mesh_id::rod) {
        for (int i = 0; i < 8; ++i) {
            visit(scale * (2.0f * glm::vec3(i & 1, (i >> 1) & 1, (i >> 2) & 1) - 1.0f));
        }
    } else if (part.mesh < mesh_id::lathe_first) {
        constexpr float low = 0.4142135f; // tangent of 22.5 degrees
        for (const glm::vec2& p : {glm::vec2(1, low), glm::vec2(low, 1)}) {
            visit_ring(p.x * scale.x, p.y * scale.x, visit);
            visit_ring(p.x * scale.x, -p.y * scale.x, visit);
        }
    } else if (own < geometry.profiles.size()) {
        for (const glm::vec2& p : geometry.profiles[own]) {
            visit_ring(p.x, p.y, visit);
        }
    } else {
        for (const HullFace& face : geometry.hulls[own - geometry.profiles.size()]) {
            std::ranges::for_each(face.corners, visit);
        }
    }
}

/// Grows by what is included.
class Area {
public:
    /// What is included is seen this much larger, `around` [m].
    Area(const glm::mat4& clip_from_world, const glm::ivec2& size, float around)
        : clip_from_world_(clip_from_world), size_(size),
          around_(0.5f * around * static_cast<float>(size.y) * glm::length(glm::vec3(glm::row(clip_from_world, 1)))) {}

    void include(const glm::vec3& point) {
        const glm::vec4 clip = clip_from_world_ * glm::vec4(point, 1.0f);
        // Beside or behind the eye there are no bounds.
        is_bounded_ = is_bounded_ && clip.w > 0.0f && clip.z < clip.w;
        const glm::vec2 pixel = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * glm::vec2(size_);
        lower_ = glm::min(lower_, pixel - around_ / clip.w);
        upper_ = glm::max(upper_, pixel + around_ / clip.w);
    }

    void include_all() { is_bounded_ = false; }

    PixelRect rect() const {
        if (!is_bounded_) {
            return {0, 0, size_.x, size_.y};
        }
        const glm::vec2 end(size_);
        const glm::ivec2 from = glm::clamp(glm::ivec2(glm::floor(glm::clamp(lower_, 0.0f * end, end))) - kept_border,
                                           glm::ivec2(0), glm::max(size_ - 2 * kept_border, 0));
        const glm::ivec2 to = glm::clamp(glm::ivec2(glm::ceil(glm::clamp(upper_, 0.0f * end, end))) + kept_border,
                                         glm::min(from + 2 * kept_border, size_), size_);
        return {from.x, from.y, to.x - from.x, to.y - from.y};
    }

private:
    glm::mat4 clip_from_world_;
    glm::ivec2 size_;
    float around_; ///< [px m] over the distance
    bool is_bounded_ = true;
    glm::vec2 lower_{std::numeric_limits<float>::max()};
    glm::vec2 upper_{std::numeric_limits<float>::lowest()};
};

class ChangeFinder {
public:
    ChangeFinder(const StatesSeen& seen, const Viewport& viewport)
        : seen_(seen), first_(seen.lists.front()),
          area_(first_.camera.clip_from_world, {viewport.width, viewport.height}, edge()),
          shadow_area_(first_.shadow.clip_from_world, glm::ivec2(viewport.shadow_size), edge()) {}

    Changed find() {
        for (const Floor& floor : first_.floors) {
            if (glm::dot(floor.frame.normal, seen_.geometry.light.to_sun) < least_sun_height) {
                area_.include_all();
            }
        }
        if (first_.floors.empty()) {
            area_.include_all(); // shadows end nowhere
        }
        for (const Parts& parts : seen_.parts) {
            for (const std::vector<Part>* group : {&parts.boxes, &parts.rounds}) {
                std::ranges::for_each(*group, [&](const Part& part) { include_moving(part); });
            }
        }
        for (const std::vector<Part>* group : {&seen_.parts.front().boxes, &seen_.parts.front().rounds}) {
            std::ranges::for_each(*group, [&](const Part& part) { include_resting(part); });
        }
        return {area_.rect(), shadow_area_.rect()};
    }

private:
    float edge() const { return shadow_edge_texels * first_.shadow.texel_size; }

    void visit(const Part& part, const auto& visit_world) const {
        visit_points(part, seen_.geometry, [&](const glm::vec3& p) {
            visit_world(part.instance.position + turned(part.instance.orientation, p));
        });
    }

    void include_moving(const Part& part) {
        if (!seen_.moves[part.body]) {
            return;
        }
        const glm::vec3& to_sun = seen_.geometry.light.to_sun;
        visit(part, [&](const glm::vec3& point) {
            area_.include(point);
            shadow_area_.include(point);
            // What lies between the body and its shadow on a floor is in the rectangle of both.
            for (const Floor& floor : first_.floors) {
                const float height = glm::dot(point - floor.frame.origin, floor.frame.normal);
                area_.include(point - to_sun * (std::max(height, 0.0f) / glm::dot(to_sun, floor.frame.normal)));
            }
        });
        moving_.push_back(&part.instance);
    }

    /// What rests beside something that moves sees less or more of the sky, and mirrors it.
    void include_resting(const Part& part) {
        const Instance& instance = part.instance;
        const bool is_mirror = !first_.mirrored.is_empty() && is_polished(part);
        const float reach = occlusion_reach_cells * seen_.geometry.occlusion_cell + instance.bounding_radius;
        const auto is_near = [&](const Instance* other) {
            return glm::length(other->position - instance.position) < reach + other->bounding_radius;
        };
        if (!seen_.moves[part.body] && (is_mirror || std::ranges::any_of(moving_, is_near))) {
            visit(part, [&](const glm::vec3& point) { area_.include(point); });
        }
    }

    const StatesSeen& seen_;
    const DrawList& first_;
    Area area_;
    Area shadow_area_;
    std::vector<const Instance*> moving_;
};

} // namespace

Changed find_changed(const StatesSeen& seen, const Viewport& viewport) {
    return ChangeFinder(seen, viewport).find();
}

} // namespace render
