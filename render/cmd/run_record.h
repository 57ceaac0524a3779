#pragma once
/// What a folder's frames were made from: frames/run.json, written before the first of them.
#include "render/cmd/workplace.h"
#include "render/film/film.h"
#include "sim/model/scene_def.h"
#include "sim/record/summary.h"

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace cmd {

inline constexpr const char* run_record_name = "frames/run.json";

struct RunRecord {
    std::string program;   ///< "tumble 0.1.0"
    std::string renderer;  ///< OpenGL's name and version
    std::string processor; ///< what else the pictures' bytes depend on
    std::string node;      ///< name of the machine
    std::string shaders;   ///< hash of their texts
    std::string scene_name;
    std::string scene_text;             ///< the scene file as read
    std::vector<std::string> overrides; ///< "dotted.key=value", in the order applied
    std::map<std::string, std::string> shader_files{}; ///< hash of each
};

/// None if the folder has no record. Throws Error (io) if it cannot be read or is damaged.
std::optional<RunRecord> read_run_record(const std::filesystem::path& folder);

/// What keeps frames made from `before` from being used for `now`; empty if nothing does.
std::string record_difference(const RunRecord& now, const RunRecord& before);

/// Makes the folder ready for frames of the scene: those of another run are removed, unless `keeps` says that
/// they are to be used, and run.json is written. forget: called before frames of another run go, or the first of a run
/// come, to remove what does not belong to them. Throws Error: usage if frames are to be used that were made with other
/// settings, io. Where frames are kept, the scene's overrides become those that they were made with, which mean the same:
/// the film says how it was made.
void prepare_frames(const Workplace& workplace, sim::SceneDef& scene, bool keeps,
                    const std::function<void()>& forget);

/// Enters in a summary what the film has made, once its threads have ended.
void add_pictures(const sim::SceneDef& scene, const render::Film& film, sim::Summary& summary);

/// Removes frames and what they were made from. Throws Error (io).
void remove_pictures(const Workplace& workplace);

} // namespace cmd
