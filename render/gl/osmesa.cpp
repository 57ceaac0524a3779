/// OpenGL in software, of a library of its own.
#include "render/gl/platform.h"
#include "sim/base/error.h"

#include <GL/osmesa.h>

#include <array>

namespace render {

namespace {

/// OSMesa wants a picture of its own; all drawing goes to framebuffer objects.
struct OsmesaContext {
    std::array<unsigned char, 4> pixel{};
    OSMesaContext context = nullptr;

    OsmesaContext() = default;
    OsmesaContext(const OsmesaContext&) = delete;
    OsmesaContext& operator=(const OsmesaContext&) = delete;
    ~OsmesaContext() {
        if (context != nullptr) {
            OSMesaDestroyContext(context);
        }
    }
};

} // namespace

PlatformContext make_osmesa_context() {
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
    const auto owner = std::make_shared<OsmesaContext>();
    owner->context = OSMesaCreateContextAttribs(attributes.data(), nullptr);
    if (owner->context == nullptr) {
        throw sim::Error(sim::ExitCode::io, "OSMesa gives no OpenGL 4.2 core context");
    }
    if (OSMesaMakeCurrent(owner->context, owner->pixel.data(), GL_UNSIGNED_BYTE, 1, 1) != GL_TRUE) {
        throw sim::Error(sim::ExitCode::io, "OSMesa cannot make its context current");
    }
    return {owner, [](const char* name) -> GlFunction { return OSMesaGetProcAddress(name); }};
}

} // namespace render
