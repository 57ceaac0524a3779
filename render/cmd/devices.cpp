/// tumble devices: what OpenGL can be had from on this machine.
#include "render/cmd/options.h"
#include "render/gl/context.h"

#include <fmt/format.h>

#include <cstdio>

namespace cmd {

void list_devices(const Options&) {
    render::configure_gl(false);
    for (const render::GlDevice& device : render::gl_devices()) {
        const std::string kind = device.is_software ? "in software" : "graphics card";
        const std::string memory =
            device.memory > 0 ? fmt::format(", {:.1f} GB", 1e-9 * static_cast<double>(device.memory)) : "";
        const std::string text = device.problem.empty()
                                     ? fmt::format("{}; {}{}", device.renderer, kind, memory)
                                     : fmt::format("cannot be used: {}", device.problem);
        std::fputs(fmt::format("{:<8}{}{}\n", device.word, text, device.is_automatic ? "; auto takes it" : "").c_str(),
                   stdout);
    }
}

} // namespace cmd
