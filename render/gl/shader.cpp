#include "render/gl/shader.h"

#include "render/shader_texts.h"
#include "sim/base/error.h"

#include <fmt/format.h>
#include <glm/gtc/type_ptr.hpp>

#include <vector>

namespace render {

namespace {

/// The file with its #include lines replaced by the files they name.
std::string expanded_text(std::string_view name) {
    constexpr std::string_view keyword = "#include \"";
    const std::string_view text = shader_text(name);
    std::string result;
    std::size_t at = 0;
    while (at < text.size()) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = text.substr(at, end - at);
        if (line.starts_with(keyword)) {
            result += expanded_text(line.substr(keyword.size(), line.size() - keyword.size() - 1));
        } else {
            result += line;
            result += '\n';
        }
        at = end + 1;
    }
    return result;
}

GlShader compile(GLenum kind, std::string_view name, const std::string& defines) {
    const std::string text = "#version 420 core\n" + defines + expanded_text(name);
    GlShader shader(glCreateShader(kind));
    const char* source = text.c_str();
    glShaderSource(shader.get(), 1, &source, nullptr);
    glCompileShader(shader.get());
    GLint is_compiled = GL_FALSE;
    glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &is_compiled);
    if (is_compiled != GL_TRUE) {
        std::vector<char> log(4096);
        glGetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw sim::Error(sim::ExitCode::io, "shader " + std::string(name) + ": " + log.data());
    }
    return shader;
}

} // namespace

std::string_view shader_text(std::string_view name) {
    for (const ShaderText& entry : shader_texts) {
        if (entry.name == name) {
            return entry.text;
        }
    }
    CHECK(!"a shader of that name");
    return {};
}

namespace {

/// FNV-1a, carried on over several texts.
std::uint64_t carry_hash(std::uint64_t hash, std::string_view text) {
    for (const char c : text) {
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    }
    return hash;
}
constexpr std::uint64_t hash_start = 0xcbf29ce484222325;

} // namespace

std::string shaders_hash() {
    std::uint64_t hash = hash_start;
    for (const ShaderText& entry : shader_texts) {
        hash = carry_hash(carry_hash(hash, entry.name), entry.text);
    }
    return fmt::format("{:016x}", hash);
}

std::map<std::string, std::string> shader_hashes() {
    std::map<std::string, std::string> hashes;
    for (const ShaderText& entry : shader_texts) {
        hashes[std::string(entry.name)] = fmt::format("{:016x}", carry_hash(hash_start, entry.text));
    }
    return hashes;
}

Program::Program(std::string_view vertex, std::string_view fragment, const std::string& defines)
    : program_(GlProgram::create()) {
    const GlShader vertex_shader = compile(GL_VERTEX_SHADER, vertex, defines);
    const GlShader fragment_shader = compile(GL_FRAGMENT_SHADER, fragment, defines);
    glAttachShader(program_.get(), vertex_shader.get());
    glAttachShader(program_.get(), fragment_shader.get());
    glLinkProgram(program_.get());
    GLint is_linked = GL_FALSE;
    glGetProgramiv(program_.get(), GL_LINK_STATUS, &is_linked);
    if (is_linked != GL_TRUE) {
        std::vector<char> log(4096);
        glGetProgramInfoLog(program_.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw sim::Error(sim::ExitCode::io,
                         "shaders " + std::string(vertex) + ", " + std::string(fragment) + ": " + log.data());
    }
    glDetachShader(program_.get(), vertex_shader.get());
    glDetachShader(program_.get(), fragment_shader.get());
}

void Program::set(const char* name, int value) const {
    glUniform1i(location(name), value);
}
void Program::set(const char* name, float value) const {
    glUniform1f(location(name), value);
}
void Program::set(const char* name, const glm::vec2& value) const {
    glUniform2fv(location(name), 1, glm::value_ptr(value));
}
void Program::set(const char* name, const glm::vec3& value) const {
    glUniform3fv(location(name), 1, glm::value_ptr(value));
}
void Program::set(const char* name, const glm::vec4& value) const {
    glUniform4fv(location(name), 1, glm::value_ptr(value));
}
void Program::set(const char* name, const glm::mat4& value) const {
    glUniformMatrix4fv(location(name), 1, GL_FALSE, glm::value_ptr(value));
}
void Program::set(const char* name, std::uint32_t value) const {
    glUniform1ui(location(name), value);
}
void Program::set(const char* name, std::span<const glm::vec2> values) const {
    glUniform2fv(location(name), static_cast<GLsizei>(values.size()), glm::value_ptr(values.front()));
}

} // namespace render
