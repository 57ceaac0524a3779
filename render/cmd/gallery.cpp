/// tumble gallery: one page of all results in a folder, with posters and a manifest, ready to be published.
#include "render/cmd/options.h"
#include "render/cmd/workplace.h"
#include "render/compare/gallery_page.h"
#include "render/compare/report.h"
#include "render/film/film.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/model/film_clock.h"
#include "sim/record/trajectory.h"
#include "sim/scene/file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;
using Json = nlohmann::json;

namespace {

/// [px] Posters are reduced to at most this width.
constexpr int poster_width = 960;
/// Samples of a plot of the energy; more would be finer than a pixel.
constexpr std::size_t plot_samples = 600;

Json read_json(const fs::path& path) {
    Json json = Json::parse(sim::read_text_file(path), nullptr, false);
    if (json.is_discarded()) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: it is damaged", path.string()));
    }
    return json;
}

/// Names of the entries of a folder, sorted. Throws Error (io).
std::vector<std::string> names_in(const fs::path& folder) {
    std::error_code error;
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        names.push_back(entry.path().filename().string());
    }
    if (error) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: {}", folder.string(), error.message()));
    }
    std::sort(names.begin(), names.end());
    return names;
}

bool has_extension(const std::string& name, std::initializer_list<const char*> extensions) {
    const std::string extension = fs::path(name).extension().string();
    return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

/// Every block of factor x factor pixels becomes one, their mean.
render::Image reduced(const render::Image& image, int factor) {
    render::Image small(image.width / factor, image.height / factor);
    for (int y = 0; y < small.height; ++y) {
        for (int x = 0; x < small.width; ++x) {
            for (int channel = 0; channel < 3; ++channel) {
                int sum = 0;
                for (int k = 0; k < factor * factor; ++k) {
                    const std::size_t row = static_cast<std::size_t>(y) * factor + k / factor;
                    const std::size_t column = static_cast<std::size_t>(x) * factor + k % factor;
                    sum += image.rgb[(row * image.width + column) * 3 + channel];
                }
                small.rgb[(static_cast<std::size_t>(y) * small.width + x) * 3 + channel] =
                    static_cast<std::uint8_t>((sum + factor * factor / 2) / (factor * factor));
            }
        }
    }
    return small;
}

/// Writes poster.png from the frame in the middle of those that are there. False if there are none.
bool write_poster(const fs::path& run) {
    std::error_code error;
    std::vector<std::string> frames;
    if (fs::is_directory(run / "frames", error)) {
        frames = names_in(run / "frames");
        std::erase_if(frames, [](const std::string& name) { return !has_extension(name, {".png"}); });
    }
    if (frames.empty()) {
        return false;
    }
    const render::Image image = render::read_image(run / "frames" / frames[frames.size() / 2]);
    const int factor = std::max(1, std::min((image.width + poster_width - 1) / poster_width, image.height));
    sim::write_file(run / "poster.png", render::encode_png(reduced(image, factor)));
    return true;
}

std::vector<diff::EnergySample> energy_of(const fs::path& path) {
    const sim::TrajectoryReader trajectory(path);
    const sim::TrajectoryInfo& info = trajectory.info();
    const sim::SceneDef scene = sim::parse_scene(info.scene_text, info.scene_name + ".toml", info.overrides);
    sim::require_same_bodies(info, scene, path.string());
    std::vector<diff::EnergySample> samples;
    const std::size_t records = trajectory.steps().size();
    const std::size_t count = std::min(records, plot_samples);
    for (std::size_t i = 0; i < count; ++i) {
        const sim::Snapshot snapshot = trajectory.read(count < 2 ? 0 : i * (records - 1) / (count - 1));
        const sim::Mechanics mechanics = sim::mechanics(scene, snapshot);
        samples.push_back({snapshot.time, mechanics.kinetic_energy, mechanics.potential_energy});
    }
    return samples;
}

std::vector<std::pair<std::string, std::string>> facts_of(const Json& summary) {
    const Json& settings = summary.at("settings");
    const double simulated = summary.at("simulated_time_s");
    const double wall = summary.at("wall_time_s");
    const auto text = [](const Json& json) { return json.get<std::string>(); };
    const std::int64_t joints = summary.at("joints");
    return {
        {"bodies", fmt::format("{}{}", summary.at("bodies").get<std::int64_t>(),
                               joints > 0 ? fmt::format(", {} joints", joints) : "")},
        {"duration", fmt::format("{} s in {} steps of {} s", simulated,
                                 summary.at("steps").get<std::int64_t>(), text(settings.at("time_step")))},
        {"picture", fmt::format("{} x {}, {} frames a second", settings.at("width_px").get<int>(),
                                settings.at("height_px").get<int>(), text(settings.at("fps")))},
        {"largest overlap",
         fmt::format("{:.2g} m of {} m allowed", summary.at("max_penetration_m").get<double>(),
                     settings.at("tolerance_m").get<double>())},
        {"most contacts", fmt::format("{}", summary.at("max_contacts").get<std::int64_t>())},
        {"time taken",
         wall > 0 ? fmt::format("{:.1f} s, {:.2g} x real time", wall, simulated / wall) : "0 s"},
        {"state hash", text(summary.at("state_hash"))},
        {"made by", text(summary.at("program"))},
    };
}

/// [s] simulated, by tenths of a second of the run's film.
std::vector<double> film_times(const fs::path& path) {
    const sim::TrajectoryReader trajectory(path);
    const sim::TrajectoryInfo& info = trajectory.info();
    const sim::SceneDef scene = sim::parse_scene(info.scene_text, info.scene_name + ".toml", info.overrides);
    std::vector<double> times;
    const int count = static_cast<int>(std::ceil(10.0 * scene.output.duration.value()));
    for (int i = 0; i <= count; ++i) {
        times.push_back(sim::simulated_time(scene.output, 0.1 * i));
    }
    return times;
}

/// name: of the run's folder in `root`.
diff::GalleryRun run_of(const fs::path& root, const std::string& name) {
    const fs::path folder = root / name;
    diff::GalleryRun run;
    run.name = name;
    const Json summary = read_json(folder / "summary.json");
    try {
        run.title = summary.at("title");
        run.facts = facts_of(summary);
    } catch (const nlohmann::json::exception&) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: it is no summary of a run",
                                              (folder / "summary.json").string()));
    }
    if (write_poster(folder)) {
        run.poster = name + "/poster.png";
    }
    for (const std::string& file : names_in(folder)) {
        const std::string path = name + "/" + file;
        // Browsers play these.
        if (has_extension(file, {".mp4", ".webm"}) && (run.film.empty() || fs::path(file).stem() == name)) {
            run.film = path;
        }
        if (has_extension(file, {".svg", ".png", ".jpg", ".webp", ".gif"}) && file != "poster.png") {
            run.plots.push_back(path);
        }
        // One of an earlier simulation is no longer the film's.
        if (has_extension(file, {".glb"}) && fs::exists(folder / "trajectory.h5") &&
            fs::last_write_time(folder / file) >= fs::last_write_time(folder / "trajectory.h5")) {
            sim::write_file(folder / (file + ".js"),
                            diff::model_script(path, sim::read_text_file(folder / file)));
            run.model = path;
        }
        if (has_extension(file, {".mp4", ".webm", ".mov", ".mkv", ".glb", ".csv", ".json", ".h5"})) {
            run.files.push_back(path);
        }
    }
    if (fs::exists(folder / "trajectory.h5")) {
        run.energy = energy_of(folder / "trajectory.h5");
        run.times = run.model.empty() ? std::vector<double>{} : film_times(folder / "trajectory.h5");
    }
    return run;
}

diff::GalleryReport report_of(const fs::path& root, const std::string& name) {
    const fs::path path = root / name / "result.json";
    const Json result = read_json(path);
    try {
        return {name, name + "/index.html", static_cast<std::int64_t>(result.at("cases").size()),
                result.at("counts").at("failed")};
    } catch (const nlohmann::json::exception&) {
        throw Error(ExitCode::io,
                    fmt::format("cannot read {}: it is no result of a comparison", path.string()));
    }
}

bool is_study(const fs::path& folder) {
    return fs::exists(folder / "study.csv") && fs::exists(folder / "index.html");
}

/// name: of its folder in `root`.
diff::GalleryStudy study_of(const fs::path& root, const std::string& name) {
    return {name, name + "/index.html", fs::exists(root / name / "diagram.svg") ? name + "/diagram.svg" : ""};
}

/// Plots and tables of a folder that is no run: `prefix` is its name and "/", or empty for the root.
void add_measurements(const fs::path& root, const std::string& prefix, diff::Gallery& gallery) {
    for (const std::string& file : names_in(prefix.empty() ? root : root / prefix)) {
        if (has_extension(file, {".svg"})) {
            gallery.plots.push_back(prefix + file);
        } else if (has_extension(file, {".md", ".txt"})) {
            gallery.texts.emplace_back(prefix + file, sim::read_text_file(root / prefix / file));
        }
    }
}

diff::Gallery gallery_of(const fs::path& root) {
    diff::Gallery gallery;
    gallery.program = "tumble " TUMBLE_VERSION;
    add_measurements(root, "", gallery);
    for (const std::string& name : names_in(root)) {
        const fs::path folder = root / name;
        if (!fs::is_directory(folder)) {
            continue;
        }
        if (fs::exists(folder / "summary.json")) {
            gallery.runs.push_back(run_of(root, name));
        } else if (fs::exists(folder / "result.json") && fs::exists(folder / "index.html")) {
            gallery.reports.push_back(report_of(root, name));
        } else if (is_study(folder)) {
            gallery.studies.push_back(study_of(root, name));
        } else {
            add_measurements(root, name + "/", gallery);
            for (const std::string& inner : names_in(folder)) { // out/study/SCENE
                if (is_study(folder / inner)) {
                    gallery.studies.push_back(study_of(root, name + "/" + inner));
                }
            }
        }
    }
    return gallery;
}

/// Every file that the page links, and the page.
std::set<std::string> files_of(const diff::Gallery& gallery) {
    std::set<std::string> files{"index.html"};
    for (const diff::GalleryRun& run : gallery.runs) {
        files.insert({run.film, run.poster});
        files.insert(run.plots.begin(), run.plots.end());
        files.insert(run.files.begin(), run.files.end());
        files.insert(run.model.empty() ? "" : run.model + ".js");
    }
    for (const diff::GalleryReport& report : gallery.reports) {
        files.insert(report.page);
    }
    for (const diff::GalleryStudy& study : gallery.studies) {
        files.insert({study.page, study.diagram});
    }
    files.insert(gallery.plots.begin(), gallery.plots.end());
    for (const auto& [path, text] : gallery.texts) {
        files.insert(path);
    }
    files.erase("");
    return files;
}

/// Summaries of the runs, by the names of their folders. Throws Error (io) if another verb works in one of them.
std::map<std::string, std::string> summaries_in(const fs::path& root) {
    std::map<std::string, std::string> summaries;
    for (const std::string& name : names_in(root)) {
        if (fs::exists(root / name / "summary.json")) {
            const FolderLock idle(root / name, FolderLock::Kind::shared, false);
            summaries[name] = sim::read_text_file(root / name / "summary.json");
        }
    }
    return summaries;
}

/// A verb tells the gallery before it changes a run: what it told before the manifest was written is told again.
void require_unchanged(const fs::path& root, const std::map<std::string, std::string>& before) {
    try {
        if (summaries_in(root) != before) {
            throw Error(ExitCode::io, fmt::format("runs in {} were changed meanwhile: make the gallery again", root.string()));
        }
    } catch (const Error&) {
        for (const auto& [name, summary] : before) {
            diff::forget_in_gallery(root / name);
        }
        throw;
    }
}

} // namespace

void write_gallery(const Options& options) {
    const fs::path root = options.out;
    const std::map<std::string, std::string> before = summaries_in(root);
    const diff::Gallery gallery = gallery_of(root);
    if (gallery.runs.empty() && gallery.reports.empty() && gallery.studies.empty()) {
        throw Error(ExitCode::io,
                    fmt::format("{} has no run, no report and no study: no folder in it has a summary.json, a "
                                "result.json or a study.csv",
                                root.string()));
    }
    sim::write_file(root / "index.html", diff::gallery_page(gallery));
    const std::set<std::string> files = files_of(gallery);
    diff::write_manifest(root, diff::gallery_kind, {files.begin(), files.end()});
    require_unchanged(root, before);
    if (!options.is_quiet) {
        std::printf("runs: %zu, reports: %zu; in %s\n", gallery.runs.size(), gallery.reports.size(),
                    (root / "index.html").c_str());
    }
}

} // namespace cmd
