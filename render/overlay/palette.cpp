#include "render/overlay/palette.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace render {

namespace {

glm::vec3 from_hex(unsigned rgb) {
    return glm::vec3(rgb >> 16, (rgb >> 8) & 0xFF, rgb & 0xFF) / 255.0f;
}

constexpr std::array<unsigned, 7> okabe_ito{0xE69F00, 0x56B4E9, 0x009E73, 0xF0E442,
                                            0x0072B2, 0xD55E00, 0xCC79A7};

/// Every eighth of the map.
constexpr std::array<unsigned, 9> viridis{0x440154, 0x472D7B, 0x3B528B, 0x2C728E, 0x21918C,
                                          0x28AE80, 0x5EC962, 0xADDC30, 0xFDE725};

} // namespace

glm::vec3 category_color(int index) {
    return from_hex(okabe_ito[static_cast<std::size_t>(index) % okabe_ito.size()]);
}

glm::vec3 scale_color(float share) {
    const float at = std::clamp(share, 0.0f, 1.0f) * (viridis.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), viridis.size() - 2);
    return glm::mix(from_hex(viridis[i]), from_hex(viridis[i + 1]), at - static_cast<float>(i));
}

glm::vec3 linear_from_display(const glm::vec3& color) {
    glm::vec3 result;
    for (int c = 0; c < 3; ++c) {
        result[c] = color[c] <= 0.04045f ? color[c] / 12.92f : std::pow((color[c] + 0.055f) / 1.055f, 2.4f);
    }
    return result;
}

glm::vec3 display_from_linear(const glm::vec3& color) {
    glm::vec3 result;
    for (int c = 0; c < 3; ++c) {
        result[c] =
            color[c] <= 0.0031308f ? color[c] * 12.92f : 1.055f * std::pow(color[c], 1.0f / 2.4f) - 0.055f;
    }
    return result;
}

} // namespace render
