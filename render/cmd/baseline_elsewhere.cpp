#include "render/cmd/baseline_elsewhere.h"

#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

/// The least time if the file is not there.
fs::file_time_type time_of(const fs::path& path) {
    std::error_code error;
    const fs::file_time_type time = fs::last_write_time(path, error);
    return error ? fs::file_time_type::min() : time;
}

fs::path record_path(const fs::path& folder) {
    return folder / "baseline.json";
}

fs::path failure_path(const fs::path& drawn) {
    return drawn / "failure.json";
}

bool is_drawn(const fs::path& report, const BaselinePlace& place) {
    const fs::path drawn = drawn_folder(report, place);
    const auto time = std::max(time_of(record_path(drawn / "frames")), time_of(failure_path(drawn)));
    return time > std::max({time_of(report / "result.json"), time_of(place.scene_file),
                            time_of(record_path(place.folder)), time_of("/proc/self/exe")});
}

std::string part_command(const BaselineOptions& options, const fs::path& report, std::size_t count) {
    std::string command = program_word() + " baseline check";
    for (const std::string& scene : options.scenes) {
        command += " " + shell_word(scene);
    }
    command += " --baselines " + shell_word(options.folder) + " --report " + shell_word(report.string());
    command += options.name.empty() ? "" : " --name " + shell_word(options.name);
    command += options.gl.empty() ? "" : " --gl " + shell_word(options.gl);
    return command + fmt::format(" --part \"$n/{}\" --jobs \"$cores\" --quiet", count);
}

} // namespace

fs::path drawn_folder(const fs::path& report, const BaselinePlace& place) {
    return report / "candidates" / place.scene / place.name;
}

bool draw_elsewhere(const BaselineOptions& options, const fs::path& report,
                    const std::vector<BaselinePlace>& places) {
    const std::size_t count = std::min(places.size(), most_tasks);
    BatchStage stage{
        .name = "draw", .commands = part_command(options, report, count), .count = static_cast<int>(count)};
    for (std::size_t n = 0; n < count; ++n) {
        for (std::size_t i = n; i < places.size(); i += count) {
            if (!is_drawn(report, places[i])) {
                stage.missing.push_back(static_cast<int>(n));
                break;
            }
        }
    }
    const auto done = [&] {
        return std::count_if(places.begin(), places.end(),
                             [&](const BaselinePlace& place) { return is_drawn(report, place); });
    };
    return run_batches({{.name = "baselines", .folder = report, .stages = {stage}}}, options.placement,
                       {.unit = "baselines",
                        .total = static_cast<std::int64_t>(places.size()),
                        .done = done,
                        .progress = options.is_quiet || options.prints_json ? ProgressStyle::quiet
                                                                         : ProgressStyle::text});
}

void begin_drawing(const fs::path& drawn) {
    std::error_code error;
    fs::remove(record_path(drawn / "frames"), error);
    fs::remove(failure_path(drawn), error);
    fs::create_directories(drawn, error);
    if (error) {
        throw Error(ExitCode::io,
                    fmt::format("cannot make the folder {}: {}", drawn.string(), error.message()));
    }
}

void keep_failure(const fs::path& drawn, const Error& error) {
    const nlohmann::json json = {{"code", static_cast<int>(error.code())}, {"message", error.what()}};
    sim::write_file(failure_path(drawn),
                    json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void throw_failure(const fs::path& drawn) {
    const fs::path path = failure_path(drawn);
    if (!fs::exists(path)) {
        return;
    }
    const nlohmann::json json = nlohmann::json::parse(sim::read_text_file(path), nullptr, false);
    if (!json.is_object() || !json.contains("code") || !json.contains("message")) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: it is damaged", path.string()));
    }
    throw Error(static_cast<ExitCode>(json["code"].get<int>()), json["message"].get<std::string>());
}

} // namespace cmd
