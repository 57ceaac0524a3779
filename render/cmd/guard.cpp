#include "render/cmd/guard.h"

#include "render/cmd/interrupt.h"
#include "sim/error.h"

#include <cstdio>
#include <exception>
#include <new>

namespace cmd {

namespace {

using sim::ExitCode;

int fail(ExitCode code, const char* message) {
    std::fprintf(stderr, "tumble: %s\n", message);
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
    try {
        return program();
    } catch (const sim::Error& error) {
        return fail(error.code(), error.what());
    } catch (const std::bad_alloc&) {
        return fail(ExitCode::stopped, "out of memory");
    } catch (const std::exception& error) {
        return fail(ExitCode::stopped, error.what());
    }
}

} // namespace cmd
