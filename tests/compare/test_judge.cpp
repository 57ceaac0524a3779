// Noise is called noise and changes are called changed, on scenes that the limits were not chosen by.
#include "render/compare/judge.h"
#include "tests/compare/painter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace {

using diff::Picture;
using diff::Tier;
using test::grid_pattern;
using test::paint;
using test::Random;
using test::rotated_pattern;
using test::Scene;

diff::Frame judged(const Picture& a, const Picture& b) {
    diff::DifferenceMap map;
    diff::Frame frame;
    diff::judge(a, b, {}, map, frame);
    return frame;
}

/// The pixels of edges mixed with a neighbour at random, as another sample pattern would.
Picture edge_noise(Picture picture, std::uint32_t seed) {
    Random random(seed);
    const Picture from = picture;
    for (int y = 1; y + 1 < picture.height; ++y) {
        for (int x = 1; x + 1 < picture.width; ++x) {
            const auto at = [&](int i, int j, int c) {
                return from.rgb[static_cast<std::size_t>(((y + j) * from.width + x + i) * 3 + c)];
            };
            if (std::abs(at(1, 0, 0) - at(-1, 0, 0)) + std::abs(at(0, 1, 0) - at(0, -1, 0)) < 24) {
                continue;
            }
            const int i = static_cast<int>(3 * random()) - 1;
            const int j = static_cast<int>(3 * random()) - 1;
            const double t = 0.5 * random();
            for (int c = 0; c < 3; ++c) {
                picture.rgb[static_cast<std::size_t>((y * from.width + x) * 3 + c)] =
                    static_cast<std::uint8_t>((1 - t) * at(0, 0, c) + t * at(i, j, c));
            }
        }
    }
    return picture;
}

/// middle: weight of the pixel itself; the rest is its eight neighbours'.
Picture filtered(Picture picture, double middle) {
    const Picture from = picture;
    for (int y = 1; y + 1 < picture.height; ++y) {
        for (int x = 1; x + 1 < picture.width; ++x) {
            for (int c = 0; c < 3; ++c) {
                double around = 0;
                for (int k = 0; k < 9; ++k) {
                    around += k == 4 ? 0 : from.rgb[static_cast<std::size_t>(((y + k / 3 - 1) * from.width + x + k % 3 - 1) * 3 + c)];
                }
                std::uint8_t& v = picture.rgb[static_cast<std::size_t>((y * from.width + x) * 3 + c)];
                v = static_cast<std::uint8_t>(std::clamp(middle * v + (1 - middle) * around / 8 + 0.5, 0.0, 255.0));
            }
        }
    }
    return picture;
}

struct Noise {
    const char* name;
    std::function<Picture(const Scene&, std::uint32_t seed)> make;
};

const Noise noises[] = {
    {"one level up or down in 10 % of the channels",
     [](const Scene& s, std::uint32_t seed) {
         Random random(seed);
         return test::each_channel(paint(s, grid_pattern(2)),
                                   [&](double v) { return random() < 0.1 ? v + (random() < 0.5 ? 1 : -1) : v; });
     }},
    {"grain of two levels",
     [](const Scene& s, std::uint32_t seed) {
         Random random(seed);
         return test::each_channel(paint(s, grid_pattern(2)), [&](double v) { return v + 2 * random.normal(); });
     }},
    {"rotated pattern of samples", [](const Scene& s, std::uint32_t) { return paint(s, rotated_pattern); }},
    {"16 samples", [](const Scene& s, std::uint32_t) { return paint(s, grid_pattern(4)); }},
    {"one sample", [](const Scene& s, std::uint32_t) { return paint(s, grid_pattern(1)); }},
    {"samples at other places",
     [](const Scene& s, std::uint32_t seed) {
         Random random(seed);
         return paint(s, {{random() - 0.5, random() - 0.5}, {random() - 0.5, -0.3}, {0.2, random() - 0.5}, {0.0, 0.1}});
     }},
    {"random mixing at edges", [](const Scene& s, std::uint32_t seed) { return edge_noise(paint(s, grid_pattern(2)), seed); }},
    {"view moved by 0.1 px", [](const Scene& s, std::uint32_t) { return paint(s, grid_pattern(2), 0.1, -0.1); }},
    {"single wrong pixels",
     [](const Scene& s, std::uint32_t seed) {
         Random random(seed);
         Picture picture = paint(s, grid_pattern(2));
         for (int i = 0; i < 40; ++i) {
             const auto pixel = static_cast<std::size_t>(random() * s.width * s.height);
             picture.rgb[pixel * 3] = static_cast<std::uint8_t>(std::min(255, picture.rgb[pixel * 3] + 31));
         }
         return picture;
     }},
    {"edges softened by a small blur",
     [](const Scene& s, std::uint32_t) {
         Picture picture = paint(s, grid_pattern(2));
         const Picture from = picture;
         for (std::size_t i = 3; i + 3 < from.rgb.size(); ++i) {
             picture.rgb[i] = static_cast<std::uint8_t>((from.rgb[i - 3] + 10 * from.rgb[i] + from.rgb[i + 3] + 6) / 12);
         }
         return picture;
     }},
};

struct Change {
    const char* name;
    const char* gate; ///< one that is exceeded; null: any
    std::function<Picture(Scene, std::size_t shape)> make;
};

const Change changes[] = {
    {"moved by 1 px", nullptr, [](Scene s, std::size_t i) { s.shapes[i].x += 1.0; return paint(s, grid_pattern(2)); }},
    {"moved by 1.5 px aslant", nullptr, [](Scene s, std::size_t i) { s.shapes[i].x += 1.1; s.shapes[i].y += 1.0; return paint(s, grid_pattern(2)); }},
    {"moved by 3 px", nullptr, [](Scene s, std::size_t i) { s.shapes[i].y -= 3.0; return paint(s, grid_pattern(2)); }},
    {"missing", "edge shift", [](Scene s, std::size_t i) { s.shapes.erase(s.shapes.begin() + static_cast<long>(i)); return paint(s, grid_pattern(2)); }},
    {"recoloured", "edge shift", [](Scene s, std::size_t i) { std::swap(s.shapes[i].color[0], s.shapes[i].color[2]); return paint(s, grid_pattern(2)); }},
    {"larger by 2 px", "edge shift", [](Scene s, std::size_t i) { s.shapes[i].size += 2; return paint(s, grid_pattern(2)); }},
    {"a spot of 4 px appears", "edge shift", [](Scene s, std::size_t) { s.shapes.push_back({test::Shape::Kind::box, 30, 150, 2, 0, {20, 20, 20}}); return paint(s, grid_pattern(2)); }},
    {"view moved by 1 px", nullptr, [](const Scene& s, std::size_t) { return paint(s, grid_pattern(2), 1.0, 0.0); }},
    {"one level up everywhere", "drift", [](const Scene& s, std::size_t) { return test::each_channel(paint(s, grid_pattern(2)), [](double v) { return v + 1; }); }},
    {"without the last bit", "drift", [](const Scene& s, std::size_t) { return test::each_channel(paint(s, grid_pattern(2)), [](double v) { return 2 * std::floor(v / 2); }); }},
    {"one pixel in a thousand white", nullptr, [](const Scene& s, std::size_t i) {
         Picture picture = paint(s, grid_pattern(2));
         Random random(static_cast<std::uint32_t>(i + 1));
         for (int k = 0; k < 57; ++k) {
             std::fill_n(picture.rgb.begin() + 3 * static_cast<long>(random() * 320 * 180), 3, std::uint8_t{255});
         }
         return picture;
     }},
    {"out of focus", "sharpness", [](const Scene& s, std::size_t) { return filtered(paint(s, grid_pattern(2)), 0.25); }},
    {"sharpened", "sharpness", [](const Scene& s, std::size_t) { return filtered(paint(s, grid_pattern(2)), 2.0); }},
    {"3 levels brighter", "drift", [](const Scene& s, std::size_t) { return test::each_channel(paint(s, grid_pattern(2)), [](double v) { return v + 3; }); }},
    {"5 % brighter", "drift", [](const Scene& s, std::size_t) { return test::each_channel(paint(s, grid_pattern(2)), [](double v) { return v * 1.05; }); }},
    {"gamma 1.05", "drift", [](const Scene& s, std::size_t) { return test::each_channel(paint(s, grid_pattern(2)), [](double v) { return 255 * std::pow(v / 255, 1.05); }); }},
    {"sky 8 levels darker", "block drift", [](Scene s, std::size_t) { s.sky[1] -= 8; return paint(s, grid_pattern(2)); }},
    {"moved by 1.25 px among noise", nullptr, [](Scene s, std::size_t i) { s.shapes[i].x -= 1.25; return edge_noise(paint(s, grid_pattern(2)), 5); }},
};

/// Scenes that nothing was chosen by.
const std::pair<std::uint32_t, int> judged_scenes[] = {{101, 12}, {102, 40}, {103, 120}};

/// The front-most shape of at least 8 px that lies within the picture.
std::size_t front_shape(const Scene& scene) {
    for (std::size_t i = scene.shapes.size(); i-- > 0;) {
        const test::Shape& s = scene.shapes[i];
        if (s.kind != test::Shape::Kind::wire && s.size >= 6 && s.x > 20 && s.x < 300 && s.y > 70 && s.y < 160 &&
            std::abs(s.color[0] - s.color[2]) > 60) {
            return i;
        }
    }
    return 0;
}

} // namespace

TEST(judge, noise_of_every_kind_is_no_change) {
    for (const auto& [seed, count] : judged_scenes) {
        const Scene scene = test::make_scene(seed, count, 2);
        const Picture reference = paint(scene, grid_pattern(2));
        for (const Noise& noise : noises) {
            const diff::Frame frame = judged(reference, noise.make(scene, seed));
            EXPECT_EQ(frame.tier, Tier::noise) << noise.name << ", scene " << seed << ": " << frame.message;
        }
    }
}

TEST(judge, changes_of_every_kind_are_seen_by_the_gate_meant_for_them) {
    for (const auto& [seed, count] : judged_scenes) {
        const Scene scene = test::make_scene(seed, count, 2);
        const Picture reference = paint(scene, grid_pattern(2));
        for (const Change& change : changes) {
            const diff::Frame frame = judged(reference, change.make(scene, front_shape(scene)));
            EXPECT_EQ(frame.tier, Tier::changed) << change.name << ", scene " << seed;
            bool is_seen = change.gate == nullptr;
            for (const diff::Gate& gate : frame.gates) {
                is_seen |= change.gate != nullptr && gate.name == change.gate && gate.is_exceeded;
                EXPECT_EQ(gate.is_exceeded, gate.value > gate.limit);
            }
            EXPECT_TRUE(is_seen) << change.name << ", scene " << seed << ": " << frame.message;
        }
    }
}

// Walls of half a pixel are as bright as samples happen to meet them: limits grow where many edges differ.
TEST(judge, walls_thinner_than_a_pixel_are_noise_and_what_appears_beside_them_is_seen) {
    Scene scene;
    scene.shapes.push_back({test::Shape::Kind::box, 160.5, 110, 65, 0, {10, 10, 10}});
    for (int i = -15; i <= 15; ++i) {
        scene.shapes.push_back({test::Shape::Kind::wire, 160.5 + 4 * i, 110, 60, std::acos(0.0), {255, 255, 255}, 0.27});
    }
    // Each of the two has the brighter walls in one half, so that they are equally sharp.
    const auto judge_samples = [](const Scene& before, const Scene& after) {
        Picture a = paint(before, rotated_pattern), b = paint(after, grid_pattern(2));
        for (std::size_t row = 0; row < a.rgb.size(); row += 960) {
            const auto middle = static_cast<std::ptrdiff_t>(row + 480);
            std::swap_ranges(a.rgb.begin() + middle, a.rgb.begin() + middle + 480, b.rgb.begin() + middle);
        }
        return judged(a, b);
    };
    const diff::Frame noise = judge_samples(scene, scene);
    EXPECT_GT(noise.gates.at(0).value, diff::Limits()[diff::GateId::edge_shift].value);
    EXPECT_EQ(noise.tier, Tier::noise) << noise.message;
    Scene other = scene;
    other.shapes.push_back({test::Shape::Kind::disc, 60, 120, 4, 0, {220, 60, 50}});
    EXPECT_EQ(judge_samples(scene, other).tier, Tier::changed);
}

// Far away the floor's pattern is as small as pixels: other samples make another pattern of it, which some shift explains.
TEST(judge, a_pattern_that_repeats_and_is_drawn_with_other_samples_has_not_moved) {
    Scene scene;
    scene.width = 1200;
    scene.height = 90;
    for (int i = 0; i < 100; ++i) {
        scene.shapes.push_back({test::Shape::Kind::box, 12.0 * i + 6.0, 20, 4, 0.3, {30, 30, 40}});
    }
    const diff::Frame frame = judged(paint(scene, grid_pattern(2)), paint(scene, rotated_pattern));
    EXPECT_EQ(frame.tier, Tier::noise) << frame.message;
}

// Forty pictures in each of which one small thing has moved by a pixel and nothing else differs.
TEST(judge, a_small_thing_moved_by_a_pixel_is_seen_where_the_edges_elsewhere_are_as_they_were) {
    int missed = 0;
    for (std::uint32_t seed = 200; seed < 240; ++seed) {
        Scene scene = test::make_scene(seed, 30, 1);
        Random random(seed);
        const double size = 3 + 5 * random();
        scene.shapes.push_back({test::Shape::Kind::box, 40 + 240 * random(), 70 + 90 * random(), size, 3 * random(),
                                {255 * random(), 255 * random(), 255 * random()}});
        const Picture reference = paint(scene, grid_pattern(2));
        const double angle = 6.3 * random();
        scene.shapes.back().x += std::cos(angle);
        scene.shapes.back().y += std::sin(angle);
        missed += judged(reference, paint(scene, grid_pattern(2))).tier != Tier::changed;
    }
    EXPECT_LE(missed, 2);
}

// Edges that lie between pixels do not change with the samples; those of one thing do.
TEST(judge, noise_on_few_edges_is_no_lone_change) {
    Scene scene = test::make_scene(108, 0, 0);
    for (int i = 0; i < 24; ++i) {
        scene.shapes.push_back({test::Shape::Kind::box, 20.0 + 12 * i, 164, 4, 0, {20, 20, 20}});
    }
    scene.shapes.push_back({test::Shape::Kind::disc, 150, 110, 25, 0, {200, 60, 50}});
    scene.shapes.push_back({test::Shape::Kind::box, 220, 100, 15, 0.3, {60, 160, 50}});
    const Picture reference = paint(scene, grid_pattern(2));
    for (const Noise& noise : noises) {
        const diff::Frame frame = judged(reference, noise.make(scene, 108));
        EXPECT_EQ(frame.tier, Tier::noise) << noise.name << ": " << frame.message;
    }
}

// Both ways round.
TEST(judge, the_verdict_does_not_depend_on_which_is_the_reference) {
    for (const auto& [seed, count] : judged_scenes) {
        const Scene scene = test::make_scene(seed, count, 2);
        const Picture reference = paint(scene, grid_pattern(2));
        std::vector<Picture> others;
        for (const Noise& noise : noises) {
            others.push_back(noise.make(scene, seed));
        }
        for (const Change& change : changes) {
            others.push_back(change.make(scene, front_shape(scene)));
        }
        for (const Picture& other : others) {
            const diff::Frame there = judged(reference, other);
            const diff::Frame back = judged(other, reference);
            EXPECT_EQ(there.tier, back.tier);
            ASSERT_EQ(there.gates.size(), back.gates.size());
            for (std::size_t i = 0; i < there.gates.size(); ++i) {
                EXPECT_DOUBLE_EQ(there.gates[i].value, back.gates[i].value) << there.gates[i].name;
            }
        }
    }
}

// A small thing that differs among others that are the same, while the edges of all else differ.
TEST(judge, a_changed_letter_is_seen_where_the_edges_elsewhere_are_noise) {
    const Scene scene = test::make_scene(109, 40, 0);
    Picture reference = paint(scene, grid_pattern(2));
    Picture candidate = paint(scene, rotated_pattern);
    const auto letter = [](Picture& picture, int column, bool is_other) {
        for (int k = 0; k < 8 * 12; ++k) {
            const int x = k % 8, y = k / 8;
            const bool is_ink = x < 2 || y < 2 || (is_other ? x > 5 : y > 9);
            std::fill_n(&picture.rgb[static_cast<std::size_t>(((10 + y) * picture.width + 12 + 10 * column + x) * 3)], 3,
                        std::uint8_t(is_ink ? 240 : 20));
        }
    };
    for (int i = 0; i < 20; ++i) {
        letter(reference, i, false);
        letter(candidate, i, false);
    }
    EXPECT_EQ(judged(reference, candidate).tier, Tier::noise);
    letter(candidate, 9, true);
    EXPECT_EQ(judged(reference, candidate).tier, Tier::changed);
}

TEST(judge, texts_are_compared_as_text_where_both_files_tell_them) {
    diff::Picture a = paint(test::make_scene(103, 10, 0), grid_pattern(2));
    diff::Picture b = paint(test::make_scene(103, 10, 0), rotated_pattern);
    a.texts = {{10, 10, 80, 12, "time"}, {100, 10, 60, 12, "1.25 s"}, {10, 30, 60, 12, "time"}};
    EXPECT_EQ(judged(a, b).tier, Tier::noise);
    b.texts = {{10, 30, 60, 12, "time"}, {11, 10, 80, 12, "time"}, {100, 10, 60, 12, "1.25 s"}};
    EXPECT_EQ(judged(a, b).tier, Tier::noise);
    b.texts[2].text = "1.26 s";
    EXPECT_EQ(judged(a, b).tier, Tier::changed);
    EXPECT_EQ(judged(a, b).message.find("the text \"1.25 s\" at (100, 10) is \"1.26 s\""), 0u)
        << judged(a, b).message;
    EXPECT_GT(judged(a, b).curve, 1.0);
    b.texts[2].is_masked = a.texts[1].is_masked = true;
    EXPECT_EQ(judged(a, b).tier, Tier::noise);
    b.texts.pop_back();
    a.texts[1].is_masked = false;
    EXPECT_NE(judged(a, b).message.find("\"1.25 s\" at (100, 10) is missing"), std::string::npos) << judged(a, b).message;
}

TEST(judge, the_shift_of_a_moved_thing_is_measured) {
    Scene scene = test::make_scene(104, 0, 0);
    scene.shapes.push_back({test::Shape::Kind::box, 150, 120, 12, 0.4, {200, 60, 50}});
    const Picture reference = paint(scene, grid_pattern(4));
    for (const auto& [dx, dy] : {std::pair{1.0, 0.0}, {0.0, -2.0}, {3.0, 1.5}, {5.0, 0.0}}) {
        Scene moved = scene;
        moved.shapes[0].x += dx;
        moved.shapes[0].y += dy;
        const diff::Frame frame = judged(reference, paint(moved, grid_pattern(4)));
        ASSERT_FALSE(frame.clusters.empty());
        const diff::Cluster& cluster = frame.clusters.front();
        EXPECT_EQ(cluster.kind, diff::ClusterKind::moved);
        EXPECT_NEAR(cluster.displacement.x, dx, 0.25);
        EXPECT_NEAR(cluster.displacement.y, dy, 0.25);
        EXPECT_GT(cluster.displacement.explained, 0.6);
        EXPECT_NEAR(cluster.box.x + 0.5 * cluster.box.width, 150 + 0.5 * dx, 3.0);
    }
}

TEST(judge, clusters_say_recoloured_or_replaced) {
    Scene scene = test::make_scene(105, 0, 0);
    scene.shapes.push_back({test::Shape::Kind::box, 150, 120, 12, 0.4, {200, 60, 50}});
    const Picture reference = paint(scene, grid_pattern(4));
    Scene other = scene;
    other.shapes[0].color = {240, 100, 20};
    EXPECT_EQ(judged(reference, paint(other, grid_pattern(4))).clusters.at(0).kind, diff::ClusterKind::recoloured);
    other.shapes.clear();
    EXPECT_EQ(judged(reference, paint(other, grid_pattern(4))).clusters.at(0).kind, diff::ClusterKind::replaced);
}

TEST(judge, equal_pictures_are_identical_and_have_no_gates) {
    const Picture picture = paint(test::make_scene(106, 10, 1), grid_pattern(1));
    const diff::Frame frame = judged(picture, picture);
    EXPECT_EQ(frame.tier, Tier::identical);
    EXPECT_TRUE(frame.gates.empty());
}

TEST(judge, pictures_of_a_few_pixels_are_judged) {
    for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {1, 7}, {3, 3}, {5, 40}}) {
        Picture a;
        a.width = width;
        a.height = height;
        a.rgb.assign(static_cast<std::size_t>(width * height * 3), 100);
        Picture b = a;
        b.rgb[0] = 101;
        EXPECT_EQ(judged(a, b).tier, Tier::noise);
        std::fill(b.rgb.begin(), b.rgb.end(), std::uint8_t{200});
        EXPECT_EQ(judged(a, b).tier, Tier::changed);
    }
}

TEST(judge, what_alpha_hides_does_not_count_and_alpha_itself_does) {
    Picture a = paint(test::make_scene(107, 10, 0), grid_pattern(2));
    a.alpha.assign(a.rgb.size() / 3, 255);
    Picture b = a;
    // A black area on black: only on white is it seen that it has become transparent.
    for (int y = 100; y < 140; ++y) {
        for (int x = 100; x < 140; ++x) {
            const auto pixel = static_cast<std::size_t>(y * a.width + x);
            for (std::size_t c = 0; c < 3; ++c) {
                a.rgb[pixel * 3 + c] = b.rgb[pixel * 3 + c] = 0;
            }
            b.alpha[pixel] = 0;
        }
    }
    const diff::Frame frame = judged(a, b);
    EXPECT_EQ(frame.tier, Tier::changed);
    EXPECT_NE(frame.message.find("on white"), std::string::npos);
}
