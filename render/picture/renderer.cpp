#include "render/picture/renderer.h"

#include "render/gl/context.h"
#include "render/gl/handles.h"
#include "render/gl/mesh.h"
#include "render/gl/shader.h"
#include "render/gl/target.h"
#include "render/picture/picture_reader.h"
#include "render/scene/mesh.h"
#include "render/scene/parts.h"
#include "sim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <deque>
#include <map>
#include <utility>

namespace render {

namespace {

constexpr std::array<int, mesh_id::sphere_count> sphere_rings{8, 16, 32, 64};
constexpr int rod_sides = 16;
constexpr int mirrored_rays = 4; ///< a pixel
/// Scales radiance before the tone curve: sunlit middle grey comes out at the middle of the display's range.
constexpr float exposure = 0.42f;

/// The uniform block `Frame` of shaders/common_frame.glsl, std140.
struct FrameBlock {
    glm::mat4 clip_from_world;
    glm::mat4 world_from_clip;
    glm::mat4 shadow_from_world;
    glm::vec4 eye;
};

std::string glsl(float value) {
    return fmt::format("float({:.9g})", value); // enough digits to give the same float
}
std::string glsl(const glm::vec3& v) {
    return fmt::format("vec3({:.9g}, {:.9g}, {:.9g})", v.x, v.y, v.z);
}
std::string glsl(const glm::vec4& v) {
    return fmt::format("vec4({:.9g}, {:.9g}, {:.9g}, {:.9g})", v.x, v.y, v.z, v.w);
}

/// What is the same in all frames of a scene, as constants of all shaders (see shaders/common_frame.glsl).
std::string scene_constants(const SceneGeometry& geometry, int shadow_size) {
    const LightBlock& light = geometry.light;
    std::string text;
    const auto add = [&text](const char* type, const char* name, const std::string& value) {
        text += fmt::format("const {} {} = {};\n", type, name, value);
    };
    add("float", "exposure", glsl(exposure));
    add("vec3", "to_sun", glsl(light.to_sun));
    add("vec3", "sun_radiance", glsl(light.sun)); // irradiance / pi
    add("vec3", "sky_zenith", glsl(light.sky_zenith));
    add("vec3", "sky_horizon", glsl(light.sky_horizon));
    add("vec3", "ground_radiance", glsl(light.ground)); // seen below the horizon
    add("float", "floor_extent", glsl(geometry.floor_extent));
    add("float", "grid_spacing", glsl(geometry.grid_spacing));
    add("vec4", "floor_plane", glsl(geometry.floor_plane));
    add("vec3", "floor_color", glsl(geometry.floor_color));
    add("float", "shadow_map_size", glsl(static_cast<float>(shadow_size)));
    return text;
}

/// Texture units, fixed for all programs.
namespace unit {
constexpr int shadow_map = 0;
constexpr int faces = 1;
constexpr int boxes = 2;
constexpr int sky_atlas = 3;
constexpr int occlusion_floor = 4;
constexpr int occlusion_first = 5; ///< and one for each further level
} // namespace unit

void bind_texture(int texture_unit, GLenum target, const GlTexture& texture) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(texture_unit));
    glBindTexture(target, texture.get());
}

/// From clip coordinates (-1..1 across, 0..1 in depth) to texture coordinates.
glm::mat4 texture_from_clip() {
    glm::mat4 result(1.0f);
    result[0][0] = result[1][1] = 0.5f;
    result[3][0] = result[3][1] = 0.5f;
    return result;
}

} // namespace

struct Renderer::Impl {
    GlContext context; // first: it outlives all names below
    std::shared_ptr<const PicturePlan> plan;
    Viewport viewport;
    std::string constants; ///< of all shaders

    GlBuffer instances;
    GlBuffer frame_block;
    GlBuffer mirrored_block;
    std::vector<std::vector<GlMesh>> meshes; // by mesh id, from coarse to fine
    ElementArray face_array;
    TriangleList far_sides; ///< of boxes, seen from the sun
    ElementArray floor_inside;
    ElementArray floor_ring;
    ElementArray sky_array;
    TexelTable faces;
    TexelTable boxes;
    std::array<GlTexture, OcclusionVolume::level_count> occlusion;
    GlTexture occlusion_floor;
    GlTexture sky_atlas;
    Target picture;
    Target deep_picture;
    std::deque<std::vector<std::uint16_t>> deep; ///< of pictures that are begun and not finished
    GlFramebuffer shadow_framebuffer;
    GlTexture shadow_map;

    Program shadow_box_program;
    Program shadow_round_program;
    Program floor_inside_program;
    Program floor_ring_program;
    Program sky_program;
    std::map<FaceKind, Program> face_programs;
    std::map<std::array<int, 4>, Program> round_programs; // by (pattern, is metal, mirrored spheres, mirrored boxes)
    RawPicture raw;
    DrawList last_list; ///< of the last picture
    DepthPicture last_depth;
    PictureReader reader;

    explicit Impl(std::shared_ptr<const PicturePlan> picture_plan)
        : context(picture_plan->settings().gl), plan(std::move(picture_plan)), viewport(plan->viewport()),
          constants(std::string("#define SOFT_SHADOWS ") + (plan->settings().soft_shadows ? "1" : "0") +
                    "\n" + scene_constants(plan->geometry(), viewport.shadow_size) +
                    plan->settings().shader_lines) {
        make_geometry();
        make_targets();
        shadow_box_program = Program("shadow_box.vert", "shadow.frag", constants);
        shadow_round_program = Program("shadow_round.vert", "shadow.frag", constants);
        floor_inside_program = Program("floor.vert", "floor.frag", "#define SHADOWED 1\n" + constants);
        floor_ring_program = Program("floor.vert", "floor.frag", "#define SHADOWED 0\n" + constants);
        sky_program = Program("sky.vert", "sky.frag", constants);
        // In software the drawing is the processor's own work: buffers would only add a copy.
        reader = PictureReader(viewport.width, viewport.height, plan->settings().reads_ids, !context.is_software());
        context.check("preparing the renderer");
    }

    void make_geometry() {
        instances = GlBuffer::create();
        frame_block = GlBuffer::create();
        mirrored_block = GlBuffer::create();
        const auto upload = [&](const Mesh& mesh) { meshes.emplace_back().push_back(upload_mesh(mesh, instances)); };
        for (const int rings : sphere_rings) {
            upload(make_sphere_mesh(rings));
        }
        upload(make_lathe_mesh(rod_profile(), rod_sides));
        for (const std::vector<glm::vec2>& profile : plan->geometry().profiles) {
            meshes.emplace_back();
            for (const int sides : lathe_sides) {
                meshes.back().push_back(upload_mesh(make_lathe_mesh(profile, sides), instances));
            }
        }
        for (const std::vector<HullFace>& hull : plan->geometry().hulls) {
            upload(make_hull_mesh(hull));
        }
        constexpr std::uint32_t quad[] = {0, 1, 3, 0, 3, 2};
        // Corners of a floor's region, then the same moved outwards.
        constexpr std::uint32_t corner_count = std::tuple_size_v<FloorRegion>;
        std::vector<std::uint32_t> fan;
        std::vector<std::uint32_t> ring;
        for (std::uint32_t i = 0; i < corner_count; ++i) {
            const std::uint32_t j = (i + 1) % corner_count;
            ring.insert(ring.end(), {i, i + corner_count, j + corner_count, i, j + corner_count, j});
            if (i > 0 && j > 0) {
                fan.insert(fan.end(), {0, i, j});
            }
        }
        constexpr std::uint32_t triangle[] = {0, 1, 2};
        face_array = ElementArray(quad, 4);
        far_sides.make();
        floor_inside = ElementArray(fan, 2 * corner_count);
        floor_ring = ElementArray(ring, 2 * corner_count);
        sky_array = ElementArray(triangle, 3);
        faces = make_texel_table();
        boxes = make_texel_table();
    }

    void make_targets() {
        picture = make_target(viewport.width, viewport.height, plan->settings().reads_ids, GL_RGBA8);
        if (plan->settings().is_deep) {
            deep_picture = make_target(viewport.width, viewport.height, false, GL_RGBA16);
        }
        for (GlTexture& level : occlusion) {
            level = make_float_texture(GL_TEXTURE_3D, 0.0f);
        }
        occlusion_floor = make_float_texture(GL_TEXTURE_2D, 1.0f);
        sky_atlas = make_float_texture(GL_TEXTURE_2D, 1.0f);
        // Outside the map everything is lit.
        shadow_map = make_float_texture(GL_TEXTURE_2D, 1.0f);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, viewport.shadow_size, viewport.shadow_size, 0,
                     GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
        shadow_framebuffer = GlFramebuffer::create();
        glBindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer.get());
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, shadow_map.get(), 0);
        glDrawBuffer(GL_NONE);
        glReadBuffer(GL_NONE);
        check_framebuffer();
    }

    void begin(const DrawList& list, bool has_depth) {
        upload_frame(list);
        draw_shadow_map(list);
        if (plan->settings().is_deep) {
            draw_picture(list, deep_picture);
            read_deep(list.redrawn);
        }
        draw_picture(list, picture); // the last: it is read later
        reader.begin(list.camera.clip_from_world, list.redrawn, has_depth);
        if (!context.is_software()) {
            glFlush(); // the card begins
        }
        context.check("drawing a frame");
    }

    void finish(RawPicture& to, DepthPicture& depth) {
        reader.finish(to, depth);
        if (!deep.empty()) {
            to.deep = std::move(deep.front());
            deep.pop_front();
        }
        context.check("reading a frame");
    }

    void upload_frame(const DrawList& list) {
        glBindBuffer(GL_ARRAY_BUFFER, instances.get());
        glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(list.rounds.size() * sizeof(Instance)),
                     list.rounds.data(), GL_STREAM_DRAW);
        upload_texels(faces, list.faces.data(), list.faces.size() * sizeof(Face));
        upload_texels(boxes, list.boxes.data(), list.boxes.size() * sizeof(Instance));

        FrameBlock block{};
        block.clip_from_world = list.camera.clip_from_world;
        block.world_from_clip = list.camera.world_from_clip;
        block.shadow_from_world = texture_from_clip() * list.shadow.clip_from_world;
        block.eye = glm::vec4(list.camera.eye, list.shadow.texel_size);
        glBindBuffer(GL_UNIFORM_BUFFER, frame_block.get());
        glBufferData(GL_UNIFORM_BUFFER, sizeof(block), &block, GL_STREAM_DRAW);
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_block.get());
        if (!list.mirrored.is_empty()) {
            glBindBuffer(GL_UNIFORM_BUFFER, mirrored_block.get());
            glBufferData(GL_UNIFORM_BUFFER, sizeof(MirroredBlock), &list.mirrored.block, GL_STREAM_DRAW);
            glBindBufferBase(GL_UNIFORM_BUFFER, 1, mirrored_block.get());
        }

        bind_texture(unit::shadow_map, GL_TEXTURE_2D, shadow_map);
        bind_texture(unit::faces, GL_TEXTURE_BUFFER, faces.texture);
        bind_texture(unit::boxes, GL_TEXTURE_BUFFER, boxes.texture);
        bind_texture(unit::sky_atlas, GL_TEXTURE_2D, sky_atlas);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, SkyAtlas::width, list.sky_atlas.height, 0, GL_RED, GL_FLOAT,
                     list.sky_atlas.open.data());
        for (int k = 0; k < OcclusionVolume::level_count && !list.rounds.empty(); ++k) {
            bind_texture(unit::occlusion_first + k, GL_TEXTURE_3D, occlusion[static_cast<std::size_t>(k)]);
            upload_level(list.occlusion.level(k));
        }
    }

    /// Into the 3D texture of the current unit; without bodies a single empty cell.
    static void upload_level(const OcclusionVolume::Level& level) {
        constexpr float empty = 0.0f;
        const bool is_empty = level.filled.empty();
        const glm::ivec3 size = is_empty ? glm::ivec3(1) : level.size;
        glTexImage3D(GL_TEXTURE_3D, 0, GL_R32F, size.x, size.y, size.z, 0, GL_RED, GL_FLOAT,
                     is_empty ? &empty : level.filled.data());
    }

    void draw_rounds(const RoundBatch& batch) const {
        const std::vector<GlMesh>& levels = meshes.at(static_cast<std::size_t>(batch.mesh));
        const GlMesh& mesh = levels.at(std::min(static_cast<std::size_t>(batch.level), levels.size() - 1));
        glBindVertexArray(mesh.vertex_array.get());
        glDrawElementsInstancedBaseInstance(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr,
                                            batch.count, static_cast<GLuint>(batch.first));
    }

    static void draw_only(const PixelRect& rect) {
        glEnable(GL_SCISSOR_TEST);
        glScissor(rect.x, rect.y, rect.width, rect.height);
    }

    void draw_shadow_map(const DrawList& list) {
        glBindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer.get());
        glViewport(0, 0, viewport.shadow_size, viewport.shadow_size);
        draw_only(list.shadows_redrawn);
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_LESS);
        glClearDepth(1.0);
        glClear(GL_DEPTH_BUFFER_BIT);
        // Far sides only: what the sun sees is never compared with itself.
        glEnable(GL_CULL_FACE);
        glCullFace(GL_FRONT);
        if (!list.boxes.empty()) {
            shadow_box_program.use();
            shadow_box_program.set("boxes", unit::boxes);
            shadow_box_program.set("clip_from_world_sun", list.shadow.clip_from_world);
            far_sides.draw(sides_away_from(plan->geometry().light.to_sun, list.boxes));
        }
        shadow_round_program.use();
        shadow_round_program.set("clip_from_world_sun", list.shadow.clip_from_world);
        for (const RoundBatch& batch : list.round_batches) {
            draw_rounds(batch);
        }
        glCullFace(GL_BACK);
    }

    const Program& face_program(const FaceKind& kind) {
        const auto known = face_programs.find(kind);
        if (known != face_programs.end()) {
            return known->second;
        }
        const std::string defines = "#define PATTERN " + std::to_string(static_cast<int>(kind.pattern)) +
                                    "\n#define LIT " + (kind.is_lit ? "1" : "0") + "\n#define METAL " +
                                    (kind.is_metal ? "1" : "0") + "\n#define LARGE " +
                                    (kind.is_large ? "1" : "0") + "\n" + constants;
        return face_programs.emplace(kind, Program("face.vert", "face.frag", defines)).first->second;
    }

    const Program& round_program(const RoundBatch& batch, const Mirrored& mirrored) {
        const std::array<int, 4> key{static_cast<int>(batch.pattern), batch.is_metal ? 1 : 0, mirrored.spheres,
                                     mirrored.boxes};
        const auto known = round_programs.find(key);
        if (known != round_programs.end()) {
            return known->second;
        }
        const std::string defines =
            fmt::format("#define PATTERN {}\n#define METAL {}\n#define MIRROR {}\n#define MIRRORED_SPHERES {}\n"
                        "#define MIRRORED_BOXES {}\n",
                        key[0], key[1], mirrored.is_empty() ? 0 : 1, key[2], key[3]);
        return round_programs.emplace(key, Program("round.vert", "round.frag", defines + constants))
            .first->second;
    }

    void read_deep(const PixelRect& rect) {
        deep.emplace_back(4 * static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height));
        glReadBuffer(GL_COLOR_ATTACHMENT0);
        glReadPixels(rect.x, rect.y, rect.width, rect.height, GL_RGBA, GL_UNSIGNED_SHORT, deep.back().data());
    }

    void draw_picture(const DrawList& list, const Target& target) {
        glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.get());
        glViewport(0, 0, viewport.width, viewport.height);
        draw_only(list.redrawn);
        // Depth 1 is near, 0 far (see CameraBlock).
        glDepthFunc(GL_GREATER);
        glClearDepth(0.0);
        glClear(GL_DEPTH_BUFFER_BIT);
        for (const FaceBatch& batch : list.face_batches) {
            const Program& program = face_program(batch.kind);
            program.use();
            program.set("shadow_map", unit::shadow_map);
            program.set("faces", unit::faces);
            program.set("sky_atlas", unit::sky_atlas);
            face_array.draw(batch.first, batch.count);
        }
        for (const RoundBatch& batch : list.round_batches) {
            const Program& program = round_program(batch, batch.is_polished ? list.mirrored : Mirrored{});
            program.use();
            program.set("shadow_map", unit::shadow_map);
            for (int k = 0; k < OcclusionVolume::level_count; ++k) {
                program.set(("occlusion_" + std::to_string(k)).c_str(), unit::occlusion_first + k);
            }
            program.set("occlusion_corner", glm::vec4(list.occlusion.lower(), list.occlusion.cell()));
            program.set("mirrored_rays", mirrored_rays);
            draw_rounds(batch);
        }
        for (const Floor& floor : list.floors) {
            draw_floor(floor);
        }
        glDepthFunc(GL_EQUAL);
        glDepthMask(GL_FALSE);
        sky_program.use();
        sky_array.draw(0, 1);
        glDepthMask(GL_TRUE);
    }

    void draw_floor(const Floor& floor) {
        glActiveTexture(GL_TEXTURE0 + unit::occlusion_floor);
        glBindTexture(GL_TEXTURE_2D, occlusion_floor.get());
        const FloorOcclusion& open = floor.occlusion;
        glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, open.width, open.height, 0, GL_RED, GL_FLOAT,
                     open.open.data());
        for (const bool is_inside : {true, false}) {
            const Program& program = is_inside ? floor_inside_program : floor_ring_program;
            program.use();
            program.set("shadow_map", unit::shadow_map);
            program.set("occlusion", unit::occlusion_floor);
            program.set("occlusion_place_of", open.place);
            program.set("origin", floor.frame.origin);
            program.set("tangent", floor.frame.tangent);
            program.set("normal", floor.frame.normal);
            program.set("corners", floor.region);
            program.set("ring_scale", floor.ring_scale);
            program.set("id", floor.id);
            program.set("grid_origin", floor.grid_origin);
            program.set("color", floor.color);
            program.set("line_color", floor.line_color);
            (is_inside ? floor_inside : floor_ring).draw(0, 1);
        }
    }
};

Renderer::Renderer(std::shared_ptr<const PicturePlan> plan)
    : impl_(std::make_unique<Impl>(std::move(plan))) {}
Renderer::Renderer(const sim::SceneDef& scene, int width, int height, const RenderSettings& settings)
    : Renderer(std::make_shared<const PicturePlan>(scene, width, height, settings)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::begin(const DrawList& list, bool has_depth) {
    impl_->begin(list, has_depth);
}

void Renderer::finish(RawPicture& raw, DepthPicture& depth) {
    impl_->finish(raw, depth);
}

int Renderer::capacity() const {
    return impl_->reader.capacity();
}

const DepthPicture& Renderer::depth() const {
    return impl_->last_depth;
}

Image Renderer::draw(const sim::Snapshot& snapshot) {
    return draw_list(impl_->plan->list(snapshot));
}

Image Renderer::draw_list(DrawList list) {
    impl_->last_list = std::move(list);
    impl_->begin(impl_->last_list, true);
    impl_->finish(impl_->raw, impl_->last_depth);
    return impl_->plan->picture(impl_->raw, impl_->last_list);
}

Image Renderer::draw_blurred(const sim::Snapshot& snapshot, double shutter, int count) {
    PictureMean mean;
    for (DrawList& list : impl_->plan->lists(states_in_shutter(snapshot, shutter, count))) {
        const PixelRect rect = list.redrawn;
        mean.add(draw_list(std::move(list)), rect);
    }
    return mean.take();
}

std::vector<std::uint32_t> Renderer::body_ids() const {
    return render::body_ids(impl_->raw, impl_->last_list);
}

std::string Renderer::renderer_string() const {
    return impl_->context.renderer_string();
}

} // namespace render
