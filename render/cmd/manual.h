#pragma once
/// The program's verbs and options for other readers than --help: a man page, the shell's completion.
#include <string>

namespace CLI {
class App;
}

namespace cmd {

/// tumble.1, in the macros of man(7), of all verbs and options.
std::string man_page(const CLI::App& app);

/// Words that bash offers after `tumble` and after each verb; file names elsewhere.
std::string bash_completion(const CLI::App& app);

} // namespace cmd
