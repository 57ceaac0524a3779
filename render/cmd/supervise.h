#pragma once
/// The main thread while others work: progress, interruption, errors.
#include "render/cmd/progress.h"
#include "render/cmd/workplace.h"
#include "render/film/thread_group.h"

#include <cstdint>
#include <functional>

namespace cmd {

/// Returns when all threads of the group have ended well. `done`: for the progress, safe in any thread.
/// workplace: where frames are kept; null: nowhere. Throws the first error of a thread. On Ctrl-C stops the group and throws Error (interrupted); a thread
/// that does not stop in time is not waited for: the program ends here, with the same line and exit code.
void supervise(render::ThreadGroup& threads, Progress& progress, const std::function<std::int64_t()>& done,
               const Workplace* workplace);

} // namespace cmd
