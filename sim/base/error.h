#pragma once
/// The one exception of the project, its exit codes, and the check for programming errors.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace sim {

/// Exit codes of the program `tumble`, everywhere.
enum class ExitCode : int {
    good = 0,               ///< of an Error: there is nothing more to do
    changed = 1,            ///< a comparison is above its limit
    usage = 2,              ///< arguments, or the content of a scene
    io = 3,                 ///< reading or writing a file
    missing_or_size = 4,    ///< picture sizes differ, or a reference is missing
    stopped = 5,            ///< the simulation stopped
    interrupted = 130,
};

/// What the user or the machine got wrong. Thrown where it is detected, caught once, in main.
class Error : public std::runtime_error {
public:
    /// message: one sentence, with file, line and column where there are any.
    Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    ExitCode code() const noexcept { return code_; }

private:
    ExitCode code_;
};

[[noreturn]] inline void check_failed(const char* condition, const char* file, int line) {
    std::fprintf(stderr, "%s:%d: internal error: %s does not hold\n", file, line, condition);
    std::abort();
}

} // namespace sim

/// Aborts on a programming error, in release builds too. Not for inner loops.
#define CHECK(condition) ((condition) ? void(0) : ::sim::check_failed(#condition, __FILE__, __LINE__))
