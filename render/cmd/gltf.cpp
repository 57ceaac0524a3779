#include "render/cmd/gltf.h"

#include "render/scene/camera.h"
#include "render/scene/mesh.h"
#include "render/scene/parts.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>
#include <type_traits>
#include <utility>

namespace cmd {

namespace {

using sim::Quat;
using sim::Vec3;

constexpr int sphere_rings = 32;
constexpr int rod_sides = 16;
/// Width over height of a picture that the camera is meant for.
constexpr double aspect = 16.0 / 9.0;
/// Share of the scene's tolerance by which a pose may be wrong.
constexpr double thinning = 0.1;
/// Poses that are left out in a row at most: each new one is held against all of them.
constexpr std::size_t longest_gap = 500;

struct Key {
    float time; ///< [s]
    Vec3 position;
    Quat orientation;
};

/// Largest distance [m] between points of a ball of this radius in two poses, at most.
double distance(const Key& a, const Vec3& position, const Quat& orientation, double radius) {
    const double half = std::acos(std::min(1.0, std::abs(a.orientation.dot(orientation))));
    return (a.position - position).norm() + 2.0 * half * radius;
}

/// The keys that are needed: each gap is as long as can be.
std::vector<Key> thinned(const std::vector<Key>& keys, double radius, double tolerance) {
    std::vector<Key> kept{keys.front()};
    std::size_t from = 0;
    const auto is_straight = [&](std::size_t to) {
        for (std::size_t k = from + 1; k < to; ++k) {
            const double share = static_cast<double>(keys[k].time - keys[from].time) /
                                 static_cast<double>(keys[to].time - keys[from].time);
            const Vec3 position = keys[from].position + share * (keys[to].position - keys[from].position);
            if (distance(keys[k], position, keys[from].orientation.slerp(share, keys[to].orientation),
                         radius) > tolerance) {
                return false;
            }
        }
        return true;
    };
    while (from + 1 < keys.size()) {
        std::size_t to = from + 1;
        while (to + 1 < keys.size() && to - from < longest_gap && is_straight(to + 1)) {
            ++to;
        }
        kept.push_back(keys[to]);
        from = to;
    }
    return kept;
}

std::vector<double> numbers(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

std::vector<double> numbers(const Quat& q) {
    return {q.x(), q.y(), q.z(), q.w()};
}

Quat quaternion(const glm::vec4& q) {
    return Quat(static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y),
                static_cast<double>(q.z))
        .normalized();
}

Vec3 vector(const glm::vec3& v) {
    return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

/// A cube of half edge 1 whose faces have corners of their own.
render::Mesh box_mesh() {
    render::Mesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 normal(0.0f), u(0.0f), v(0.0f);
            normal[axis] = side;
            u[(axis + 1) % 3] = side;
            v[(axis + 2) % 3] = 1.0f;
            const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
            for (const auto& [a, b] : {std::pair(-1.0f, -1.0f), {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
                mesh.vertices.push_back({normal + a * u + b * v, normal, 0});
            }
            mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
        }
    }
    return mesh;
}

/// Half edge 1 in the plane z = 0, seen from above.
render::Mesh floor_mesh() {
    render::Mesh mesh;
    for (const auto& [x, y] : {std::pair(-1.0f, -1.0f), {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
        mesh.vertices.push_back({{x, y, 0.0f}, {0.0f, 0.0f, 1.0f}, 0});
    }
    mesh.indices = {0, 1, 2, 0, 2, 3};
    return mesh;
}

constexpr int floor_id = -2; ///< beside the mesh ids of render::Part

/// The model as it grows.
class Builder {
public:
    Builder(const sim::SceneDef& scene, const sim::Snapshot& start)
        : scene_(scene), camera_(render::find_camera(scene, scene.output.camera)),
          geometry_(render::make_scene_geometry(scene, camera_)), start_(start) {
        model_.asset.version = "2.0";
        model_.asset.generator = "tumble " TUMBLE_VERSION;
        model_.buffers.resize(1);
        model_.scenes.resize(1);
        model_.scenes[0].name = scene.name;
        model_.defaultScene = 0;
        tinygltf::Node root;
        root.name = "z up";
        root.rotation = {-std::numbers::sqrt2 / 2.0, 0.0, 0.0, std::numbers::sqrt2 / 2.0};
        model_.nodes.push_back(root);
        model_.scenes[0].nodes.push_back(0);
        add_bodies();
        add_rods();
        add_sun();
    }

    int node_of_body(std::size_t body) const { return node_of_body_[body]; }
    double radius_of_body(std::size_t body) const { return radius_of_body_[body]; }
    std::size_t node_count() const { return model_.nodes.size(); }
    render::View view(const sim::Snapshot& state) const {
        return render::camera_view(camera_, state, aspect);
    }

    /// Where a camera stands that looks along -z of its node.
    static Key pose_of(const render::View& view, float time) {
        const Vec3 forward = (view.target - view.eye).normalized();
        const Vec3 hint = std::abs(forward.z()) > 0.999 ? Vec3::UnitY() : Vec3::UnitZ();
        sim::Mat3 axes;
        axes.col(0) = forward.cross(hint).normalized();
        axes.col(2) = -forward;
        axes.col(1) = axes.col(2).cross(axes.col(0));
        return {time, view.eye, Quat(axes).normalized()};
    }

    int add_camera(const render::View& view) {
        tinygltf::Camera camera;
        camera.name = camera_.name;
        camera.type = "perspective";
        camera.perspective.aspectRatio = aspect;
        camera.perspective.yfov = view.fov_degrees * std::numbers::pi / 180.0;
        camera.perspective.znear = 1e-3 * render::view_scale(camera_);
        camera.perspective.zfar = 100.0 * render::view_scale(camera_);
        model_.cameras.push_back(camera);
        const Key pose = pose_of(view, 0.0f);
        tinygltf::Node node;
        node.name = "camera " + camera_.name;
        node.camera = 0;
        node.translation = numbers(pose.position);
        node.rotation = numbers(pose.orientation);
        return add_node(node, 0);
    }

    void animate(int node, const std::vector<Key>& keys) {
        std::vector<float> times, positions, orientations;
        Quat last = keys.front().orientation;
        for (const Key& key : keys) {
            times.push_back(key.time);
            for (const double x : numbers(key.position)) {
                positions.push_back(static_cast<float>(x));
            }
            // Of the two quaternions of an orientation the one nearer to the last.
            Quat orientation = key.orientation;
            orientation.coeffs() *= orientation.dot(last) < 0.0 ? -1.0 : 1.0;
            last = orientation;
            for (const double x : numbers(orientation)) {
                orientations.push_back(static_cast<float>(x));
            }
        }
        const int input = add_accessor(times, TINYGLTF_TYPE_SCALAR, 0, true);
        add_channel(node, "translation", input, add_accessor(positions, TINYGLTF_TYPE_VEC3, 0));
        add_channel(node, "rotation", input, add_accessor(orientations, TINYGLTF_TYPE_VEC4, 0));
    }

    /// A body that is not there has no size. keys: its own; none: it never comes.
    void hide_before(int node, const std::vector<Key>& keys) {
        const std::vector<float> times = keys.empty() ? std::vector{0.0f} : std::vector{0.0f, keys.front().time};
        std::vector<float> sizes(3 * times.size(), 1.0f);
        std::fill_n(sizes.begin(), 3, 0.0f);
        const int input = add_accessor(times, TINYGLTF_TYPE_SCALAR, 0, true);
        add_channel(node, "scale", input, add_accessor(sizes, TINYGLTF_TYPE_VEC3, 0), "STEP");
    }

    std::string bytes() {
        tinygltf::TinyGLTF writer;
        std::ostringstream stream;
        CHECK(writer.WriteGltfSceneToStream(&model_, stream, false, true));
        return stream.str();
    }

private:
    int add_node(const tinygltf::Node& node, int parent) {
        model_.nodes.push_back(node);
        const int index = static_cast<int>(model_.nodes.size()) - 1;
        model_.nodes[static_cast<std::size_t>(parent)].children.push_back(index);
        return index;
    }

    void add_channel(int node, const char* path, int input, int output, const char* interpolation = "LINEAR") {
        model_.animations.resize(1);
        model_.animations[0].name = scene_.name;
        tinygltf::Animation& animation = model_.animations[0];
        tinygltf::AnimationSampler sampler;
        sampler.input = input;
        sampler.output = output;
        sampler.interpolation = interpolation;
        animation.samplers.push_back(sampler);
        tinygltf::AnimationChannel channel;
        channel.sampler = static_cast<int>(animation.samplers.size()) - 1;
        channel.target_node = node;
        channel.target_path = path;
        animation.channels.push_back(channel);
    }

    /// target: what OpenGL uses the numbers for; 0: nothing. has_bounds: with smallest and largest value.
    template <class Number>
    int add_accessor(const std::vector<Number>& values, int type, int target, bool has_bounds = false) {
        std::vector<unsigned char>& data = model_.buffers[0].data;
        data.resize((data.size() + 3) / 4 * 4);
        tinygltf::BufferView view;
        view.buffer = 0;
        view.byteOffset = data.size();
        view.byteLength = values.size() * sizeof(Number);
        view.target = target;
        data.resize(data.size() + view.byteLength);
        std::memcpy(data.data() + view.byteOffset, values.data(), view.byteLength);
        model_.bufferViews.push_back(view);
        tinygltf::Accessor accessor;
        accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
        accessor.type = type;
        accessor.componentType = std::is_same_v<Number, float> ? TINYGLTF_COMPONENT_TYPE_FLOAT
                                                               : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        const auto width = static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
        accessor.count = values.size() / width;
        if (has_bounds) {
            accessor.minValues.assign(width, std::numeric_limits<double>::max());
            accessor.maxValues.assign(width, std::numeric_limits<double>::lowest());
            for (std::size_t i = 0; i < values.size(); ++i) {
                const auto value = static_cast<double>(values[i]);
                accessor.minValues[i % width] = std::min(accessor.minValues[i % width], value);
                accessor.maxValues[i % width] = std::max(accessor.maxValues[i % width], value);
            }
        }
        model_.accessors.push_back(accessor);
        return static_cast<int>(model_.accessors.size()) - 1;
    }

    render::Mesh make_mesh(int id) const {
        if (id == -1) {
            return box_mesh();
        }
        if (id == floor_id) {
            return floor_mesh();
        }
        if (id < render::mesh_id::rod) {
            return render::make_sphere_mesh(sphere_rings);
        }
        if (id == render::mesh_id::rod) {
            return render::make_lathe_mesh(render::rod_profile(), rod_sides);
        }
        const auto own = static_cast<std::size_t>(id - render::mesh_id::lathe_first);
        return own < geometry_.profiles.size()
                   ? render::make_lathe_mesh(geometry_.profiles[own], render::lathe_sides.back())
                   : render::make_hull_mesh(geometry_.hulls[own - geometry_.profiles.size()]);
    }

    /// Accessors of positions, normals and indices, each mesh once.
    const std::array<int, 3>& accessors_of(int id) {
        const int key = id >= 0 && id < render::mesh_id::rod ? 0 : id; // all spheres are one
        const auto [place, is_new] = accessors_of_mesh_.try_emplace(key);
        if (is_new) {
            const render::Mesh mesh = make_mesh(key);
            std::vector<float> positions, normals;
            for (const render::Vertex& vertex : mesh.vertices) {
                positions.insert(positions.end(), {vertex.position.x, vertex.position.y, vertex.position.z});
                const glm::vec3 normal = glm::normalize(vertex.normal);
                normals.insert(normals.end(), {normal.x, normal.y, normal.z});
            }
            place->second = {
                add_accessor(positions, TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER, true),
                add_accessor(normals, TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER),
                add_accessor(mesh.indices, TINYGLTF_TYPE_SCALAR, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER)};
        }
        return place->second;
    }

    int material_of(const sim::LookDef& look) {
        const std::array<double, 5> key{look.color.x(), look.color.y(), look.color.z(), look.metallic,
                                        look.roughness};
        const auto [place, is_new] = materials_.try_emplace(key, static_cast<int>(model_.materials.size()));
        if (is_new) {
            tinygltf::Material material;
            material.pbrMetallicRoughness.baseColorFactor = {key[0], key[1], key[2], 1.0};
            material.pbrMetallicRoughness.metallicFactor = key[3];
            material.pbrMetallicRoughness.roughnessFactor = key[4];
            model_.materials.push_back(material);
        }
        return place->second;
    }

    int mesh_of(int id, const sim::LookDef& look) {
        const int material = material_of(look);
        const std::array<int, 3> accessors = accessors_of(id);
        const auto [place, is_new] = meshes_.try_emplace({accessors[0], material}, static_cast<int>(model_.meshes.size()));
        if (is_new) {
            tinygltf::Primitive primitive;
            primitive.attributes = {{"POSITION", accessors[0]}, {"NORMAL", accessors[1]}};
            primitive.indices = accessors[2];
            primitive.material = material;
            primitive.mode = TINYGLTF_MODE_TRIANGLES;
            tinygltf::Mesh mesh;
            mesh.primitives.push_back(primitive);
            model_.meshes.push_back(mesh);
        }
        return place->second;
    }

    void add_part(std::size_t body, const render::Instance& instance, int mesh_id) {
        const sim::BodySnapshot& state = start_.bodies[body];
        const Quat back = state.orientation.conjugate();
        tinygltf::Node node;
        node.mesh = mesh_of(mesh_id, scene_.bodies[body].look);
        node.translation = numbers(Vec3(back * (vector(instance.position) - state.position)));
        node.rotation = numbers((back * quaternion(instance.orientation)).normalized());
        node.scale = numbers(vector(instance.scale));
        add_node(node, node_of_body_[body]);
        const double reach = (vector(instance.position) - state.position).norm();
        radius_of_body_[body] = std::max(radius_of_body_[body], reach + static_cast<double>(instance.bounding_radius));
    }

    void add_bodies() {
        node_of_body_.assign(scene_.bodies.size(), -1);
        radius_of_body_.assign(scene_.bodies.size(), 0.0);
        for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
            if (!scene_.bodies[i].look.visible) {
                continue;
            }
            tinygltf::Node node;
            node.name = scene_.bodies[i].name;
            node.translation = numbers(start_.bodies[i].position);
            node.rotation = numbers(start_.bodies[i].orientation);
            node_of_body_[i] = add_node(node, 0);
            if (std::holds_alternative<sim::Plane>(scene_.bodies[i].shape)) {
                render::Instance ground{};
                ground.orientation = render::to_glm(start_.bodies[i].orientation);
                ground.position = render::to_glm(start_.bodies[i].position);
                ground.scale = {geometry_.floor_extent, geometry_.floor_extent, 1.0f};
                add_part(i, ground, floor_id);
            }
        }
        sim::Snapshot all = start_;
        all.time = std::numeric_limits<double>::infinity();
        const render::Parts parts = render::collect_parts(scene_, geometry_, all, view(start_), {0.0, 1000.0});
        for (const std::vector<render::Part>* group : {&parts.boxes, &parts.rounds}) {
            for (const render::Part& part : *group) {
                if (part.body > 0) { // rods are added from the joints
                    add_part(part.body - 1, part.instance, part.mesh);
                }
            }
        }
    }

    /// A joint's rod, from the anchor to the centre of body a, hangs from that body.
    void add_rods() {
        const double radius = render::rod_radius_in_views * render::view_scale(camera_);
        for (const sim::JointDef& joint : scene_.joints) {
            if (!joint.is_drawn || joint.body_a < 0) {
                continue;
            }
            const auto a = static_cast<std::size_t>(joint.body_a);
            const sim::Pose& pose = scene_.bodies[a].pose;
            const Vec3 anchor = pose.orientation.conjugate() * (joint.anchor - pose.position);
            if (node_of_body_[a] < 0 || anchor == Vec3::Zero()) {
                continue;
            }
            tinygltf::Node node;
            node.name = "rod";
            node.mesh = mesh_of(render::mesh_id::rod, render::rod_look());
            node.translation = numbers(Vec3(0.5 * anchor));
            node.rotation = numbers(sim::rotation_between(Vec3::UnitZ(), anchor));
            node.scale = {radius, radius, 0.5 * anchor.norm()};
            add_node(node, node_of_body_[a]);
            radius_of_body_[a] = std::max(radius_of_body_[a], anchor.norm() + radius);
        }
    }

    void add_sun() {
        tinygltf::Light sun;
        sun.name = "sun";
        sun.type = "directional";
        sun.color = numbers(scene_.light.sun_color);
        sun.intensity =
            scene_.light.sun_intensity * std::numbers::pi; // a white surface has this radiance over pi
        model_.lights.push_back(sun);
        const render::View from_sun{scene_.light.to_sun, Vec3::Zero(), 1.0};
        tinygltf::Node node;
        node.name = "sun";
        node.rotation = numbers(pose_of(from_sun, 0.0f).orientation);
        tinygltf::Value::Object light;
        light["light"] = tinygltf::Value(0);
        node.extensions["KHR_lights_punctual"] = tinygltf::Value(light);
        add_node(node, 0);
    }

    const sim::SceneDef& scene_;
    const sim::CameraDef& camera_;
    render::SceneGeometry geometry_;
    const sim::Snapshot& start_;
    tinygltf::Model model_;
    std::vector<int> node_of_body_;
    std::vector<double> radius_of_body_;
    std::map<int, std::array<int, 3>> accessors_of_mesh_;
    std::map<std::array<double, 5>, int> materials_;
    std::map<std::pair<int, int>, int> meshes_;
};

bool is_moved(const std::vector<Key>& keys) {
    return std::ranges::any_of(keys, [&](const Key& key) {
        return key.position != keys.front().position ||
               key.orientation.coeffs() != keys.front().orientation.coeffs();
    });
}

} // namespace

GltfSummary write_gltf(const std::filesystem::path& path, const sim::SceneDef& scene,
                       const sim::TrajectoryReader& trajectory) {
    const sim::Snapshot start = trajectory.read(0);
    Builder builder(scene, start);
    std::vector<std::vector<Key>> keys(scene.bodies.size());
    std::vector<Key> camera_keys;
    for (std::size_t record = 0; record < trajectory.steps().size(); ++record) {
        const sim::Snapshot state = record == 0 ? start : trajectory.read(record);
        const auto time = static_cast<float>(state.time);
        for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
            const sim::BodyDef& body = scene.bodies[i];
            if (!body.is_fixed() && builder.node_of_body(i) >= 0 && body.is_there(state.time)) {
                keys[i].push_back({time, state.bodies[i].position, state.bodies[i].orientation});
            }
        }
        camera_keys.push_back(Builder::pose_of(builder.view(state), time));
    }
    const double tolerance = thinning * scene.step.tolerance;
    GltfSummary summary;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (builder.node_of_body(i) >= 0 && !scene.bodies[i].is_there(start.time)) {
            builder.hide_before(builder.node_of_body(i), keys[i]);
        }
        if (keys[i].size() > 1 && is_moved(keys[i])) {
            const std::vector<Key> kept = thinned(keys[i], builder.radius_of_body(i), tolerance);
            builder.animate(builder.node_of_body(i), kept);
            summary.records += keys[i].size();
            summary.keys += kept.size();
        }
        keys[i] = {};
    }
    const int camera = builder.add_camera(builder.view(start));
    if (camera_keys.size() > 1 && is_moved(camera_keys)) {
        builder.animate(camera, thinned(camera_keys,
                                        render::view_scale(render::find_camera(scene, scene.output.camera)),
                                        tolerance));
    }
    summary.nodes = builder.node_count();
    sim::write_file(path, builder.bytes());
    return summary;
}

} // namespace cmd
