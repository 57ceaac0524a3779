#pragma once
/// Slurm's commands: jobs of the scripts of a batch, and what the queue says of them.
#include "render/cmd/slurm.h"

#include <map>

namespace cmd {

struct SlurmJob {
    const Batch* batch = nullptr;
    const BatchStage* stage = nullptr;
    std::string id{};     ///< Slurm's number; of an array: of all its tasks
    bool is_ours = false; ///< submitted by this run of the program, not an earlier one
};

/// What Slurm says of our tasks that have not ended.
struct Queue {
    std::map<std::string, std::string> held{}; ///< tasks that will never start, "13_2", and why
    std::map<std::string, int> tasks{};        ///< by the number of the job
    std::map<std::string, int> pending{};      ///< of these
};

/// Are its commands on this machine?
bool has_slurm();

/// What a command of Slurm's prints; it is ended if it gets no answer.
std::string ask_slurm(const std::string& command);

std::filesystem::path scripts_of(const Batch& batch);

/// "draw-3" of an array, "join".
std::string task_name(const BatchStage& stage, int number);

/// None if the controller does not answer; said: what squeue says.
std::optional<Queue> read_queue(std::string& said);

/// Only our jobs of it.
bool is_any_queued(const std::vector<SlurmJob>& jobs, const Queue& queue);

std::string ids_of(const std::vector<SlurmJob>& jobs);

/// Writes the scripts and submits them. Throws Error (io) with what sbatch says; nothing of it is left submitted.
std::vector<SlurmJob> submit(const Batch& batch, const Placement& placement);

/// Those that this run of the program has submitted; returns them.
std::vector<SlurmJob> cancel(std::vector<SlurmJob> jobs);

/// Those of the batch that are in the queue already. Throws Error (usage) if they are of other scripts.
std::vector<SlurmJob> jobs_under_way(const Batch& batch, const Queue& queue);

} // namespace cmd
