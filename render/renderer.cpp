#include "render/renderer.h"

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/gl_context.h"
#include "render/gl_handles.h"
#include "render/mesh.h"
#include "render/shader.h"
#include "sim/error.h"

#include <cstddef>
#include <cstring>
#include <map>
#include <utility>

namespace render {

namespace {

constexpr int sphere_rings_fine = 48;
constexpr int sphere_rings_coarse = 12;
constexpr int rod_sides = 16;
constexpr int lathe_sides = 96;
/// Scales radiance before the tone curve: sunlit middle grey comes out at the middle of the display's range.
constexpr float exposure = 0.5f;

/// The uniform block `Frame` of shaders/common_frame.glsl, std140.
struct FrameBlock {
    glm::mat4 clip_from_world;
    glm::mat4 world_from_clip;
    glm::mat4 shadow_from_world;
    glm::vec4 eye;
    glm::vec4 to_sun;
    glm::vec4 sun;
    glm::vec4 sky_zenith;
    glm::vec4 sky_horizon;
    glm::vec4 ground;
};

/// A mesh in GL buffers, with the instance buffer as further attributes.
struct GlMesh {
    GlVertexArray vertex_array;
    GlBuffer vertices;
    GlBuffer indices;
    GLsizei index_count = 0;
};

void set_attribute(GLuint index, int size, std::size_t stride, std::size_t offset, GLuint divisor) {
    glEnableVertexAttribArray(index);
    glVertexAttribPointer(index, size, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                          reinterpret_cast<const void*>(offset));
    glVertexAttribDivisor(index, divisor);
}

GlMesh upload(const Mesh& mesh, const GlBuffer& instances) {
    GlMesh result;
    result.vertex_array = GlVertexArray::create();
    result.vertices = GlBuffer::create();
    result.indices = GlBuffer::create();
    result.index_count = static_cast<GLsizei>(mesh.indices.size());
    glBindVertexArray(result.vertex_array.get());
    glBindBuffer(GL_ARRAY_BUFFER, result.vertices.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(Vertex)),
                 mesh.vertices.data(), GL_STATIC_DRAW);
    set_attribute(0, 3, sizeof(Vertex), offsetof(Vertex, position), 0);
    set_attribute(1, 3, sizeof(Vertex), offsetof(Vertex, normal), 0);
    glBindBuffer(GL_ARRAY_BUFFER, instances.get());
    set_attribute(2, 4, sizeof(Instance), offsetof(Instance, orientation), 1);
    set_attribute(3, 4, sizeof(Instance), offsetof(Instance, position), 1);
    set_attribute(4, 4, sizeof(Instance), offsetof(Instance, scale), 1);
    set_attribute(5, 3, sizeof(Instance), offsetof(Instance, color), 1);
    set_attribute(6, 3, sizeof(Instance), offsetof(Instance, pattern_color), 1);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, result.indices.get());
    glBufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(std::uint32_t)), mesh.indices.data(),
                 GL_STATIC_DRAW);
    return result;
}

/// A framebuffer with its attachments.
struct Target {
    GlFramebuffer framebuffer;
    GlRenderbuffer color;
    GlRenderbuffer depth;
};

GlRenderbuffer make_renderbuffer(GLenum format, int width, int height, int samples) {
    GlRenderbuffer buffer = GlRenderbuffer::create();
    glBindRenderbuffer(GL_RENDERBUFFER, buffer.get());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, width, height);
    return buffer;
}

void check_framebuffer() {
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw sim::Error(sim::ExitCode::io, "OpenGL refuses the framebuffer");
    }
}

Target make_target(int width, int height, int samples, bool has_depth) {
    Target target;
    target.framebuffer = GlFramebuffer::create();
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.get());
    target.color = make_renderbuffer(GL_RGBA8, width, height, samples);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, target.color.get());
    if (has_depth) {
        target.depth = make_renderbuffer(GL_DEPTH_COMPONENT32F, width, height, samples);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, target.depth.get());
    }
    check_framebuffer();
    return target;
}

/// Drops the alpha channel and turns the picture the right way up: OpenGL's first row is the lowest.
Image flipped_rgb(const std::vector<std::uint8_t>& rgba, int width, int height) {
    Image image(width, height);
    for (int y = 0; y < height; ++y) {
        const std::uint8_t* from = rgba.data() + static_cast<std::size_t>(height - 1 - y) * width * 4;
        std::uint8_t* to = image.rgb.data() + static_cast<std::size_t>(y) * width * 3;
        for (int x = 0; x < width; ++x) {
            to[3 * x] = from[4 * x];
            to[3 * x + 1] = from[4 * x + 1];
            to[3 * x + 2] = from[4 * x + 2];
        }
    }
    return image;
}

} // namespace

struct Renderer::Impl {
    GlContext context; // first: it outlives all names below
    const sim::SceneDef scene;
    const sim::CameraDef camera;
    Viewport viewport;
    int samples;
    LatheTable lathes;

    GlBuffer instances;
    GlBuffer frame_block;
    GlBuffer corner_buffer;
    GlVertexArray corners;
    std::vector<GlMesh> meshes; // by mesh id
    Target picture;
    Target resolved; // only with several samples
    GlFramebuffer shadow_framebuffer;
    GlTexture shadow_map;

    Program shadow_program;
    Program floor_program;
    Program sky_program;
    std::map<std::pair<bool, sim::Pattern>, Program> surface_programs; // by (is of revolution, pattern)
    std::vector<std::uint8_t> rgba;

    Impl(const sim::SceneDef& scene_def, int width, int height, const RenderSettings& settings)
        : scene(scene_def),
          camera(find_camera(scene, settings.camera.empty() ? scene.output.camera : settings.camera)),
          viewport{width, height, settings.shadow_size}, samples(settings.samples),
          lathes(make_lathe_table(scene)) {
        CHECK(width > 0 && height > 0 && settings.shadow_size > 0);
        make_meshes();
        make_targets();
        shadow_program = Program("shadow.vert", "shadow.frag");
        floor_program = Program("floor.vert", "floor.frag");
        sky_program = Program("sky.vert", "sky.frag");
        rgba.resize(static_cast<std::size_t>(width) * height * 4);
        context.check("preparing the renderer");
    }

    void make_meshes() {
        instances = GlBuffer::create();
        frame_block = GlBuffer::create();
        meshes.push_back(upload(make_box_mesh(), instances));
        meshes.push_back(upload(make_sphere_mesh(sphere_rings_fine), instances));
        meshes.push_back(upload(make_sphere_mesh(sphere_rings_coarse), instances));
        meshes.push_back(upload(make_cylinder_mesh(rod_sides), instances));
        for (const std::vector<glm::vec2>& profile : lathes.profiles) {
            meshes.push_back(upload(make_lathe_mesh(profile, lathe_sides), instances));
        }
        constexpr float corner_positions[] = {-1, -1, 1, -1, -1, 1, 1, 1, -1, -1, 3, -1, -1, 3};
        corners = GlVertexArray::create();
        corner_buffer = GlBuffer::create();
        glBindVertexArray(corners.get());
        glBindBuffer(GL_ARRAY_BUFFER, corner_buffer.get());
        glBufferData(GL_ARRAY_BUFFER, sizeof(corner_positions), corner_positions, GL_STATIC_DRAW);
        set_attribute(0, 2, 2 * sizeof(float), 0, 0);
    }

    void make_targets() {
        picture = make_target(viewport.width, viewport.height, samples, true);
        if (samples > 1) {
            resolved = make_target(viewport.width, viewport.height, 1, false);
        }
        shadow_map = GlTexture::create();
        glBindTexture(GL_TEXTURE_2D, shadow_map.get());
        glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, viewport.shadow_size, viewport.shadow_size, 0,
                     GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
        // Outside the map everything is lit.
        constexpr float border[] = {1, 1, 1, 1};
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
        glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, border);
        shadow_framebuffer = GlFramebuffer::create();
        glBindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer.get());
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, shadow_map.get(), 0);
        glDrawBuffer(GL_NONE);
        glReadBuffer(GL_NONE);
        check_framebuffer();
    }

    Image draw(const sim::Snapshot& snapshot) {
        const DrawList list = make_draw_list(scene, lathes, camera, snapshot, viewport);
        upload_frame(list);
        draw_shadow_map(list);
        draw_picture(list);
        return read_picture();
    }

    void upload_frame(const DrawList& list) {
        glBindBuffer(GL_ARRAY_BUFFER, instances.get());
        glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(list.instances.size() * sizeof(Instance)),
                     list.instances.data(), GL_STREAM_DRAW);

        // From clip coordinates (-1..1 across, 0..1 in depth) to texture coordinates.
        glm::mat4 texture_from_clip(1.0f);
        texture_from_clip[0][0] = texture_from_clip[1][1] = 0.5f;
        texture_from_clip[3][0] = texture_from_clip[3][1] = 0.5f;
        FrameBlock block{};
        block.clip_from_world = list.camera.clip_from_world;
        block.world_from_clip = list.camera.world_from_clip;
        block.shadow_from_world = texture_from_clip * list.shadow.clip_from_world;
        block.eye = glm::vec4(list.camera.eye, exposure);
        block.to_sun = glm::vec4(list.light.to_sun, list.shadow.texel_size);
        block.sun = glm::vec4(list.light.sun, static_cast<float>(viewport.shadow_size));
        block.sky_zenith = glm::vec4(list.light.sky_zenith, 0.0f);
        block.sky_horizon = glm::vec4(list.light.sky_horizon, list.floor_extent);
        block.ground = glm::vec4(list.light.ground, list.grid_spacing);
        glBindBuffer(GL_UNIFORM_BUFFER, frame_block.get());
        glBufferData(GL_UNIFORM_BUFFER, sizeof(block), &block, GL_STREAM_DRAW);
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_block.get());
    }

    void draw_batch(const Batch& batch) const {
        const GlMesh& mesh = meshes.at(static_cast<std::size_t>(batch.mesh));
        glBindVertexArray(mesh.vertex_array.get());
        glDrawElementsInstancedBaseInstance(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr,
                                            batch.count, static_cast<GLuint>(batch.first));
    }

    void draw_shadow_map(const DrawList& list) {
        glBindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer.get());
        glViewport(0, 0, viewport.shadow_size, viewport.shadow_size);
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_LESS);
        glClearDepth(1.0);
        glClear(GL_DEPTH_BUFFER_BIT);
        // Far sides only: what the sun sees is never compared with itself.
        glEnable(GL_CULL_FACE);
        glCullFace(GL_FRONT);
        shadow_program.use();
        shadow_program.set("clip_from_world_sun", list.shadow.clip_from_world);
        for (const Batch& batch : list.batches) {
            draw_batch(batch);
        }
        glCullFace(GL_BACK);
    }

    const Program& surface_program(const Batch& batch) {
        const bool is_round = batch.mesh != mesh_id::box;
        const auto key = std::make_pair(is_round, batch.pattern);
        const auto known = surface_programs.find(key);
        if (known != surface_programs.end()) {
            return known->second;
        }
        const std::string defines = "#define PATTERN " + std::to_string(static_cast<int>(batch.pattern)) +
                                    "\n#define ROUND " + (is_round ? "1" : "0") + "\n";
        return surface_programs.emplace(key, Program("surface.vert", "surface.frag", defines)).first->second;
    }

    void draw_picture(const DrawList& list) {
        glBindFramebuffer(GL_FRAMEBUFFER, picture.framebuffer.get());
        glViewport(0, 0, viewport.width, viewport.height);
        // Depth 1 is near, 0 far (see CameraBlock).
        glDepthFunc(GL_GREATER);
        glClearDepth(0.0);
        glClearColor(0, 0, 0, 1);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        glActiveTexture(GL_TEXTURE0);
        glBindTexture(GL_TEXTURE_2D, shadow_map.get());
        for (const Batch& batch : list.batches) {
            surface_program(batch).use();
            draw_batch(batch);
        }
        glBindVertexArray(corners.get());
        draw_floors(list);
        glDepthFunc(GL_EQUAL);
        glDepthMask(GL_FALSE);
        sky_program.use();
        glDrawArrays(GL_TRIANGLES, 4, 3);
        glDepthMask(GL_TRUE);
    }

    void draw_floors(const DrawList& list) {
        floor_program.use();
        for (const Floor& floor : list.floors) {
            floor_program.set("origin", floor.origin);
            floor_program.set("tangent", floor.tangent);
            floor_program.set("normal", floor.normal);
            floor_program.set("grid_origin", floor.grid_origin);
            floor_program.set("color", floor.color);
            floor_program.set("line_color", floor.line_color);
            glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
        }
    }

    Image read_picture() {
        if (samples > 1) {
            glBindFramebuffer(GL_READ_FRAMEBUFFER, picture.framebuffer.get());
            glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved.framebuffer.get());
            glBlitFramebuffer(0, 0, viewport.width, viewport.height, 0, 0, viewport.width, viewport.height,
                              GL_COLOR_BUFFER_BIT, GL_NEAREST);
            glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved.framebuffer.get());
        }
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
        glReadPixels(0, 0, viewport.width, viewport.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
        context.check("drawing a frame");
        return flipped_rgb(rgba, viewport.width, viewport.height);
    }
};

Renderer::Renderer(const sim::SceneDef& scene, int width, int height, const RenderSettings& settings)
    : impl_(std::make_unique<Impl>(scene, width, height, settings)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Image Renderer::draw(const sim::Snapshot& snapshot) {
    return impl_->draw(snapshot);
}

std::string Renderer::renderer_string() const {
    return impl_->context.renderer_string();
}

} // namespace render
