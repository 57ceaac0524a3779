#include "render/gl/context.h"

#include "render/gl/handles.h"
#include "sim/base/error.h"

#include <GL/osmesa.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <thread>

namespace render {

namespace {

struct ContextDeleter {
    void operator()(osmesa_context* context) const noexcept { OSMesaDestroyContext(context); }
};

std::string gl_string(GLenum name) {
    const GLubyte* text = glGetString(name);
    return text == nullptr ? "unknown" : reinterpret_cast<const char*>(text);
}

} // namespace

struct GlContext::Impl {
    /// OSMesa wants a picture of its own; all drawing goes to framebuffer objects.
    std::array<std::uint8_t, 4> pixel{};
    std::unique_ptr<osmesa_context, ContextDeleter> context;
};

void configure_gl(bool portable) {
    constexpr int keeps = 0; // what the user has set
    const unsigned cores = std::thread::hardware_concurrency();
    // Pixels are the largest part of a film's work, and one thread could not do them beside all else in time.
    setenv("LP_NUM_THREADS", std::to_string(cores > 1 ? std::max(cores - 2, 2u) : 0).c_str(), keeps);
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

GlContext::GlContext() : impl_(std::make_unique<Impl>()) {
    constexpr std::array<int, 15> attributes{OSMESA_FORMAT,
                                             OSMESA_RGBA,
                                             OSMESA_DEPTH_BITS,
                                             0,
                                             OSMESA_STENCIL_BITS,
                                             0,
                                             OSMESA_ACCUM_BITS,
                                             0,
                                             OSMESA_PROFILE,
                                             OSMESA_CORE_PROFILE,
                                             OSMESA_CONTEXT_MAJOR_VERSION,
                                             4,
                                             OSMESA_CONTEXT_MINOR_VERSION,
                                             2,
                                             0};
    impl_->context.reset(OSMesaCreateContextAttribs(attributes.data(), nullptr));
    if (impl_->context == nullptr) {
        throw sim::Error(sim::ExitCode::io, "OSMesa gives no OpenGL 4.2 core context");
    }
    if (OSMesaMakeCurrent(impl_->context.get(), impl_->pixel.data(), GL_UNSIGNED_BYTE, 1, 1) != GL_TRUE) {
        throw sim::Error(sim::ExitCode::io, "OSMesa cannot make its context current");
    }
    // The one function that the library has but does not export by name.
    const auto clip_control = reinterpret_cast<PFNGLCLIPCONTROLPROC>(OSMesaGetProcAddress("glClipControl"));
    if (clip_control == nullptr) {
        throw sim::Error(sim::ExitCode::io, "OSMesa has no glClipControl");
    }
    clip_control(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
}

GlContext::~GlContext() = default;

std::string renderer_string() {
    return GlContext().renderer_string();
}

std::string GlContext::renderer_string() const {
    return gl_string(GL_RENDERER) + ", OpenGL " + gl_string(GL_VERSION);
}

void GlContext::check(const char* where) const {
    const GLenum error = glGetError();
    if (error != GL_NO_ERROR) {
        throw sim::Error(sim::ExitCode::io,
                         std::string("OpenGL error ") + std::to_string(error) + " while " + where);
    }
}

} // namespace render
