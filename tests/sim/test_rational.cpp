#include "sim/base/rational.h"

#include <gtest/gtest.h>

#include <limits>

using sim::Rational;

TEST(rational, decimal_texts_are_read_exactly) {
    EXPECT_EQ(sim::parse_rational("0.001"), (Rational{1, 1000}));
    EXPECT_EQ(sim::parse_rational("1e-3"), (Rational{1, 1000}));
    EXPECT_EQ(sim::parse_rational("60"), (Rational{60, 1}));
    EXPECT_EQ(sim::parse_rational("29.97"), (Rational{2997, 100}));
    EXPECT_EQ(sim::parse_rational("-2.50"), (Rational{-5, 2}));
    EXPECT_EQ(sim::parse_rational("1.5E+2"), (Rational{150, 1}));
    EXPECT_EQ(sim::parse_rational("0e300"), (Rational{0, 1}));
}

TEST(rational, fraction_texts_are_reduced) {
    EXPECT_EQ(sim::parse_rational("24000/1001"), (Rational{24000, 1001}));
    EXPECT_EQ(sim::parse_rational("2/480"), (Rational{1, 240}));
    EXPECT_EQ(sim::parse_rational("3/-6"), (Rational{-1, 2}));
}

TEST(rational, other_texts_are_refused) {
    for (const char* text : {"",
                             "/",
                             "1/0",
                             "1/",
                             "/2",
                             "1.5/2",
                             "abc",
                             "1.",
                             ".5",
                             "1e",
                             "e5",
                             "1 ",
                             " 1",
                             "0x10",
                             "1e-30",
                             "1e30",
                             "nan",
                             "inf",
                             "--1",
                             "+-1",
                             "1e99999999999",
                             "92233720368547758080",
                             "-9223372036854775808/1",
                             "1/-9223372036854775808",
                             "1.5.2"}) {
        EXPECT_FALSE(sim::parse_rational(text).has_value()) << text;
    }
}

TEST(rational, doubles_become_their_shortest_decimal) {
    EXPECT_EQ(sim::rational_from_decimal(0.001), (Rational{1, 1000}));
    EXPECT_EQ(sim::rational_from_decimal(1e-5), (Rational{1, 100000}));
    EXPECT_EQ(sim::rational_from_decimal(0.1), (Rational{1, 10}));
    EXPECT_EQ(sim::rational_from_decimal(6.0), (Rational{6, 1}));
    EXPECT_FALSE(sim::rational_from_decimal(1e-40).has_value());
    EXPECT_FALSE(sim::rational_from_decimal(std::numeric_limits<double>::quiet_NaN()).has_value());
    EXPECT_FALSE(sim::rational_from_decimal(std::numeric_limits<double>::infinity()).has_value());
}

TEST(rational, frames_show_the_nearest_step_halves_up) {
    // 1 ms steps at 60 frames/s: 16.67, 33.33, 50.
    const Rational h{1, 1000};
    EXPECT_EQ(sim::step_of_frame(0, {60, 1}, h), 0);
    EXPECT_EQ(sim::step_of_frame(1, {60, 1}, h), 17);
    EXPECT_EQ(sim::step_of_frame(2, {60, 1}, h), 33);
    EXPECT_EQ(sim::step_of_frame(3, {60, 1}, h), 50);
    // 10 ms steps at 40 frames/s: 2.5 goes up.
    EXPECT_EQ(sim::step_of_frame(1, {40, 1}, {1, 100}), 3);
    // No drift after a day of film at 24000/1001: 1001/24 steps a frame.
    EXPECT_EQ(sim::step_of_frame(24 * 86400, {24000, 1001}, h), 1001LL * 86400);
    // More frames than steps: frames repeat.
    EXPECT_EQ(sim::step_of_frame(1, {240, 1}, {1, 60}), 0);
    EXPECT_EQ(sim::step_of_frame(2, {240, 1}, {1, 60}), 1);
}

TEST(rational, frame_counts_are_rounded_halves_up) {
    EXPECT_EQ(sim::frame_count({6, 1}, {60, 1}), 360);
    EXPECT_EQ(sim::frame_count({1, 1000}, {60, 1}), 0);
    EXPECT_EQ(sim::frame_count({1, 120}, {60, 1}), 1);
    EXPECT_EQ(sim::frame_count({10, 1}, {24000, 1001}), 240);
}

TEST(rational, long_fractions_do_not_overflow) {
    const std::int64_t large = 1'000'000'000'000;
    EXPECT_EQ(sim::step_of_frame(std::int64_t{1} << 40, {large, large - 1}, {large, large - 1}),
              (std::int64_t{1} << 40) - 2);
}

TEST(rational, steps_of_a_film_reach_its_end_but_never_miss_its_last_frame) {
    EXPECT_EQ(sim::step_count({6, 1}, {1, 1000}), 6000);
    EXPECT_EQ(sim::step_count({3, 20}, {1, 5}), 1);   // 0.75 of a step
    // 2.5 frames of 2 s become 3, the last of which shows 4 s.
    EXPECT_EQ(sim::frame_count({5, 1}, {1, 2}), 3);
    EXPECT_LE(sim::step_of_frame(2, {1, 2}, {1, 10}), sim::step_count({5, 1}, {1, 10}));
}
