#pragma once
/// Ambient occlusion: how much of the sky a point sees, from a coarse volume of what is filled with bodies.
#include "render/scene/draw_types.h"
#include "render/scene/mesh.h"

#include <glm/glm.hpp>

#include <array>
#include <span>
#include <vector>

namespace render {

/// Filled share of the cells of a grid, and of cells twice and four times as large.
class OcclusionVolume {
public:
    OcclusionVolume() = default;
    /// Empty volume of cells of side `cell` [m] that covers lower..upper [m]; its place is a multiple of the
    /// cell, its size at most `most_cells` along an axis.
    OcclusionVolume(const glm::vec3& lower, const glm::vec3& upper, float cell);

    void add_box(const Instance& box);
    /// A sphere, a rod, or what fills about the same: an ellipsoid of the instance's scale.
    void add_ellipsoid(const Instance& instance);
    /// Surface of revolution of the given (radius, z) profile [m].
    void add_lathe(const Instance& instance, std::span<const glm::vec2> profile);
    /// A convex body [m].
    void add_hull(const Instance& instance, std::span<const HullFace> faces);
    /// All below the plane through `origin` with unit `normal`.
    void add_half_space(const glm::vec3& origin, const glm::vec3& normal);
    /// Call once, when all is added: prepares what is seen from afar.
    void finish();

    /// Share 0..1 of the sky that is open at a point of a surface with unit normal; 1 outside the volume.
    float open_share(const glm::vec3& position, const glm::vec3& normal) const;
    /// The same at four points of one surface.
    std::array<float, 4> open_shares(const std::array<glm::vec3, 4>& positions,
                                     const glm::vec3& normal) const;

    /// Filled share 0..1 of the cells of one size.
    struct Level {
        glm::ivec3 size{0};        ///< cells
        std::vector<float> filled; ///< [size.z][size.y][size.x]
    };
    /// Level k has cells of 2^k times the side; all levels have the same lower corner.
    static constexpr int level_count = 3;
    const Level& level(int k) const { return levels_[static_cast<std::size_t>(k)]; }

    bool is_empty() const { return levels_[0].filled.empty(); }
    float cell() const { return cell_; }
    /// Between points of a large surface at which the share of the sky is taken [m]; at cells and a half, what is
    /// interpolated between them cannot be told from a point in each cell.
    float point_distance() const { return 1.5f * cell_; }
    glm::vec3 lower() const { return lower_; }
    glm::vec3 upper() const { return lower_ + glm::vec3(levels_[0].size) * cell_; }

    static constexpr int most_cells = 192;

private:
    static Level coarser(const Level& fine);
    template <class Clip, class Share>
    void add(const Instance& instance, const glm::vec3& half, const Clip& clip, const Share& share);
    auto to_box(const glm::vec3& half) const;

    glm::vec3 lower_{0.0f}; ///< [m]
    float cell_ = 1.0f;     ///< [m]
    std::array<Level, level_count> levels_;
};

} // namespace render
