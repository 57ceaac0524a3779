#include "render/cmd/supervise.h"

#include "render/cmd/interrupt.h"
#include "sim/base/error.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

namespace cmd {

namespace {

using namespace std::chrono_literals;

constexpr auto poll_interval = 50ms;
// Ctrl-C is to end the program within a second: this much for a step or picture under way.
constexpr auto supervisor_patience = 700ms;

} // namespace

void supervise(render::ThreadGroup& threads, Progress& progress, const std::function<std::int64_t()>& done,
               const Workplace* workplace) {
    while (!threads.wait_for(poll_interval)) {
        if (!is_interrupted()) {
            progress.update(done());
            continue;
        }
        threads.stop();
        const bool have_stopped = threads.wait_for(supervisor_patience);
        progress.clear();
        const std::string message =
            workplace != nullptr && (workplace->has_frames() || workplace->has_checkpoint())
                ? fmt::format(
                      "interrupted; what is done is kept in {}: the same command with --resume goes on",
                      workplace->folder().string())
                : "interrupted; nothing is kept";
        if (!have_stopped) {
            if (workplace != nullptr) {
                workplace->remove_parts();
            }
            std::fprintf(stderr, "tumble: %s\n", message.c_str());
            std::_Exit(static_cast<int>(sim::ExitCode::interrupted));
        }
        throw sim::Error(sim::ExitCode::interrupted, message);
    }
    progress.update(done());
    progress.clear();
    threads.join();
}

} // namespace cmd
