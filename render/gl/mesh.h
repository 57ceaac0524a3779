#pragma once
/// Geometry in OpenGL buffers.
#include "render/gl/handles.h"
#include "render/scene/draw_types.h"
#include "render/scene/mesh.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace render {

/// A mesh with an instance buffer as further attributes (locations of shaders/round.vert).
struct GlMesh {
    GlVertexArray vertex_array;
    GlBuffer vertices;
    GlBuffer indices;
    GLsizei index_count = 0;
};
GlMesh upload_mesh(const Mesh& mesh, const GlBuffer& instances);

/// Vertices without attributes: the vertex shader finds all it needs by their number. Elements of the same
/// kind, each of `vertices_each` vertices, are drawn `indices` each.
class ElementArray {
public:
    ElementArray() = default;
    ElementArray(std::span<const std::uint32_t> indices, std::uint32_t vertices_each);

    /// Draws `count` elements from number `first` on.
    void draw(int first, int count);

private:
    GlVertexArray vertex_array_;
    GlBuffer buffer_;
    std::vector<std::uint32_t> pattern_;
    std::uint32_t vertices_each_ = 0;
    int capacity_ = 0; ///< elements in the buffer
};

/// Triangles that change from picture to picture, of vertices that are told from their number alone.
class TriangleList {
public:
    void make();
    /// Three indices a triangle.
    void draw(std::span<const std::uint32_t> indices) const;

private:
    GlVertexArray vertex_array_;
    GlBuffer buffer_;
};

/// Numbers that shaders read as a table of texels of four floats.
struct TexelTable {
    GlBuffer buffer;
    GlTexture texture;
};
TexelTable make_texel_table();
/// Replaces the content. size in bytes.
void upload_texels(const TexelTable& table, const void* data, std::size_t size);

/// A float texture of one channel with linear interpolation; what lies outside reads `border`.
GlTexture make_float_texture(GLenum target, float border);

} // namespace render
