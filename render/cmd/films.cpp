#include "render/cmd/films.h"

#include "render/film/video_reader.h"
#include "render/film/video_writer.h"

#include <algorithm>
#include <cmath>

namespace cmd {

namespace {

class LibavReader : public diff::FilmReader {
public:
    explicit LibavReader(const std::filesystem::path& path) : video_(path) {}

    bool read(diff::Picture& picture) override {
        if (!video_.read(image_)) {
            return false;
        }
        picture.width = image_.width;
        picture.height = image_.height;
        picture.rgb = image_.rgb;
        picture.alpha.clear();
        picture.fine_hash = 0;
        return true;
    }
    double fps() const override { return video_.fps(); }

private:
    render::VideoReader video_;
    render::Image image_;
};

class LibavWriter : public diff::FilmWriter {
public:
    LibavWriter(const std::filesystem::path& path, int width, int height, double fps)
        : video_(path, width, height, settings_of(fps)), image_(width, height) {}

    void add(const diff::Picture& picture) override {
        image_.rgb = picture.rgb;
        video_.add(image_);
    }
    void finish() override { video_.finish(); }

private:
    static render::VideoSettings settings_of(double fps) {
        render::VideoSettings settings;
        settings.preset = "superfast"; // for the eye, and as large as a few pictures anyway
        settings.fps = sim::make_rational(std::max(1L, std::lround(fps * 1001)), 1001);
        return settings;
    }

    render::VideoWriter video_;
    render::Image image_;
};

} // namespace

diff::FilmTools film_tools() {
    diff::FilmTools tools;
    tools.open = [](const std::filesystem::path& path) { return std::make_unique<LibavReader>(path); };
    tools.create = [](const std::filesystem::path& path, int width, int height, double fps) {
        return std::make_unique<LibavWriter>(path, width, height, fps);
    };
    return tools;
}

std::string film_note(const sim::SceneDef& scene) {
    const std::string& encoder = scene.output.encoder;
    const bool is_x264 = encoder == render::automatic_encoder || encoder == "libx264";
    return is_x264 && scene.output.crf == 0 ? scene.name + ": crf 0 is a lossless film, which browsers do not play\n" : "";
}

} // namespace cmd
