#include "render/cmd/slurm_jobs.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <sys/wait.h>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

// Ends a question that gets no answer [s].
constexpr int question_limit = 20;

struct Outcome {
    int code = -1;
    std::string text; ///< all that was printed
};

Outcome run_command(const std::string& command) {
    Outcome outcome;
    FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) {
        return outcome;
    }
    char buffer[4096];
    for (std::size_t read = 0; (read = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) {
        outcome.text.append(buffer, read);
    }
    const int status = pclose(pipe);
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return outcome;
}

Outcome ask(const std::string& command) {
    return run_command(fmt::format("timeout {} {}", question_limit, command));
}

/// Lines as one, separated by semicolons.
std::string one_line(std::string text) {
    while (!text.empty() && text.back() == '\n') {
        text.pop_back();
    }
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;) {
        text.replace(at, 1, "; ");
    }
    return text;
}

/// A path in which Slurm replaces nothing.
std::string without_patterns(std::string path) {
    for (std::size_t at = 0; (at = path.find('%', at)) != std::string::npos; at += 2) {
        path.insert(at, 1, '%');
    }
    return path;
}

std::string script_text(const Batch& batch, const BatchStage& stage) {
    const bool is_array = stage.count > 1;
    const fs::path folder = scripts_of(batch);
    const std::string log =
        without_patterns(folder.string()) + "/" + stage.name + (is_array ? "-%a.log" : ".log");
    return fmt::format(R"(#!/bin/sh
#SBATCH --job-name={name}
#SBATCH --chdir={here}
#SBATCH --output={log}
#SBATCH --ntasks=1
#SBATCH --requeue
# By hand: cd {here} && sh {folder}/{stage}.sh{number}
n=${{SLURM_ARRAY_TASK_ID:-${{1:-0}}}}
cores=${{SLURM_CPUS_ON_NODE:-$(nproc)}}
if ! cd {here} || [ ! -d {folder} ]; then
    echo "tumble: ${{SLURMD_NODENAME:-$(hostname)}} does not see" {all} "expected a folder that all nodes share" >&2
    exit 3
fi
rm -f {folder}/"{task}.exit"
(
set -e
{commands})
code=$?
[ $code = 130 ] || echo $code >{folder}/"{task}.exit" # ended from outside: no code of its own
exit $code
)",
                       fmt::arg("name", shell_word(batch.name + "-" + stage.name)),
                       fmt::arg("here", shell_word(fs::current_path().string())),
                       fmt::arg("log", shell_word(log)), fmt::arg("folder", shell_word(folder.string())),
                       fmt::arg("stage", stage.name), fmt::arg("number", is_array ? " NUMBER" : ""),
                       fmt::arg("all", shell_word(fs::absolute(folder).string() + ",")),
                       fmt::arg("task", is_array ? stage.name + "-$n" : stage.name),
                       fmt::arg("commands", stage.commands));
}

/// Submits the stages one after the other, and writes their numbers to `jobs`.
std::string submit_text(const Batch& batch, const Placement& placement) {
    std::string text = fmt::format("#!/bin/sh\n# Submits what was missing when this was written. By hand: cd "
                                   "{} && sh {}\nset -e\njobs={}\n: >\"$jobs\"\n",
                                   shell_word(fs::current_path().string()),
                                   shell_word((scripts_of(batch) / "submit.sh").string()),
                                   shell_word((scripts_of(batch) / "jobs").string()));
    std::string after;
    for (const BatchStage& stage : batch.stages) {
        if (stage.missing.empty()) {
            continue;
        }
        const std::string array =
            stage.count > 1 ? fmt::format(" --array={}", fmt::join(stage.missing, ",")) : std::string();
        text += fmt::format("id=$(sbatch --parsable{}{}{}{} {})\necho \"{} ${{id%%;*}}\" >>\"$jobs\"\n",
                            placement.slurm.empty() ? "" : " ", placement.slurm, array, after,
                            shell_word((scripts_of(batch) / (stage.name + ".sh")).string()), stage.name);
        after = " --dependency=afterok:\"${id%%;*}\" --kill-on-invalid-dep=yes";
    }
    return text;
}

std::vector<SlurmJob> read_jobs(const Batch& batch) {
    std::vector<SlurmJob> jobs;
    const fs::path path = scripts_of(batch) / "jobs";
    if (!fs::exists(path)) {
        return jobs;
    }
    std::istringstream lines(sim::read_text_file(path));
    for (std::string name, id; lines >> name >> id;) {
        for (const BatchStage& stage : batch.stages) {
            if (stage.name == name) {
                jobs.push_back({&batch, &stage, id});
            }
        }
    }
    return jobs;
}

} // namespace

bool has_slurm() {
    return run_command("command -v sbatch").code == 0;
}

std::string ask_slurm(const std::string& command) {
    return ask(command).text;
}

fs::path scripts_of(const Batch& batch) {
    return batch.folder / "slurm";
}

std::string task_name(const BatchStage& stage, int number) {
    return stage.count > 1 ? fmt::format("{}-{}", stage.name, number) : stage.name;
}

std::optional<Queue> read_queue(std::string& said) {
    const Outcome outcome = ask("squeue --me --noheader --array --format='%F %K %t %r'");
    said = one_line(outcome.text);
    if (outcome.code != 0) {
        return std::nullopt;
    }
    Queue queue;
    std::istringstream lines(outcome.text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string id, number, state, reason;
        words >> id >> number >> state;
        std::getline(words >> std::ws, reason);
        ++queue.tasks[id];
        if (state == "PD") {
            ++queue.pending[id];
            std::replace(reason.begin(), reason.end(), '_', ' ');
            if (reason.find("requeued held") != std::string::npos) {
                queue.held[number == "N/A" ? id : id + "_" + number] = reason;
            }
        }
    }
    return queue;
}

bool is_any_queued(const std::vector<SlurmJob>& jobs, const Queue& queue) {
    return std::any_of(jobs.begin(), jobs.end(),
                       [&](const SlurmJob& job) { return queue.tasks.contains(job.id); });
}

std::string ids_of(const std::vector<SlurmJob>& jobs) {
    std::string text;
    for (const SlurmJob& job : jobs) {
        text += (text.empty() ? "" : " ") + job.id;
    }
    return text;
}

std::vector<SlurmJob> cancel(std::vector<SlurmJob> jobs) {
    std::erase_if(jobs, [](const SlurmJob& job) { return !job.is_ours; });
    if (!jobs.empty()) {
        ask("scancel " + ids_of(jobs));
    }
    return jobs;
}

std::vector<SlurmJob> submit(const Batch& batch, const Placement& placement) {
    const fs::path folder = scripts_of(batch);
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
        throw Error(ExitCode::io,
                    fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
    }
    bool is_anything_missing = false;
    for (const BatchStage& stage : batch.stages) {
        sim::write_file(folder / (stage.name + ".sh"), script_text(batch, stage));
        is_anything_missing = is_anything_missing || !stage.missing.empty();
        for (const int number : stage.missing) {
            fs::remove(folder / (task_name(stage, number) + ".exit"), error);
            fs::remove(folder / (task_name(stage, number) + ".log"), error);
        }
    }
    if (!is_anything_missing) {
        return {};
    }
    sim::write_file(folder / "submit.sh", submit_text(batch, placement));
    const Outcome outcome = run_command("sh " + shell_word((folder / "submit.sh").string()));
    std::vector<SlurmJob> jobs = read_jobs(batch);
    for (SlurmJob& job : jobs) {
        job.is_ours = true;
    }
    if (outcome.code != 0) {
        cancel(jobs);
        throw Error(ExitCode::io, fmt::format("Slurm refuses {}: {}", batch.name, one_line(outcome.text)));
    }
    return jobs;
}

std::vector<SlurmJob> jobs_under_way(const Batch& batch, const Queue& queue) {
    std::vector<SlurmJob> jobs = read_jobs(batch);
    if (!is_any_queued(jobs, queue)) {
        return {};
    }
    for (const BatchStage& stage : batch.stages) {
        const fs::path path = scripts_of(batch) / (stage.name + ".sh");
        if (!fs::exists(path) || sim::read_text_file(path) != script_text(batch, stage)) {
            throw Error(
                ExitCode::usage,
                fmt::format("jobs of another command are under way in {}: wait for them, or scancel {}",
                            batch.folder.string(), ids_of(jobs)));
        }
    }
    return jobs;
}

} // namespace cmd
