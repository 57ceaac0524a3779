/// Lets EGL's device that draws in software pass for a graphics card, egl:0, so that what is done for cards alone is
/// tested where there is none. Loaded before libEGL (LD_PRELOAD).
///
/// CARD_NODE: the card's file; without it, it has none. CARD_LOST_AFTER: so many questions for OpenGL's
/// errors are answered by the driver, then it is lost. HIDDEN_LIBRARY: part of the name of those that cannot be loaded.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <dlfcn.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

namespace {

using Function = void (*)();

char card; // its address is the handle

template <class Type>
Type real(const char* name) {
    return reinterpret_cast<Type>(dlsym(RTLD_NEXT, name));
}

Function real_address(const char* name) {
    return real<Function (*)(const char*)>("eglGetProcAddress")(name);
}

EGLBoolean query_devices(EGLint most, EGLDeviceEXT* devices, EGLint* count) {
    devices[0] = &card;
    const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(real_address("eglQueryDevicesEXT"));
    const EGLBoolean result = query(most - 1, devices + 1, count);
    ++*count;
    return result;
}

const char* query_string(EGLDeviceEXT device, EGLint name) {
    if (device == &card) {
        return name == EGL_EXTENSIONS ? "EGL_EXT_device_drm" : std::getenv("CARD_NODE");
    }
    return reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(real_address("eglQueryDeviceStringEXT"))(device, name);
}

GLenum get_error() {
    static std::atomic<int> asked = 0;
    const char* last = std::getenv("CARD_LOST_AFTER");
    if (last != nullptr && ++asked > std::atoi(last)) {
        return GL_CONTEXT_LOST;
    }
    return reinterpret_cast<PFNGLGETERRORPROC>(real_address("glGetError"))();
}

} // namespace

extern "C" {

void* dlopen(const char* name, int flags) {
    const char* hidden = std::getenv("HIDDEN_LIBRARY");
    const bool is_hidden = name != nullptr && hidden != nullptr && std::strstr(name, hidden) != nullptr;
    return real<void* (*)(const char*, int)>("dlopen")(is_hidden ? "libHidden.so" : name, flags);
}

Function eglGetProcAddress(const char* name) {
    if (std::strcmp(name, "eglQueryDevicesEXT") == 0) {
        return reinterpret_cast<Function>(query_devices);
    }
    if (std::strcmp(name, "eglQueryDeviceStringEXT") == 0) {
        return reinterpret_cast<Function>(query_string);
    }
    return std::strcmp(name, "glGetError") == 0 ? reinterpret_cast<Function>(get_error) : real_address(name);
}

EGLDisplay eglGetPlatformDisplay(EGLenum platform, void* device, const EGLAttrib* attributes) {
    EGLDeviceEXT devices[2] = {device, nullptr};
    EGLint count = 0;
    if (device == &card) {
        query_devices(2, devices, &count);
        device = devices[1];
    }
    return real<PFNEGLGETPLATFORMDISPLAYPROC>("eglGetPlatformDisplay")(platform, device, attributes);
}
}
