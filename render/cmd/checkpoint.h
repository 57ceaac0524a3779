#pragma once
/// Where a simulation goes on after an interruption: checkpoint.bin, its state at one step, and checkpoint.states, what
/// trajectory and film were given until then. Both go when the run is whole.
#include "sim/base/bytes.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cmd {

struct Checkpoint {
    std::string bytes;                  ///< of checkpoint.bin
    std::size_t state = 0;              ///< where in them that of the simulation begins
    std::uint64_t states_size = 0;      ///< [byte] of checkpoint.states then
    std::vector<std::string> overrides; ///< of the scene, in the order applied
};

/// The folder's checkpoint; none if it has none. Throws Error: usage if it is of another build of the program or of
/// another scene, io if it cannot be read or is damaged.
std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& folder, const sim::SceneDef& scene);

/// The states up to a checkpoint of this folder, one after the other, until `take` returns false. Throws Error (io).
void read_states(const std::filesystem::path& folder, const Checkpoint& checkpoint,
                 const std::function<bool(sim::Snapshot)>& take);

class CheckpointWriter {
public:
    /// Goes on after `from`; null: anew. Throws Error (io).
    CheckpointWriter(std::filesystem::path folder, const sim::SceneDef& scene, const Checkpoint* from);

    /// What trajectory and film are given. Throws Error (io).
    void add(sim::Snapshot state);
    /// What was added, and what `state` puts, make a checkpoint; the one before stays if that fails. Throws Error (io).
    void write(const std::function<void(sim::ByteWriter&)>& state);

private:
    struct Closer {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    [[noreturn]] void fail() const;

    std::filesystem::path folder_;
    sim::ByteWriter origin_; ///< with which each checkpoint begins: program and scene
    std::unique_ptr<std::FILE, Closer> states_;
    std::uint64_t states_size_ = 0;
};

} // namespace cmd
