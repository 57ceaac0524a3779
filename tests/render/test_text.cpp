#include "render/overlay/text.h"

#include <gtest/gtest.h>

using namespace render;

namespace {

/// First and last row with something in it, and how much there is.
struct Ink {
    int top = -1;
    int bottom = -1;
    double amount = 0.0;
};
Ink ink_of(Font& font, std::string_view text, float size) {
    Image image(400, 60);
    Canvas canvas(image);
    font.draw(canvas, {10.0f, 40.0f}, text, {size, {}});
    Ink ink;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const int value =
                image.rgb[3 * (static_cast<std::size_t>(y) * 400 + static_cast<std::size_t>(x))];
            if (value > 0) {
                ink.top = ink.top < 0 ? y : ink.top;
                ink.bottom = y;
                ink.amount += value / 255.0;
            }
        }
    }
    return ink;
}

} // namespace

TEST(text, digits_stand_on_the_baseline_and_are_as_high_as_said) {
    Font font;
    const Ink ink = ink_of(font, "1", 40.0f);
    EXPECT_EQ(ink.bottom, 39);
    EXPECT_NEAR(40 - ink.top, Font::digit_height(40.0f), 1.0);
}

TEST(text, numbers_of_as_many_digits_are_equally_wide) {
    const Font font;
    EXPECT_FLOAT_EQ(font.width("111.11", 15.0f), font.width("888.40", 15.0f));
    EXPECT_NEAR(font.width("0", 100.0f), 100.0f * 1164.0f / 2048.0f, 1e-3);
}

TEST(text, pairs_of_letters_are_kerned) {
    const Font font;
    EXPECT_LT(font.width("To", 100.0f), font.width("T", 100.0f) + font.width("o", 100.0f) - 1.0f);
}

TEST(text, other_alphabets_are_there_and_what_is_not_is_a_box) {
    Font font;
    const double box = ink_of(font, "\u4e00", 30.0f).amount; // a Chinese character
    EXPECT_GT(box, 10.0);
    for (const char* letter : {"\u00e4", "\u03bc", "\u0416", "\u0159", "\u2212", "\u2265", "\u00b2"}) {
        const double amount = ink_of(font, letter, 30.0f).amount;
        EXPECT_GT(amount, 10.0) << letter;
        EXPECT_NE(amount, box) << letter;
    }
}

TEST(text, bytes_that_are_no_utf8_are_question_marks) {
    Font font;
    EXPECT_FLOAT_EQ(font.width("a\xFF", 20.0f), font.width("a?", 20.0f));
    EXPECT_FLOAT_EQ(font.width("\xC3", 20.0f), font.width("?", 20.0f));
}

TEST(text, alignment_moves_the_line_by_its_width) {
    Font font;
    Image left(200, 40);
    Image right(200, 40);
    Canvas on_left(left);
    Canvas on_right(right);
    const float width = font.width("12.5 s", 16.0f);
    font.draw(on_left, {100.0f - width, 30.0f}, "12.5 s", {16.0f, {}, TextAlign::left});
    font.draw(on_right, {100.0f, 30.0f}, "12.5 s", {16.0f, {}, TextAlign::right});
    EXPECT_EQ(left.rgb, right.rgb);
}

TEST(text, a_line_is_noted_with_the_pixels_it_covers) {
    Font font;
    Image image(200, 60);
    Canvas canvas(image);
    font.draw(canvas, {150.0f, 40.0f}, "1 m", {30.0f, {}, TextAlign::right});
    font.draw(canvas, {10.0f, 40.0f}, " ", {30.0f, {}});
    ASSERT_EQ(image.texts.size(), 1u);
    const TextLine& line = image.texts[0];
    EXPECT_EQ(line.text, "1 m");
    bool is_edge_inked = false;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const bool is_inside = x >= line.x && x < line.x + line.width && y >= line.y && y < line.y + line.height;
            const bool is_inked = image.rgb[3 * static_cast<std::size_t>(y * image.width + x)] > 0;
            EXPECT_TRUE(is_inside || !is_inked) << x << " " << y;
            is_edge_inked |= is_inked && y == line.y + line.height - 1;
        }
    }
    EXPECT_TRUE(is_edge_inked);
}
