#pragma once
/// Owners of OpenGL names: move-only, released by the destructor while the context that made them is current.
#include "render/gl/functions.h"

#include <utility>

namespace render {

/// One name of the kind that Traits creates and destroys; 0 is none.
template <class Traits>
class GlName {
public:
    GlName() = default;
    explicit GlName(GLuint name) noexcept : name_(name) {}
    ~GlName() { reset(); }
    GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    GlName& operator=(GlName&& other) noexcept {
        if (this != &other) {
            reset();
            name_ = std::exchange(other.name_, 0);
        }
        return *this;
    }

    static GlName create() { return GlName(Traits::create()); }
    GLuint get() const noexcept { return name_; }

private:
    void reset() noexcept {
        if (name_ != 0) {
            Traits::destroy(name_);
            name_ = 0;
        }
    }

    GLuint name_ = 0;
};

struct BufferTraits {
    static GLuint create() {
        GLuint name = 0;
        glGenBuffers(1, &name);
        return name;
    }
    static void destroy(GLuint name) noexcept { glDeleteBuffers(1, &name); }
};
using GlBuffer = GlName<BufferTraits>;

struct VertexArrayTraits {
    static GLuint create() {
        GLuint name = 0;
        glGenVertexArrays(1, &name);
        return name;
    }
    static void destroy(GLuint name) noexcept { glDeleteVertexArrays(1, &name); }
};
using GlVertexArray = GlName<VertexArrayTraits>;

struct TextureTraits {
    static GLuint create() {
        GLuint name = 0;
        glGenTextures(1, &name);
        return name;
    }
    static void destroy(GLuint name) noexcept { glDeleteTextures(1, &name); }
};
using GlTexture = GlName<TextureTraits>;

struct RenderbufferTraits {
    static GLuint create() {
        GLuint name = 0;
        glGenRenderbuffers(1, &name);
        return name;
    }
    static void destroy(GLuint name) noexcept { glDeleteRenderbuffers(1, &name); }
};
using GlRenderbuffer = GlName<RenderbufferTraits>;

struct FramebufferTraits {
    static GLuint create() {
        GLuint name = 0;
        glGenFramebuffers(1, &name);
        return name;
    }
    static void destroy(GLuint name) noexcept { glDeleteFramebuffers(1, &name); }
};
using GlFramebuffer = GlName<FramebufferTraits>;

/// Shaders and programs are created by kind (shader.cpp), so only their end is here.
struct ShaderTraits {
    static void destroy(GLuint name) noexcept { glDeleteShader(name); }
};
using GlShader = GlName<ShaderTraits>;

struct ProgramTraits {
    static GLuint create() { return glCreateProgram(); }
    static void destroy(GLuint name) noexcept { glDeleteProgram(name); }
};
using GlProgram = GlName<ProgramTraits>;

} // namespace render
