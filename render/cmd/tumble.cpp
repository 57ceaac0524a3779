/// The program: arguments to a verb, the verb's outcome to an exit code.
#include "sim/error.h"

#include <CLI/CLI.hpp>

#include <cstdio>

int main(int argc, char** argv) {
    CLI::App app("Simulates rigid bodies in contact from a scene file and makes a film of them.", "tumble");
    app.set_version_flag("--version", "tumble " TUMBLE_VERSION);
    try {
        app.parse(argc, argv);
        return static_cast<int>(sim::ExitCode::good);
    } catch (const CLI::ParseError& error) {
        // Help and version arrive here too, with code 0.
        const bool is_wrong = app.exit(error) != 0;
        return static_cast<int>(is_wrong ? sim::ExitCode::usage : sim::ExitCode::good);
    } catch (const sim::Error& error) {
        std::fprintf(stderr, "tumble: %s\n", error.what());
        return static_cast<int>(error.code());
    }
}
