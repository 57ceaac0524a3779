#include "render/cmd/run_record.h"

#include "render/gl/context.h"
#include "render/gl/shader.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/difference.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdlib>
#include <regex>
#include <unistd.h>

namespace cmd {

namespace fs = std::filesystem;

namespace {

std::string node_name() {
    if (const char* name = std::getenv("SLURMD_NODENAME")) {
        return name;
    }
    std::array<char, 256> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

RunRecord record_of(const sim::SceneDef& scene) {
    return {"tumble " TUMBLE_VERSION,
            render::renderer_string(scene.output.gl),
            render::processor_class(),
            node_name(),
            render::shaders_hash(),
            scene.name,
            scene.text,
            scene.overrides,
            render::shader_hashes()};
}

/// "llvmpipe (LLVM 15.0.6, 256 bits)": pictures do not depend on the width of its vectors.
std::string without_width(const std::string& renderer) {
    return std::regex_replace(renderer, std::regex(", [0-9]+ bits"), "");
}

/// Throws Error (io).
void write_run_record(const fs::path& folder, const RunRecord& record) {
    const nlohmann::ordered_json json = {{"program", record.program},      {"renderer", record.renderer},
                                         {"processor", record.processor},  {"node", record.node},
                                         {"shaders_hash", record.shaders}, {"scene_name", record.scene_name},
                                         {"overrides", record.overrides}, {"shaders", record.shader_files},
                                         {"scene_text", record.scene_text}};
    // Bytes that are no UTF-8 (a file name) are replaced: dump() would throw.
    sim::write_file(folder / run_record_name,
                    json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

} // namespace

std::string record_difference(const RunRecord& now, const RunRecord& before) {
    if (now.program != before.program) {
        return fmt::format("this is {}, it was {}", now.program, before.program);
    }
    if (without_width(now.renderer) != without_width(before.renderer)) {
        return fmt::format("this renderer is {}, it was {}", now.renderer, before.renderer);
    }
    if (now.shaders != before.shaders) {
        return fmt::format("the shaders have the hash {}, they had {}", now.shaders, before.shaders);
    }
    if (now.processor != before.processor) {
        return fmt::format("the processor of {} is {}, of {} it was {}; with --portable both draw the same, and "
                           "--slurm --constraint=... keeps to nodes of one kind",
                           now.node, now.processor, before.node, before.processor);
    }
    return sim::scene_difference({now.scene_text, now.overrides}, {before.scene_text, before.overrides});
}

std::optional<RunRecord> read_run_record(const fs::path& folder) {
    const fs::path path = folder / run_record_name;
    std::error_code error;
    if (!fs::exists(path, error)) {
        return std::nullopt;
    }
    const std::string text = sim::read_text_file(path);
    try {
        const nlohmann::json json = nlohmann::json::parse(text);
        RunRecord record{json.at("program"),      json.at("renderer"),   json.at("processor"),
                         json.value("node", "another machine"),
                         json.at("shaders_hash"), json.at("scene_name"), json.at("scene_text"),
                         json.at("overrides")};
        if (sim::is_file_name(record.scene_name)) {
            return record;
        }
    } catch (const nlohmann::json::exception&) {
        // Said below.
    }
    throw sim::Error(sim::ExitCode::io, fmt::format("cannot read {}: it is damaged", path.string()));
}

void add_pictures(const sim::SceneDef& scene, const render::Film& film, sim::Summary& summary) {
    const auto count = static_cast<double>(sim::frame_count(scene.output.duration, scene.output.fps));
    const render::FilmTimes& times = film.times();
    summary.shaders_hash = render::shaders_hash();
    summary.renderer = film.renderer_string();
    summary.processor = render::processor_class();
    summary.picture_ms = {{"list", times.list / count},
                          {"draw", times.draw / count},
                          {"edges", times.edges / count},
                          {"png", times.png / count},
                          {"video", times.video / count}};
    const std::vector<sim::WrittenFile> files = film.files();
    summary.files.insert(summary.files.end(), files.begin(), files.end());
}

void remove_pictures(const Workplace& workplace) {
    workplace.remove_file(run_record_name);
    workplace.remove_frames();
}

void prepare_frames(const Workplace& workplace, sim::SceneDef& scene, bool keeps,
                    const std::function<void()>& forget) {
    const fs::path& folder = workplace.folder();
    const RunRecord now = record_of(scene);
    if (!keeps) {
        forget();
        remove_pictures(workplace);
    }
    workplace.make_frames_folder();
    // Of several slices that start at once, one writes the record.
    const FolderLock lock(folder / "frames", FolderLock::Kind::alone, true);
    const std::optional<RunRecord> before = read_run_record(folder);
    if (!before && workplace.has_frames()) {
        throw sim::Error(
            sim::ExitCode::usage,
            fmt::format("the frames in {} are of an unknown run; remove them, or run without --resume "
                        "and --frames",
                        folder.string()));
    }
    if (!before) {
        if (keeps) {
            forget();
        }
        write_run_record(folder, now);
        return;
    }
    const std::string difference = record_difference(now, *before);
    if (!difference.empty()) {
        throw sim::Error(
            sim::ExitCode::usage,
            fmt::format("cannot go on in {}: {}; run without --resume and --frames to start again",
                        folder.string(), difference));
    }
    scene.overrides = before->overrides;
}

} // namespace cmd
