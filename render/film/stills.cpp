#include "render/film/stills.h"

#include "render/film/gif.h"
#include "render/picture/image.h"
#include "sim/base/error.h"

#include <stb_image_resize.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

namespace render {

namespace {

using sim::Error;
using sim::ExitCode;

/// Width of a sheet, and the gap between its frames [px].
constexpr int sheet_width = 1920;
constexpr int sheet_gap = 8;
constexpr std::uint8_t sheet_gray = 20;
/// libwebp's quality 0..100: 6 s of 480 px, 15 pictures a second, have about 1 MB.
constexpr float animation_quality = 60.0f;

/// The picture, `width` wide at most; light is averaged, not display values.
Image reduced_to_width(Image image, int width) {
    if (image.width <= width) {
        return image;
    }
    const double scale = static_cast<double>(width) / image.width;
    Image small(width, std::max(1, static_cast<int>(std::lround(image.height * scale))));
    CHECK(stbir_resize_uint8_srgb(image.rgb.data(), image.width, image.height, 0, small.rgb.data(),
                                  small.width, small.height, 0, 3, STBIR_ALPHA_CHANNEL_NONE, 0) == 1);
    return small;
}

/// Frames side by side, row by row.
Image make_sheet(std::span<const Image> tiles, int columns) {
    const int rows = (static_cast<int>(tiles.size()) + columns - 1) / columns;
    const int width = tiles.front().width;
    const int height = tiles.front().height;
    Image sheet(columns * (width + sheet_gap) + sheet_gap, rows * (height + sheet_gap) + sheet_gap);
    std::ranges::fill(sheet.rgb, sheet_gray);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const int x = sheet_gap + static_cast<int>(i) % columns * (width + sheet_gap);
        const int y = sheet_gap + static_cast<int>(i) / columns * (height + sheet_gap);
        for (int row = 0; row < height; ++row) {
            std::copy_n(tiles[i].rgb.begin() + static_cast<std::ptrdiff_t>(3) * row * width, 3 * width,
                        sheet.rgb.begin() + static_cast<std::ptrdiff_t>(3) * ((y + row) * sheet.width + x));
        }
    }
    return sheet;
}

struct EncoderDeleter {
    void operator()(WebPAnimEncoder* encoder) const noexcept { WebPAnimEncoderDelete(encoder); }
};
struct PictureDeleter {
    void operator()(WebPPicture* picture) const noexcept { WebPPictureFree(picture); }
};

[[noreturn]] void fail(const std::string& reason) {
    throw Error(ExitCode::io, "cannot encode the animation: " + reason);
}

/// Pictures of one size -> the bytes of an animated WebP.
class Animation {
public:
    void add(const Image& image, int start_ms) {
        if (encoder_ == nullptr) {
            WebPAnimEncoderOptions options{};
            CHECK(WebPAnimEncoderOptionsInit(&options) != 0 && WebPConfigInit(&config_) != 0);
            config_.quality = animation_quality;
            encoder_.reset(WebPAnimEncoderNew(image.width, image.height, &options));
        }
        WebPPicture picture{};
        CHECK(WebPPictureInit(&picture) != 0);
        picture.width = image.width;
        picture.height = image.height;
        picture.use_argb = 1;
        const std::unique_ptr<WebPPicture, PictureDeleter> owner(&picture);
        if (encoder_ == nullptr || WebPPictureImportRGB(&picture, image.rgb.data(), 3 * image.width) == 0) {
            fail("out of memory");
        }
        check(WebPAnimEncoderAdd(encoder_.get(), &picture, start_ms, &config_));
    }

    std::vector<std::uint8_t> finish(int end_ms) {
        WebPData data{};
        check(WebPAnimEncoderAdd(encoder_.get(), nullptr, end_ms, nullptr));
        check(WebPAnimEncoderAssemble(encoder_.get(), &data));
        std::vector<std::uint8_t> bytes(data.bytes, data.bytes + data.size);
        WebPDataClear(&data);
        return bytes;
    }

private:
    void check(int is_good) const {
        if (is_good == 0) {
            fail(WebPAnimEncoderGetError(encoder_.get()));
        }
    }

    std::unique_ptr<WebPAnimEncoder, EncoderDeleter> encoder_;
    WebPConfig config_{};
};

/// Those frames of the film that an animation shows, each from its time in the film on.
AnimationPictures pictures_of(const sim::SceneDef& scene, const StillsSettings& settings,
                        const std::function<std::filesystem::path(std::int64_t)>& frame_path) {
    const double fps = scene.output.fps.value();
    const std::int64_t frames = sim::frame_count(scene.output.duration, scene.output.fps);
    const double step = std::max(1.0, fps / settings.animation_rate);
    const auto count = static_cast<int>(std::ceil(static_cast<double>(frames) / step - 1e-9));
    const auto frame_of = [=](int i) { return std::min(std::llround(i * step), static_cast<long long>(frames - 1)); };
    return {count, [=](int i) { return reduced_to_width(read_image(frame_path(frame_of(i))), settings.animation_width); },
            [=](int i) { return static_cast<double>(i == count ? frames : frame_of(i)) / fps; }};
}

} // namespace

std::array<std::string, 4> stills_names(const std::string& scene) {
    return {scene + "_poster.png", scene + "_sheet.png", scene + ".webp", scene + ".gif"};
}

std::vector<sim::WrittenFile>
make_stills(const sim::SceneDef& scene, const StillsSettings& settings,
            const std::function<std::filesystem::path(std::int64_t)>& frame_path,
            const std::filesystem::path& folder) {
    const std::array<std::string, 4> names = stills_names(scene.name);
    std::vector<sim::WrittenFile> files;
    const auto write = [&](const std::string& name, std::span<const std::uint8_t> bytes) {
        sim::write_file(folder / name, bytes);
        files.push_back(sim::describe_file(folder, name));
    };
    const double fps = scene.output.fps.value();
    const std::int64_t count = sim::frame_count(scene.output.duration, scene.output.fps);
    const auto last = static_cast<double>(count - 1);
    if (settings.poster_time) {
        write(names[0],
              encode_png(read_image(frame_path(std::llround(std::min(*settings.poster_time * fps, last))))));
    }
    if (settings.sheet_count > 0) {
        const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(settings.sheet_count))));
        const int width = std::max(1, (sheet_width - (columns + 1) * sheet_gap) / columns);
        std::vector<Image> tiles;
        for (int i = 0; i < settings.sheet_count; ++i) {
            const double share = settings.sheet_count == 1 ? 0.5 : i / (settings.sheet_count - 1.0);
            tiles.push_back(reduced_to_width(read_image(frame_path(std::llround(share * last))), width));
        }
        write(names[1], encode_png(make_sheet(tiles, columns)));
    }
    const AnimationPictures pictures = pictures_of(scene, settings, frame_path);
    if (settings.has_webp) {
        const auto ms_of = [&](int i) { return static_cast<int>(std::llround(1e3 * pictures.start_time(i))); };
        Animation animation;
        for (int i = 0; i < pictures.count; ++i) {
            animation.add(pictures.picture(i), ms_of(i));
        }
        write(names[2], animation.finish(ms_of(pictures.count)));
    }
    if (settings.has_gif) {
        write(names[3], encode_gif(pictures));
    }
    return files;
}

} // namespace render
