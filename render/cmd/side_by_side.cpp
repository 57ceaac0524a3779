#include "render/cmd/side_by_side.h"

#include "render/cmd/interrupt.h"
#include "render/cmd/run_folder.h"
#include "render/film/panels.h"
#include "render/film/video_reader.h"
#include "render/film/video_writer.h"
#include "sim/base/error.h"
#include "sim/base/rational.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

constexpr std::size_t most_films = 4;
/// [px] Width of the whole film at most.
constexpr int most_width = 1920;

/// The film itself, or the one in the folder of a run.
fs::path film_of(const std::string& input) {
    std::error_code error;
    const fs::path path = fs::path(input).has_filename() ? fs::path(input) : fs::path(input).parent_path();
    if (!fs::is_directory(path, error)) {
        return path;
    }
    std::vector<fs::path> films;
    for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
        if (std::ranges::find(render::film_extensions, entry.path().extension()) != render::film_extensions.end()) {
            films.push_back(entry.path());
        }
    }
    if (films.size() != 1) {
        throw Error(ExitCode::io, fmt::format("{} has {} films, expected one", input, films.size()));
    }
    return films.front();
}

/// A film that is read as time goes on.
class Track {
public:
    explicit Track(const fs::path& path) : reader_(path) {
        is_over_ = !reader_.read(panel.picture);
        if (is_over_) {
            throw Error(ExitCode::io, path.string() + " has no picture");
        }
        has_next_ = reader_.read(next_);
    }

    double fps() const { return reader_.fps(); }
    /// The last picture stays when the film is over.
    bool is_over() const { return is_over_; }

    /// Shows the picture of a time [s]; times ascend.
    void go_to(double time) {
        // A thousandth of a frame: a time that is a frame's own, but for rounding, shows that frame.
        const auto wanted = static_cast<std::int64_t>(std::floor(time * fps() + 1e-3));
        while (index_ < wanted && has_next_) {
            std::swap(panel.picture, next_);
            has_next_ = reader_.read(next_);
            ++index_;
        }
        is_over_ = index_ < wanted;
    }

    render::Panel panel;

private:
    render::VideoReader reader_;
    render::Image next_;
    bool has_next_ = false;
    bool is_over_ = false;
    std::int64_t index_ = 0;
};

std::vector<Track> open_tracks(const SideBySideOptions& options) {
    std::vector<Track> tracks;
    for (std::size_t i = 0; i < options.inputs.size(); ++i) {
        const fs::path film = film_of(options.inputs[i]);
        tracks.emplace_back(film);
        const bool is_run = fs::is_directory(options.inputs[i]);
        const std::string name =
            is_run ? fs::path(options.inputs[i]).lexically_normal().string() : film.stem().string();
        tracks.back().panel.labels = {options.labels.empty() ? name : options.labels[i]};
    }
    return tracks;
}

/// A fraction near a film's rate: 23.976 is 24000/1001.
sim::Rational rate_of(double fps) {
    const double thousand = fps * 1001.0 / 1000.0;
    if (std::abs(fps - std::round(fps)) > 1e-6 && std::abs(thousand - std::round(thousand)) < 1e-3) {
        return sim::make_rational(static_cast<std::int64_t>(std::llround(thousand)) * 1000, 1001);
    }
    return sim::make_rational(static_cast<std::int64_t>(std::llround(fps * 1000.0)), 1000);
}

/// That of the largest picture, smaller if the film would be too wide; even, as films are.
render::PanelSize panel_size(const std::vector<Track>& tracks) {
    render::PanelSize size;
    for (const Track& track : tracks) {
        size.width = std::max(size.width, track.panel.picture.width);
        size.height = std::max(size.height, track.panel.picture.height);
    }
    const double scale =
        std::min(1.0, static_cast<double>(most_width) / arranged_size(size, tracks.size()).width);
    const auto even = [&](int x) { return std::max(2, static_cast<int>(x * scale) / 2 * 2); };
    return {even(size.width), even(size.height), 0};
}

std::vector<render::Panel> panels_of(const std::vector<Track>& tracks) {
    std::vector<render::Panel> panels;
    for (const Track& track : tracks) {
        panels.push_back(track.panel);
    }
    return panels;
}

} // namespace

void add_side_by_side_options(CLI::App& verb, SideBySideOptions& options) {
    verb.add_option("RUN", options.inputs, "Two to four films, or folders of runs")
        ->required()
        ->type_name("");
    verb.add_option("-o,--output", options.film, "The film that is written")
        ->required()
        ->type_name("FILE.mp4");
    verb.add_option("--label", options.labels, "Text above a film: given once for each, in their order")
        ->type_name("TEXT")
        ->allow_extra_args(false);
    verb.add_flag("--quiet", options.is_quiet, "Only errors are printed");
}

void write_films_side_by_side(const SideBySideOptions& options) {
    const std::size_t count = options.inputs.size();
    if (count < 2 || count > most_films) {
        throw Error(ExitCode::usage,
                    fmt::format("side-by-side: {} films are given, expected 2 to {}", count, most_films));
    }
    if (!options.labels.empty() && options.labels.size() != count) {
        throw Error(ExitCode::usage,
                    fmt::format("--label is given {} times, expected one for each of {} films",
                                options.labels.size(), count));
    }
    if (fs::path(options.film).extension() != ".mp4") {
        throw Error(ExitCode::usage,
                    fmt::format("--output '{}': expected a name that ends in .mp4", options.film));
    }
    require_no_file_of_run(options.film);
    std::vector<Track> tracks = open_tracks(options);
    double fps = 0.0;
    for (const Track& track : tracks) {
        fps = std::max(fps, track.fps());
    }
    render::Font font;
    render::PanelSize size = panel_size(tracks);
    size.label_height = label_height(panels_of(tracks), size.width, font);
    const render::PanelSize whole = arranged_size(size, count);
    render::VideoSettings settings;
    settings.fps = rate_of(fps);
    std::int64_t frame = 0;
    {
        render::VideoWriter video(options.film, whole.width, whole.height, settings);
        for (;; ++frame) {
            if (is_interrupted()) {
                throw Error(ExitCode::interrupted, "interrupted; no film was made");
            }
            for (Track& track : tracks) {
                track.go_to(static_cast<double>(frame) / settings.fps.value());
            }
            if (std::ranges::all_of(tracks, &Track::is_over)) {
                break;
            }
            video.add(arranged(panels_of(tracks), size, font));
        }
        video.finish();
    }
    if (!options.is_quiet) {
        fmt::print("{}: {} frames of {} films\n", options.film, frame, count);
    }
}

} // namespace cmd
