#include "render/scene/changed.h"

#include "render/scene/floor_region.h"

#include <glm/gtc/matrix_access.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace render {

namespace {

/// Distance over which the occlusion volume tells of a body [cells]: that of its farthest sample, and what the largest
/// cells blur.
constexpr float occlusion_reach_cells = 12.0f;
/// Half width of a shadow's edge [texels of the shadow map].
constexpr float shadow_edge_texels = 3.0f;
/// Smooth edges see one pixel around, and the outermost of a part of a picture are not kept.
constexpr int kept_border = 4;

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

    std::vector<glm::vec3> points_of(const Part& part) const {
        std::vector<glm::vec3> points;
        append_points(part, seen_.geometry, points);
        return points;
    }

    void include_moving(const Part& part) {
        if (!seen_.moves[part.body]) {
            return;
        }
        const glm::vec3& to_sun = seen_.geometry.light.to_sun;
        for (const glm::vec3& point : points_of(part)) {
            area_.include(point);
            shadow_area_.include(point);
            // What lies between the body and its shadow on a floor is in the rectangle of both.
            for (const Floor& floor : first_.floors) {
                const float height = glm::dot(point - floor.frame.origin, floor.frame.normal);
                area_.include(point - to_sun * (std::max(height, 0.0f) / glm::dot(to_sun, floor.frame.normal)));
            }
        }
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
            for (const glm::vec3& point : points_of(part)) {
                area_.include(point);
            }
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
