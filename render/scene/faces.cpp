#include "render/scene/faces.h"

#include "render/scene/projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace render {

namespace {

/// A face larger than this many cells of the occlusion volume is large.
constexpr float small_cells = 4.0f;
/// Points along one side of a large face at which the share of the sky is taken, at most.
constexpr int most_points = SkyAtlas::width / 2;

/// Places rectangles in rows of the atlas: each row as high as its highest one.
class AtlasRows {
public:
    explicit AtlasRows(SkyAtlas& atlas) : atlas_(atlas) {}

    /// Lowest corner of a free rectangle; width at most that of the atlas.
    glm::ivec2 place(int width, int height) {
        if (next_.x + width > SkyAtlas::width) {
            next_ = {0, next_.y + row_height_};
            row_height_ = 0;
        }
        const glm::ivec2 at = next_;
        next_.x += width;
        row_height_ = std::max(row_height_, height);
        atlas_.height = std::max(atlas_.height, next_.y + row_height_);
        atlas_.open.resize(static_cast<std::size_t>(atlas_.height) * SkyAtlas::width, 1.0f);
        return at;
    }

private:
    SkyAtlas& atlas_;
    glm::ivec2 next_{0};
    int row_height_ = 0;
};

std::uint32_t packed_share(float share) {
    return static_cast<std::uint32_t>(std::clamp(share, 0.0f, 1.0f) * 255.0f + 0.5f);
}

/// Collects the faces that the camera sees, kind by kind.
class FaceMaker {
public:
    FaceMaker(const SceneGeometry& geometry, DrawList& list)
        : geometry_(geometry), list_(list), rows_(list.sky_atlas) {}

    void add_box(const Part& box) {
        const Instance& instance = box.instance;
        if (is_outside(list_.camera, instance.position, instance.bounding_radius)) {
            return;
        }
        for (int axis = 0; axis < 3; ++axis) {
            for (const float side : {1.0f, -1.0f}) {
                add_face(box, axis, side);
            }
        }
        ++box_count_;
    }

    /// Moves the faces into the list, kind by kind, and numbers them.
    void finish() {
        std::size_t count = 0;
        for (const auto& [kind, faces] : faces_) {
            count += faces.size();
        }
        list_.faces.reserve(count);
        for (auto& [kind, faces] : faces_) {
            list_.face_batches.push_back(
                {kind, static_cast<int>(list_.faces.size()), static_cast<int>(faces.size())});
            for (Face& face : faces) {
                list_.body_of_id.push_back(face.id);
                face.id = static_cast<std::uint32_t>(list_.faces.size() + 1);
                // Known only now: in texels so far.
                face.open_place /= glm::vec4(SkyAtlas::width, list_.sky_atlas.height, SkyAtlas::width,
                                             list_.sky_atlas.height);
                list_.faces.push_back(face);
            }
        }
    }

private:
    void add_face(const Part& box, int axis, float side) {
        const Instance& instance = box.instance;
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        const auto unit = [&](int k) {
            glm::vec3 e(0.0f);
            e[k] = 1.0f;
            return turned(instance.orientation, e);
        };
        const glm::vec3 normal = unit(axis) * side;
        Face face{};
        face.id = box.body; // until finish() numbers the faces
        face.box = box_count_;
        face.center = instance.position + normal * instance.scale[axis];
        if (glm::dot(normal, list_.camera.eye - face.center) <= 0.0f) {
            return;
        }
        face.half_u = unit(u) * (instance.scale[u] * side);
        face.half_v = unit(v) * instance.scale[v];
        face.roughness = instance.roughness;
        face.metallic = instance.metallic;
        face.color = instance.color;
        face.pattern_color = instance.pattern_color;
        // A grid is counted in metres from the body's middle, the other patterns in shares of its size.
        const bool is_metric = box.pattern == sim::Pattern::grid;
        const glm::vec3 half = is_metric ? instance.scale / geometry_.grid_spacing : glm::vec3(0.5f);
        face.body_center = glm::vec3(is_metric ? 0.0f : 0.5f);
        face.body_center[axis] += half[axis] * side;
        face.body_half_u[u] = half[u] * side;
        face.body_half_v[v] = half[v];

        const float largest = 2.0f * std::max(instance.scale[u], instance.scale[v]);
        const FaceKind kind{box.pattern, glm::dot(normal, geometry_.light.to_sun) > 0.0f,
                            instance.metallic > 0.0f,
                            !list_.occlusion.is_empty() && largest > small_cells * list_.occlusion.cell()};
        if (kind.is_large) {
            fill_atlas(normal, face);
        } else {
            const std::array<float, 4> open =
                list_.occlusion.open_shares({on_face(face, {-1, -1}), on_face(face, {1, -1}),
                                             on_face(face, {-1, 1}), on_face(face, {1, 1})},
                                            normal);
            for (std::size_t k = 0; k < open.size(); ++k) {
                face.open_corners |= packed_share(open[k]) << (8 * k);
            }
        }
        faces_[kind].push_back(face);
    }

    static glm::vec3 on_face(const Face& face, const glm::vec2& place) {
        return face.center + face.half_u * place.x + face.half_v * place.y;
    }

    void fill_atlas(const glm::vec3& normal, Face& face) {
        const auto points_along = [this](const glm::vec3& half) {
            const float n = 2.0f * glm::length(half) / list_.occlusion.point_distance();
            return static_cast<int>(std::clamp(std::ceil(n) + 1.0f, 2.0f, static_cast<float>(most_points)));
        };
        const glm::ivec2 count(points_along(face.half_u), points_along(face.half_v));
        const glm::ivec2 at = rows_.place(count.x, count.y);
        for (int j = 0; j < count.y; ++j) {
            float* row =
                list_.sky_atlas.open.data() + static_cast<std::size_t>(at.y + j) * SkyAtlas::width + at.x;
            for (int i = 0; i < count.x; i += 4) {
                std::array<glm::vec3, 4> points;
                for (int k = 0; k < 4; ++k) {
                    points[static_cast<std::size_t>(k)] =
                        on_face(face, 2.0f * glm::vec2(i + k, j) / glm::vec2(count - 1) - 1.0f);
                }
                const std::array<float, 4> open = list_.occlusion.open_shares(points, normal);
                std::copy_n(open.begin(), std::min(4, count.x - i), row + i);
            }
        }
        // The face's edges lie at the middle of the outermost texels.
        face.open_place = glm::vec4(glm::vec2(at) + 0.5f, glm::vec2(at + count) - 0.5f);
    }

    const SceneGeometry& geometry_;
    DrawList& list_;
    AtlasRows rows_;
    std::uint32_t box_count_ = 0;
    std::map<FaceKind, std::vector<Face>> faces_;
};

} // namespace

void add_faces(std::span<const Part> boxes, const SceneGeometry& geometry, DrawList& list) {
    FaceMaker maker(geometry, list);
    for (const Part& box : boxes) {
        maker.add_box(box);
    }
    maker.finish();
}

} // namespace render
