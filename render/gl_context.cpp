#include "render/gl_context.h"

#include "render/gl_handles.h"
#include "sim/error.h"

#include <GL/osmesa.h>

#include <array>
#include <cstdint>

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
