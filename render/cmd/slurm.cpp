#include "render/cmd/slurm_jobs.h"

#include "render/cmd/interrupt.h"
#include "render/cmd/progress.h"
#include "render/cmd/usage.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <optional>
#include <sstream>
#include <thread>

namespace cmd {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using sim::Error;
using sim::ExitCode;

namespace {

using Clock = std::chrono::steady_clock;

// A controller, or a shared disk, that many users ask more often than this has little time for jobs.
constexpr auto question_interval = 2s;
// So long without an answer, and the controller counts as gone. What is done on disk is seen meanwhile.
constexpr auto most_silence = 10min;
/// What a log says in its last line of ours, or in its last line.
std::string last_message(const fs::path& log) {
    std::error_code error;
    if (!fs::is_regular_file(log, error)) {
        return "";
    }
    std::istringstream lines(sim::read_text_file(log));
    std::string last;
    bool is_ours = false;
    for (std::string line; std::getline(lines, line);) {
        const bool is_message = line.starts_with("tumble: ");
        if (!line.empty() && (is_message || !is_ours)) {
            last = is_message ? line.substr(8) : line;
            is_ours = is_message;
        }
    }
    return last;
}

/// Tasks that Slurm could not start, "13_2", and why: it would hold them for ever.
using Unstarted = std::map<std::string, std::string>;

/// "CANCELLED on node2", as long as the controller remembers.
std::string fate_of(const SlurmJob& job, int number, const Unstarted& unstarted) {
    const std::string id = job.stage->count > 1 ? fmt::format("{}_{}", job.id, number) : job.id;
    if (const auto found = unstarted.find(id); found != unstarted.end()) {
        return fmt::format("{}: a node could not start it, which must see {}", found->second,
                           fs::absolute(scripts_of(*job.batch)).string());
    }
    std::istringstream words(ask_slurm("scontrol --oneliner show job " + id));
    std::string state, node;
    for (std::string word; words >> word;) {
        if (word.starts_with("JobState=")) {
            state = word.substr(9);
        } else if (word.starts_with("NodeList=") && word != "NodeList=(null)") {
            node = word.substr(9);
        }
    }
    return state.empty() ? "unknown to the controller" : state + (node.empty() ? "" : " on " + node);
}

/// Throws what one task of a job became, unless it became what it should: of those that left an exit code, or
/// of those that did not.
void check_task(const SlurmJob& job, int number, const Unstarted& unstarted, bool has_exit_code) {
    const fs::path folder = scripts_of(*job.batch);
    const std::string name = task_name(*job.stage, number);
    const fs::path log = folder / (name + ".log");
    const fs::path exit_file = folder / (name + ".exit");
    const std::string title = fmt::format("{}, {} (job {})", job.batch->name, name, job.id);
    std::error_code error;
    if (fs::exists(exit_file, error) != has_exit_code) {
        return;
    }
    std::string said = last_message(log);
    if (!has_exit_code) {
        said = said.starts_with("interrupted") ? "" : said; // by Slurm, which says more
        throw Error(ExitCode::io,
                    fmt::format("{} ended without an exit code: {}{}; what is whole is kept in {}: the "
                                "same command goes on; log: {}",
                                title, fate_of(job, number, unstarted), said.empty() ? "" : ": " + said,
                                job.batch->folder.string(), log.string()));
    }
    const int code = std::atoi(sim::read_text_file(exit_file).c_str());
    if (code != 0) {
        const bool is_known = (code >= 1 && code <= 5) || code == 130;
        throw Error(is_known ? static_cast<ExitCode>(code) : ExitCode::io,
                    fmt::format("{}: {}; log: {}", title, said, log.string()));
    }
}

/// Throws the first failure: of a task that says why, else of one that was ended.
void check_tasks(const std::vector<SlurmJob>& jobs, const Unstarted& unstarted) {
    for (const bool has_exit_code : {true, false}) {
        for (const SlurmJob& job : jobs) {
            for (const int number : job.stage->missing) {
                check_task(job, number, unstarted, has_exit_code);
            }
        }
    }
}

int failed_tasks(const std::vector<SlurmJob>& jobs) {
    int count = 0;
    for (const SlurmJob& job : jobs) {
        for (const int number : job.stage->missing) {
            const fs::path path = scripts_of(*job.batch) / (task_name(*job.stage, number) + ".exit");
            std::error_code error;
            count += fs::exists(path, error) && sim::read_text_file(path) != "0\n" ? 1 : 0;
        }
    }
    return count;
}

/// "; 2 running, 3 pending, 1 failed".
std::string queue_text(const std::vector<SlurmJob>& jobs, Queue queue) {
    int tasks = 0, pending = 0;
    for (const SlurmJob& job : jobs) {
        tasks += queue.tasks[job.id];
        pending += queue.pending[job.id];
    }
    return fmt::format("; {} running, {} pending, {} failed", tasks - pending, pending, failed_tasks(jobs));
}

/// Those of our jobs are cancelled.
void cancel_held(const std::vector<SlurmJob>& jobs, const Queue& queue, Unstarted& unstarted) {
    for (const auto& [id, reason] : queue.held) {
        const auto is_its = [number = id.substr(0, id.find('_'))](const SlurmJob& job) {
            return job.id == number;
        };
        if (std::any_of(jobs.begin(), jobs.end(), is_its)) {
            unstarted[id] = reason;
            ask_slurm("scancel " + id);
        }
    }
}

/// Until no job is in the queue. Throws Error: interrupted after the jobs are cancelled, io for what will
/// never start.
Unstarted wait_for(const std::vector<SlurmJob>& jobs, const Watched& watched) {
    Unstarted unstarted;
    Progress progress(fmt::format("{} jobs of Slurm's", jobs.size()), watched.unit,
                      std::max<std::int64_t>(1, watched.total), watched.progress);
    Clock::time_point answered = Clock::now();
    Clock::time_point asked = Clock::now() - question_interval;
    std::string note;
    std::int64_t done = 0;
    while (true) {
        if (is_interrupted()) {
            progress.clear();
            const std::vector<SlurmJob> cancelled = cancel(jobs);
            throw Error(ExitCode::interrupted,
                        fmt::format("interrupted; {}; what is whole is kept: the same command goes on",
                                    cancelled.empty() ? "the jobs of an earlier command go on"
                                                      : "cancelled the jobs " + ids_of(cancelled)));
        }
        if (Clock::now() - asked >= question_interval) {
            asked = Clock::now();
            std::string said;
            const std::optional<Queue> queue = read_queue(said);
            if (queue) {
                answered = asked;
                if (!is_any_queued(jobs, *queue)) {
                    break;
                }
                cancel_held(jobs, *queue, unstarted);
            } else if (asked - answered > most_silence) {
                progress.clear();
                throw Error(ExitCode::io,
                            fmt::format("Slurm's controller has not answered for 10 minutes; the jobs {} "
                                        "may go on: the same command watches them again",
                                        ids_of(jobs)));
            }
            done = watched.done();
            note = queue ? queue_text(jobs, *queue) : "; the controller does not answer";
        }
        progress.update(done, note);
        std::this_thread::sleep_for(100ms);
    }
    progress.clear();
    return unstarted;
}

/// While Slurm is asked, a signal must not end the program before its jobs are cancelled.
class Patience {
public:
    Patience() : before_(std::signal(SIGALRM, SIG_IGN)) {}
    ~Patience() { std::signal(SIGALRM, before_); }
    Patience(const Patience&) = delete;
    Patience& operator=(const Patience&) = delete;

private:
    void (*before_)(int);
};

} // namespace

void add_placement_options(CLI::App& verb, Placement& placement) {
    verb.add_option("--on", placement.on, "Where the work is done: local (if not given) or slurm")
        ->type_name("ENGINE")
        ->check(one_of({"local", "slurm"}));
    verb.add_option("--slurm", placement.slurm, "For sbatch, such as \"--partition=render --time=1:00:00\"")
        ->type_name("WORDS");
    verb.add_flag("--detach", placement.is_detached,
                  "With --on slurm: prints the jobs' numbers and does not wait");
}

bool is_elsewhere(const Placement& placement) {
    if (placement.on == "slurm") {
        return true;
    }
    for (const auto& [is_given, name] :
         {std::pair(!placement.slurm.empty(), "--slurm"), std::pair(placement.slices > 0, "--slices"),
          std::pair(placement.is_detached, "--detach")}) {
        if (is_given) {
            throw Error(ExitCode::usage, fmt::format("{}: only with --on slurm", name));
        }
    }
    return false;
}

std::optional<Share> parse_share(std::string_view text) {
    Share share;
    const char* const end = text.data() + text.size();
    const auto [slash, first_error] = std::from_chars(text.data(), end, share.first);
    if (first_error != std::errc{} || slash == end || *slash != '/') {
        return std::nullopt;
    }
    const auto [rest, count_error] = std::from_chars(slash + 1, end, share.count);
    if (count_error != std::errc{} || rest != end || share.first >= share.count) {
        return std::nullopt;
    }
    return share;
}

std::string shell_word(const std::string& text) {
    constexpr std::string_view plain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/";
    if (!text.empty() && text.find_first_not_of(plain) == std::string::npos) {
        return text;
    }
    std::string word = "'";
    for (const char c : text) {
        word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    return word + "'";
}

std::string program_word() {
    std::error_code error;
    const fs::path self = fs::read_symlink("/proc/self/exe", error);
    return shell_word((self.parent_path() / "tumble").string());
}

bool run_batches(const std::vector<Batch>& batches, const Placement& placement, const Watched& watched) {
    const Patience patience;
    if (!has_slurm()) {
        throw Error(ExitCode::io,
                    "--on slurm: there is no sbatch on this machine, expected Slurm's commands (Debian: "
                    "slurm-client) and a cluster");
    }
    std::string said;
    const std::optional<Queue> queue = read_queue(said);
    if (!queue) {
        throw Error(ExitCode::io,
                    "Slurm does not answer: " + (said.empty() ? "squeue waited in vain" : said));
    }
    std::vector<SlurmJob> jobs;
    try {
        for (const Batch& batch : batches) {
            std::vector<SlurmJob> more = jobs_under_way(batch, *queue);
            if (more.empty()) {
                more = submit(batch, placement);
            }
            jobs.insert(jobs.end(), more.begin(), more.end());
        }
    } catch (...) {
        cancel(jobs);
        throw;
    }
    if (placement.is_detached) {
        if (watched.progress != ProgressStyle::quiet) {
            for (const SlurmJob& job : jobs) {
                std::printf("%s, %s: job %s\n", job.batch->name.c_str(), job.stage->name.c_str(),
                            job.id.c_str());
            }
        }
        return false;
    }
    check_tasks(jobs, wait_for(jobs, watched));
    return true;
}

} // namespace cmd
