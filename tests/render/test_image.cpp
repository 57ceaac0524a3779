#include "render/picture/image.h"
#include "tests/support/out_folder.h"

#include "sim/base/error.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

namespace {

const std::filesystem::path out_dir = test::out_folder("image");

/// Every pixel differs from its neighbours, rows are no multiple of four bytes.
render::Image gradient(int width, int height) {
    render::Image image(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            std::uint8_t* pixel = image.rgb.data() + (static_cast<std::size_t>(y) * width + x) * 3;
            pixel[0] = static_cast<std::uint8_t>(x * 7 + y);
            pixel[1] = static_cast<std::uint8_t>(y * 11);
            pixel[2] = static_cast<std::uint8_t>(x ^ y);
        }
    }
    return image;
}

std::filesystem::path write(const std::string& name, const std::vector<std::uint8_t>& bytes) {
    std::filesystem::create_directories(out_dir);
    const std::filesystem::path path = out_dir / name;
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return path;
}

} // namespace

TEST(image, png_reads_back_equal) {
    for (const auto& [width, height] : {std::pair{1, 1}, {67, 41}, {256, 3}}) {
        const render::Image image = gradient(width, height);
        const render::Image back =
            render::read_image(write("image_round_trip.png", render::encode_png(image)));
        EXPECT_EQ(back.width, width);
        EXPECT_EQ(back.height, height);
        EXPECT_EQ(back.rgb, image.rgb);
    }
}

TEST(image, same_picture_gives_same_bytes) {
    EXPECT_EQ(render::encode_png(gradient(67, 41)), render::encode_png(gradient(67, 41)));
}

TEST(image, png_begins_with_signature_and_ends_with_iend) {
    const std::vector<std::uint8_t> file = render::encode_png(gradient(5, 4));
    const std::vector<std::uint8_t> head{0x89, 'P', 'N', 'G', 13,  10,  26,  10,
                                         0,    0,   0,   13,  'I', 'H', 'D', 'R'};
    const std::vector<std::uint8_t> tail{0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};
    EXPECT_TRUE(std::equal(head.begin(), head.end(), file.begin()));
    EXPECT_TRUE(std::equal(tail.rbegin(), tail.rend(), file.rbegin()));
}

TEST(image, missing_and_damaged_files_are_io_errors) {
    try {
        render::read_image(out_dir / "no_such_picture.png");
        FAIL() << "no error";
    } catch (const sim::Error& error) {
        EXPECT_EQ(error.code(), sim::ExitCode::io);
        EXPECT_NE(std::string(error.what()).find("no_such_picture.png"), std::string::npos);
    }
    std::vector<std::uint8_t> file = render::encode_png(gradient(67, 41));
    file.resize(file.size() / 2);
    EXPECT_THROW(render::read_image(write("image_cut.png", file)), sim::Error);
}
