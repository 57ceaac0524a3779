#include "render/overlay/text.h"

#include "render/font_data.h"
#include "sim/base/error.h"

#include <fmt/format.h>
#include <stb_truetype.h>

#include <algorithm>
#include <climits>
#include <cmath>

namespace render {

struct Font::Face {
    stbtt_fontinfo info{};
};

namespace {

/// The next code point of UTF-8; what is no UTF-8 counts byte by byte.
int next_letter(std::string_view& text) {
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
    };
    const unsigned first = byte(0);
    const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 1;
    unsigned code = length == 1 ? first : first & (0xFFu >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0u) != 0x80u) {
            text.remove_prefix(1);
            return '?';
        }
        code = (code << 6) | (byte(i) & 0x3Fu);
    }
    text.remove_prefix(length);
    return static_cast<int>(code);
}

/// Calls visit(letter index, offset in font units) along the line; returns the whole advance.
template <class Visit>
int walk(const stbtt_fontinfo& info, std::string_view text, const Visit& visit) {
    int offset = 0;
    int last = 0;
    while (!text.empty()) {
        const int index = stbtt_FindGlyphIndex(&info, next_letter(text));
        offset += stbtt_GetGlyphKernAdvance(&info, last, index);
        visit(index, offset);
        int advance = 0;
        stbtt_GetGlyphHMetrics(&info, index, &advance, nullptr);
        offset += advance;
        last = index;
    }
    return offset;
}

} // namespace

Font::Font() : face_(std::make_unique<Face>()) {
    CHECK(stbtt_InitFont(&face_->info, font_data, 0) != 0);
}

Font::~Font() = default;

float Font::width(std::string_view text, float size) const {
    return stbtt_ScaleForMappingEmToPixels(&face_->info, size) *
           static_cast<float>(walk(face_->info, text, [](int, int) {}));
}

std::vector<std::string> Font::lines(std::string_view text, float size, float width_limit) const {
    std::vector<std::string> lines{""};
    const auto fits = [&](const std::string& line) { return width(line, size) <= width_limit; };
    // A word with the space before it, or the end of a line.
    while (!text.empty()) {
        if (text.front() == '\n') {
            lines.emplace_back();
            text.remove_prefix(1);
            continue;
        }
        const std::size_t end = std::min(text.find_first_of(" \n", 1), text.size());
        std::string_view word = text.substr(0, end);
        text.remove_prefix(end);
        if (fits(lines.back() + std::string(word))) {
            lines.back() += word;
            continue;
        }
        word.remove_prefix(word.front() == ' ' ? 1 : 0);
        if (!lines.back().empty()) {
            lines.emplace_back();
        }
        while (!word.empty()) {
            std::string_view rest = word;
            next_letter(rest);
            const std::string letter(word.substr(0, word.size() - rest.size()));
            if (!lines.back().empty() && !fits(lines.back() + letter)) {
                lines.emplace_back();
            }
            lines.back() += letter;
            word = rest;
        }
    }
    return lines;
}

std::string Font::missing_letter(std::string_view text) const {
    while (!text.empty()) {
        const std::string_view before = text;
        const int code = next_letter(text);
        if (code != '\n' && stbtt_FindGlyphIndex(&face_->info, code) == 0) {
            return fmt::format("{} (U+{:04X})", before.substr(0, before.size() - text.size()), code);
        }
    }
    return "";
}

const Font::Glyph& Font::glyph(int letter, float scale, int quarter) {
    const auto [place, is_new] = glyphs_.try_emplace({letter, scale, quarter});
    Glyph& glyph = place->second;
    if (is_new) {
        const float shift = 0.25f * static_cast<float>(quarter);
        int x1 = 0;
        int y1 = 0;
        stbtt_GetGlyphBitmapBoxSubpixel(&face_->info, letter, scale, scale, shift, 0.0f, &glyph.x, &glyph.y,
                                        &x1, &y1);
        glyph.width = x1 - glyph.x;
        glyph.height = y1 - glyph.y;
        glyph.coverage.resize(static_cast<std::size_t>(glyph.width) * static_cast<std::size_t>(glyph.height));
        if (!glyph.coverage.empty()) {
            stbtt_MakeGlyphBitmapSubpixel(&face_->info, glyph.coverage.data(), glyph.width, glyph.height,
                                          glyph.width, scale, scale, shift, 0.0f, letter);
        }
    }
    return glyph;
}

void Font::draw(Canvas& canvas, const glm::vec2& at, std::string_view text, const TextStyle& style) {
    const float size = style.size;
    const float scale = stbtt_ScaleForMappingEmToPixels(&face_->info, size);
    const float share = style.align == TextAlign::left ? 0.0f : style.align == TextAlign::center ? 0.5f : 1.0f;
    const float start = at.x - (style.align == TextAlign::left ? 0.0f : share * width(text, size));
    const int baseline = static_cast<int>(std::round(at.y));
    glm::ivec2 lower(INT_MAX);
    glm::ivec2 upper(INT_MIN);
    walk(face_->info, text, [&](int letter, int offset) {
        const float quarters = std::round(4.0f * (start + scale * static_cast<float>(offset)));
        const int pen = static_cast<int>(std::floor(quarters / 4.0f));
        const Glyph& shape = glyph(letter, scale, static_cast<int>(quarters) - 4 * pen);
        const glm::ivec2 corner(pen + shape.x, baseline + shape.y);
        canvas.mask({corner.x, corner.y, shape.width, shape.height, shape.coverage}, style.paint);
        if (!shape.coverage.empty()) {
            lower = glm::min(lower, corner);
            upper = glm::max(upper, corner + glm::ivec2(shape.width, shape.height));
        }
    });
    if (upper.x > lower.x) {
        canvas.note({lower.x, lower.y, upper.x - lower.x, upper.y - lower.y, std::string(text)});
    }
}

} // namespace render
