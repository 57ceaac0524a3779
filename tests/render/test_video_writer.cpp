#include "render/film/video_reader.h"
#include "render/film/video_writer.h"
#include "tests/support/out_folder.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "tests/support/film_reader.h"

#include <gtest/gtest.h>

using namespace render;
namespace fs = std::filesystem;

namespace {

fs::path fresh_folder() {
    const fs::path folder =
        test::out_folder("video_writer") / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder);
    fs::create_directories(folder);
    return folder;
}

void set_pixel(Image& image, int x, int y, std::array<int, 3> rgb) {
    for (int c = 0; c < 3; ++c) {
        image.rgb[(static_cast<std::size_t>(y) * image.width + x) * 3 + c] =
            static_cast<std::uint8_t>(std::clamp(rgb[c], 0, 255));
    }
}

/// A smooth background and a disc that moves 3 px a frame.
Image test_picture(int width, int height, int frame) {
    Image image(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double dx = x - 20 - 3 * frame;
            const double dy = y - height / 2.0;
            const bool disc = dx * dx + dy * dy < 15 * 15;
            set_pixel(image, x, y,
                      disc ? std::array{200, 180, 60}
                           : std::array{60 + x * 100 / width, 90 + y * 90 / height, 140});
        }
    }
    return image;
}

Image plain_picture(int width, int height, std::array<int, 3> rgb) {
    Image image(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            set_pixel(image, x, y, rgb);
        }
    }
    return image;
}

void write_film(const fs::path& path, const std::vector<Image>& pictures, const VideoSettings& settings) {
    VideoWriter video(path, pictures.front().width, pictures.front().height, settings);
    for (const Image& picture : pictures) {
        video.add(picture);
    }
    video.finish();
}

std::vector<Image> test_pictures(int width, int height, int count) {
    std::vector<Image> pictures;
    for (int k = 0; k < count; ++k) {
        pictures.push_back(test_picture(width, height, k));
    }
    return pictures;
}

} // namespace

TEST(video_writer, decoded_film_has_every_frame_at_its_time_and_close_to_its_source) {
    const fs::path path = fresh_folder() / "a film.mp4";
    const std::vector<Image> pictures = test_pictures(160, 90, 40);
    write_film(path, pictures, {.fps = {24000, 1001}});
    EXPECT_FALSE(fs::exists(sim::part_path(path)));
    const test::Film film = test::read_film(path);
    EXPECT_EQ(film.width, 160);
    EXPECT_EQ(film.height, 90);
    EXPECT_EQ(film.fps, (sim::Rational{24000, 1001}));
    ASSERT_EQ(film.frames.size(), pictures.size());
    for (std::size_t k = 0; k < pictures.size(); ++k) {
        EXPECT_EQ(film.times[k], sim::make_rational(static_cast<std::int64_t>(k) * 1001, 24000));
        // Chroma of half the size costs most at the disc's edge; a frame in the wrong place reads below 28
        // dB.
        EXPECT_GT(test::psnr(test::to_rgb(film.frames[k]), pictures[k]), 34.0) << "frame " << k;
    }
}

TEST(video_writer, films_of_other_encoders_can_be_read_again) {
    const fs::path folder = fresh_folder();
    const std::vector<Image> pictures = test_pictures(160, 90, 12);
    const std::vector<std::string> names = encoder_names();
    for (const char* encoder : {"libx265", "libsvtav1"}) {
        if (std::ranges::find(names, encoder) == names.end()) {
            continue; // another libavcodec than Debian's
        }
        const fs::path path = folder / (std::string(encoder) + ".mp4");
        require_encoder({.encoder = encoder}, 160, 90); // and closed, before it has had a picture
        write_film(path, pictures, {.encoder = encoder});
        const test::Film film = test::read_film(path);
        ASSERT_EQ(film.frames.size(), pictures.size()) << encoder;
        for (std::size_t k = 0; k < pictures.size(); ++k) {
            EXPECT_GT(test::psnr(test::to_rgb(film.frames[k]), pictures[k]), 30.0)
                << encoder << " frame " << k;
        }
    }
}

// By libavcodec's names: what the file begins with, and what is read of it.
TEST(video_writer, codecs_come_in_the_container_that_fits) {
    const fs::path folder = fresh_folder();
    const std::vector<Image> pictures = test_pictures(160, 90, 6);
    const std::vector<std::string> names = encoder_names();
    struct Case {
        const char* encoder;
        int bits;
        const char* extension;
        std::string brand; ///< in the first 64 bytes
        double least;      ///< [dB] against the pictures
    };
    for (const Case& c :
         {Case{"libx265", 10, ".mp4", "ftypisom", 30.0}, Case{"libsvtav1", 8, ".mp4", "ftypisom", 30.0},
          Case{"libvpx-vp9", 8, ".webm", "webm", 30.0}, Case{"prores_ks", 8, ".mov", "ftypqt", 30.0},
          Case{"ffv1", 8, ".mkv", "matroska", 1000.0}}) {
        if (std::ranges::find(names, c.encoder) == names.end()) {
            continue; // another libavcodec than Debian's
        }
        ASSERT_EQ(film_extension(c.encoder), c.extension);
        const fs::path path = folder / (std::string(c.encoder) + c.extension);
        testing::internal::CaptureStderr();
        write_film(path, pictures, {.encoder = c.encoder, .bits = c.bits});
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << c.encoder;
        EXPECT_NE(sim::read_text_file(path).substr(0, 64).find(c.brand), std::string::npos) << c.encoder;
        VideoReader reader(path);
        Image image;
        for (const Image& picture : pictures) {
            ASSERT_TRUE(reader.read(image)) << c.encoder;
            EXPECT_TRUE(image.rgb == picture.rgb || test::psnr(image, picture) > c.least) << c.encoder;
        }
        EXPECT_FALSE(reader.read(image)) << c.encoder;
    }
    EXPECT_EQ(film_extension(automatic_encoder), std::string(".mp4"));
    try {
        require_encoder({.encoder = "prores"}, 64, 48); // of 4:2:2 10 bits as well
        require_encoder({.encoder = "png"}, 64, 48);
        FAIL() << "no error";
    } catch (const sim::Error& error) {
        EXPECT_EQ(error.code(), sim::ExitCode::usage);
        EXPECT_NE(std::string(error.what()).find("libx264"), std::string::npos) << error.what();
    }
}

TEST(video_writer, pure_colours_arrive_as_bt709_limited_range_and_are_tagged) {
    const fs::path folder = fresh_folder();
    const std::array<std::array<int, 3>, 5> colors{
        {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 255}, {0, 0, 0}}};
    for (const auto& rgb : colors) {
        const fs::path path =
            folder / (std::to_string(rgb[0]) + std::to_string(rgb[1]) + std::to_string(rgb[2]));
        write_film(path, {plain_picture(64, 48, rgb)}, {});
        const test::Film film = test::read_film(path);
        EXPECT_TRUE(film.is_tagged_bt709);
        ASSERT_EQ(film.frames.size(), 1u);
        const test::YcbcrColor expected = test::to_bt709(rgb[0], rgb[1], rgb[2]);
        const std::size_t centre = 24 * 64 + 32;
        EXPECT_NEAR(film.frames[0].y[centre], expected.y, 1.0);
        EXPECT_NEAR(film.frames[0].cb[12 * 32 + 16], expected.cb, 1.0);
        EXPECT_NEAR(film.frames[0].cr[12 * 32 + 16], expected.cr, 1.0);
    }
}

// Red rises by 6 levels a pixel to the right and blue downwards: Cr by 2.6 a pixel, so that half a pixel in
// the place of the chroma samples is 1.3 levels. Sited left: on column 2 c, between rows 2 r and 2 r + 1.
TEST(video_writer, chroma_samples_lie_on_the_left_column_between_the_rows) {
    const fs::path path = fresh_folder() / "ramp.mp4";
    Image ramp(40, 40);
    for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 40; ++x) {
            set_pixel(ramp, x, y, {6 * x, 100, 6 * y});
        }
    }
    write_film(path, {ramp}, {.crf = 0});
    const test::Film film = test::read_film(path);
    double cr_error = 0, cb_error = 0;
    int count = 0;
    for (int row = 4; row < 16; ++row) {
        for (int col = 4; col < 16; ++col) {
            const test::YcbcrColor expected = test::to_bt709(6 * 2 * col, 100, 6 * (2 * row + 0.5));
            cr_error += film.frames[0].cr[row * 20 + col] - expected.cr;
            cb_error += film.frames[0].cb[row * 20 + col] - expected.cb;
            ++count;
        }
    }
    EXPECT_NEAR(cr_error / count, 0.0, 0.5);
    EXPECT_NEAR(cb_error / count, 0.0, 0.5);
}

TEST(video_writer, same_pictures_and_settings_give_the_same_bytes_and_no_version_or_date_of_the_writer) {
    const fs::path folder = fresh_folder();
    const VideoSettings settings{.fps = {30, 1},
                                 .metadata = {{"title", "Five balls"}, {"scene", "office_toy"}}};
    write_film(folder / "a.mp4", test_pictures(96, 64, 12), settings);
    write_film(folder / "b.mp4", test_pictures(96, 64, 12), settings);
    const std::string bytes = sim::read_text_file(folder / "a.mp4");
    EXPECT_TRUE(bytes == sim::read_text_file(folder / "b.mp4"));
    EXPECT_EQ(bytes.find("Lavf"), std::string::npos);
    EXPECT_EQ(bytes.find("Lavc"), std::string::npos);
    // x264 writes its settings into the stream: none may depend on the number of cores.
    EXPECT_NE(bytes.find(" threads=1 lookahead_threads=1 "), std::string::npos);
    EXPECT_NE(bytes.find(" crf=18.0 "), std::string::npos);
    // Fast start: the index lies before the pictures.
    EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
    const test::Film film = test::read_film(folder / "a.mp4");
    EXPECT_EQ(film.metadata.at("title"), "Five balls");
    EXPECT_EQ(film.metadata.at("scene"), "office_toy");
    EXPECT_EQ(film.metadata.count("creation_time"), 0u);
}

TEST(video_writer, odd_sizes_are_padded_by_the_last_column_and_row) {
    const fs::path folder = fresh_folder();
    for (const auto& [width, height] : {std::pair{41, 31}, std::pair{1, 1}, std::pair{2, 3}}) {
        const fs::path path = folder / (std::to_string(width) + "x" + std::to_string(height) + ".mp4");
        write_film(path, {plain_picture(width, height, {10, 200, 30})}, {});
        const test::Film film = test::read_film(path);
        EXPECT_EQ(film.width, width + width % 2);
        EXPECT_EQ(film.height, height + height % 2);
        ASSERT_EQ(film.frames.size(), 1u);
        const test::YcbcrColor expected = test::to_bt709(10, 200, 30);
        for (const std::uint8_t y : film.frames[0].y) {
            EXPECT_NEAR(y, expected.y, 2.0);
        }
    }
}

TEST(video_writer, a_film_that_is_not_finished_leaves_no_file) {
    const fs::path path = fresh_folder() / "a.mp4";
    {
        VideoWriter video(path, 32, 32, {});
        video.add(Image(32, 32));
        EXPECT_TRUE(fs::exists(sim::part_path(path)));
    }
    EXPECT_FALSE(fs::exists(path));
    EXPECT_FALSE(fs::exists(sim::part_path(path)));
}

TEST(video_writer, a_missing_folder_and_a_full_device_are_io_errors) {
    const fs::path folder = fresh_folder();
    const auto code_of = [](const fs::path& path) {
        try {
            write_film(path, test_pictures(320, 180, 30), {.crf = 0});
        } catch (const sim::Error& error) {
            return error.code();
        }
        return sim::ExitCode::good;
    };
    EXPECT_EQ(code_of(folder / "nowhere" / "a.mp4"), sim::ExitCode::io);
    fs::create_symlink("/dev/full", folder / "a.mp4.part");
    EXPECT_EQ(code_of(folder / "a.mp4"), sim::ExitCode::io);
    EXPECT_FALSE(fs::exists(folder / "a.mp4"));
}

TEST(video_writer, settings_that_x264_refuses_are_usage_errors) {
    const fs::path path = fresh_folder() / "a.mp4";
    try {
        VideoWriter video(path, 32, 32, {.preset = "hasty"});
        FAIL();
    } catch (const sim::Error& error) {
        EXPECT_EQ(error.code(), sim::ExitCode::usage);
        EXPECT_NE(std::string(error.what()).find("preset 'hasty'"), std::string::npos);
    }
    EXPECT_THROW(VideoWriter(path, 32, 32, {.fps = {std::int64_t(1) << 40, 1}}), sim::Error);
    EXPECT_FALSE(fs::exists(sim::part_path(path)));
}
