/// OpenGL of a graphics card or in software, through EGL without a window and without a surface.
#include "render/gl/platform.h"
#include "sim/base/error.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <unistd.h>

namespace render {

namespace {

/// Destroyed in the thread that made it. The display stays open: other threads may draw on it.
struct EglContext {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;

    EglContext() = default;
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;
    ~EglContext() {
        if (context != EGL_NO_CONTEXT) {
            eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
            eglDestroyContext(display, context);
            eglReleaseThread();
        }
    }
};

[[noreturn]] void fail(const EglDevice& device, const std::string& reason) {
    const std::string where = device.node.empty() ? "" : " of " + device.node;
    throw sim::Error(sim::ExitCode::io, fmt::format("EGL{}: {}", where, reason));
}

/// A whole word of a list separated by spaces.
bool has_word(const char* list, std::string_view word) {
    for (std::string_view rest = list == nullptr ? "" : list; !rest.empty();) {
        const std::size_t end = std::min(rest.find(' '), rest.size());
        if (rest.substr(0, end) == word) {
            return true;
        }
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return false;
}

template <class Function>
Function find_extension(const char* name) {
    return reinterpret_cast<Function>(eglGetProcAddress(name));
}

EglDevice describe(EGLDeviceEXT handle) {
    const auto query = find_extension<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    const char* extensions = query(handle, EGL_EXTENSIONS);
    EglDevice device{.handle = handle, .is_software = has_word(extensions, "EGL_MESA_device_software")};
    for (const auto& [extension, name] : {std::pair("EGL_EXT_device_drm", EGL_DRM_DEVICE_FILE_EXT),
                                          std::pair("EGL_EXT_device_drm_render_node", EGL_DRM_RENDER_NODE_FILE_EXT)}) {
        if (const char* node = has_word(extensions, extension) ? query(handle, name) : nullptr; node != nullptr) {
            device.node = node;
        }
    }
    return device;
}

EGLDisplay open_display(const EglDevice& device) {
    if (!device.node.empty() && ::access(device.node.c_str(), R_OK | W_OK) != 0) {
        fail(device, std::strerror(errno));
    }
    const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (device.handle == nullptr && !has_word(extensions, "EGL_MESA_platform_surfaceless")) {
        fail(device, "it has neither a device that draws in software nor the surfaceless platform; expected Mesa's "
                     "drivers (Debian: libegl-mesa0, libgl1-mesa-dri)");
    }
    if (device.handle == nullptr) {
        setenv("LIBGL_ALWAYS_SOFTWARE", "true", 1); // else this platform takes a graphics card where there is one
    }
    const EGLenum platform = device.handle == nullptr ? EGL_PLATFORM_SURFACELESS_MESA : EGL_PLATFORM_DEVICE_EXT;
    const EGLDisplay display =
        eglGetPlatformDisplay(platform, device.handle == nullptr ? EGL_DEFAULT_DISPLAY : device.handle, nullptr);
    EGLint major = 0;
    EGLint minor = 0;
    if (display == EGL_NO_DISPLAY || eglInitialize(display, &major, &minor) != EGL_TRUE) {
        fail(device, fmt::format("its driver does not start (error {:#x})", eglGetError()));
    }
    return display;
}

} // namespace

std::vector<EglDevice> egl_devices() {
    if (!has_word(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_EXT_device_enumeration")) {
        return {};
    }
    constexpr EGLint most = 64;
    std::array<EGLDeviceEXT, most> handles{};
    EGLint count = 0;
    if (find_extension<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT")(most, handles.data(), &count) != EGL_TRUE) {
        return {};
    }
    std::vector<EglDevice> devices;
    for (EGLint i = 0; i < count; ++i) {
        devices.push_back(describe(handles[static_cast<std::size_t>(i)]));
    }
    return devices;
}

PlatformContext make_egl_context(const EglDevice& device) {
    const auto owner = std::make_shared<EglContext>();
    owner->display = open_display(device);
    const char* extensions = eglQueryString(owner->display, EGL_EXTENSIONS);
    for (const char* needed : {"EGL_KHR_surfaceless_context", "EGL_KHR_no_config_context"}) {
        if (!has_word(extensions, needed)) {
            fail(device, fmt::format("its driver has no {}", needed));
        }
    }
    std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                   4,
                                   EGL_CONTEXT_MINOR_VERSION,
                                   2,
                                   EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                   EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
    if (has_word(extensions, "EGL_EXT_create_context_robustness")) {
        // A driver that is lost says so, instead of drawing nothing.
        attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
    }
    attributes.push_back(EGL_NONE);
    if (eglBindAPI(EGL_OPENGL_API) == EGL_TRUE) {
        owner->context =
            eglCreateContext(owner->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    }
    if (owner->context == EGL_NO_CONTEXT) {
        fail(device, "its driver gives no OpenGL 4.2 core context");
    }
    if (eglMakeCurrent(owner->display, EGL_NO_SURFACE, EGL_NO_SURFACE, owner->context) != EGL_TRUE) {
        fail(device, "its driver cannot make its context current");
    }
    return {owner, [](const char* name) -> GlFunction { return eglGetProcAddress(name); }};
}

} // namespace render
