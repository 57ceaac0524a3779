#include "render/cmd/guard.h"

#include "render/cmd/interrupt.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>

#include <climits>
#include <cstdio>
#include <exception>
#include <malloc.h>
#include <new>
#include <sys/resource.h>
#include <system_error>

namespace cmd {

namespace {

using sim::ExitCode;

/// One line: what a file or an argument holds of control characters, as \xNN.
std::string printable(const std::string& text) {
    std::string line;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        line += byte < 0x20 || byte == 0x7f ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
    }
    return line;
}

int fail(ExitCode code, const char* message) {
    std::fprintf(stderr, "tumble: %s\n", printable(message).c_str());
    return static_cast<int>(code);
}

} // namespace

std::string command_line(int argc, char** argv) {
    std::string text = "tumble";
    for (int i = 1; i < argc; ++i) {
        text += std::string(" ") + argv[i];
    }
    return text;
}

int guarded(const std::function<int()>& program) {
    catch_interrupts();
    // Where addresses are limited (ulimit -v), threads share one arena: each of their own takes 64 MB of them.
    rlimit addresses{};
    if (::getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY) {
        ::mallopt(M_ARENA_MAX, 1);
    }
    // What a picture used is kept for the next, not handed back to the system after each.
    ::mallopt(M_TRIM_THRESHOLD, INT_MAX);
    ::mallopt(M_MMAP_THRESHOLD, INT_MAX);
    try {
        const int code = program();
        if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && !sim::is_output_unread()) {
            throw sim::Error(ExitCode::io, "cannot write to the standard output");
        }
        return code;
    } catch (const sim::Error& error) {
        return error.code() == ExitCode::good ? static_cast<int>(ExitCode::good) : fail(error.code(), error.what());
    } catch (const std::bad_alloc&) {
        return fail(ExitCode::stopped, "out of memory");
    } catch (const std::system_error& error) {
        const bool is_thread = error.code() == std::errc::resource_unavailable_try_again;
        return fail(ExitCode::stopped, is_thread ? "out of memory: no room for another thread" : error.what());
    } catch (const std::exception& error) {
        return fail(ExitCode::stopped, error.what());
    }
}

} // namespace cmd
