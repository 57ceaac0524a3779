#pragma once
/// An OpenGL context without a window (OSMesa, software). Belongs to the thread that made it.
#include <memory>
#include <string>

namespace render {

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
