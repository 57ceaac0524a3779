#include "render/scene/floor_region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace render {

namespace {

constexpr int side_count = static_cast<int>(std::tuple_size_v<FloorRegion>);

/// How far the region reaches in each of the directions.
class Reach {
public:
    explicit Reach(float most) : most_(most) {
        distance_.fill(std::numeric_limits<float>::lowest());
        for (int i = 0; i < side_count; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / side_count;
            direction_[i] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
        }
    }

    void include(const glm::vec2& place, float radius) {
        const glm::vec2 p = glm::clamp(place, -most_, most_);
        for (int i = 0; i < side_count / 2; ++i) {
            const float along = glm::dot(p, direction_[i]);
            distance_[i] = std::max(distance_[i], along + radius);
            distance_[i + side_count / 2] = std::max(distance_[i + side_count / 2], radius - along);
        }
    }

    /// Corners where neighbouring sides meet; a point if nothing was included.
    FloorRegion corners() const {
        FloorRegion result{};
        if (distance_[0] < -most_) {
            return result;
        }
        for (int i = 0; i < side_count; ++i) {
            const int j = (i + 1) % side_count;
            const glm::vec2& a = direction_[i];
            const glm::vec2& b = direction_[j];
            const float area = a.x * b.y - a.y * b.x;
            result[i] =
                glm::vec2(distance_[i] * b.y - distance_[j] * a.y, distance_[j] * a.x - distance_[i] * b.x) /
                area;
        }
        return result;
    }

private:
    float most_;
    std::array<glm::vec2, side_count> direction_;
    std::array<float, side_count> distance_;
};

} // namespace

FloorRegion make_floor_region(const FloorFrame& floor, const FloorRegionSetup& setup,
                              std::span<const glm::vec3> points) {
    Reach reach(setup.most);
    const float sun_height = glm::dot(floor.normal, setup.to_sun);
    if (sun_height < least_sun_height) {
        for (const glm::vec2& corner :
             {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
            reach.include(corner * setup.most, 0.0f);
        }
        return reach.corners();
    }
    const glm::vec2 drift = floor.place(floor.origin + setup.to_sun) / sun_height;
    for (const glm::vec3& point : points) {
        const float height = glm::dot(point - floor.origin, floor.normal);
        const glm::vec2 below = floor.place(point);
        reach.include(below - drift * std::max(height, 0.0f), setup.shadow_margin / sun_height);
        if (height < setup.occlusion_margin) {
            reach.include(below, setup.occlusion_margin);
        }
    }
    return reach.corners();
}

} // namespace render
