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
#include <cstdio>
#include <thread>

namespace cmd {

namespace {

using sim::Error;
using sim::ExitCode;
using Counter = std::atomic<std::int64_t>;
static_assert(Counter::is_always_lock_free); // it is shared between processes

/// A counter a job, seen by parent and children.
class Counters {
public:
    explicit Counters(std::size_t count) : bytes_(std::max<std::size_t>(1, count) * sizeof(Counter)) {
        void* memory = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) {
            throw Error(ExitCode::io, fmt::format("cannot share memory: {}", std::strerror(errno)));
        }
        first_ = static_cast<Counter*>(memory);
        for (std::size_t i = 0; i < count; ++i) {
            new (first_ + i) Counter(0);
        }
    }
    ~Counters() { munmap(first_, bytes_); }
    Counters(const Counters&) = delete;
    Counters& operator=(const Counters&) = delete;

    Counter& operator[](std::size_t i) { return first_[i]; }

private:
    std::size_t bytes_;
    Counter* first_ = nullptr;
};

struct Child {
    pid_t pid = 0;
    std::size_t job = 0;
};

[[noreturn]] void be_child(const Job& job, int limit, Counter& counter) {
    prctl(PR_SET_PDEATHSIG, SIGKILL); // no orphans
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU}) {
        std::signal(signal, SIG_DFL);
    }
    const auto seconds = static_cast<rlim_t>(limit);
    const rlimit time{seconds, seconds + 5};
    setrlimit(RLIMIT_CPU, &time);
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    try {
        job.work(counter);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "\n%s: %s\n", job.name.c_str(), error.what());
        _exit(1);
    }
    _exit(0);
}

Child start(const Job& job, std::size_t index, int limit, Counter& counter) {
    std::fflush(nullptr); // or the child would print it again
    const pid_t pid = fork();
    if (pid < 0) {
        throw Error(ExitCode::io, fmt::format("cannot start a process: {}", std::strerror(errno)));
    }
    if (pid == 0) {
        be_child(job, limit, counter);
    }
    return {pid, index};
}

/// True if the child has ended; its job then has failed or succeeded.
bool has_ended(const Child& child, const Job& job, int limit, Counter& counter) {
    int status = 0;
    if (waitpid(child.pid, &status, WNOHANG) != child.pid) {
        return false;
    }
    counter = job.steps;
    if (WIFSIGNALED(status)) {
        const bool is_too_dear = WTERMSIG(status) == SIGXCPU;
        job.on_failure(is_too_dear, is_too_dear ? fmt::format("not done after {} s of processor time", limit)
                                                : fmt::format("ended by signal {}", WTERMSIG(status)));
    } else if (WEXITSTATUS(status) != 0) {
        job.on_failure(false, fmt::format("ended with {}", WEXITSTATUS(status)));
    }
    return true;
}

void end_all(const std::vector<Child>& children) {
    for (const Child& child : children) {
        kill(child.pid, SIGKILL);
        waitpid(child.pid, nullptr, 0);
    }
}

} // namespace

void run_jobs(const std::vector<Job>& jobs, const CrewSettings& settings) {
    Counters counters(jobs.size());
    std::int64_t total = 0;
    for (const Job& job : jobs) {
        total += job.steps;
    }
    Progress progress(settings.label, "steps", std::max<std::int64_t>(1, total), settings.is_quiet);
    std::vector<Child> children;
    std::size_t next = 0;
    const auto wanted = static_cast<std::size_t>(settings.processes);
    while (next < jobs.size() || !children.empty()) {
        if (is_interrupted()) {
            end_all(children);
            progress.clear();
            throw Error(ExitCode::interrupted,
                        "interrupted; points that are done are kept: the same command goes on");
        }
        for (; next < jobs.size() && children.size() < wanted; ++next) {
            children.push_back(start(jobs[next], next, settings.limit, counters[next]));
        }
        std::erase_if(children, [&](const Child& child) {
            return has_ended(child, jobs[child.job], settings.limit, counters[child.job]);
        });
        std::int64_t done = 0;
        for (std::size_t i = 0; i < next; ++i) {
            done += counters[i];
        }
        progress.update(done);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    progress.clear();
}

} // namespace cmd
