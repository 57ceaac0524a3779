#include "render/cmd/baseline_record.h"

#include "render/cmd/options.h"
#include "render/compare/limits_file.h"
#include "render/compare/mask.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/tree.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

constexpr const char* record_name = "baseline.json";

bool is_ascending(const std::vector<std::int64_t>& frames) {
    return (frames.empty() || frames.front() >= 0) &&
           std::adjacent_find(frames.begin(), frames.end(), std::greater_equal<>()) == frames.end();
}

/// "0,5,10": ascending; "default": none. Throws Error (usage).
std::vector<std::int64_t> parse_frames(const std::string& text) {
    std::vector<std::int64_t> frames;
    if (text == "default") {
        return frames;
    }
    const char* at = text.data();
    const char* end = at + text.size();
    while (true) {
        std::int64_t frame = 0;
        const auto [next, error] = std::from_chars(at, end, frame);
        frames.push_back(frame);
        if (error != std::errc() || !is_ascending(frames) || (next != end && *next != ',')) {
            throw Error(ExitCode::usage,
                        fmt::format("--frames '{}': expected ascending numbers such as 0,5,10, or default", text));
        }
        if (next == end) {
            return frames;
        }
        at = next + 1;
    }
}

/// What stands before '=', without spaces.
std::string key_of(const std::string& assignment) {
    std::string key = assignment.substr(0, assignment.find('='));
    std::erase(key, ' ');
    return key;
}

std::string value_of(const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    return equals == std::string::npos ? std::string() : assignment.substr(equals + 1);
}

void assign(const std::string& assignment, std::vector<std::string>& overrides) {
    std::erase_if(overrides, [&](const std::string& old) { return key_of(old) == key_of(assignment); });
    overrides.push_back(assignment);
}

void unset(const std::string& word, BaselineRecord& record) {
    std::vector<std::string> known;
    const auto clear = [&](const char* name, auto& list) {
        if (!list.empty()) {
            known.emplace_back(name);
        }
        if (word == name && !list.empty()) {
            list.clear();
            return true;
        }
        return false;
    };
    if (clear("mask", record.masks) || clear("limits", record.limits) ||
        clear("ignore-body", record.ignored_bodies)) {
        return;
    }
    for (const std::string& assignment : record.overrides) {
        known.push_back(key_of(assignment));
    }
    if (std::erase_if(record.overrides, [&](const std::string& old) { return key_of(old) == word; }) == 0) {
        throw Error(ExitCode::usage, fmt::format("--unset '{}': the baseline does not set it{}", word,
                                                 sim::suggestion(word, known)));
    }
}

template <typename Map>
std::string text_of(const Map& map) {
    std::vector<std::string> parts;
    for (const auto& [key, value] : map) {
        parts.push_back(fmt::format("{} {:.4g}", key, value));
    }
    return fmt::format("{}", fmt::join(parts, ", "));
}

} // namespace

std::optional<BaselineRecord> read_baseline_record(const fs::path& folder) {
    const fs::path path = folder / record_name;
    std::error_code error;
    if (!fs::exists(path, error)) {
        return std::nullopt;
    }
    const std::string text = sim::read_text_file(path);
    const auto fail = [&](const char* what) {
        return Error(ExitCode::io, fmt::format("cannot read {}: {}", path.string(), what));
    };
    try {
        const nlohmann::json json = nlohmann::json::parse(text);
        BaselineRecord record;
        record.origin = {json.at("program"),       json.at("scene_name"), json.at("state_hash"),
                         json.at("shaders_hash"),  json.at("renderer"),   json.value("processor", ""),
                         json.value("shaders", std::map<std::string, std::string>{})};
        record.scene_file = json.value("scene_file", "");
        json.at("scene_text").get_to(record.scene_text);
        json.at("overrides").get_to(record.overrides);
        json.at("frames").get_to(record.frames);
        json.at("has_body_ids").get_to(record.has_body_ids);
        record.limits = json.value("limits", record.limits);
        record.masks = json.value("masks", record.masks);
        record.ignored_bodies = json.value("ignored_bodies", record.ignored_bodies);
        record.pictures = json.value("pictures", record.pictures);
        if (!is_ascending(record.frames)) {
            throw fail("its frames are not ascending numbers >= 0");
        }
        return record;
    } catch (const nlohmann::json::exception&) {
        throw fail("it is damaged");
    }
}

void write_baseline_record(const fs::path& folder, const BaselineRecord& record) {
    const diff::Origin& origin = record.origin;
    const nlohmann::ordered_json json = {
        {"program", origin.program},           {"scene_name", origin.scene},
        {"scene_file", record.scene_file},     {"state_hash", origin.state_hash},
        {"shaders_hash", origin.shaders_hash}, {"renderer", origin.renderer},
        {"processor", origin.processor},       {"frames", record.frames},
        {"has_body_ids", record.has_body_ids}, {"overrides", record.overrides},
        {"limits", record.limits},             {"masks", record.masks},
        {"ignored_bodies", record.ignored_bodies}, {"shaders", origin.shaders},
        {"pictures", record.pictures},         {"scene_text", record.scene_text}};
    sim::write_file(folder / record_name,
                    json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

void change_record(const BaselineChanges& changes, BaselineRecord& record) {
    for (const std::string& word : changes.unset) {
        unset(word, record);
    }
    Options options;
    options.size = changes.size;
    options.assignments = changes.assignments;
    for (const std::string& assignment : overrides_of(options)) {
        assign(assignment, record.overrides);
    }
    if (!changes.frames.empty()) {
        record.frames = parse_frames(changes.frames);
    }
    record.has_body_ids = changes.has_body_ids.value_or(record.has_body_ids);
    record.masks.insert(record.masks.end(), changes.masks.begin(), changes.masks.end());
    record.ignored_bodies.insert(record.ignored_bodies.end(), changes.ignored_bodies.begin(),
                                 changes.ignored_bodies.end());
    if (!changes.limits.empty()) {
        record.limits.clear();
        const diff::Limits limits = diff::read_limits(changes.limits);
        for (std::size_t i = 0; i < diff::gate_count; ++i) {
            const auto id = static_cast<diff::GateId>(i);
            if (limits[id].source != diff::Limit().source) {
                record.limits[diff::name_of(id)] = limits[id].value;
            }
        }
    }
}

std::vector<std::string> record_changes(const BaselineRecord& before, const BaselineRecord& now) {
    std::map<std::string, std::pair<std::string, std::string>> values;
    const auto collect = [&](const BaselineRecord& record, std::string std::pair<std::string, std::string>::*side) {
        for (const std::string& assignment : record.overrides) {
            values[key_of(assignment)].*side = value_of(assignment);
        }
        values["frames"].*side =
            record.frames.empty() ? "start, quarters, end" : fmt::format("{}", fmt::join(record.frames, ","));
        values["body ids"].*side = record.has_body_ids ? "yes" : "no";
        values["masks"].*side = fmt::format("{}", fmt::join(record.masks, " "));
        values["ignored bodies"].*side = fmt::format("{}", fmt::join(record.ignored_bodies, " "));
        values["limits"].*side = text_of(record.limits);
    };
    collect(before, &std::pair<std::string, std::string>::first);
    collect(now, &std::pair<std::string, std::string>::second);
    std::vector<std::string> lines;
    for (const auto& [key, pair] : values) {
        const auto shown = [](const std::string& value) { return value.empty() ? "not set" : value; };
        if (pair.first != pair.second) {
            lines.push_back(fmt::format("{}: {} -> {}", key, shown(pair.first), shown(pair.second)));
        }
    }
    return lines;
}

diff::Limits limits_of(const BaselineRecord& record, double level, const fs::path& folder) {
    diff::Limits limits;
    const std::string source = (folder / record_name).string();
    limits.of[static_cast<std::size_t>(diff::GateId::levels)] = {level, "what made the two"};
    for (std::size_t i = 0; i < diff::gate_count; ++i) {
        const auto found = record.limits.find(diff::name_of(static_cast<diff::GateId>(i)));
        if (found != record.limits.end()) {
            limits.of[i] = {found->second, source};
        }
    }
    return limits;
}

} // namespace cmd
