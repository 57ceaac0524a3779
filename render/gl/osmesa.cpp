/// OpenGL in software, of a library of its own: loaded when something is to be drawn, for it takes as long to load as all others
/// together; where there is none, EGL draws. Its header is not needed, so that all builds are the same: what is used of it has
/// not changed since Mesa 11.2.
#include "render/gl/platform.h"
#include "sim/base/error.h"

#include <array>
#include <dlfcn.h>
#include <type_traits>

namespace render {

namespace {

struct OsmesaLibrary {
    using Context = struct osmesa_context*;
    Context (*create)(const int* attributes, Context shared) = nullptr;
    void (*destroy)(Context context) = nullptr;
    unsigned char (*make_current)(Context context, void* pixels, GLenum type, int width, int height) = nullptr;
    GlFunction (*find)(const char* name) = nullptr;
    std::string problem{}; ///< why it cannot be loaded; else empty

    OsmesaLibrary() {
        void* const handle = dlopen("libOSMesa.so.8", RTLD_LAZY | RTLD_LOCAL);
        const auto load = [&](auto& function, const char* name) {
            if (problem.empty()) {
                function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(handle, name));
                problem = function == nullptr ? dlerror() : "";
            }
        };
        if (handle == nullptr) {
            problem = dlerror();
        }
        load(create, "OSMesaCreateContextAttribs");
        load(destroy, "OSMesaDestroyContext");
        load(make_current, "OSMesaMakeCurrent");
        load(find, "OSMesaGetProcAddress");
    }
};

/// Loaded once; it stays until the program ends.
const OsmesaLibrary& osmesa() {
    static const OsmesaLibrary loaded;
    return loaded;
}

/// OSMesa wants a picture of its own; all drawing goes to framebuffer objects.
struct OsmesaContext {
    std::array<unsigned char, 4> pixel{};
    OsmesaLibrary::Context context = nullptr;

    OsmesaContext() = default;
    OsmesaContext(const OsmesaContext&) = delete;
    OsmesaContext& operator=(const OsmesaContext&) = delete;
    ~OsmesaContext() {
        if (context != nullptr) {
            osmesa().destroy(context);
        }
    }
};

} // namespace

bool has_osmesa() {
    return osmesa().problem.empty();
}

PlatformContext make_osmesa_context() {
    // As GL/osmesa.h has them.
    constexpr int format = 0x22;
    constexpr int depth_bits = 0x30;
    constexpr int stencil_bits = 0x31;
    constexpr int accum_bits = 0x32;
    constexpr int profile = 0x33;
    constexpr int core_profile = 0x34;
    constexpr int major_version = 0x36;
    constexpr int minor_version = 0x37;
    constexpr std::array attributes{format,  GL_RGBA,      depth_bits,    0, stencil_bits,  0, accum_bits, 0,
                                    profile, core_profile, major_version, 4, minor_version, 2, 0};
    if (!has_osmesa()) {
        throw sim::Error(sim::ExitCode::io, "OSMesa cannot be loaded: " + osmesa().problem);
    }
    const auto owner = std::make_shared<OsmesaContext>();
    owner->context = osmesa().create(attributes.data(), nullptr);
    if (owner->context == nullptr) {
        throw sim::Error(sim::ExitCode::io, "OSMesa gives no OpenGL 4.2 core context");
    }
    if (osmesa().make_current(owner->context, owner->pixel.data(), GL_UNSIGNED_BYTE, 1, 1) != GL_TRUE) {
        throw sim::Error(sim::ExitCode::io, "OSMesa cannot make its context current");
    }
    return {owner, osmesa().find};
}

} // namespace render
