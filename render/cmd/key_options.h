#pragma once
/// Options that set a key of the scene by a shorter name: one table of what --help says, the key and its value in TOML.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace cmd {

struct Options;
enum class Changes;

/// Adds to a verb those that it has a use for. `options` must outlive the parsing.
void add_key_options(CLI::App& verb, Options& options, Changes changes);

/// Assignments "dotted.key=value" of those that were given. Throws Error (usage).
std::vector<std::string> key_overrides(const Options& options);

/// A message about one of these assignments, "--set output.width=0: ...", as the user typed it: "--size 0x36: ...".
/// Any other message stays as it is. Throws Error (usage) as key_overrides() does.
std::string as_typed(const std::string& message, const Options& options);

/// The whole text as an integer.
std::optional<long> parse_integer(std::string_view text);

} // namespace cmd
