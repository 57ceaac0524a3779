#pragma once
/// What a baseline says of itself: baseline.json beside its pictures.
#include "render/compare/judge.h"
#include "render/compare/result.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cmd {

/// How the pictures of a baseline are made and compared, and what made them.
struct BaselineRecord {
    diff::Origin origin;
    std::string scene_file; ///< relative to the folder of all baselines; empty in those of earlier versions
    std::string scene_text; ///< the scene file as read
    std::vector<std::string> overrides; ///< "dotted.key=value"
    std::vector<std::int64_t> frames;   ///< ascending; empty: start, quarters and end of the film
    bool has_body_ids = true;
    std::map<std::string, double> limits; ///< by gate; a gate that is not there has its default
    std::vector<std::string> masks;       ///< "X,Y,WIDTH,HEIGHT", or the name of a picture in the baseline's folder
    std::vector<std::string> ignored_bodies;
    std::map<std::string, std::string> pictures; ///< SHA-256 by file
};

/// What a call of `baseline update` changes of it.
struct BaselineChanges {
    std::string size{};                     ///< "WxH" [px]
    std::vector<std::string> assignments{}; ///< "dotted.key=value"
    std::vector<std::string> unset{};       ///< keys that go back to the scene's value; mask, limits, ignore-body
    std::string frames{};                   ///< "0,5,10", or "default"
    std::optional<bool> has_body_ids{};
    std::vector<std::string> masks{};
    std::vector<std::string> ignored_bodies{};
    std::string limits{}; ///< file
};

/// None if the folder has none. Throws Error (io) if it is damaged.
std::optional<BaselineRecord> read_baseline_record(const std::filesystem::path& folder);
/// Throws Error (io).
void write_baseline_record(const std::filesystem::path& folder, const BaselineRecord& record);

/// Applies the changes: a later value of a key replaces an earlier one, all else stays. Throws Error (usage, io).
void change_record(const BaselineChanges& changes, BaselineRecord& record);

/// A line for each setting that differs: "output.width: 640 -> 320".
std::vector<std::string> record_changes(const BaselineRecord& before, const BaselineRecord& now);

/// The gates' limits of a record. level: the limit of gate `levels` where the record does not set one.
diff::Limits limits_of(const BaselineRecord& record, double level, const std::filesystem::path& folder);

} // namespace cmd
