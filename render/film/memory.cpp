#include "render/film/memory.h"

#include "sim/base/error.h"

#include <fmt/format.h>

#include <cstddef>
#include <sys/mman.h>
#include <unistd.h>

namespace render {

namespace {

// Measured under a limit: 460 MB for small pictures, most of it OpenGL's compiler and stacks of threads; 76 bytes a
// pixel beyond, and 24 MB for a film of 1280x720.
constexpr std::size_t least_bytes = 490u << 20;
constexpr std::size_t bytes_a_pixel = 80;

} // namespace

void require_memory(int width, int height) {
    const std::size_t bytes =
        least_bytes + bytes_a_pixel * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const std::size_t machine = static_cast<std::size_t>(::sysconf(_SC_PHYS_PAGES)) *
                                static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    if (bytes > machine) {
        throw sim::Error(sim::ExitCode::stopped,
                         fmt::format("out of memory: pictures of {}x{} pixels need {} MB, this machine has {} MB", width,
                                     height, bytes >> 20, machine >> 20));
    }
    // Asks for the addresses only: no memory is taken.
    void* room = ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (room == MAP_FAILED) {
        throw sim::Error(
            sim::ExitCode::stopped,
            fmt::format(
                "out of memory: pictures of {}x{} pixels need {} MB more than the limit (ulimit -v) leaves",
                width, height, bytes >> 20));
    }
    ::munmap(room, bytes);
}

} // namespace render
