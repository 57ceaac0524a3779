#pragma once
/// What pictures are drawn into.
#include "render/gl/handles.h"

namespace render {

/// Colour, part numbers and depth of the picture.
struct Target {
    GlFramebuffer framebuffer;
    GlRenderbuffer color;
    GlRenderbuffer ids;
    GlRenderbuffer depth;
};

/// width, height [px]; part numbers only where they are used. It stays bound. Throws Error (io) if OpenGL refuses it.
Target make_target(int width, int height, bool has_ids, GLenum color_format);

/// Of the one that is bound. Throws Error (io).
void check_framebuffer();

} // namespace render
