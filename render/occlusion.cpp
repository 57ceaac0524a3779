#include "render/occlusion.h"

#include <algorithm>
#include <cmath>

namespace render {

namespace {

/// Fine cells along one side of a coarse one.
constexpr int coarsening = 4;

/// Distances of the samples above the surface in cells, and the share of the sky each one takes when it lies
/// in filled cells. A cell is as wide as the blur of the volume, so the first sample begins to clear the
/// surface's own body.
struct Tap {
    float distance;
    float weight;
};
constexpr Tap fine_taps[] = {{0.8f, 0.45f}, {2.0f, 0.35f}};
constexpr Tap coarse_tap{5.0f, 0.45f};
/// Filled share that the first sample finds above a lone flat face: taken off.
constexpr float own_share = 0.10f;

/// Trilinear interpolation between cell centres; 0 outside. p in cells.
float interpolated(const std::vector<float>& values, const glm::ivec3& size, const glm::vec3& p) {
    const glm::vec3 q = p - 0.5f;
    const glm::vec3 base = glm::floor(q);
    const glm::ivec3 i(base);
    if (i.x < -1 || i.y < -1 || i.z < -1 || i.x >= size.x || i.y >= size.y || i.z >= size.z) {
        return 0.0f;
    }
    const glm::vec3 f = q - base;
    const int x0 = std::max(i.x, 0);
    const int y0 = std::max(i.y, 0);
    const int z0 = std::max(i.z, 0);
    const int x1 = std::min(i.x + 1, size.x - 1);
    const int y1 = std::min(i.y + 1, size.y - 1);
    const int z1 = std::min(i.z + 1, size.z - 1);
    const auto row = [&](int y, int z) {
        const float* at = values.data() + (static_cast<std::size_t>(z) * size.y + y) * size.x;
        return at[x0] + f.x * (at[x1] - at[x0]);
    };
    const float lower = row(y0, z0) + f.y * (row(y1, z0) - row(y0, z0));
    const float upper = row(y0, z1) + f.y * (row(y1, z1) - row(y0, z1));
    return lower + f.z * (upper - lower);
}

/// Radius of a profile at height z; 0 beyond its ends. Where the profile overhangs, the largest.
float profile_radius(std::span<const glm::vec2> profile, float z) {
    float radius = 0.0f;
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        const glm::vec2 a = profile[i];
        const glm::vec2 b = profile[i + 1];
        if ((z < a.y) == (z < b.y)) {
            continue;
        }
        radius = std::max(radius, a.x + (b.x - a.x) * (z - a.y) / (b.y - a.y));
    }
    return radius;
}

} // namespace

OcclusionVolume::OcclusionVolume(const glm::vec3& lower, const glm::vec3& upper, float cell) : cell_(cell) {
    const glm::vec3 first = glm::floor(lower / cell);
    const glm::vec3 last = glm::ceil(upper / cell);
    size_ = glm::clamp(glm::ivec3(last - first), glm::ivec3(1), glm::ivec3(most_cells));
    lower_ = first * cell;
    filled_.assign(static_cast<std::size_t>(size_.x) * size_.y * size_.z, 0.0f);
}

/// Adds share(p) 0..1 to each cell near the instance, p [m] in its frame.
template <class Share>
void OcclusionVolume::add(const Instance& instance, const glm::vec3& half, const Share& share) {
    const glm::vec3 center = (instance.position - lower_) / cell_;
    // A box of half extents `half` in the instance's frame holds it; this is how far that reaches along the
    // axes.
    glm::vec3 reach(0.5f);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 edge(0.0f);
        edge[axis] = half[axis] / cell_;
        reach += glm::abs(turned(instance.orientation, edge));
    }
    const glm::ivec3 from = glm::max(glm::ivec3(glm::floor(glm::max(center - reach, -1.0f))), 0);
    const glm::ivec3 to = glm::min(glm::ivec3(glm::ceil(glm::min(center + reach, 1e6f))), size_);
    const glm::vec3 step_x = turned_back(instance.orientation, {cell_, 0, 0});
    for (int z = from.z; z < to.z; ++z) {
        for (int y = from.y; y < to.y; ++y) {
            const glm::vec3 first((static_cast<float>(from.x) + 0.5f - center.x) * cell_,
                                  (static_cast<float>(y) + 0.5f - center.y) * cell_,
                                  (static_cast<float>(z) + 0.5f - center.z) * cell_);
            const glm::vec3 p = turned_back(instance.orientation, first);
            // Only the part of the row that lies in the box of half extents `half`, and half a cell around
            // it.
            float begin = 0.0f;
            float end = static_cast<float>(to.x - from.x - 1);
            for (int axis = 0; axis < 3; ++axis) {
                const float limit = half[axis] + 0.5f * cell_;
                if (std::abs(step_x[axis]) > 1e-6f * cell_) {
                    const float a = (-limit - p[axis]) / step_x[axis];
                    const float b = (limit - p[axis]) / step_x[axis];
                    begin = std::max(begin, std::min(a, b));
                    end = std::min(end, std::max(a, b));
                } else if (std::abs(p[axis]) > limit) {
                    end = -1.0f;
                }
            }
            float* row = filled_.data() + (static_cast<std::size_t>(z) * size_.y + y) * size_.x + from.x;
            for (int i = static_cast<int>(std::ceil(begin)); static_cast<float>(i) <= end; ++i) {
                row[i] = std::min(1.0f, row[i] + share(p + step_x * static_cast<float>(i)));
            }
        }
    }
}

void OcclusionVolume::add_box(const Instance& box) {
    const float inverse = 1.0f / cell_;
    const glm::vec3 half = box.scale * inverse + 0.5f;
    add(box, box.scale, [&](const glm::vec3& p) {
        const glm::vec3 inside = glm::clamp(half - glm::abs(p) * inverse, 0.0f, 1.0f);
        return inside.x * inside.y * inside.z;
    });
}

void OcclusionVolume::add_ellipsoid(const Instance& instance) {
    const glm::vec3 inverse_scale = 1.0f / instance.scale;
    const float least = std::min({instance.scale.x, instance.scale.y, instance.scale.z});
    add(instance, instance.scale, [&](const glm::vec3& p) {
        return glm::clamp(0.5f + (1.0f - glm::length(p * inverse_scale)) * least / cell_, 0.0f, 1.0f);
    });
}

void OcclusionVolume::add_lathe(const Instance& instance, std::span<const glm::vec2> profile) {
    add(instance, glm::vec3(instance.bounding_radius), [&](const glm::vec3& p) {
        const float radius = profile_radius(profile, p.z);
        return radius <= 0.0f ? 0.0f
                              : glm::clamp(0.5f + (radius - glm::length(glm::vec2(p))) / cell_, 0.0f, 1.0f);
    });
}

void OcclusionVolume::add_half_space(const glm::vec3& origin, const glm::vec3& normal) {
    for (int z = 0; z < size_.z; ++z) {
        for (int y = 0; y < size_.y; ++y) {
            const glm::vec3 first = lower_ + (glm::vec3(0, y, z) + 0.5f) * cell_ - origin;
            float depth = 0.5f - glm::dot(first, normal) / cell_;
            if (depth <= 0.0f && depth - normal.x * static_cast<float>(size_.x) <= 0.0f) {
                continue;
            }
            float* row = filled_.data() + (static_cast<std::size_t>(z) * size_.y + y) * size_.x;
            for (int x = 0; x < size_.x; ++x) {
                row[x] = std::min(1.0f, row[x] + std::clamp(depth, 0.0f, 1.0f));
                depth -= normal.x;
            }
        }
    }
}

void OcclusionVolume::finish() {
    coarse_size_ = (size_ + coarsening - 1) / coarsening;
    coarse_.assign(static_cast<std::size_t>(coarse_size_.x) * coarse_size_.y * coarse_size_.z, 0.0f);
    std::vector<float> sum(static_cast<std::size_t>(coarse_size_.x) * coarsening);
    for (int z = 0; z < coarse_size_.z; ++z) {
        for (int y = 0; y < coarse_size_.y; ++y) {
            // The rows of one row of coarse cells are added first, then its columns.
            std::fill(sum.begin(), sum.end(), 0.0f);
            for (int k = 0; k < coarsening * coarsening; ++k) {
                const int fine_z = z * coarsening + k / coarsening;
                const int fine_y = y * coarsening + k % coarsening;
                if (fine_z < size_.z && fine_y < size_.y) {
                    const float* row =
                        filled_.data() + (static_cast<std::size_t>(fine_z) * size_.y + fine_y) * size_.x;
                    for (int x = 0; x < size_.x; ++x) {
                        sum[x] += row[x];
                    }
                }
            }
            float* to = coarse_.data() + (static_cast<std::size_t>(z) * coarse_size_.y + y) * coarse_size_.x;
            for (int x = 0; x < coarse_size_.x; ++x) {
                to[x] = sum[4 * x] + sum[4 * x + 1] + sum[4 * x + 2] + sum[4 * x + 3];
            }
        }
    }
    constexpr float share = 1.0f / (coarsening * coarsening * coarsening);
    for (float& value : coarse_) {
        value *= share;
    }
}

float OcclusionVolume::open_share(const glm::vec3& position, const glm::vec3& normal) const {
    if (filled_.empty()) {
        return 1.0f;
    }
    const glm::vec3 p = (position - lower_) / cell_;
    float open = 1.0f;
    float own = own_share;
    for (const Tap& tap : fine_taps) {
        const float filled = interpolated(filled_, size_, p + normal * tap.distance);
        open *= 1.0f - tap.weight * std::max(0.0f, filled - own) / (1.0f - own);
        own = 0.0f;
    }
    const glm::vec3 far = (p + normal * coarse_tap.distance) / static_cast<float>(coarsening);
    return open * (1.0f - coarse_tap.weight * interpolated(coarse_, coarse_size_, far));
}

} // namespace render
