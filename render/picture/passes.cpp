#include "render/picture/passes.h"

#include "render/scene/mesh.h"
#include "sim/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace render {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// What a part number stands for; all null: sky.
struct Surface {
    const Face* face = nullptr;
    const Floor* floor = nullptr;
    const Instance* round = nullptr;
    const HullFace* hull_face = nullptr;      ///< of a round part that is a hull
    std::span<const LatheBand> bands = {};    ///< of one that is a surface of revolution
};

/// By part number; owns the bands.
class Surfaces {
public:
    Surfaces(const SceneGeometry& geometry, const DrawList& list) : surfaces_(list.body_of_id.size()) {
        for (const std::vector<glm::vec2>& profile : geometry.profiles) {
            bands_.push_back(make_lathe_bands(profile));
        }
        rod_bands_ = make_lathe_bands(rod_profile());
        for (const Face& face : list.faces) {
            surfaces_.at(face.id).face = &face;
        }
        for (const RoundBatch& batch : list.round_batches) {
            for (int i = 0; i < batch.count; ++i) {
                add_round(geometry, list.rounds[static_cast<std::size_t>(batch.first + i)], batch.mesh);
            }
        }
        for (const Floor& floor : list.floors) {
            surfaces_.at(floor.id).floor = &floor;
        }
    }

    const Surface& operator[](std::uint32_t id) const { return surfaces_.at(id); }

private:
    void add_round(const SceneGeometry& geometry, const Instance& instance, int mesh) {
        const auto own = static_cast<std::size_t>(mesh - mesh_id::lathe_first);
        for (std::uint32_t group = 0; group < geometry.group_count[static_cast<std::size_t>(mesh)]; ++group) {
            Surface& surface = surfaces_.at(instance.id + group);
            surface.round = &instance;
            if (mesh == mesh_id::rod) {
                surface.bands = of_group(rod_bands_, group);
            } else if (mesh >= mesh_id::lathe_first && own < bands_.size()) {
                surface.bands = of_group(bands_[own], group);
            } else if (mesh >= mesh_id::lathe_first) {
                surface.hull_face = &geometry.hulls[own - bands_.size()][group];
            }
        }
    }

    static std::span<const LatheBand> of_group(const std::vector<LatheBand>& bands, std::uint32_t group) {
        const auto is_of_it = [&](const LatheBand& band) { return band.group == group; };
        const auto first = std::ranges::find_if(bands, is_of_it);
        return {first, std::find_if_not(first, bands.end(), is_of_it)};
    }

    std::vector<Surface> surfaces_;
    std::vector<std::vector<LatheBand>> bands_;
    std::vector<LatheBand> rod_bands_;
};

/// Outward normal (radial, z) of the band that is nearest to a point (radius, z).
glm::vec2 band_normal(std::span<const LatheBand> bands, const glm::vec2& p) {
    float least = infinity;
    glm::vec2 normal(0, 1);
    for (const LatheBand& band : bands) {
        const glm::vec2 along = band.upper - band.lower;
        const float share = glm::clamp(glm::dot(p - band.lower, along) / glm::dot(along, along), 0.0f, 1.0f);
        const float distance = glm::length(p - band.lower - along * share);
        if (distance < least) {
            least = distance;
            normal = glm::normalize(glm::vec2(along.y, -along.x));
        }
    }
    return normal;
}

/// At a point of the world on it.
glm::vec3 normal_at(const Surface& surface, const glm::vec3& point) {
    if (surface.face != nullptr) {
        return glm::normalize(glm::cross(surface.face->half_u, surface.face->half_v));
    }
    if (surface.floor != nullptr) {
        return surface.floor->frame.normal;
    }
    if (surface.round == nullptr) {
        return glm::vec3(0.0f);
    }
    const Instance& instance = *surface.round;
    if (surface.hull_face != nullptr) {
        return turned(instance.orientation, surface.hull_face->normal);
    }
    const glm::vec3 p = turned_back(instance.orientation, point - instance.position) / instance.scale;
    glm::vec3 normal = p;
    if (!surface.bands.empty()) {
        const float radius = glm::length(glm::vec2(p));
        const glm::vec2 n = band_normal(surface.bands, {radius, p.z});
        normal = glm::vec3(radius > 0.0f ? glm::vec2(p) / radius * n.x : glm::vec2(0.0f), n.y);
    }
    return glm::normalize(turned(instance.orientation, normal / instance.scale));
}

/// What the centre of a pixel shows, and where.
struct Seen {
    std::uint32_t id;
    glm::dvec3 point; ///< [m]; of the sky: a direction
    double depth;     ///< [m]
};

class PassMaker {
public:
    explicit PassMaker(const PassSource& source)
        : source_(source), raw_(source.raw), surfaces_(source.plan.geometry(), source.list),
          world_from_clip_(glm::inverse(glm::dmat4(source.depth.clip_from_world))),
          next_(moved(source.snapshot, source.frame_time)),
          next_clip_from_world_(source.plan.clip_from_world(next_)) {
        CHECK(raw_.ids.size() == source.depth.depth.size() && raw_.x == 0 && raw_.y == 0);
    }

    /// Visits all pixels, the top row first.
    void each(const auto& take) const {
        for (int y = raw_.height - 1; y >= 0; --y) {
            for (int x = 0; x < raw_.width; ++x) {
                take(x, y, seen(x, y));
            }
        }
    }

    glm::vec3 normal(const Seen& seen) const { return normal_at(surfaces_[seen.id], glm::vec3(seen.point)); }

    glm::vec2 motion(int x, int y, const Seen& seen) const {
        const std::uint32_t body = source_.list.body_of_id.at(seen.id);
        glm::dvec4 point(seen.point, seen.id == 0 ? 0.0 : 1.0);
        if (body > 0) {
            const sim::BodySnapshot& from = source_.snapshot.bodies[body - 1];
            const sim::BodySnapshot& to = next_.bodies[body - 1];
            const sim::Vec3 p = sim::Vec3(point.x, point.y, point.z) - from.position;
            const sim::Vec3 q = to.orientation * (from.orientation.conjugate() * p) + to.position;
            point = {q.x(), q.y(), q.z(), 1.0};
        }
        const glm::dvec4 clip = next_clip_from_world_ * point;
        if (!(clip.w > 0.0)) {
            return glm::vec2(0.0f); // behind the eye
        }
        const glm::dvec2 size(raw_.width, raw_.height);
        const glm::dvec2 pixel = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size - glm::dvec2(x + 0.5, y + 0.5);
        return {pixel.x, -pixel.y};
    }

private:
    Seen seen(int x, int y) const {
        const auto k = static_cast<std::size_t>(y) * static_cast<std::size_t>(raw_.width) + static_cast<std::size_t>(x);
        const glm::dvec2 place = glm::dvec2((x + 0.5) / raw_.width, (y + 0.5) / raw_.height) * 2.0 - 1.0;
        const bool is_sky = raw_.ids[k] == 0;
        // Any depth tells the direction to the sky.
        const double depth = is_sky ? 0.5 : static_cast<double>(source_.depth.depth[k]);
        const glm::dvec4 p = world_from_clip_ * glm::dvec4(place, depth, 1.0);
        const glm::dvec3 eye(source_.list.camera.eye);
        const glm::dvec3 ray = glm::dvec3(p) / p.w - eye;
        if (is_sky) {
            return {0, ray, std::numeric_limits<double>::infinity()};
        }
        const double share = share_to_ball(surfaces_[raw_.ids[k]], eye, ray);
        return {raw_.ids[k], eye + share * ray, share / p.w};
    }

    /// OpenGL draws a ball of few triangles if it is small: the share of the ray at which it meets the ball itself; 1 for
    /// all other surfaces.
    static double share_to_ball(const Surface& surface, const glm::dvec3& eye, const glm::dvec3& ray) {
        if (surface.round == nullptr || !surface.bands.empty() || surface.hull_face != nullptr) {
            return 1.0;
        }
        const glm::dvec3 origin = eye - glm::dvec3(surface.round->position);
        const auto radius = static_cast<double>(surface.round->scale.x);
        const double a = glm::dot(ray, ray);
        const double b = glm::dot(origin, ray);
        const double d = b * b - a * (glm::dot(origin, origin) - radius * radius);
        return d < 0.0 ? 1.0 : (-b - std::sqrt(d)) / a;
    }

    const PassSource& source_;
    const RawPicture& raw_;
    Surfaces surfaces_;
    glm::dmat4 world_from_clip_;
    sim::Snapshot next_;
    glm::dmat4 next_clip_from_world_;
};

/// By part number: is it a body's, no plane and no sky?
std::vector<bool> parts_of_bodies(const DrawList& list) {
    std::vector<bool> is_body(list.body_of_id.size(), true);
    is_body[0] = false;
    for (const Floor& floor : list.floors) {
        is_body[floor.id] = false;
    }
    return is_body;
}

/// The picture of bodies before black planes and sky. is_white: and all of them white, which is the share of each pixel that
/// they cover.
Image bodies_alone(const PassSource& source, bool is_white) {
    RawPicture mask = source.raw;
    const std::vector<bool> is_body = parts_of_bodies(source.list);
    for (std::size_t k = 0; k < mask.ids.size(); ++k) {
        const bool is_seen = is_body.at(mask.ids[k]);
        if (is_white || !is_seen) {
            std::fill_n(mask.rgba.begin() + static_cast<std::ptrdiff_t>(4 * k), 4, is_seen ? 255 : 0);
        }
    }
    return source.plan.picture(mask, source.list);
}

std::vector<float> cover(const PassSource& source) {
    const Image image = bodies_alone(source, true);
    std::vector<float> shares;
    for (std::size_t k = 0; k < image.rgb.size(); k += 3) {
        shares.push_back(static_cast<float>(image.rgb[k]) / 255.0f);
    }
    return shares;
}

} // namespace

std::vector<std::uint8_t> rgba_samples(const PassSource& source) {
    const Image color = bodies_alone(source, false); // at edges mixed with black
    const Image share = bodies_alone(source, true);
    std::vector<std::uint8_t> samples;
    samples.reserve(color.rgb.size() / 3 * 4);
    for (std::size_t k = 0; k < color.rgb.size(); k += 3) {
        const int alpha = share.rgb[k];
        for (std::size_t c = 0; c < 3; ++c) {
            const int whole = alpha > 0 ? (color.rgb[k + c] * 255 + alpha / 2) / alpha : 0;
            samples.push_back(static_cast<std::uint8_t>(std::min(whole, 255)));
        }
        samples.push_back(static_cast<std::uint8_t>(alpha));
    }
    return samples;
}

std::vector<std::uint8_t> depth16_samples(const PassSource& source) {
    const PassMaker maker(source);
    std::vector<std::uint8_t> samples;
    maker.each([&](int, int, const Seen& seen) {
        const auto value = static_cast<unsigned>(std::clamp(std::round(1e3 * seen.depth), 0.0, 65535.0));
        samples.push_back(static_cast<std::uint8_t>(value >> 8));
        samples.push_back(static_cast<std::uint8_t>(value & 255u));
    });
    return samples;
}

std::vector<std::uint8_t> rgb16_samples(const PassSource& source) {
    std::vector<std::uint8_t> samples;
    for (const std::uint16_t value : source.plan.deep_picture(source.raw, source.list)) {
        samples.push_back(static_cast<std::uint8_t>(value >> 8));
        samples.push_back(static_cast<std::uint8_t>(value & 255u));
    }
    return samples;
}

std::vector<Channel> make_passes(const PassSource& source, const sim::OutputDef& output) {
    const PassMaker maker(source);
    std::vector<Channel> channels;
    if (output.has(sim::PicturePass::depth)) {
        Channel& z = channels.emplace_back(Channel{.name = "depth.Z"});
        maker.each([&](int, int, const Seen& seen) { z.values.push_back(static_cast<float>(seen.depth)); });
    }
    if (output.has(sim::PicturePass::normal)) {
        Channel x{.name = "normal.X"}, y{.name = "normal.Y"}, z{.name = "normal.Z"};
        maker.each([&](int, int, const Seen& seen) {
            const glm::vec3 normal = maker.normal(seen);
            x.values.push_back(normal.x);
            y.values.push_back(normal.y);
            z.values.push_back(normal.z);
        });
        channels.insert(channels.end(), {std::move(x), std::move(y), std::move(z)});
    }
    if (output.has(sim::PicturePass::body)) {
        channels.push_back({.name = "body.id", .counts = body_ids(source.raw, source.list)});
    }
    if (output.has(sim::PicturePass::motion)) {
        Channel across{.name = "motion.X"}, down{.name = "motion.Y"};
        maker.each([&](int x, int y, const Seen& seen) {
            const glm::vec2 motion = maker.motion(x, y, seen);
            across.values.push_back(motion.x);
            down.values.push_back(motion.y);
        });
        channels.insert(channels.end(), {std::move(across), std::move(down)});
    }
    if (output.has(sim::PicturePass::alpha)) {
        channels.push_back({.name = "alpha.A", .values = cover(source)});
    }
    return channels;
}

} // namespace render
