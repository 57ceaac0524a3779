#include "render/film/gif.h"

#include "render/film/video_reader.h"
#include "sim/base/file_io.h"
#include "tests/support/out_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

using render::Image;

/// As many colours as there are, further apart than dithering moves them: none is lost.
TEST(gif, as_many_colours_as_it_has_are_kept) {
    Image picture(64, 64); // 256 squares of 4 px
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const int i = 16 * (y / 4) + x / 4;
            const std::size_t at = 3 * static_cast<std::size_t>(picture.width * y + x);
            picture.rgb[at] = static_cast<std::uint8_t>(16 + 32 * (i % 8));
            picture.rgb[at + 1] = static_cast<std::uint8_t>(16 + 32 * (i / 8 % 8));
            picture.rgb[at + 2] = static_cast<std::uint8_t>(32 + 64 * (i / 64));
        }
    }
    const auto bytes = render::encode_gif({1, [&](int) { return picture; }, [](int k) { return 0.1 * k; }});
    const std::filesystem::path folder = test::out_folder("gif");
    std::filesystem::create_directories(folder);
    const std::filesystem::path path = folder / "colours.gif";
    sim::write_file(path, bytes);
    render::VideoReader reader(path);
    Image shown;
    ASSERT_TRUE(reader.read(shown));
    ASSERT_EQ(shown.rgb.size(), picture.rgb.size());
    int most = 0;
    for (std::size_t i = 0; i < shown.rgb.size(); ++i) {
        most = std::max(most, std::abs(shown.rgb[i] - picture.rgb[i]));
    }
    EXPECT_LE(most, 2);
}
