#pragma once
/// Several pictures in one, each with its lines of text: two side by side, three or four in two rows.
#include "render/overlay/text.h"
#include "render/picture/image.h"

#include <span>
#include <string>
#include <vector>

namespace render {

struct Panel {
    Image picture;
    std::vector<std::string> labels; ///< above it; lines that are too long are broken
};

/// Pixels of one panel.
struct PanelSize {
    int width = 0;
    int height = 0;       ///< of the picture
    int label_height = 0; ///< of the strip above it
};

/// Of the strips above these panels, the same for all; even.
int label_height(std::span<const Panel> panels, int width, Font& font);

/// Size of the picture of `count` panels, 1 to 4.
PanelSize arranged_size(const PanelSize& panel, std::size_t count);

/// The panels in one picture, row by row. A picture of another size is made as large as fits, on black; light is
/// averaged, not display values.
Image arranged(std::span<const Panel> panels, const PanelSize& size, Font& font);

} // namespace render
