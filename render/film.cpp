#include "render/film.h"

#include "render/body_image.h"
#include "render/overlay.h"
#include "render/renderer.h"
#include "sim/error.h"

#include <fmt/format.h>

#include <algorithm>

namespace render {

namespace {

// A state of 1000 bodies is 0.1 MB.
constexpr std::size_t states_ahead = 8;

// Pictures that may wait for one writer: as many as fit in 64 MB, 1 to 8.
std::size_t pictures_ahead(const sim::OutputDef& output) {
    constexpr std::size_t bytes = 64 << 20;
    const std::size_t picture =
        static_cast<std::size_t>(output.width) * static_cast<std::size_t>(output.height) * 3;
    return std::clamp<std::size_t>(bytes / picture, 1, 8);
}

// One frame with all that lies over it.
Image draw_frame(Renderer& renderer, Overlay& overlay, const sim::Snapshot& snapshot, const Notes& notes) {
    if (overlay.colors().is_needed()) {
        renderer.set_colors(overlay.colors().of(snapshot));
    }
    Image image = renderer.draw(snapshot);
    if (overlay.is_needed()) {
        overlay.draw(image, snapshot, notes, overlay.needs_depth() ? renderer.depth() : DepthPicture());
    }
    return image;
}

std::string to_text(const sim::Rational& r) {
    return r.den == 1 ? fmt::format("{}", r.num) : fmt::format("{}/{}", r.num, r.den);
}

} // namespace

VideoSettings video_settings(const sim::SceneDef& scene) {
    std::string comment = fmt::format("tumble {}; scene {}; time step {} s; tolerance {} m; {} frames/s",
                                      TUMBLE_VERSION, scene.name, to_text(scene.step.time_step),
                                      scene.step.tolerance, to_text(scene.output.fps));
    for (const std::string& assignment : scene.overrides) {
        comment += "; " + assignment;
    }
    VideoSettings settings;
    settings.fps = scene.output.fps;
    settings.metadata = {{"title", scene.title.empty() ? scene.name : scene.title}, {"comment", comment}};
    return settings;
}

std::string frame_file_name(std::int64_t frame) {
    return fmt::format("frames/frame_{:06}.png", frame);
}

Film::Film(const sim::SceneDef& scene, const FilmSettings& settings)
    : scene_(scene), settings_(settings), note_taker_(scene), states_(states_ahead),
      for_png_(pictures_ahead(scene.output)), for_video_(pictures_ahead(scene.output)) {}

void Film::start(ThreadGroup& threads) {
    threads.on_stop([this] {
        states_.cancel();
        for_png_.cancel();
        for_video_.cancel();
    });
    if (settings_.write_png) {
        threads.start([this] { write_frames(); });
    }
    if (settings_.write_video) {
        threads.start([this, &threads] { encode_video(threads); });
    }
    threads.start([this] { draw_frames(); });
}

bool Film::add(std::int64_t frame, std::shared_ptr<const sim::Snapshot> snapshot) {
    observe(*snapshot);
    if (frame < settings_.first_frame) {
        return true;
    }
    return states_.push({frame, std::move(snapshot), note_taker_.notes()});
}

void Film::observe(const sim::Snapshot& snapshot) {
    if (note_taker_.is_needed()) {
        note_taker_.observe(snapshot);
    }
}

std::int64_t Film::frames_done() const {
    if (!settings_.write_png) {
        return video_frames_done_;
    }
    return settings_.write_video ? std::min<std::int64_t>(pngs_done_, video_frames_done_) : pngs_done_.load();
}

std::vector<sim::WrittenFile> Film::files() const {
    std::vector<sim::WrittenFile> files = video_files_;
    files.insert(files.end(), png_files_.begin(), png_files_.end());
    files.insert(files.end(), body_files_.begin(), body_files_.end());
    return files;
}

// The picture in the file of a frame that is there and whole.
std::shared_ptr<const Image> Film::kept_picture(std::int64_t frame) const {
    const std::filesystem::path path = settings_.folder / frame_file_name(frame);
    std::error_code error;
    if (!settings_.keep_frames || !std::filesystem::is_regular_file(path, error)) {
        return nullptr;
    }
    try {
        Image image = read_image(path);
        if (image.width == scene_.output.width && image.height == scene_.output.height) {
            return std::make_shared<const Image>(std::move(image));
        }
    } catch (const sim::Error&) {
        // A damaged file is drawn again.
    }
    return nullptr;
}

void Film::draw_frames() {
    // The OpenGL context belongs to this thread.
    Renderer renderer(scene_, scene_.output.width, scene_.output.height);
    renderer_string_ = renderer.renderer_string();
    Overlay overlay(scene_);
    while (const std::optional<State> state = states_.pop()) {
        std::shared_ptr<const Image> image = kept_picture(state->frame);
        const bool is_kept = image != nullptr;
        if (!is_kept) {
            image = std::make_shared<const Image>(draw_frame(renderer, overlay, *state->snapshot, *state->notes));
            if (settings_.write_bodies) {
                const std::string frame = frame_file_name(state->frame);
                for (const std::string& name :
                     write_body_image(settings_.folder, frame, scene_, *state->snapshot, renderer.body_ids())) {
                    body_files_.push_back(sim::describe_file(settings_.folder, name));
                }
            }
        }
        const Picture picture{state->frame, image, is_kept};
        if (settings_.write_png) {
            for_png_.push(picture);
        }
        if (settings_.write_video) {
            for_video_.push(picture);
        }
    }
    for_png_.close();
    for_video_.close();
}

void Film::write_frames() {
    while (const std::optional<Picture> picture = for_png_.pop()) {
        const std::string name = frame_file_name(picture->frame);
        if (!picture->is_kept) {
            sim::write_file(settings_.folder / name, encode_png(*picture->image));
        }
        png_files_.push_back(sim::describe_file(settings_.folder, name));
        ++pngs_done_;
    }
}

void Film::encode_video(const ThreadGroup& threads) {
    const std::string name = scene_.name + ".mp4";
    VideoWriter video(settings_.folder / name, scene_.output.width, scene_.output.height,
                      video_settings(scene_));
    while (const std::optional<Picture> picture = for_video_.pop()) {
        video.add(*picture->image);
        ++video_frames_done_;
    }
    if (threads.is_stopping()) {
        return; // the part file goes
    }
    video.finish();
    video_files_.push_back(sim::describe_file(settings_.folder, name));
}

} // namespace render
