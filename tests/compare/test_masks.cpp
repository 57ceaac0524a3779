// More masked is never more changed: what masks hide tells of noise all the same.
#include "render/compare/judge.h"
#include "render/compare/pair.h"
#include "tests/compare/painter.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace {

using diff::Tier;
using test::Random;

/// A pair that is nearly noise or just beyond: other samples, levels that go one way here and another way there, patches.
std::pair<diff::Picture, diff::Picture> random_pair(std::uint32_t seed) {
    Random random(seed);
    const test::Scene scene = test::make_scene(seed, 5 + static_cast<int>(40 * random()), 2);
    const diff::Picture a = test::paint(scene, test::grid_pattern(2));
    diff::Picture b = random() < 0.5 ? a : test::paint(scene, test::rotated_pattern);
    const int patches = static_cast<int>(8 * random());
    for (int i = 0; i < patches; ++i) {
        const int left = static_cast<int>(b.width * random()), width = static_cast<int>(150 * random());
        const int top = static_cast<int>(b.height * random()), height = static_cast<int>(100 * random());
        const double change = 5 * random() - 2.5;
        for (int y = top; y < std::min(top + height, b.height); ++y) {
            for (int k = 3 * left; k < 3 * std::min(left + width, b.width); ++k) {
                std::uint8_t& v = b.rgb[static_cast<std::size_t>(y * b.width * 3 + k)];
                v = static_cast<std::uint8_t>(std::clamp(v + change + random(), 0.0, 255.0));
            }
        }
    }
    return {a, b};
}

} // namespace

// Limits grow with the noise of all edges, hidden or not.
TEST(masks, limits_do_not_shrink_where_noise_is_hidden) {
    const test::Scene scene = test::make_scene(3, 60, 2);
    diff::PairSettings settings;
    const auto limit_of = [&settings, &scene] {
        diff::PairMemory memory;
        memory.a = test::paint(scene, test::grid_pattern(2));
        memory.b = test::paint(scene, test::grid_pattern(2), 1.0, 0.0);
        diff::Frame frame;
        diff::compare_pictures(settings, memory, frame);
        return frame.gates.at(0).limit;
    };
    const double limit = limit_of();
    EXPECT_GT(limit, diff::Limits()[diff::GateId::edge_shift].value);
    settings.mask.boxes.push_back({0, 0, scene.width, scene.height - 10});
    EXPECT_EQ(limit_of(), limit);
}

TEST(masks, more_masked_is_never_more_changed) {
    constexpr int most_masks = 6;
    int of_noise = 0;
    for (std::uint32_t seed = 1; seed <= 15; ++seed) {
        const auto [a, b] = random_pair(seed);
        Random random(seed + 1000);
        diff::PairSettings settings;
        settings.is_lossy = seed % 3 == 0;
        Tier tier = Tier::changed;
        double drift = 255;
        diff::PairMemory memory;
        for (int count = 0; count <= most_masks; ++count) {
            memory.a = a;
            memory.b = b;
            diff::Frame frame;
            diff::compare_pictures(settings, memory, frame);
            EXPECT_LE(frame.tier, tier) << "seed " << seed << ", " << count << " masks: " << frame.message;
            tier = frame.tier;
            of_noise += count == 0 && tier == Tier::noise;
            for (const diff::Gate& gate : frame.gates) {
                if (gate.name == diff::name_of(diff::GateId::drift)) {
                    EXPECT_LE(gate.value, drift + 1e-12) << "seed " << seed << ", " << count << " masks";
                    drift = gate.value;
                }
            }
            const int x = static_cast<int>(a.width * random()), y = static_cast<int>(a.height * random());
            settings.mask.boxes.push_back({x, y, 1 + static_cast<int>(120 * random()), 1 + static_cast<int>(80 * random())});
        }
    }
    EXPECT_GT(of_noise, 3);
}
