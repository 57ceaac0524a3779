#include "render/cmd/checkpoint.h"

#include "render/cmd/workplace.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/difference.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <unistd.h>
#include <utility>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

/// Two builds may round differently, or keep a state in another form.
std::string this_program() {
    return "tumble " TUMBLE_VERSION " (build " + sim::sha256_of_file("/proc/self/exe").substr(0, 12) + ")";
}

/// Of what a checkpoint was made.
struct Origin {
    std::string program;
    std::string scene_text; ///< with what it takes from other files
    std::vector<std::string> overrides;
};

template <typename Archive, typename Text>
void exchange_texts(Archive& archive, std::vector<Text>& texts) {
    std::size_t count = texts.size();
    archive(count);
    if constexpr (std::is_same_v<Archive, sim::ByteReader>) {
        texts.resize(count);
    }
    for (Text& text : texts) {
        archive(text);
    }
}

template <typename Archive>
void exchange(Archive& archive, Origin& origin) {
    archive(origin.program);
    archive(origin.scene_text);
    exchange_texts(archive, origin.overrides);
}

template <typename Archive>
void exchange(Archive& archive, sim::Snapshot& state) {
    archive(state.step);
    archive(state.time);
    archive(state.bodies);
    archive(state.contact_count);
    archive(state.contacts);
    archive(state.impacts);
}

[[noreturn]] void fail_damaged(const fs::path& path) {
    throw Error(ExitCode::io,
                fmt::format("cannot read {}: it is damaged; run without --resume to start again", path.string()));
}

/// What stands before each state in checkpoint.states.
struct StateHead {
    std::uint64_t size = 0; ///< [byte]
    std::uint64_t checksum = 0;
};

/// However many. Throws Error (io).
std::string read_bytes(const fs::path& path) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    if (error) {
        fail_damaged(path); // no file at all
    }
    std::string bytes(size, '\0');
    std::ifstream file(path, std::ios::binary);
    if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) {
        throw Error(ExitCode::io, fmt::format("cannot read {}", path.string()));
    }
    return bytes;
}

/// What keeps a checkpoint of `before` from being used for the scene; empty if nothing does.
std::string difference(const Origin& before, const sim::SceneDef& scene) {
    if (const std::string program = this_program(); before.program != program) {
        return fmt::format("this is {}, {} is of {}", program, checkpoint_name, before.program);
    }
    return sim::scene_difference({scene.text, scene.overrides}, {before.scene_text, before.overrides});
}

} // namespace

std::optional<Checkpoint> read_checkpoint(const fs::path& folder, const sim::SceneDef& scene) {
    const fs::path path = folder / checkpoint_name;
    std::error_code error;
    if (!fs::exists(path, error)) {
        return std::nullopt;
    }
    Checkpoint checkpoint;
    checkpoint.bytes = read_bytes(path);
    const std::string_view bytes = checkpoint.bytes;
    Origin origin;
    std::uint64_t sum = 0;
    if (bytes.size() < sizeof sum) {
        fail_damaged(path);
    }
    const std::string_view content = bytes.substr(0, bytes.size() - sizeof sum);
    sim::ByteReader(bytes.substr(content.size()))(sum);
    if (sum != sim::checksum(content)) {
        fail_damaged(path);
    }
    sim::ByteReader reader(content);
    exchange(reader, origin);
    reader(checkpoint.states_size);
    checkpoint.state = content.size() - reader.left();
    if (const std::string other = difference(origin, scene); !other.empty()) {
        throw Error(ExitCode::usage, fmt::format("cannot go on in {}: {}; run without --resume to start again",
                                                 folder.string(), other));
    }
    const std::uintmax_t size = fs::file_size(folder / states_name, error);
    if (error || size < checkpoint.states_size) {
        fail_damaged(folder / states_name);
    }
    checkpoint.overrides = origin.overrides;
    return checkpoint;
}

void read_states(const fs::path& folder, const Checkpoint& checkpoint,
                 const std::function<bool(sim::Snapshot)>& take) {
    const fs::path path = folder / states_name;
    std::FILE* const file = std::fopen(path.c_str(), "rbe");
    if (file == nullptr) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: {}", path.string(), std::strerror(errno)));
    }
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> owner(file, std::fclose);
    std::string bytes;
    for (std::uint64_t left = checkpoint.states_size; left > 0;) {
        StateHead head;
        if (left < sizeof head || std::fread(&head, sizeof head, 1, file) != 1 || head.size > left - sizeof head) {
            fail_damaged(path);
        }
        bytes.resize(head.size);
        if (std::fread(bytes.data(), 1, bytes.size(), file) != bytes.size() || sim::checksum(bytes) != head.checksum) {
            fail_damaged(path);
        }
        left -= sizeof head + head.size;
        sim::Snapshot state;
        sim::ByteReader reader(bytes);
        exchange(reader, state);
        if (!take(std::move(state))) {
            return;
        }
    }
}

CheckpointWriter::CheckpointWriter(fs::path folder, const sim::SceneDef& scene, const Checkpoint* from)
    : folder_(std::move(folder)), states_size_(from != nullptr ? from->states_size : 0) {
    const fs::path path = folder_ / states_name;
    states_.reset(std::fopen(path.c_str(), from != nullptr ? "r+be" : "wbe"));
    if (states_ == nullptr || ::ftruncate(::fileno(states_.get()), static_cast<off_t>(states_size_)) != 0 ||
        std::fseek(states_.get(), 0, SEEK_END) != 0) {
        fail();
    }
    Origin origin{this_program(), scene.text, scene.overrides};
    exchange(origin_, origin);
}

void CheckpointWriter::fail() const {
    throw Error(ExitCode::io,
                fmt::format("cannot write {}: {}", (folder_ / states_name).string(), std::strerror(errno)));
}

void CheckpointWriter::add(sim::Snapshot state) {
    sim::ByteWriter bytes;
    exchange(bytes, state);
    const StateHead head{bytes.bytes().size(), sim::checksum(bytes.bytes())};
    if (std::fwrite(&head, sizeof head, 1, states_.get()) != 1 ||
        std::fwrite(bytes.bytes().data(), 1, bytes.bytes().size(), states_.get()) != bytes.bytes().size()) {
        fail();
    }
    states_size_ += sizeof head + bytes.bytes().size();
}

void CheckpointWriter::write(const std::function<void(sim::ByteWriter&)>& state) {
    if (std::fflush(states_.get()) != 0 || ::fdatasync(::fileno(states_.get())) != 0) {
        fail();
    }
    sim::ByteWriter bytes = origin_;
    bytes(states_size_);
    state(bytes);
    bytes(sim::checksum(bytes.bytes()));
    sim::write_file(folder_ / checkpoint_name, bytes.bytes());
}

} // namespace cmd
