#pragma once
/// An OpenGL context without a window, in software or of a graphics card. Belongs to the thread that made it.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace render {

/// To be called before the program's first thread: how OpenGL is to use the processor, unless the environment
/// says it. Where two cores are all there is, OpenGL draws in the thread that calls it: the other stages of a
/// film need the rest. portable: no instructions beyond SSE4.1, so that processors with and without fused
/// multiply-add draw the same.
void configure_gl(bool portable);

/// What the bytes of a picture depend on beside program, scene and libraries: "x86-64, fused multiply-add".
std::string processor_class();

/// What a context can be had from.
struct GlDevice {
    std::string word;         ///< as output.gl and --gl name it: "osmesa", "egl" (both in software), "egl:0"
    std::string renderer{};   ///< GlContext::renderer_string()
    std::int64_t memory = 0;  ///< [bytes] of the graphics card; 0: it does not say, or draws in main memory
    bool is_software = false;
    bool is_automatic = false; ///< what "auto" takes
    std::string problem{};     ///< why it cannot be used; empty: it can
};

/// All there are, each tried.
std::vector<GlDevice> gl_devices();

/// Name and version of OpenGL, as of any context of this word. Throws Error as GlContext does.
std::string renderer_string(const std::string& word);

class GlContext {
public:
    /// Creates a core-profile context and makes it current in this thread; depth in clip space is 0..1, not
    /// -1..1. word: "auto", or a GlDevice's. Throws Error (io) if there is no such device, or if it offers no OpenGL
    /// 4.2 with that depth range.
    explicit GlContext(const std::string& word);
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    /// Name and version of the renderer, for manifests: pictures are compared within one such name.
    std::string renderer_string() const;

    bool is_software() const { return is_software_; }

    /// Throws Error (io) if an OpenGL call since the last check failed. where: what was being done.
    void check(const char* where) const;

private:
    std::string word_; ///< not "auto"
    bool is_software_;
    std::shared_ptr<void> owner_; ///< of the platform's context
};

} // namespace render
