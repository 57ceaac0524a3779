/// libFuzzer: any bytes are a trajectory, all of whose records can be read, or a sim::Error.
#include "sim/base/error.h"
#include "sim/record/trajectory.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace {

/// A file that lives in memory, under a path.
class MemoryFile {
public:
    MemoryFile(const std::uint8_t* data, std::size_t size) : descriptor_(memfd_create("trajectory", MFD_CLOEXEC)) {
        CHECK(descriptor_ >= 0);
        CHECK(write(descriptor_, data, size) == static_cast<ssize_t>(size));
    }
    ~MemoryFile() { close(descriptor_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

private:
    int descriptor_;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const MemoryFile file(data, size);
    try {
        const sim::TrajectoryReader trajectory(file.path());
        for (std::size_t k = 0; k < trajectory.steps().size(); ++k) {
            CHECK(trajectory.read(k).bodies.size() == trajectory.info().body_names.size());
        }
    } catch (const sim::Error& error) {
        CHECK(error.code() == sim::ExitCode::io);
    }
    return 0;
}
