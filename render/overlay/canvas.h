#pragma once
/// Smooth lines, discs, arrows and panels blended into a picture on the CPU. Positions in pixels from the top
/// left corner, pixel centres at halves. Colours are display values; the same calls give the same bytes
/// everywhere.
#include "render/picture/image.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace render {

/// Display colour 0..1 and opacity 0..1.
struct Paint {
    glm::vec3 color{1.0f};
    float alpha = 1.0f;
};

/// How a line is drawn.
struct Pen {
    Paint paint;
    float width = 1.0f; ///< [px]
    float dash = 0.0f;  ///< [px] length of dashes and of the gaps between; 0: unbroken
};

/// Coverage 0..255 of pixels, row by row, of which the first is (x, y).
struct Coverage {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
    std::span<const std::uint8_t> share; ///< [height * width]
};

class Canvas {
public:
    /// Draws into `image`, which must outlive this.
    explicit Canvas(Image& image) : image_(image) {}

    int width() const { return image_.width; }
    int height() const { return image_.height; }

    /// A line through the points, blended once however often it crosses itself.
    void stroke(std::span<const glm::vec2> points, const Pen& pen);
    void disc(const glm::vec2& center, float radius, const Paint& paint);
    /// A ring `width` [px] wide.
    void ring(const glm::vec2& center, float radius, float width, const Paint& paint);
    /// A straight arrow; its head is `head` [px] long, or as long as the arrow if that is shorter.
    void arrow(const glm::vec2& from, const glm::vec2& to, float head, const Pen& pen);
    /// A rectangle with round corners.
    void panel(const glm::vec2& lower, const glm::vec2& upper, float radius, const Paint& paint);
    void mask(const Coverage& shape, const Paint& paint);
    /// A picture whose upper left corner is the pixel (x, y).
    void picture(int x, int y, const AlphaImage& picture);
    /// A line of text that masks have written.
    void note(TextLine line) { image_.texts.push_back(std::move(line)); }

private:
    /// Pixels x0 .. x1 - 1, y0 .. y1 - 1.
    struct Box {
        int x0, y0, x1, y1;
    };
    Box clipped(const glm::vec2& lower, const glm::vec2& upper) const;
    void blend(int x, int y, const Paint& paint, float coverage);
    /// Marks the pixels within half a width of a segment in the coverage of `box`.
    void cover_segment(const Box& box, const glm::vec2& a, const glm::vec2& b, float half_width);
    /// Blends what a function of the pixel's centre covers, 0..1.
    template <class Coverage>
    void fill(const Box& box, const Paint& paint, const Coverage& coverage);

    Image& image_;
    std::vector<float> coverage_;
};

} // namespace render
