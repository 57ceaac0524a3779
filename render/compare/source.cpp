#include "render/compare/source.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string_view>

namespace diff {

namespace fs = std::filesystem;

namespace {

/// Files of a folder whose names end in one of these, in any case.
bool is_picture_name(const fs::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

/// A JSON file of a run; null if there is none or it is no JSON.
nlohmann::json read_json(const fs::path& path) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) {
        return nullptr;
    }
    return nlohmann::json::parse(sim::read_text_file(path), nullptr, false);
}

std::string text_of(const nlohmann::json& json, const char* key) {
    const auto found = json.is_object() ? json.find(key) : json.end();
    return json.is_object() && found != json.end() && found->is_string() ? found->get<std::string>()
                                                                         : std::string();
}

/// What a run's files say of it.
void read_origin(const fs::path& folder, Source& source) {
    const nlohmann::json run = read_json(folder / "frames" / "run.json");
    const nlohmann::json summary = read_json(folder / "summary.json");
    Origin& origin = source.origin;
    origin.program = text_of(run, "program");
    origin.scene = text_of(run, "scene_name");
    origin.state_hash = text_of(summary, "state_hash");
    for (const nlohmann::json* json : {&summary, &run}) {
        if (origin.shaders_hash.empty()) {
            origin.shaders_hash = text_of(*json, "shaders_hash");
            origin.renderer = text_of(*json, "renderer");
        }
    }
    source.scene_text = text_of(run, "scene_text");
    try {
        source.overrides = run.is_object() ? run.value("overrides", source.overrides) : source.overrides;
        origin.processor = text_of(run, "processor");
        origin.shaders = run.is_object() ? run.value("shaders", origin.shaders) : origin.shaders;
    } catch (const nlohmann::json::exception&) {
        // Of another form: the cause stays unknown.
    }
}

/// "the drawing changed: other shaders: common_light.glsl"
std::string drawing_text(const Origin& a, const Origin& b) {
    std::string files;
    for (const auto& [name, hash] : b.shaders) {
        const auto before = a.shaders.find(name);
        if (!a.shaders.empty() && (before == a.shaders.end() || before->second != hash)) {
            files += (files.empty() ? " " : ", ") + name;
        }
    }
    for (const auto& [name, hash] : a.shaders) {
        if (!b.shaders.empty() && !b.shaders.contains(name)) {
            files += (files.empty() ? " " : ", ") + name + " (gone)";
        }
    }
    if (a.shaders_hash != b.shaders_hash) {
        return "the drawing changed: same states, other shaders" + (files.empty() ? files : ":" + files);
    }
    return fmt::format("the program changed: same states and shaders, {} instead of {}", b.program, a.program);
}

} // namespace

bool is_film(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    std::array<char, 12> start{};
    in.read(start.data(), start.size());
    const std::string_view text(start.data(), static_cast<std::size_t>(in.gcount()));
    return text.size() == start.size() &&
           (text.substr(4, 4) == "ftyp" || text.substr(0, 4) == "\x1a\x45\xdf\xa3" ||
            (text.substr(0, 4) == "RIFF" && text.substr(8, 4) == "AVI "));
}

std::vector<std::string> picture_names(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        if (is_picture_name(entry.path()) && !entry.path().stem().string().ends_with(".bodies")) {
            names.push_back(entry.path().filename().string());
        }
    }
    if (error) {
        throw sim::Error(sim::ExitCode::io, "cannot read " + folder.string() + ": " + error.message());
    }
    std::sort(names.begin(), names.end());
    return names;
}

std::optional<fs::path> film_in(const fs::path& folder) {
    std::error_code error;
    std::optional<fs::path> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        if (entry.is_regular_file(error) && is_film(entry.path())) {
            if (found) {
                return std::nullopt;
            }
            found = entry.path();
        }
    }
    return found;
}

Source find_source(const fs::path& path) {
    Source source;
    source.path = path;
    std::error_code error;
    if (!fs::exists(path, error)) {
        return source;
    }
    if (!fs::is_directory(path, error)) {
        source.kind = is_film(path) ? SourceKind::film : SourceKind::picture;
        return source;
    }
    source.kind = SourceKind::frames;
    const bool is_run = fs::is_directory(path / "frames", error);
    if (is_run) {
        source.path = path / "frames";
    }
    read_origin(path.filename() == "frames" ? path.parent_path() : path, source);
    source.names = picture_names(source.path);
    if (source.names.empty()) {
        const std::optional<fs::path> film = film_in(path);
        if (!film) {
            throw sim::Error(sim::ExitCode::io,
                             path.string() + " has no pictures (PNG, JPEG) and not exactly one film");
        }
        source.kind = SourceKind::film;
        source.path = *film;
    }
    return source;
}

void find_cause(const Source& reference, const Source& candidate, Case& result) {
    const Origin& a = reference.origin;
    const Origin& b = candidate.origin;
    const auto both_differ = [](const std::string& x, const std::string& y) {
        return !x.empty() && !y.empty() && x != y;
    };
    const bool have_scenes = !reference.scene_text.empty() && !candidate.scene_text.empty();
    if (have_scenes &&
        (reference.scene_text != candidate.scene_text || reference.overrides != candidate.overrides)) {
        result.cause = Cause::scene;
        result.cause_text = "the two were made from other scenes or settings";
    } else if (both_differ(a.state_hash, b.state_hash)) {
        result.cause = Cause::simulation;
        result.cause_text = fmt::format("the simulation changed: the last state is {}, it was {}",
                                        b.state_hash, a.state_hash);
    } else if (both_differ(a.shaders_hash, b.shaders_hash) || both_differ(a.program, b.program)) {
        result.cause = Cause::drawing;
        result.cause_text = drawing_text(a, b);
    } else if (both_differ(a.renderer, b.renderer)) {
        result.cause = Cause::machine;
        result.cause_text = fmt::format("another machine: same states and shaders, drawn by {}, before by {}",
                                        b.renderer, a.renderer);
    }
    if (result.tier == Tier::identical) {
        const bool is_told = result.cause == Cause::scene || result.cause == Cause::simulation;
        result.cause_text = is_told ? "equal pixels, but " + result.cause_text : std::string();
        result.cause = is_told ? result.cause : Cause::unknown;
    }
}

} // namespace diff
