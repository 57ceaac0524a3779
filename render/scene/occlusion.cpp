#include "render/scene/occlusion.h"

#include "render/scene/float4.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace render {

namespace {

/// The sky over a surface is divided among four directions that lean towards its sides. Each is sampled
/// twice: near by in the cells, farther away in cells of twice the side, at distances where the blur of the
/// cells just clears the surface's own body; straight above one sample in the largest cells tells of the
/// surroundings. Distance [cells], share of the sky taken when the sample lies in filled cells, level of the
/// cells.
struct Tap {
    float distance;
    float weight;
    int level;
};
constexpr Tap leaning_taps[] = {{1.8f, 0.60f, 0}, {3.6f, 0.50f, 1}};
constexpr int last_cell = OcclusionVolume::most_cells + 1;
constexpr Tap upright_tap{6.0f, 0.40f, 2};
/// Filled share that a sample may find above a lone flat face that lies askew: taken off.
constexpr float own_share = 0.03f;

template <class Vector>
Vector least(Vector a, Vector b) {
    return chosen(a < b, a, b);
}
template <class Vector>
Vector largest(Vector a, Vector b) {
    return chosen(a > b, a, b);
}

/// Four points or directions: x, y, z.
using Points4 = std::array<Float4, 3>;

Float4 open_after(const Tap& tap, Float4 filled) {
    return all(1.0f) - all(tap.weight) * largest(all(0.0f), filled - all(own_share)) / all(1.0f - own_share);
}

/// Cells on both sides of a place along one axis, and where between their centres it lies.
struct Between {
    Int4 lower;
    Int4 upper;
    Float4 share;
};

/// p in cells. Clears `is_inside` where it lies outside.
[[gnu::always_inline]] inline Between between_cells(Float4 p, int size, Int4& is_inside) {
    // floor() of what may lie a little below 0.
    constexpr int below = 1024;
    const Float4 q = least(largest(p - all(0.5f), all(-2.0f)), all(static_cast<float>(last_cell)));
    const Int4 i = __builtin_convertvector(q + all(static_cast<float>(below)), Int4) - all(below);
    is_inside = is_inside & (i >= all(-1)) & (i < all(size));
    const Int4 end = all(size - 1);
    return {largest(least(i, end), all(0)), largest(least(i + all(1), end), all(0)),
            q - __builtin_convertvector(i, Float4)};
}

/// Trilinear interpolation between cell centres; 0 outside. p in cells.
[[gnu::always_inline]] inline Float4 interpolated(const OcclusionVolume::Level& level, const Points4& p) {
    const glm::ivec3& size = level.size;
    Int4 is_inside = all(-1);
    const Between x = between_cells(p[0], size.x, is_inside);
    const Between y = between_cells(p[1], size.y, is_inside);
    const Between z = between_cells(p[2], size.z, is_inside);
    const auto row = [&](Int4 at_y, Int4 at_z) {
        const Int4 first = (at_z * all(size.y) + at_y) * all(size.x);
        const Int4 lower = first + x.lower;
        const Int4 upper = first + x.upper;
        Float4 a;
        Float4 b;
        for (int k = 0; k < 4; ++k) {
            a[k] = level.filled[static_cast<std::size_t>(lower[k])];
            b[k] = level.filled[static_cast<std::size_t>(upper[k])];
        }
        return a + x.share * (b - a);
    };
    const Float4 a = row(y.lower, z.lower);
    const Float4 b = row(y.lower, z.upper);
    const Float4 lower = a + y.share * (row(y.upper, z.lower) - a);
    const Float4 upper = b + y.share * (row(y.upper, z.upper) - b);
    return chosen(is_inside, lower + z.share * (upper - lower), all(0.0f));
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
    const glm::ivec3 size = glm::clamp(glm::ivec3(last - first), glm::ivec3(1), glm::ivec3(most_cells));
    lower_ = first * cell;
    levels_[0] = {size, std::vector<float>(static_cast<std::size_t>(size.x) * size.y * size.z, 0.0f)};
}

/// A row of cells in an instance's frame [m]: the first at p, each further one a step on.
struct CellRow {
    glm::vec3 p;
    glm::vec3 step;
    glm::vec3 per_step; ///< 1 / step: the same for all rows of an instance
    float begin; ///< of the cells 0.. that are worth a look, the first and last
    float end;

    /// Keeps those where f, which changes by `slope` from cell to cell, is at most `limit`.
    void keep(float f, float slope, float limit) {
        if (std::abs(slope) <= 1e-6f * std::abs(limit)) {
            end = f > limit ? -1.0f : end;
        } else if (slope > 0.0f) {
            end = std::min(end, (limit - f) / slope);
        } else {
            begin = std::max(begin, (limit - f) / slope);
        }
    }
};

/// Adds share(p) 0..1 to each cell near the instance, p [m] in its frame. A box of half extents `half` in that frame
/// holds it; clip(row) keeps the cells of a row that it may reach.
template <class Clip, class Share>
void OcclusionVolume::add(const Instance& instance, const glm::vec3& half, const Clip& clip, const Share& share) {
    const glm::ivec3& size = levels_[0].size;
    const glm::vec3 center = (instance.position - lower_) / cell_;
    // How far the box reaches along the axes.
    glm::vec3 reach(0.5f);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 edge(0.0f);
        edge[axis] = half[axis] / cell_;
        reach += glm::abs(turned(instance.orientation, edge));
    }
    const glm::ivec3 from = glm::max(glm::ivec3(glm::floor(glm::max(center - reach, -1.0f))), 0);
    const glm::ivec3 to = glm::min(glm::ivec3(glm::ceil(glm::min(center + reach, 1e6f))), size);
    const glm::vec3 step = turned_back(instance.orientation, {cell_, 0, 0});
    CellRow cells{{}, step, 1.0f / step, 0.0f, 0.0f};
    for (int z = from.z; z < to.z; ++z) {
        for (int y = from.y; y < to.y; ++y) {
            const glm::vec3 first((static_cast<float>(from.x) + 0.5f - center.x) * cell_,
                                  (static_cast<float>(y) + 0.5f - center.y) * cell_,
                                  (static_cast<float>(z) + 0.5f - center.z) * cell_);
            cells.p = turned_back(instance.orientation, first);
            cells.begin = 0.0f;
            cells.end = static_cast<float>(to.x - from.x - 1);
            clip(cells);
            if (cells.begin > cells.end) {
                continue; // between 0 and the last otherwise
            }
            float* row =
                levels_[0].filled.data() + (static_cast<std::size_t>(z) * size.y + y) * size.x + from.x;
            const auto last = static_cast<int>(cells.end);
            auto i = static_cast<int>(cells.begin);
            for (i += static_cast<float>(i) < cells.begin ? 1 : 0; i <= last; ++i) {
                row[i] = std::min(1.0f, row[i] + share(cells.p + cells.step * static_cast<float>(i)));
            }
        }
    }
}

/// Clips to a box of half extents `half`, and half a cell around it.
auto OcclusionVolume::to_box(const glm::vec3& half) const {
    return [limit = half + 0.5f * cell_](CellRow& row) {
        // Across the row these are infinite, or no numbers where all shares are 0.
        const glm::vec3 from_lower = (-limit - row.p) * row.per_step;
        const glm::vec3 from_upper = (limit - row.p) * row.per_step;
        const glm::vec3 begin = glm::min(from_lower, from_upper);
        const glm::vec3 end = glm::max(from_lower, from_upper);
        row.begin = std::max({row.begin, begin.x, begin.y, begin.z});
        row.end = std::min({row.end, end.x, end.y, end.z});
    };
}

void OcclusionVolume::add_box(const Instance& box) {
    const float inverse = 1.0f / cell_;
    const glm::vec3 half = box.scale * inverse + 0.5f;
    add(box, box.scale, to_box(box.scale), [&](const glm::vec3& p) {
        const glm::vec3 inside = glm::clamp(half - glm::abs(p) * inverse, 0.0f, 1.0f);
        return inside.x * inside.y * inside.z;
    });
}

void OcclusionVolume::add_ellipsoid(const Instance& instance) {
    const glm::vec3 inverse_scale = 1.0f / instance.scale;
    const float least = std::min({instance.scale.x, instance.scale.y, instance.scale.z});
    add(instance, instance.scale, to_box(instance.scale), [&](const glm::vec3& p) {
        return glm::clamp(0.5f + (1.0f - glm::length(p * inverse_scale)) * least / cell_, 0.0f, 1.0f);
    });
}

void OcclusionVolume::add_lathe(const Instance& instance, std::span<const glm::vec2> profile) {
    const glm::vec3 half(instance.bounding_radius);
    add(instance, half, to_box(half), [&](const glm::vec3& p) {
        const float radius = profile_radius(profile, p.z);
        return radius <= 0.0f ? 0.0f
                              : glm::clamp(0.5f + (radius - glm::length(glm::vec2(p))) / cell_, 0.0f, 1.0f);
    });
}

void OcclusionVolume::add_hull(const Instance& instance, std::span<const HullFace> faces) {
    const glm::vec3 half(instance.bounding_radius);
    const auto clip = [&, to_ball = to_box(half)](CellRow& row) {
        to_ball(row);
        for (const HullFace& face : faces) {
            row.keep(glm::dot(face.normal, row.p - face.corners[0]), glm::dot(face.normal, row.step), 0.51f * cell_);
        }
    };
    add(instance, half, clip, [&](const glm::vec3& p) {
        float outside = -instance.bounding_radius;
        for (const HullFace& face : faces) {
            outside = std::max(outside, glm::dot(face.normal, p - face.corners[0]));
        }
        return glm::clamp(0.5f - outside / cell_, 0.0f, 1.0f);
    });
}

void OcclusionVolume::add_half_space(const glm::vec3& origin, const glm::vec3& normal) {
    const glm::ivec3& size = levels_[0].size;
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            const glm::vec3 first = lower_ + (glm::vec3(0, y, z) + 0.5f) * cell_ - origin;
            float depth = 0.5f - glm::dot(first, normal) / cell_;
            if (depth <= 0.0f && depth - normal.x * static_cast<float>(size.x) <= 0.0f) {
                continue;
            }
            float* row = levels_[0].filled.data() + (static_cast<std::size_t>(z) * size.y + y) * size.x;
            for (int x = 0; x < size.x; ++x) {
                row[x] = std::min(1.0f, row[x] + std::clamp(depth, 0.0f, 1.0f));
                depth -= normal.x;
            }
        }
    }
}

/// A level of cells twice as large.
OcclusionVolume::Level OcclusionVolume::coarser(const Level& fine) {
    const glm::ivec3 size = (fine.size + 1) / 2;
    Level coarse{size, std::vector<float>(static_cast<std::size_t>(size.x) * size.y * size.z, 0.0f)};
    std::vector<float> sum(static_cast<std::size_t>(size.x) * 2, 0.0f);
    for (int row = 0; row < size.y * size.z; ++row) {
        // The four rows of one row of larger cells are added first, then its columns.
        std::fill(sum.begin(), sum.end(), 0.0f);
        for (int i = 0; i < 4; ++i) {
            const int z = 2 * (row / size.y) + i / 2;
            const int y = 2 * (row % size.y) + i % 2;
            if (z < fine.size.z && y < fine.size.y) {
                const float* from = fine.filled.data() + (static_cast<std::size_t>(z) * fine.size.y + y) * fine.size.x;
                for (int x = 0; x < fine.size.x; ++x) {
                    sum[x] += from[x];
                }
            }
        }
        float* to = coarse.filled.data() + static_cast<std::size_t>(row) * size.x;
        for (int x = 0; x < size.x; ++x) {
            to[x] = (sum[2 * x] + sum[2 * x + 1]) * 0.125f;
        }
    }
    return coarse;
}

void OcclusionVolume::finish() {
    for (std::size_t k = 1; k < levels_.size(); ++k) {
        levels_[k] = coarser(levels_[k - 1]);
    }
}

float OcclusionVolume::open_share(const glm::vec3& position, const glm::vec3& normal) const {
    return open_shares({position, position, position, position}, normal)[0];
}

FOR_ALL_AND_AVX2
std::array<float, 4> OcclusionVolume::open_shares(const std::array<glm::vec3, 4>& positions,
                                                  const glm::vec3& normal) const {
    if (is_empty()) {
        return {1.0f, 1.0f, 1.0f, 1.0f};
    }
    Points4 p{};
    for (int k = 0; k < 4; ++k) {
        const glm::vec3 place = (positions[static_cast<std::size_t>(k)] - lower_) / cell_;
        for (int axis = 0; axis < 3; ++axis) {
            p[static_cast<std::size_t>(axis)][k] = place[axis];
        }
    }
    const auto open_at = [&](const Tap& tap, const glm::vec3& direction) __attribute__((always_inline)) {
        Points4 at{};
        const float scale = 1.0f / static_cast<float>(1 << tap.level);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            at[axis] = (p[axis] + all(direction[static_cast<int>(axis)] * tap.distance)) * all(scale);
        }
        return open_after(tap, interpolated(level(tap.level), at));
    };
    // Any two directions across the normal will do.
    const glm::vec3 side = std::abs(normal.z) < 0.7f ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
    const glm::vec3 t = glm::normalize(glm::cross(side, normal));
    const glm::vec3 s = glm::cross(normal, t);
    constexpr float lean = 0.70710678f;
    Float4 open{};
    for (const glm::vec3& across : {t, -t, s, -s}) {
        const glm::vec3 direction = (normal + across) * lean;
        open += all(0.25f) * open_at(leaning_taps[0], direction) * open_at(leaning_taps[1], direction);
    }
    open *= open_at(upright_tap, normal);
    return {open[0], open[1], open[2], open[3]};
}

} // namespace render
