#include "render/film/film.h"

#include "render/picture/body_image.h"
#include "render/picture/passes.h"
#include "render/picture/renderer.h"
#include "sim/base/error.h"
#include "sim/model/film_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <deque>

namespace render {

namespace {

// A state of 1000 bodies is 0.1 MB.
constexpr std::size_t states_ahead = 8;

// Shots between two stages of a picture: one is worked on while another waits.
constexpr std::size_t shots_ahead = 2;

// Raw pictures: two that wait, one in each of two stages.
constexpr std::size_t raw_pictures = 4;

// Adds the processor time of this thread while it exists.
class Stopwatch {
public:
    explicit Stopwatch(double& sum_ms) : sum_ms_(sum_ms), start_ms_(now_ms()) {}
    ~Stopwatch() { sum_ms_ += now_ms() - start_ms_; }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    static double now_ms() {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
    }

    double& sum_ms_;
    double start_ms_;
};

RenderSettings film_settings(const sim::OutputDef& output, bool writes_bodies) {
    RenderSettings settings = render_settings(output);
    settings.reads_ids = settings.smooth_edges || writes_bodies || output.has_passes();
    settings.is_deep = output.has(sim::PicturePass::rgb16);
    return settings;
}

// Pictures that may wait for one writer: as many as fit in 64 MB, 1 to 8.
std::size_t pictures_ahead(const sim::OutputDef& output) {
    constexpr std::size_t bytes = 64 << 20;
    const std::size_t picture =
        static_cast<std::size_t>(output.width) * static_cast<std::size_t>(output.height) * 3;
    return std::clamp<std::size_t>(bytes / picture, 1, 8);
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
    settings.crf = scene.output.crf;
    settings.preset = scene.output.effort;
    settings.encoder = scene.output.encoder;
    settings.bits = scene.output.bits;
    settings.metadata = {{"title", scene.title.empty() ? scene.name : scene.title}, {"comment", comment}};
    return settings;
}

std::string frame_file_name(std::int64_t frame) {
    return fmt::format("frames/frame_{:06}.png", frame);
}

std::string film_file_name(const sim::SceneDef& scene) {
    return scene.name + film_extension(scene.output.encoder);
}

namespace {

/// What the passes of a frame are written as, after its name.
constexpr std::string_view exr_suffix = ".exr";
constexpr std::string_view rgba_suffix = ".rgba.png";
constexpr std::string_view depth_suffix = ".depth.png";
constexpr std::string_view deep_suffix = ".rgb16.png";

std::vector<std::string_view> pass_suffixes(const sim::OutputDef& output) {
    using enum sim::PicturePass;
    std::vector<std::string_view> suffixes;
    if (output.has(depth) || output.has(normal) || output.has(body) || output.has(motion) || output.has(alpha)) {
        suffixes.push_back(exr_suffix);
    }
    if (output.has(rgba)) {
        suffixes.push_back(rgba_suffix);
    }
    if (output.has(depth16)) {
        suffixes.push_back(depth_suffix);
    }
    if (output.has(rgb16)) {
        suffixes.push_back(deep_suffix);
    }
    return suffixes;
}

std::vector<std::uint8_t> pass_file(std::string_view suffix, const PassSource& source, const sim::OutputDef& output) {
    if (suffix == rgba_suffix) {
        return encode_png(PngKind::rgba8, output.width, output.height, rgba_samples(source));
    }
    if (suffix == depth_suffix) {
        return encode_png(PngKind::gray16, output.width, output.height, depth16_samples(source));
    }
    if (suffix == deep_suffix) {
        return encode_png(PngKind::rgb16, output.width, output.height, rgb16_samples(source));
    }
    return encode_exr(make_passes(source, output), output.width, output.height);
}

std::string pass_file_name(std::string_view suffix, std::int64_t frame) {
    return fmt::format("frames/frame_{:06}{}", frame, suffix);
}

} // namespace

std::vector<std::string> pass_file_names(const sim::OutputDef& output, std::int64_t frame) {
    std::vector<std::string> names;
    for (const std::string_view suffix : pass_suffixes(output)) {
        names.push_back(pass_file_name(suffix, frame));
    }
    return names;
}

Film::Film(const sim::SceneDef& scene, const FilmSettings& settings)
    : scene_(scene), settings_(settings), note_taker_(scene), overlay_(scene),
      plan_(std::make_shared<const PicturePlan>(scene, scene.output.width, scene.output.height,
                                                film_settings(scene.output, settings.write_bodies))),
      states_(states_ahead), listed_(shots_ahead), drawn_(shots_ahead), blanks_(raw_pictures),
      for_png_(pictures_ahead(scene.output)), for_video_(pictures_ahead(scene.output)) {}

void Film::start(ThreadGroup& threads) {
    threads.on_stop([this] {
        states_.cancel();
        listed_.cancel();
        drawn_.cancel();
        blanks_.cancel();
        for_png_.cancel();
        for_video_.cancel();
    });
    if (settings_.write_png) {
        threads.start([this] { write_frames(); });
    }
    if (settings_.write_video) {
        threads.start([this, &threads] { encode_video(threads); });
    }
    if (settings_.raw) {
        threads.start([this] { write_raw(); });
    }
    threads.start([this] { finish_pictures(); });
    threads.start([this] { draw_shots(); });
    threads.start([this] { list_shots(); });
}

bool Film::add(std::int64_t frame, std::shared_ptr<const sim::Snapshot> snapshot) {
    observe(*snapshot);
    if (frame < settings_.first_frame ||
        (!settings_.frames.empty() && !std::binary_search(settings_.frames.begin(), settings_.frames.end(), frame))) {
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
    files.insert(files.end(), number_files_.begin(), number_files_.end());
    return files;
}

// The picture in the file of a frame that is there and whole.
std::shared_ptr<const Image> Film::kept_picture(std::int64_t frame) const {
    const std::filesystem::path path = settings_.folder / frame_file_name(frame);
    std::error_code error;
    const std::vector<std::string> passes = pass_file_names(scene_.output, frame);
    const auto is_there = [&](const std::filesystem::path& file) { return std::filesystem::is_regular_file(file, error); };
    if (!settings_.keep_frames || !is_there(path) ||
        !std::ranges::all_of(passes, [&](const std::string& name) { return is_there(settings_.folder / name); })) {
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

void Film::list_shots() {
    const sim::OutputDef& output = scene_.output;
    sim::SceneDef colored = scene_; // its bodies' colours may change from frame to frame
    while (const std::optional<State> state = states_.pop()) {
        const Stopwatch watch(times_.list);
        Shot shot{*state};
        if ((shot.kept = kept_picture(state->frame)) != nullptr) {
            listed_.push(std::move(shot));
            continue;
        }
        if (overlay_.colors().is_needed()) {
            const std::vector<sim::Vec3> colors = overlay_.colors().of(*state->snapshot);
            for (std::size_t i = 0; i < colors.size(); ++i) {
                colored.bodies[i].look.color = colors[i];
            }
        }
        const double open = output.shutter * frame_time(state->frame);
        const std::vector<sim::Snapshot> moments = output.shutter > 0.0
                                                       ? states_in_shutter(*state->snapshot, open, output.subframes)
                                                       : std::vector{*state->snapshot};
        shot.left = static_cast<int>(moments.size());
        for (DrawList& list : plan_->lists(colored, moments)) {
            --shot.left;
            Shot next = shot;
            next.list = std::move(list);
            listed_.push(std::move(next));
            shot.is_first = false;
        }
    }
    listed_.close();
}

void Film::draw_shots() {
    // The OpenGL context belongs to this thread.
    std::optional<Renderer> renderer;
    {
        const Stopwatch watch(times_.draw);
        renderer.emplace(plan_);
        renderer_string_ = renderer->renderer_string();
    }
    for (std::size_t i = 0; i < raw_pictures; ++i) {
        blanks_.push({});
    }
    // Shots that OpenGL has begun, and kept ones between them.
    std::deque<Shot> begun;
    int drawing = 0; // of them that OpenGL has begun
    const auto hand_on_first = [&] { // false: the film was given up
        Shot shot = std::move(begun.front());
        begun.pop_front();
        if (shot.kept == nullptr) {
            std::optional<RawPicture> blank = blanks_.pop();
            if (!blank) {
                return false;
            }
            const Stopwatch watch(times_.draw);
            shot.raw = std::move(*blank);
            renderer->finish(shot.raw, shot.depth);
            --drawing;
        }
        return drawn_.push(std::move(shot));
    };
    const bool needs_depth = overlay_.needs_depth() || scene_.output.has_passes();
    const int middle = scene_.output.shutter > 0.0 ? scene_.output.subframes / 2 : 0;
    while (std::optional<Shot> shot = listed_.pop()) {
        if (shot->kept == nullptr) {
            const Stopwatch watch(times_.draw);
            // What lies over a blurred picture lies where the middle one shows it.
            renderer->begin(shot->list, needs_depth && shot->left == middle);
            ++drawing;
        }
        begun.push_back(std::move(*shot));
        while (drawing == renderer->capacity() || (!begun.empty() && begun.front().kept != nullptr)) {
            if (!hand_on_first()) {
                return;
            }
        }
    }
    while (!begun.empty() && hand_on_first()) {
    }
    drawn_.close();
}

void Film::finish_pictures() {
    PictureMean mean;
    DepthPicture depth;
    while (std::optional<Shot> shot = drawn_.pop()) {
        if (shot->kept != nullptr) {
            hand_on({shot->state.frame, shot->kept, true});
            continue;
        }
        Image image;
        {
            const Stopwatch watch(times_.edges);
            image = plan_->picture(shot->raw, shot->list);
            if (!shot->depth.depth.empty()) {
                depth = std::move(shot->depth);
            }
            if (shot->is_first) {
                write_numbers(*shot, depth);
            }
            mean.add(std::move(image), shot->list.redrawn);
            image = shot->left == 0 ? mean.take() : Image();
            if (shot->left == 0 && overlay_.is_needed()) {
                const double film_time = static_cast<double>(shot->state.frame) / scene_.output.fps.value();
                overlay_.draw(image, {film_time, *shot->state.snapshot, *shot->state.notes, depth});
            }
        }
        blanks_.push(std::move(shot->raw));
        if (shot->left == 0) {
            hand_on({shot->state.frame, std::make_shared<const Image>(std::move(image)), false});
        }
    }
    for_png_.close();
    for_video_.close();
}

void Film::write_numbers(const Shot& shot, const DepthPicture& depth) {
    const std::string name = frame_file_name(shot.state.frame);
    if (settings_.write_bodies) {
        for (const std::string& file : write_body_image(settings_.folder, name, scene_, *shot.state.snapshot,
                                                        body_ids(shot.raw, shot.list))) {
            number_files_.push_back(sim::describe_file(settings_.folder, file));
        }
    }
    if (scene_.output.has_passes()) {
        const PassSource source{*plan_, shot.raw, shot.list, depth, *shot.state.snapshot, frame_time(shot.state.frame)};
        for (const std::string_view suffix : pass_suffixes(scene_.output)) {
            const std::string file = pass_file_name(suffix, shot.state.frame);
            sim::write_file_unsynced(settings_.folder / file, pass_file(suffix, source, scene_.output));
            number_files_.push_back(sim::describe_file(settings_.folder, file));
        }
    }
}

double Film::frame_time(std::int64_t frame) const {
    const double fps = scene_.output.fps.value();
    return sim::speed_at(scene_.output, static_cast<double>(frame) / fps) / fps;
}

void Film::hand_on(const Picture& picture) {
    if (settings_.write_png) {
        for_png_.push(picture);
    }
    if (settings_.write_video || settings_.raw) { // never both
        for_video_.push(picture);
    }
}

void Film::write_frames() {
    while (const std::optional<Picture> picture = for_png_.pop()) {
        const Stopwatch watch(times_.png);
        const std::string name = frame_file_name(picture->frame);
        if (!picture->is_kept) {
            sim::write_file_unsynced(settings_.folder / name, encode_png(*picture->image));
        }
        png_files_.push_back(sim::describe_file(settings_.folder, name));
        ++pngs_done_;
    }
    sim::sync_files(settings_.folder);
}

void Film::encode_video(const ThreadGroup& threads) {
    const std::string name = film_file_name(scene_);
    VideoWriter video(settings_.folder / name, scene_.output.width, scene_.output.height,
                      video_settings(scene_));
    while (const std::optional<Picture> picture = for_video_.pop()) {
        const Stopwatch watch(times_.video);
        video.add(*picture->image);
        ++video_frames_done_;
    }
    if (threads.is_stopping()) {
        return; // the part file goes
    }
    const Stopwatch watch(times_.video);
    video.finish();
    video_files_.push_back(sim::describe_file(settings_.folder, name));
}

void Film::write_raw() {
    std::optional<RawWriter> writer;
    while (const std::optional<Picture> picture = for_video_.pop()) {
        const Stopwatch watch(times_.video);
        if (!writer) {
            writer.emplace(stdout, *settings_.raw, *picture->image, scene_.output.fps);
        }
        writer->add(*picture->image);
        ++video_frames_done_;
    }
    if (writer) {
        writer->finish();
    }
}

} // namespace render
