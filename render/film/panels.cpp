#include "render/film/panels.h"

#include "render/overlay/canvas.h"
#include "sim/base/error.h"

#include <stb_image_resize.h>

#include <algorithm>
#include <cmath>

namespace render {

namespace {

constexpr float label_text = 15.0f; ///< [px]
constexpr float label_edge = 8.0f;  ///< [px] between labels and the panel's edges

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

void label(Image& picture, std::span<const std::string> lines, Font& font) {
    Canvas canvas(picture);
    float y = label_edge;
    for (const std::string& line : lines) {
        const glm::vec2 lower(label_edge - 3.0f, y - 2.0f);
        canvas.panel(lower, lower + glm::vec2(font.width(line, label_text) + 6.0f, label_text + 4.0f), 3.0f,
                     {glm::vec3(0.0f), 0.55f});
        font.draw(canvas, {label_edge, y + 0.8f * label_text}, line, {label_text, {}});
        y += label_text + 6.0f;
    }
}

void paste(const Image& from, int left, int top, Image& to) {
    for (int y = 0; y < from.height; ++y) {
        std::copy_n(from.rgb.begin() + static_cast<std::ptrdiff_t>(y) * from.width * 3, from.width * 3,
                    to.rgb.begin() + (static_cast<std::ptrdiff_t>(top + y) * to.width + left) * 3);
    }
}

} // namespace

PanelSize arranged_size(const PanelSize& panel, std::size_t count) {
    const int columns = columns_of(count);
    const int rows = (static_cast<int>(count) + columns - 1) / columns;
    return {columns * panel.width, rows * panel.height};
}

Image arranged(std::span<const Panel> panels, const PanelSize& size, Font& font) {
    const int columns = columns_of(panels.size());
    const PanelSize whole_size = arranged_size(size, panels.size());
    Image whole(whole_size.width, whole_size.height);
    for (std::size_t i = 0; i < panels.size(); ++i) {
        Image picture = fitted(panels[i].picture, size);
        label(picture, panels[i].labels, font);
        const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
        paste(picture, column * size.width + (size.width - picture.width) / 2,
              row * size.height + (size.height - picture.height) / 2, whole);
    }
    return whole;
}

} // namespace render
