#include "render/film/panels.h"

#include "render/overlay/canvas.h"
#include "sim/base/error.h"

#include <stb_image_resize.h>

#include <algorithm>
#include <cmath>

namespace render {

namespace {

constexpr float label_share = 0.03f;  ///< [-] of a panel's width: size of its text
constexpr float least_label = 15.0f;  ///< [px]
constexpr float label_row = 1.4f;     ///< [-] of that size
constexpr float label_edge = 0.5f;    ///< [-] of that size, between labels and the panel's edges

float label_size(int width) {
    return std::max(least_label, std::round(label_share * static_cast<float>(width)));
}

std::vector<std::string> label_lines(const Panel& panel, int width, Font& font) {
    const float size = label_size(width);
    std::vector<std::string> lines;
    for (const std::string& label : panel.labels) {
        for (const std::string& line : font.lines(label, size, static_cast<float>(width) - 2.0f * label_edge * size)) {
            lines.push_back(line);
        }
    }
    return lines;
}

int columns_of(std::size_t count) {
    return count > 1 ? 2 : 1;
}

Image fitted(const Image& picture, const PanelSize& size) {
    if (picture.width == size.width && picture.height == size.height) {
        return picture;
    }
    const double scale = std::min(static_cast<double>(size.width) / picture.width,
                                  static_cast<double>(size.height) / picture.height);
    Image result(std::clamp(static_cast<int>(std::lround(picture.width * scale)), 1, size.width),
                 std::clamp(static_cast<int>(std::lround(picture.height * scale)), 1, size.height));
    CHECK(stbir_resize_uint8_srgb(picture.rgb.data(), picture.width, picture.height, 0, result.rgb.data(),
                                  result.width, result.height, 0, 3, STBIR_ALPHA_CHANNEL_NONE, 0) == 1);
    return result;
}

/// The strip above a panel.
Image label_strip(const Panel& panel, const PanelSize& size, Font& font) {
    Image strip(size.width, size.label_height);
    Canvas canvas(strip);
    const float text = label_size(size.width);
    float y = label_edge * text + Font::digit_height(text);
    for (const std::string& line : label_lines(panel, size.width, font)) {
        font.draw(canvas, {label_edge * text, y}, line, {text, {}});
        y += label_row * text;
    }
    return strip;
}

void paste(const Image& from, int left, int top, Image& to) {
    for (int y = 0; y < from.height; ++y) {
        std::copy_n(from.rgb.begin() + static_cast<std::ptrdiff_t>(y) * from.width * 3, from.width * 3,
                    to.rgb.begin() + (static_cast<std::ptrdiff_t>(top + y) * to.width + left) * 3);
    }
}

} // namespace

int label_height(std::span<const Panel> panels, int width, Font& font) {
    std::size_t most = 0;
    for (const Panel& panel : panels) {
        most = std::max(most, label_lines(panel, width, font).size());
    }
    const float text = label_size(width);
    const float rows = label_row * static_cast<float>(most) - label_row + 2.0f * label_edge;
    return most == 0 ? 0 : 2 * static_cast<int>(std::ceil(0.5f * (rows * text + Font::digit_height(text))));
}

PanelSize arranged_size(const PanelSize& panel, std::size_t count) {
    const int columns = columns_of(count);
    const int rows = (static_cast<int>(count) + columns - 1) / columns;
    return {columns * panel.width, rows * (panel.label_height + panel.height), 0};
}

Image arranged(std::span<const Panel> panels, const PanelSize& size, Font& font) {
    const int columns = columns_of(panels.size());
    const PanelSize whole_size = arranged_size(size, panels.size());
    Image whole(whole_size.width, whole_size.height);
    for (std::size_t i = 0; i < panels.size(); ++i) {
        const Image picture = fitted(panels[i].picture, size);
        const int left = static_cast<int>(i) % columns * size.width;
        const int top = static_cast<int>(i) / columns * (size.label_height + size.height);
        if (size.label_height > 0) {
            paste(label_strip(panels[i], size, font), left, top, whole);
        }
        paste(picture, left + (size.width - picture.width) / 2,
              top + size.label_height + (size.height - picture.height) / 2, whole);
    }
    return whole;
}

} // namespace render
