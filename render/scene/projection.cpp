#include "render/scene/projection.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace render {

namespace {

/// Near over far at the least. Depth is stored as a float that is 1 near and 0 far, which keeps its
/// precision.
constexpr double least_near_share = 1e-5;

/// A direction that is not along `axis`.
glm::dvec3 up_for(const glm::dvec3& axis) {
    return std::abs(axis.z) > 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
}

/// Perspective with depth 1 at the near plane and 0 at the far plane.
glm::dmat4 reversed_perspective(const ViewPoint& view, const DepthRange& range) {
    const double f = 1.0 / std::tan(0.5 * glm::radians(view.fov_degrees));
    glm::dmat4 m(0.0);
    m[0][0] = f / view.aspect;
    m[1][1] = f;
    m[2][2] = range.near / (range.far - range.near);
    m[2][3] = -1.0;
    m[3][2] = range.near * range.far / (range.far - range.near);
    return m;
}

/// Smallest power of 2^(1/4) that is at least x.
double stepped_size(double x) {
    return std::exp2(0.25 * std::ceil(4.0 * std::log2(std::max(x, 1e-9))));
}

} // namespace

DepthRange depth_range(const ViewPoint& view, std::span<const Instance> instances, double extent,
                       bool has_floor) {
    const glm::dvec3 forward = glm::normalize(view.target - view.eye);
    double nearest = extent;
    double farthest = has_floor ? extent : 1e-6;
    for (const Instance& instance : instances) {
        const double depth = glm::dot(glm::dvec3(instance.position) - view.eye, forward);
        const double radius = static_cast<double>(instance.bounding_radius);
        nearest = std::min(nearest, depth - radius);
        farthest = std::max(farthest, depth + radius);
    }
    if (has_floor) {
        nearest = std::min(nearest, extent * 1e-4);
    }
    return {std::max(nearest * 0.95, farthest * least_near_share), farthest * 1.05};
}

CameraBlock make_camera(const ViewPoint& view, const DepthRange& range) {
    const glm::dvec3 forward = glm::normalize(view.target - view.eye);
    const glm::dmat4 clip_from_world =
        reversed_perspective(view, range) * glm::lookAt(view.eye, view.target, up_for(forward));
    CameraBlock camera{};
    camera.clip_from_world = glm::mat4(clip_from_world);
    camera.world_from_clip = glm::mat4(glm::inverse(clip_from_world));
    camera.eye = glm::vec3(view.eye);
    return camera;
}

bool is_outside(const CameraBlock& camera, const glm::vec3& center, float radius) {
    // Planes w + x >= 0 and so on, as rows of the matrix (Gribb & Hartmann 2001).
    const glm::mat4 rows = glm::transpose(camera.clip_from_world);
    const std::array<glm::vec4, 5> planes{rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
                                          rows[3] - rows[1], rows[3]};
    for (const glm::vec4& plane : planes) {
        if (glm::dot(plane, glm::vec4(center, 1.0f)) < -radius * glm::length(glm::vec3(plane))) {
            return true;
        }
    }
    return false;
}

ShadowVolume make_shadow_volume(const ShadowSetup& setup, std::span<const Instance> instances) {
    const glm::dmat4 light_from_world = glm::lookAt(glm::dvec3(0.0), -setup.to_sun, up_for(setup.to_sun));
    glm::dvec3 lower(1e300);
    glm::dvec3 upper(-1e300);
    for (const Instance& instance : instances) {
        const glm::dvec3 position(instance.position);
        const double radius = static_cast<double>(instance.bounding_radius);
        if (glm::length(position - setup.target) - radius > setup.reach_in_views * setup.view_distance) {
            continue;
        }
        // Of a body larger than the view only the part near the target counts.
        const bool is_huge = radius > setup.view_distance;
        const glm::dvec3 p(light_from_world * glm::dvec4(is_huge ? setup.target : position, 1.0));
        const double shown = (is_huge ? setup.view_distance : radius) + setup.margin;
        lower = glm::min(lower, p - shown);
        upper = glm::max(upper, p + shown);
    }
    if (lower.x > upper.x) {
        lower = glm::dvec3(light_from_world * glm::dvec4(setup.target, 1.0)) - setup.view_distance;
        upper = lower + 2.0 * setup.view_distance;
    }
    // Four texels on each side stay free, so that the filter finds light outside.
    const double side = stepped_size(std::max(upper.x - lower.x, upper.y - lower.y));
    const double texel = std::max(side / (setup.map_size - 8), setup.least_texel);
    const double half = 0.5 * texel * setup.map_size;
    const glm::dvec2 center = glm::round((glm::dvec2(lower) + glm::dvec2(upper)) * 0.5 / texel) * texel;
    const double spare = 0.01 * (upper.z - lower.z);
    const glm::dmat4 clip_from_light = glm::orthoRH_ZO(center.x - half, center.x + half, center.y - half,
                                                       center.y + half, -upper.z - spare, -lower.z + spare);
    const glm::dmat4 clip_from_world = clip_from_light * light_from_world;
    return {glm::mat4(clip_from_world), glm::mat4(glm::inverse(clip_from_world)), static_cast<float>(texel)};
}

} // namespace render
