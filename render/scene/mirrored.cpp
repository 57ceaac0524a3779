#include "render/scene/mirrored.h"

#include <algorithm>

namespace render {

namespace {

/// Least roughness that mirrors nothing sharply [-].
constexpr float polished_roughness = 0.4f;

bool is_sphere(const Part& part) {
    return part.mesh < mesh_id::sphere_first + mesh_id::sphere_count;
}

/// Spheres and boxes of all bodies, those too that are not there yet: what mirrors must not change during a film.
std::size_t mirrored_count(const sim::SceneDef& scene) {
    std::size_t count = 0;
    const Overload add{[&](const sim::Box&) { ++count; }, [&](const sim::Sphere&) { ++count; }, [](const auto&) {}};
    const Overload add_all{[&](const sim::Compound& compound) {
                               for (const sim::CompoundPart& part : compound.parts) {
                                   std::visit(add, part.shape);
                               }
                           },
                           add};
    for (const sim::BodyDef& body : scene.bodies) {
        if (body.look.visible && body.look.lathe.size() < 2) {
            std::visit(add_all, body.drawn_shape());
        }
    }
    return count;
}

} // namespace

bool is_polished(const Part& part) {
    return part.instance.metallic > 0.5f && part.instance.roughness < polished_roughness;
}

Mirrored find_mirrored(const Parts& parts, const sim::SceneDef& scene) {
    Mirrored found;
    if (std::ranges::none_of(parts.rounds, is_polished) || mirrored_count(scene) > MirroredBlock::most) {
        return found;
    }
    std::size_t next = 0;
    const auto add_look = [&](const Instance& instance) {
        found.block.looks[next++] = glm::vec4(instance.color, instance.metallic);
    };
    for (const Part& part : parts.rounds) {
        if (is_sphere(part)) {
            found.block.spheres[next] = glm::vec4(part.instance.position, part.instance.scale.x);
            add_look(part.instance);
        }
    }
    found.spheres = static_cast<int>(next);
    for (std::size_t i = 0; i < parts.boxes.size(); ++i) {
        const Instance& box = parts.boxes[i].instance;
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec3 row(0.0f);
            row[axis] = 1.0f / box.scale[axis];
            row = turned(box.orientation, row);
            found.block.boxes[3 * i + static_cast<std::size_t>(axis)] =
                glm::vec4(row, -glm::dot(row, box.position));
        }
        add_look(box);
    }
    found.boxes = static_cast<int>(parts.boxes.size());
    return found;
}

} // namespace render
