#include "render/cmd/films.h"

#include "render/video_reader.h"

#include <utility>

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

} // namespace

diff::FilmTools film_tools() {
    diff::FilmTools tools;
    tools.open = [](const std::filesystem::path& path) { return std::make_unique<LibavReader>(path); };
    return tools;
}

} // namespace cmd
