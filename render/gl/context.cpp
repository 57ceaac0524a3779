#include "render/gl/context.h"

#include "render/gl/platform.h"
#include "sim/base/cores.h"
#include "sim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

namespace render {

using sim::Error;
using sim::ExitCode;

namespace {

// From GL_NVX_gpu_memory_info, in kilobytes.
constexpr GLenum total_memory = 0x9048;

/// What "auto" stands for.
const char* automatic() {
    return has_osmesa() ? "osmesa" : "egl";
}

/// Those of graphics cards, or the one that draws in software.
std::vector<EglDevice> egl_devices_of(bool is_software) {
    std::vector<EglDevice> devices = egl_devices();
    std::erase_if(devices, [&](const EglDevice& device) { return device.is_software != is_software; });
    return devices;
}

PlatformContext make_egl(const std::string& word) {
    const bool is_software = word == "egl";
    const std::vector<EglDevice> devices = egl_devices_of(is_software);
    if (is_software) {
        return make_egl_context(devices.empty() ? EglDevice{.is_software = true} : devices.front());
    }
    std::size_t index = devices.size();
    std::from_chars(word.data() + word.find(':') + 1, word.data() + word.size(), index);
    if (index >= devices.size()) {
        throw Error(ExitCode::io, fmt::format("there is no graphics card {}: EGL finds {}; tumble devices lists what "
                                              "can draw",
                                              word, devices.size()));
    }
    return make_egl_context(devices[index]);
}

std::string gl_string(GLenum name) {
    const GLubyte* text = glGetString(name);
    return text == nullptr ? "unknown" : reinterpret_cast<const char*>(text);
}

/// What a device is, or why it cannot be used.
GlDevice try_device(const std::string& word) {
    GlDevice device{.word = word};
    device.is_automatic = word == automatic();
    device.is_software = !word.starts_with("egl:");
    try {
        const GlContext context(word);
        device.renderer = context.renderer_string();
        GLint kilobytes = 0;
        glGetIntegerv(total_memory, &kilobytes);
        if (glGetError() == GL_NO_ERROR && !device.is_software) {
            device.memory = std::int64_t{1024} * kilobytes;
        }
    } catch (const Error& error) {
        device.problem = error.what();
    }
    return device;
}

} // namespace

void load_gl_functions(GlFunction (*find)(const char* name)) {
#define GL_LOAD(name, type)                                                                                            \
    name = reinterpret_cast<type>(find(#name));                                                                        \
    if (name == nullptr) {                                                                                             \
        throw Error(ExitCode::io, "OpenGL has no " #name);                                                             \
    }
    GL_FUNCTIONS(GL_LOAD)
#undef GL_LOAD
}

void configure_gl(bool portable) {
    constexpr int keeps = 0; // what the user has set
    const int cores = sim::core_count();
    // Pixels are the largest part of a film's work, and one thread could not do them beside all else in time.
    setenv("LP_NUM_THREADS", std::to_string(cores > 1 ? std::max(cores - 2, 2) : 0).c_str(), keeps);
    if (portable) {
        setenv("GALLIUM_OVERRIDE_CPU_CAPS", "sse4.1", 1);
    }
    // Mesa keeps compiled shaders for later runs, and does not tell for which instructions and widths.
    for (const char* name : {"GALLIUM_OVERRIDE_CPU_CAPS", "GALLIUM_NOSSE", "LP_NATIVE_VECTOR_WIDTH"}) {
        if (std::getenv(name) != nullptr) {
            setenv("MESA_SHADER_CACHE_DISABLE", "true", keeps);
        }
    }
}

std::string processor_class() {
#if defined(__x86_64__)
    if (const char* caps = std::getenv("GALLIUM_OVERRIDE_CPU_CAPS")) {
        return std::string("x86-64, no more than ") + caps;
    }
    return __builtin_cpu_supports("fma") ? "x86-64, fused multiply-add" : "x86-64, no fused multiply-add";
#elif defined(__aarch64__)
    return "aarch64";
#else
    return "unknown";
#endif
}

std::vector<GlDevice> gl_devices() {
    std::vector<GlDevice> devices{try_device("osmesa"), try_device("egl")};
    for (std::size_t i = 0; i < egl_devices_of(false).size(); ++i) {
        devices.push_back(try_device(fmt::format("egl:{}", i)));
    }
    return devices;
}

GlContext::GlContext(const std::string& word)
    : word_(word == "auto" ? automatic() : word), is_software_(!word_.starts_with("egl:")) {
    const PlatformContext context = word_ == "osmesa" ? make_osmesa_context() : make_egl(word_);
    owner_ = context.owner;
    load_gl_functions(context.find);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    GLint depth_mode = 0;
    glGetIntegerv(GL_CLIP_DEPTH_MODE, &depth_mode);
    if (glGetError() != GL_NO_ERROR || depth_mode != GL_ZERO_TO_ONE) {
        throw Error(ExitCode::io, fmt::format("{} ({}) has no glClipControl", word_, renderer_string()));
    }
}

GlContext::~GlContext() = default;

std::string renderer_string(const std::string& word) {
    return GlContext(word).renderer_string();
}

std::string GlContext::renderer_string() const {
    return gl_string(GL_RENDERER) + ", OpenGL " + gl_string(GL_VERSION);
}

void GlContext::check(const char* where) const {
    const GLenum error = glGetError();
    if (error == GL_CONTEXT_LOST) {
        throw Error(ExitCode::io, fmt::format("the driver of {} was lost while {}", word_, where));
    }
    if (error != GL_NO_ERROR) {
        throw Error(ExitCode::io, fmt::format("OpenGL error {} while {}", error, where));
    }
}

} // namespace render
