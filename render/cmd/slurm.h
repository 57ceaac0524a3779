#pragma once
/// Work given to Slurm: batch scripts beside the results, their jobs (slurm_jobs.h), and what became of these.
#include "render/cmd/progress.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace cmd {

/// Where the work is done.
struct Placement {
    std::string on = "local"; ///< or "slurm"
    std::string slurm{};      ///< words for sbatch, as typed
    int slices = 0;           ///< of a film; 0: as many as have enough work
    bool is_detached = false; ///< jobs are left to themselves
};

/// Adds --on, --slurm and --detach.
void add_placement_options(CLI::App& verb, Placement& placement);

/// False on this machine. Throws Error (usage) if an option asks this machine for what only a cluster does.
bool is_elsewhere(const Placement& placement);

/// What of many equal pieces of work one task does: every count-th, from first on.
struct Share {
    std::size_t first = 0;
    std::size_t count = 1;
};

/// "3/25"; none if it is not so.
std::optional<Share> parse_share(std::string_view text);

/// Of a stage: Slurm's own limit of an array, unless its administrator has set another.
inline constexpr std::size_t most_tasks = 1000;

/// Tasks of one kind, each after all of the stage before.
struct BatchStage {
    std::string name{};         ///< "draw"
    std::string commands{};     ///< of a shell; $n: the task's number
    int count = 1;              ///< tasks 0 .. count - 1
    std::vector<int> missing{}; ///< those that are to be run, ascending; empty: the stage is done
};

/// Work on one scene or study.
struct Batch {
    std::string name{};             ///< "funnel"
    std::filesystem::path folder{}; ///< of its results, relative to where the program runs; scripts in slurm/
    std::vector<BatchStage> stages{};
};

/// What is watched: how much is done on disk.
struct Watched {
    std::string unit{}; ///< "frames"
    std::int64_t total = 1;
    std::function<std::int64_t()> done{};
    ProgressStyle progress = ProgressStyle::text;
};

/// Text as one word of a shell.
std::string shell_word(const std::string& text);

/// Path of the program as tasks call it, as one word of a shell.
std::string program_word();

/// Submits what is missing of each batch, unless jobs of the same scripts are there already, and waits for
/// all. Returns false if they are left to themselves. Throws Error: io if Slurm refuses, in its own words, or
/// if a task left no exit code; the code and message of the first task that failed; interrupted once its jobs
/// are cancelled.
bool run_batches(const std::vector<Batch>& batches, const Placement& placement, const Watched& watched);

} // namespace cmd
