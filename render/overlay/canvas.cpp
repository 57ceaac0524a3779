#include "render/overlay/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace render {

namespace {

/// Distance from p to the segment a b.
float segment_distance(const glm::vec2& p, const glm::vec2& a, const glm::vec2& b) {
    const glm::vec2 along = b - a;
    const float length2 = glm::dot(along, along);
    const float t = length2 > 0.0f ? std::clamp(glm::dot(p - a, along) / length2, 0.0f, 1.0f) : 0.0f;
    return glm::length(p - (a + t * along));
}

/// Share of a pixel inside an edge that lies `distance` [px] from its centre, > 0 inside.
float inside(float distance) {
    return std::clamp(distance + 0.5f, 0.0f, 1.0f);
}

/// The pieces of a line that are drawn, and the gaps left out.
std::vector<std::array<glm::vec2, 2>> dashes(std::span<const glm::vec2> points, float dash) {
    std::vector<std::array<glm::vec2, 2>> pieces;
    float travelled = 0.0f;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const glm::vec2 along = points[i + 1] - points[i];
        const float length = glm::length(along);
        if (dash <= 0.0f || length == 0.0f) {
            pieces.push_back({points[i], points[i + 1]});
            continue;
        }
        for (float at = 0.0f; at < length;) {
            const float phase = std::fmod(travelled + at, 2.0f * dash);
            const float end =
                std::min(length, at + std::max(1e-3f, (phase < dash ? dash : 2.0f * dash) - phase));
            if (phase < dash) {
                pieces.push_back({points[i] + along * (at / length), points[i] + along * (end / length)});
            }
            at = end;
        }
        travelled += length;
    }
    return pieces;
}

} // namespace

Canvas::Box Canvas::clipped(const glm::vec2& lower, const glm::vec2& upper) const {
    const auto bound = [](float x, int limit) {
        return static_cast<int>(std::clamp(x, 0.0f, static_cast<float>(limit)));
    };
    return {bound(std::floor(lower.x), image_.width), bound(std::floor(lower.y), image_.height),
            bound(std::ceil(upper.x), image_.width), bound(std::ceil(upper.y), image_.height)};
}

void Canvas::blend(int x, int y, const Paint& paint, float coverage) {
    const float share = paint.alpha * coverage;
    std::uint8_t* pixel =
        image_.rgb.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                                 static_cast<std::size_t>(x));
    for (int c = 0; c < 3; ++c) {
        const float old = static_cast<float>(pixel[c]);
        pixel[c] = static_cast<std::uint8_t>(old + share * (255.0f * paint.color[c] - old) + 0.5f);
    }
}

template <class Coverage>
void Canvas::fill(const Box& box, const Paint& paint, const Coverage& coverage) {
    for (int y = box.y0; y < box.y1; ++y) {
        for (int x = box.x0; x < box.x1; ++x) {
            const float share =
                coverage(glm::vec2(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f));
            if (share > 0.0f) {
                blend(x, y, paint, share);
            }
        }
    }
}

void Canvas::cover_segment(const Box& box, const glm::vec2& a, const glm::vec2& b, float half_width) {
    const float reach = half_width + 1.0f;
    const Box part = clipped(glm::min(a, b) - reach, glm::max(a, b) + reach);
    for (int y = std::max(part.y0, box.y0); y < std::min(part.y1, box.y1); ++y) {
        for (int x = std::max(part.x0, box.x0); x < std::min(part.x1, box.x1); ++x) {
            const glm::vec2 p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
            float& covered =
                coverage_[static_cast<std::size_t>(y - box.y0) * static_cast<std::size_t>(box.x1 - box.x0) +
                          static_cast<std::size_t>(x - box.x0)];
            covered = std::max(covered, inside(half_width - segment_distance(p, a, b)));
        }
    }
}

void Canvas::stroke(std::span<const glm::vec2> points, const Pen& pen) {
    if (points.size() < 2) {
        return;
    }
    glm::vec2 lower = points[0];
    glm::vec2 upper = points[0];
    for (const glm::vec2& p : points) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    // Lines thinner than a pixel are one pixel wide and fainter.
    const float half_width = 0.5f * std::max(pen.width, 1.0f);
    const Box box = clipped(lower - half_width - 1.0f, upper + half_width + 1.0f);
    if (box.x0 >= box.x1 || box.y0 >= box.y1) {
        return;
    }
    coverage_.assign(static_cast<std::size_t>(box.x1 - box.x0) * static_cast<std::size_t>(box.y1 - box.y0),
                     0.0f);
    for (const std::array<glm::vec2, 2>& piece : dashes(points, pen.dash)) {
        cover_segment(box, piece[0], piece[1], half_width);
    }
    const Paint paint{pen.paint.color, pen.paint.alpha * std::min(pen.width, 1.0f)};
    std::size_t i = 0;
    for (int y = box.y0; y < box.y1; ++y) {
        for (int x = box.x0; x < box.x1; ++x, ++i) {
            if (coverage_[i] > 0.0f) {
                blend(x, y, paint, coverage_[i]);
            }
        }
    }
}

void Canvas::disc(const glm::vec2& center, float radius, const Paint& paint) {
    fill(clipped(center - radius - 1.0f, center + radius + 1.0f), paint,
         [&](const glm::vec2& p) { return inside(radius - glm::length(p - center)); });
}

void Canvas::ring(const glm::vec2& center, float radius, float width, const Paint& paint) {
    const float reach = radius + width + 1.0f;
    fill(clipped(center - reach, center + reach), paint, [&](const glm::vec2& p) {
        return inside(0.5f * width - std::abs(glm::length(p - center) - radius));
    });
}

void Canvas::arrow(const glm::vec2& from, const glm::vec2& to, float head, const Pen& pen) {
    const float length = glm::length(to - from);
    if (!(length > 0.0f)) {
        return;
    }
    const glm::vec2 along = (to - from) / length;
    const float head_length = std::min(head, length);
    const float half_head = 0.42f * head_length;
    const glm::vec2 neck = to - along * head_length;
    const float half_width = 0.5f * std::max(pen.width, 1.0f);
    const float reach = half_head + half_width + 1.0f;
    fill(clipped(glm::min(from, to) - reach, glm::max(from, to) + reach), pen.paint, [&](const glm::vec2& p) {
        const float shaft =
            length > head_length ? inside(half_width - segment_distance(p, from, neck)) : 0.0f;
        const float s = glm::dot(p - neck, along); // 0 at the neck, head_length at the tip
        const float side = std::abs((p - neck).x * along.y - (p - neck).y * along.x);
        const float slant = half_head / std::sqrt(half_head * half_head + head_length * head_length);
        const float edge = (half_head * (1.0f - s / head_length) - side) * (slant / 0.42f);
        return std::max(shaft, std::min(inside(edge), inside(s)));
    });
}

void Canvas::panel(const glm::vec2& lower, const glm::vec2& upper, float radius, const Paint& paint) {
    const glm::vec2 center = 0.5f * (lower + upper);
    const glm::vec2 half = 0.5f * (upper - lower) - radius;
    fill(clipped(lower - 1.0f, upper + 1.0f), paint, [&](const glm::vec2& p) {
        const glm::vec2 q = glm::abs(p - center) - half;
        return inside(radius - glm::length(glm::max(q, glm::vec2(0.0f))) -
                      std::min(std::max(q.x, q.y), 0.0f));
    });
}

void Canvas::mask(const Coverage& shape, const Paint& paint) {
    const auto& [x, y, width, height, coverage] = shape;
    for (int row = std::max(0, -y); row < std::min(height, image_.height - y); ++row) {
        for (int column = std::max(0, -x); column < std::min(width, image_.width - x); ++column) {
            const std::uint8_t share = coverage[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                                                static_cast<std::size_t>(column)];
            if (share != 0) {
                blend(x + column, y + row, paint, static_cast<float>(share) / 255.0f);
            }
        }
    }
}

void Canvas::picture(int x, int y, const AlphaImage& picture) {
    for (int row = std::max(0, -y); row < std::min(picture.height, image_.height - y); ++row) {
        for (int column = std::max(0, -x); column < std::min(picture.width, image_.width - x); ++column) {
            const std::uint8_t* rgba = picture.rgba.data() + std::size_t{4} * (static_cast<std::size_t>(row) * picture.width + column);
            blend(x + column, y + row, {glm::vec3(rgba[0], rgba[1], rgba[2]) / 255.0f}, static_cast<float>(rgba[3]) / 255.0f);
        }
    }
}

} // namespace render
