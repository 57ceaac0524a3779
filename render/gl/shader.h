#pragma once
/// Shader programs from the texts in shaders/, which the build places in the program.
#include "render/gl/handles.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

namespace render {

/// Text of one file of shaders/. The name must be one of them: CHECK.
std::string_view shader_text(std::string_view name);

/// FNV-1a of all files of shaders/, 16 hexadecimal digits: which drawing this program makes.
std::string shaders_hash();

/// The same of each file, by its name.
std::map<std::string, std::string> shader_hashes();

/// A linked program. Files may #include others of shaders/ by a line of its own.
class Program {
public:
    Program() = default;
    /// vertex, fragment: file names. defines: lines placed before the text.
    /// Throws Error (io) with the compiler's message.
    Program(std::string_view vertex, std::string_view fragment, const std::string& defines = {});

    void use() const { glUseProgram(program_.get()); }

    /// Sets a uniform of the program in use; one that the compiler removed is passed over.
    void set(const char* name, int value) const;
    void set(const char* name, float value) const;
    void set(const char* name, const glm::vec2& value) const;
    void set(const char* name, const glm::vec3& value) const;
    void set(const char* name, const glm::vec4& value) const;
    void set(const char* name, const glm::mat4& value) const;
    void set(const char* name, std::uint32_t value) const;
    void set(const char* name, std::span<const glm::vec2> values) const;

private:
    GLint location(const char* name) const { return glGetUniformLocation(program_.get(), name); }

    GlProgram program_;
};

} // namespace render
