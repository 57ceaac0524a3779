#pragma once
/// Where contexts come from: osmesa.cpp and egl.cpp. Only context.cpp sees this.
#include "render/gl/functions.h"

#include <memory>
#include <string>
#include <vector>

namespace render {

/// A core-profile context of OpenGL 4.2 or later, current in the thread that made it until the owner is destroyed.
struct PlatformContext {
    std::shared_ptr<void> owner{};
    GlFunction (*find)(const char* name) = nullptr; ///< a function's address by its name, or null
};

/// Whether this machine has the library; it is loaded then.
bool has_osmesa();

/// In software. Throws Error (io).
PlatformContext make_osmesa_context();

/// A device of EGL's, or none where EGL has one platform for all.
struct EglDevice {
    void* handle = nullptr; ///< of EGL; null: the surfaceless platform
    std::string node{};     ///< "/dev/dri/renderD128", or empty
    bool is_software = false;
};

/// In EGL's order; none without EGL's list of devices.
std::vector<EglDevice> egl_devices();

/// Throws Error (io): what the device lacks, or that its node may not be opened.
PlatformContext make_egl_context(const EglDevice& device);

} // namespace render
