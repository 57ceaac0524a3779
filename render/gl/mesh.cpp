#include "render/gl/mesh.h"

#include <algorithm>

namespace render {

namespace {

/// Where an attribute lies in its buffer [bytes], and how often it advances.
struct Layout {
    std::size_t stride;
    std::size_t offset;
    GLuint divisor;
};

void set_floats(GLuint index, int count, const Layout& layout) {
    glEnableVertexAttribArray(index);
    glVertexAttribPointer(index, count, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(layout.stride),
                          reinterpret_cast<const void*>(layout.offset));
    glVertexAttribDivisor(index, layout.divisor);
}

void set_number(GLuint index, const Layout& layout) {
    glEnableVertexAttribArray(index);
    glVertexAttribIPointer(index, 1, GL_UNSIGNED_INT, static_cast<GLsizei>(layout.stride),
                           reinterpret_cast<const void*>(layout.offset));
    glVertexAttribDivisor(index, layout.divisor);
}

} // namespace

GlMesh upload_mesh(const Mesh& mesh, const GlBuffer& instances) {
    GlMesh result{GlVertexArray::create(), GlBuffer::create(), GlBuffer::create(),
                  static_cast<GLsizei>(mesh.indices.size())};
    glBindVertexArray(result.vertex_array.get());
    glBindBuffer(GL_ARRAY_BUFFER, result.vertices.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(Vertex)),
                 mesh.vertices.data(), GL_STATIC_DRAW);
    set_floats(0, 3, {sizeof(Vertex), offsetof(Vertex, position), 0});
    set_floats(1, 3, {sizeof(Vertex), offsetof(Vertex, normal), 0});
    set_number(2, {sizeof(Vertex), offsetof(Vertex, group), 0});
    for (GLuint k = 0; k < 3; ++k) {
        set_floats(9 + k, 3, {sizeof(Vertex), offsetof(Vertex, faces) + k * sizeof(glm::vec3), 0});
    }
    set_floats(12, 3, {sizeof(Vertex), offsetof(Vertex, inside), 0});
    glBindBuffer(GL_ARRAY_BUFFER, instances.get());
    set_floats(3, 4, {sizeof(Instance), offsetof(Instance, orientation), 1});
    set_floats(4, 4, {sizeof(Instance), offsetof(Instance, position), 1});
    set_floats(5, 4, {sizeof(Instance), offsetof(Instance, scale), 1});
    set_floats(6, 3, {sizeof(Instance), offsetof(Instance, color), 1});
    set_floats(7, 3, {sizeof(Instance), offsetof(Instance, pattern_color), 1});
    set_number(8, {sizeof(Instance), offsetof(Instance, id), 1});
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, result.indices.get());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(std::uint32_t)), mesh.indices.data(),
                 GL_STATIC_DRAW);
    return result;
}

ElementArray::ElementArray(std::span<const std::uint32_t> indices, std::uint32_t vertices_each)
    : vertex_array_(GlVertexArray::create()), buffer_(GlBuffer::create()),
      pattern_(indices.begin(), indices.end()), vertices_each_(vertices_each) {}

void ElementArray::draw(int first, int count) {
    glBindVertexArray(vertex_array_.get());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer_.get());
    if (first + count > capacity_) {
        capacity_ = std::max(first + count, 2 * capacity_);
        std::vector<std::uint32_t> indices;
        indices.reserve(static_cast<std::size_t>(capacity_) * pattern_.size());
        for (int i = 0; i < capacity_; ++i) {
            for (const std::uint32_t index : pattern_) {
                indices.push_back(static_cast<std::uint32_t>(i) * vertices_each_ + index);
            }
        }
        glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(std::uint32_t)),
                     indices.data(), GL_STATIC_DRAW);
    }
    const std::size_t offset = static_cast<std::size_t>(first) * pattern_.size() * sizeof(std::uint32_t);
    glDrawElements(GL_TRIANGLES, count * static_cast<GLsizei>(pattern_.size()), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(offset));
}

void TriangleList::make() {
    vertex_array_ = GlVertexArray::create();
    buffer_ = GlBuffer::create();
}

void TriangleList::draw(std::span<const std::uint32_t> indices) const {
    glBindVertexArray(vertex_array_.get());
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer_.get());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size_bytes()), indices.data(),
                 GL_STREAM_DRAW);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(indices.size()), GL_UNSIGNED_INT, nullptr);
}

TexelTable make_texel_table() {
    TexelTable table{GlBuffer::create(), GlTexture::create()};
    upload_texels(table, nullptr, 16);
    glBindTexture(GL_TEXTURE_BUFFER, table.texture.get());
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, table.buffer.get());
    return table;
}

void upload_texels(const TexelTable& table, const void* data, std::size_t size) {
    glBindBuffer(GL_TEXTURE_BUFFER, table.buffer.get());
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(std::max<std::size_t>(size, 16)),
                 size > 0 ? data : nullptr, GL_STREAM_DRAW);
}

GlTexture make_float_texture(GLenum target, float border) {
    GlTexture texture = GlTexture::create();
    glBindTexture(target, texture.get());
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    const float color[] = {border, border, border, border};
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
        glTexParameteri(target, axis, GL_CLAMP_TO_BORDER);
    }
    glTexParameterfv(target, GL_TEXTURE_BORDER_COLOR, color);
    return texture;
}

} // namespace render
