#pragma once
/// An OpenGL context without a window (OSMesa, software). Belongs to the thread that made it.
#include <memory>
#include <string>

namespace render {

/// To be called before the program's first thread: how OpenGL is to use the processor, unless the environment
/// says it. Where two cores are all there is, OpenGL draws in the thread that calls it: the other stages of a
/// film need the rest. portable: no instructions beyond SSE4.1, so that processors with and without fused
/// multiply-add draw the same.
void configure_gl(bool portable);

/// What the bytes of a picture depend on beside program, scene and libraries: "x86-64, fused multiply-add".
std::string processor_class();

/// Name and version of OpenGL, as of any context made here. Throws Error (io) if none can be made.
std::string renderer_string();

class GlContext {
public:
    /// Creates a core-profile context and makes it current in this thread; depth in clip space is 0..1, not
    /// -1..1. Throws Error (io) if the library offers no OpenGL 4.2 with that depth range.
    GlContext();
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    /// Name and version of the renderer, for manifests: pictures are compared within one such name.
    std::string renderer_string() const;

    /// Throws Error (io) if an OpenGL call since the last check failed. where: what was being done.
    void check(const char* where) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace render
