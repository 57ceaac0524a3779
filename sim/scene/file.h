#pragma once
/// TOML text -> SceneDef. Strict: what is not understood is an error with file:line:column and a suggestion.
#include "sim/model/scene_def.h"

#include <filesystem>
#include <span>
#include <string>

namespace sim {

/// "scenes/funnel.toml" -> "funnel": the name of folders and files too. Throws Error (usage) for one that cannot be.
std::string scene_name_of(const std::string& file);

/// Reads a scene file. overrides: "dotted.key=value" in TOML syntax, applied before validation.
/// Throws Error: io if the file cannot be read, usage for what its content has wrong.
SceneDef load_scene(const std::filesystem::path& path, std::span<const std::string> overrides = {});

/// The same from text; `file` is the name shown in messages, from which the scene has its name.
SceneDef parse_scene(const std::string& text, const std::string& file,
                     std::span<const std::string> overrides = {});

/// What is wrong with a word for output.gl, "'elg': expected auto, ..."; empty if nothing is.
std::string gl_word_fault(const std::string& word);

/// The reference of all scene keys (key, type, unit, default, meaning) as Markdown, from the parser's own table.
std::string scene_key_reference();

} // namespace sim
