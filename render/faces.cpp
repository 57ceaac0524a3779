#include "render/faces.h"

#include "render/projection.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace render {

namespace {

/// Sky shares are taken at the corners of patches: at least this many cells a side, and about this many
/// patches over all large faces.
constexpr float least_patch_cells = 1.5f;
constexpr float most_patches = 4000.0f;

/// Divides the faces that the camera sees into patches.
class FaceMaker {
public:
    FaceMaker(DrawList& list, float patch_size) : list_(list), patch_size_(patch_size) {}

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
    }

    /// Moves the patches into the list, batch by batch.
    void finish() {
        for (std::size_t key = 0; key < patches_.size(); ++key) {
            if (patches_[key].empty()) {
                continue;
            }
            list_.face_batches.push_back({static_cast<sim::Pattern>(key / 2), key % 2 == 0,
                                          static_cast<int>(list_.faces.size()),
                                          static_cast<int>(patches_[key].size())});
            list_.faces.insert(list_.faces.end(), patches_[key].begin(), patches_[key].end());
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
        WholeFace whole{instance.position + normal * instance.scale[axis],
                        unit(u) * (instance.scale[u] * side), unit(v) * instance.scale[v]};
        if (glm::dot(normal, list_.camera.eye - whole.center) <= 0.0f) {
            return;
        }
        list_.whole_faces.push_back(whole);

        Face face{};
        face.roughness = instance.roughness;
        face.metallic = instance.metallic;
        face.id = static_cast<std::uint32_t>(list_.whole_faces.size());
        face.color = instance.color;
        face.pattern_color = instance.pattern_color;
        // A grid is counted in metres from the body's middle, the other patterns in shares of its size.
        const bool is_metric = box.pattern == sim::Pattern::grid;
        const glm::vec3 half = is_metric ? instance.scale / list_.grid_spacing : glm::vec3(0.5f);
        face.body_center = glm::vec3(is_metric ? 0.0f : 0.5f);
        face.body_center[axis] += half[axis] * side;
        face.body_half_u[u] = half[u] * side;
        face.body_half_v[v] = half[v];
        const bool is_lit = glm::dot(normal, list_.light.to_sun) > 0.0f;
        const auto key = 2 * static_cast<std::size_t>(box.pattern) + (is_lit ? 0 : 1);
        divide(face, whole, normal, patches_[key]);
    }

    void divide(const Face& face, const WholeFace& whole, const glm::vec3& normal,
                std::vector<Face>& patches) {
        const auto count = [this](const glm::vec3& half) {
            const float n = std::ceil(2.0f * glm::length(half) / patch_size_ - 0.25f);
            return static_cast<int>(std::clamp(n, 1.0f, 64.0f));
        };
        const int count_u = count(whole.half_u);
        const int count_v = count(whole.half_v);
        // Sky shares at all corners, row by row.
        open_.clear();
        for (int j = 0; j <= count_v; ++j) {
            for (int i = 0; i <= count_u; ++i) {
                const glm::vec3 corner =
                    whole.center +
                    whole.half_u * (2.0f * static_cast<float>(i) / static_cast<float>(count_u) - 1.0f) +
                    whole.half_v * (2.0f * static_cast<float>(j) / static_cast<float>(count_v) - 1.0f);
                open_.push_back(list_.occlusion.open_share(corner, normal));
            }
        }
        const float share_u = 1.0f / static_cast<float>(count_u);
        const float share_v = 1.0f / static_cast<float>(count_v);
        for (int j = 0; j < count_v; ++j) {
            for (int i = 0; i < count_u; ++i) {
                const float at_u = static_cast<float>(2 * i + 1) * share_u - 1.0f;
                const float at_v = static_cast<float>(2 * j + 1) * share_v - 1.0f;
                const std::size_t first = static_cast<std::size_t>(j) * (count_u + 1) + i;
                Face patch = face;
                patch.center = whole.center + whole.half_u * at_u + whole.half_v * at_v;
                patch.half_u = whole.half_u * share_u;
                patch.half_v = whole.half_v * share_v;
                patch.open = {open_[first], open_[first + 1], open_[first + count_u + 1],
                              open_[first + count_u + 2]};
                patch.body_center = face.body_center + face.body_half_u * at_u + face.body_half_v * at_v;
                patch.body_half_u = face.body_half_u * share_u;
                patch.body_half_v = face.body_half_v * share_v;
                patches.push_back(patch);
            }
        }
    }

    DrawList& list_;
    float patch_size_;
    std::array<std::vector<Face>, 8> patches_; ///< by pattern and whether lit
    std::vector<float> open_;
};

/// Patches so large that the large faces of all boxes together have about `most_patches`.
float patch_size(std::span<const Part> boxes, float cell) {
    float area = 0.0f;
    for (const Part& box : boxes) {
        const glm::vec3 s = box.instance.scale;
        if (std::max({s.x, s.y, s.z}) > 4.0f * cell) {
            area += 4.0f * (s.x * s.y + s.y * s.z + s.z * s.x);
        }
    }
    return std::max(least_patch_cells * cell, std::sqrt(area / most_patches));
}

} // namespace

void add_faces(std::span<const Part> boxes, DrawList& list) {
    FaceMaker maker(list, patch_size(boxes, list.occlusion.cell()));
    for (const Part& box : boxes) {
        maker.add_box(box);
    }
    maker.finish();
}

} // namespace render
