#include "render/cmd/study_crew.h"

#include "render/cmd/interrupt.h"
#include "render/cmd/progress.h"
#include "sim/base/error.h"

#include <fmt/format.h>

#include <csignal>
#include <cstring>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <new>
#include <thread>

namespace cmd {

namespace {

using sim::Error;
using sim::ExitCode;
using Counter = std::atomic<std::int64_t>;
static_assert(Counter::is_always_lock_free); // it is shared between processes

/// What parent and child see of a job.
struct Desk {
    Counter steps = 0;
    std::array<char, 512> reason{}; ///< why it failed: text that ends with 0
};

class Desks {
public:
    explicit Desks(std::size_t count) : bytes_(std::max<std::size_t>(1, count) * sizeof(Desk)) {
        void* memory = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) {
            throw Error(ExitCode::io, fmt::format("cannot share memory: {}", std::strerror(errno)));
        }
        first_ = static_cast<Desk*>(memory);
        for (std::size_t i = 0; i < count; ++i) {
            new (first_ + i) Desk;
        }
    }
    ~Desks() { munmap(first_, bytes_); }
    Desks(const Desks&) = delete;
    Desks& operator=(const Desks&) = delete;

    Desk& operator[](std::size_t i) { return first_[i]; }

private:
    std::size_t bytes_;
    Desk* first_ = nullptr;
};

struct Child {
    pid_t pid = 0;
    std::size_t job = 0;
    int status = 0; ///< of waitpid
};

[[noreturn]] void be_child(const Job& job, int limit, Desk& desk) {
    prctl(PR_SET_PDEATHSIG, SIGKILL); // no orphans
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU}) {
        std::signal(signal, SIG_DFL);
    }
    const auto seconds = static_cast<rlim_t>(limit);
    const rlimit time{seconds, seconds + 5};
    setrlimit(RLIMIT_CPU, &time);
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    const auto fail = [&desk](ExitCode code, const char* reason) {
        std::snprintf(desk.reason.data(), desk.reason.size(), "%s", reason);
        _exit(static_cast<int>(code));
    };
    try {
        job.work(desk.steps);
    } catch (const Error& error) {
        fail(error.code(), error.what());
    } catch (const std::bad_alloc&) {
        fail(ExitCode::stopped, "out of memory");
    } catch (const std::exception& error) {
        fail(ExitCode::stopped, error.what());
    }
    _exit(0);
}

Child start(const Job& job, std::size_t index, int limit, Desk& desk) {
    std::fflush(nullptr); // or the child would print it again
    const pid_t pid = fork();
    if (pid < 0) {
        throw Error(ExitCode::io, fmt::format("cannot start a process: {}", std::strerror(errno)));
    }
    if (pid == 0) {
        be_child(job, limit, desk);
    }
    return {pid, index};
}

/// True once the child has ended; its status is there from then on.
bool is_over(Child& child) {
    return waitpid(child.pid, &child.status, WNOHANG) == child.pid;
}

/// A job whose child has ended has failed or succeeded. Throws Error (io): no other point would fare better.
void settle(const Child& child, const Job& job, int limit, Desk& desk) {
    const int status = child.status;
    desk.steps = job.steps;
    if (WIFSIGNALED(status)) {
        const bool is_too_dear = WTERMSIG(status) == SIGXCPU;
        job.on_failure(is_too_dear, is_too_dear ? fmt::format("not done after {} s of processor time", limit)
                                                : fmt::format("ended by signal {}", WTERMSIG(status)));
    } else if (WEXITSTATUS(status) == static_cast<int>(ExitCode::io)) {
        throw Error(ExitCode::io, desk.reason.data());
    } else if (WEXITSTATUS(status) != 0) {
        job.on_failure(false, desk.reason.data());
    }
}

/// The children at work; none outlives it.
struct Crew {
    std::vector<Child> children{};

    Crew() = default;
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;
    ~Crew() {
        for (const Child& child : children) {
            kill(child.pid, SIGKILL);
            waitpid(child.pid, nullptr, 0);
        }
    }
};

} // namespace

void run_jobs(const std::vector<Job>& jobs, const CrewSettings& settings) {
    Desks desks(jobs.size());
    std::int64_t total = 0;
    for (const Job& job : jobs) {
        total += job.steps;
    }
    Progress progress(settings.label, "steps", std::max<std::int64_t>(1, total),
                      settings.is_quiet ? ProgressStyle::quiet : ProgressStyle::text);
    Crew crew;
    std::size_t next = 0;
    const auto wanted = static_cast<std::size_t>(settings.processes);
    while (next < jobs.size() || !crew.children.empty()) {
        if (is_interrupted()) {
            progress.clear();
            throw Error(ExitCode::interrupted,
                        "interrupted; points that are done are kept: the same command goes on");
        }
        for (; next < jobs.size() && crew.children.size() < wanted; ++next) {
            crew.children.push_back(start(jobs[next], next, settings.limit, desks[next]));
        }
        for (std::size_t i = 0; i < crew.children.size();) {
            if (!is_over(crew.children[i])) {
                ++i;
                continue;
            }
            const Child child = crew.children[i];
            crew.children.erase(crew.children.begin() + static_cast<std::ptrdiff_t>(i));
            settle(child, jobs[child.job], settings.limit, desks[child.job]);
        }
        std::int64_t done = 0;
        for (std::size_t i = 0; i < next; ++i) {
            done += desks[i].steps;
        }
        progress.update(done);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    progress.clear();
}

} // namespace cmd
