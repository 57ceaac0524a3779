#include "render/film/libav.h"

#include "sim/base/error.h"

#include <fmt/format.h>

#include <array>
#include <dlfcn.h>

namespace render {

namespace {

// libavformat brings libavcodec and libavutil; of the versions whose headers this was compiled with.
constexpr std::array libav_files{"libavformat.so." AV_STRINGIFY(LIBAVFORMAT_VERSION_MAJOR),
                                 "libswscale.so." AV_STRINGIFY(LIBSWSCALE_VERSION_MAJOR)};

[[noreturn]] void fail_to_load() {
    throw sim::Error(
        sim::ExitCode::io,
        fmt::format("films, GIFs and encoders by name need FFmpeg's libraries; --no-video leaves films out: {}",
                    dlerror()));
}

/// Loaded once; they stay until the program ends.
std::array<void*, libav_files.size()> load_libav() {
    std::array<void*, libav_files.size()> handles{};
    for (std::size_t i = 0; i < libav_files.size(); ++i) {
        handles[i] = dlopen(libav_files[i], RTLD_LAZY | RTLD_LOCAL);
        if (handles[i] == nullptr) {
            fail_to_load();
        }
    }
    return handles;
}

} // namespace

void* libav_function(const char* name) {
    static const std::array handles = load_libav();
    for (void* handle : handles) {
        if (void* function = dlsym(handle, name)) {
            return function;
        }
    }
    fail_to_load();
}

} // namespace render
