#pragma once
/// Text in a picture: Roboto Medium, compiled into the program (sole user of stb_truetype).
#include "render/overlay/canvas.h"

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace render {

/// Where the given point lies on a line of text.
enum class TextAlign { left, center, right };

struct TextStyle {
    float size = 0.0f; ///< of an em [px]
    Paint paint;
    TextAlign align = TextAlign::left;
};

class Font {
public:
    Font();
    ~Font();
    Font(const Font&) = delete;
    Font& operator=(const Font&) = delete;

    /// Width of one line of UTF-8 [px]; size: of an em [px]. Letters the font lacks are shown as a box.
    float width(std::string_view text, float size) const;
    /// The lines of a text: one ends at "\n", and before a word (or, where that alone is too long, a letter) that would
    /// make it wider than `width` [px].
    std::vector<std::string> lines(std::string_view text, float size, float width) const;
    /// The first letter of a text that the font lacks, and its number: "\u6f22 (U+6F22)"; empty if there is none.
    std::string missing_letter(std::string_view text) const;
    /// Height of a digit [px].
    static float digit_height(float size) { return 0.711f * size; }
    /// Draws one line with its baseline at `at`, and notes it in the picture.
    void draw(Canvas& canvas, const glm::vec2& at, std::string_view text, const TextStyle& style);

private:
    struct Face;
    /// Coverage of one letter; its first pixel lies at (x, y) from the pen's pixel.
    struct Glyph {
        int x = 0;
        int y = 0;
        int width = 0;
        int height = 0;
        std::vector<std::uint8_t> coverage;
    };
    const Glyph& glyph(int letter, float scale, int quarter);

    std::unique_ptr<Face> face_;
    std::map<std::tuple<int, float, int>, Glyph> glyphs_; // by letter, scale, quarter of a pixel
};

} // namespace render
