/// The program `tumble`: compares pictures itself, in milliseconds. Whatever draws, simulates or reads films is in
/// the program tumble-draw beside it, whose libraries take longer to load; that takes this one's place.
#include "render/cmd/compare.h"
#include "render/cmd/guard.h"
#include "render/cmd/interrupt.h"
#include "sim/base/error.h"

#include <CLI/CLI.hpp>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

namespace {

// Beside this one where they are built; where they are installed, among programs that no user calls.
constexpr const char* drawing_program = "tumble-draw";
constexpr const char* installed_folder = "libexec/tumble";

// Measured: 26 MB for its libraries, and a margin to say what is missing.
constexpr rlim_t library_bytes = rlim_t{48} << 20;

/// Does not return. Throws Error (io).
[[noreturn]] void start_drawing_program(char** argv) {
    std::error_code error;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
    std::filesystem::path path = self.parent_path() / drawing_program; // its name alone where /proc is missing
    if (!std::filesystem::exists(path, error)) {
        path = self.parent_path().parent_path() / installed_folder / drawing_program;
    }
    rlimit addresses{};
    if (::getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur < library_bytes) {
        throw sim::Error(sim::ExitCode::stopped,
                         "out of memory: the limit (ulimit -v) is " + std::to_string(addresses.rlim_cur >> 20) +
                             " MB, loading the libraries takes " + std::to_string(library_bytes >> 20) + " MB");
    }
    if (cmd::is_interrupted()) {
        throw sim::Error(sim::ExitCode::interrupted, "interrupted");
    }
    ::execvp(path.c_str(), argv);
    throw sim::Error(sim::ExitCode::io, "cannot start " + path.string() + ": " + std::strerror(errno));
}

int start(int argc, char** argv) {
    if (argc < 2 || std::strcmp(argv[1], "compare") != 0) {
        start_drawing_program(argv);
    }
    CLI::App app("", "tumble");
    cmd::CompareOptions options;
    cmd::add_compare_options(*app.add_subcommand("compare"), options);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError&) {
        start_drawing_program(argv); // prints the help, or what is wrong
    }
    if (cmd::needs_films(options)) {
        start_drawing_program(argv);
    }
    return cmd::compare(options, cmd::command_line(argc, argv), nullptr);
}

} // namespace

int main(int argc, char** argv) {
    return cmd::guarded([&] { return start(argc, argv); });
}
