#include "render/gl/target.h"

#include "sim/base/error.h"

namespace render {

void check_framebuffer() {
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw sim::Error(sim::ExitCode::io, "OpenGL refuses the framebuffer");
    }
}

Target make_target(int width, int height, bool has_ids, GLenum color_format) {
    Target target;
    target.framebuffer = GlFramebuffer::create();
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.get());
    const auto attach = [&](GLenum attachment, GLenum format) {
        GlRenderbuffer buffer = GlRenderbuffer::create();
        glBindRenderbuffer(GL_RENDERBUFFER, buffer.get());
        glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer.get());
        return buffer;
    };
    target.color = attach(GL_COLOR_ATTACHMENT0, color_format);
    if (has_ids) {
        target.ids = attach(GL_COLOR_ATTACHMENT1, GL_R32UI);
    }
    target.depth = attach(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F);
    constexpr GLenum attachments[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(has_ids ? 2 : 1, attachments);
    check_framebuffer();
    return target;
}

} // namespace render
