#include "render/overlay/world_layer.h"

#include "render/overlay/palette.h"
#include "render/scene/camera.h"
#include "render/scene/geometry.h"

#include <algorithm>
#include <cmath>

namespace render {

namespace {

using sim::Shown;
using sim::Vec3;

/// A point counts as hidden if what is before it is nearer to the camera by this share of the distance.
constexpr float depth_tolerance = 0.004f;
/// In view distances: length of normals, of the arrow of an impact that stops a mean body after a fall of that length, and
/// of the arrow of the impulse that carries a column of mean bodies, as high as the cube of all of them, for one step.
constexpr double normal_in_views = 0.022;
constexpr double arrow_in_views = 0.05;
/// Opacity of what lies behind bodies.
constexpr float hidden_alpha = 0.3f;
/// Of the line that joins pieces of a contact path: is_hop().
constexpr float hop_alpha = 0.45f;
constexpr int hop_points = 9;
/// Steps in which trails fade.
constexpr int fade_steps = 12;

constexpr glm::vec3 dark(0.03f, 0.04f, 0.06f);

/// Sticking and sliding contacts: sky blue and vermilion of Okabe & Ito.
const glm::vec3 sticking_color = category_color(1);
const glm::vec3 sliding_color = category_color(5);
/// Impacts, and the path of the contact on the body: yellow.
const glm::vec3 impact_color = category_color(3);
const glm::vec3 path_on_body_color = category_color(3);
constexpr glm::vec3 path_in_world_color(0.95f, 0.96f, 1.0f);

glm::vec3 vec3_of(const Eigen::Vector3f& v) {
    return {v.x(), v.y(), v.z()};
}

/// From the end of a piece to the beginning of the next, on a ball about the origin.
std::vector<Vec3> hop(const Path& from, const Path& to) {
    std::vector<Vec3> points;
    const Vec3& a = from.back().at;
    const Vec3& b = to.front().at;
    const sim::Quat turn = sim::rotation_between(a, b);
    for (int i = 0; i < hop_points; ++i) {
        const double share = static_cast<double>(i) / (hop_points - 1);
        const double length = (1.0 - share) * a.norm() + share * b.norm();
        points.push_back(sim::Quat::Identity().slerp(share, turn) * a.normalized() * length);
    }
    return points;
}

} // namespace

/// A body's own colour as seen on the screen, made light enough for a dark panel.
glm::vec3 panel_color(const sim::BodyDef& body) {
    const glm::vec3 color = display_from_linear(to_glm(body.look.color));
    const float light = glm::dot(color, glm::vec3(0.3f, 0.6f, 0.1f));
    return glm::mix(color, glm::vec3(1.0f), std::clamp(0.45f - light, 0.0f, 0.45f));
}

/// Points of the world -> pixels.
class WorldLayer::Projection {
public:
    /// Where a point lies in the picture.
    struct Place {
        glm::vec2 at{0.0f};
        bool is_before_camera = false;
        bool is_visible = false; ///< nothing is before it
    };

    Projection(const DepthPicture& picture, float scale) : picture_(picture), scale_(scale) {}

    /// [px] 1/720 of the picture's height.
    float scale() const { return scale_; }

    Place place(const glm::vec3& point) const {
        const glm::vec4 clip = picture_.clip_from_world * glm::vec4(point, 1.0f);
        Place result;
        if (!(clip.w > 1e-9f)) {
            return result;
        }
        const float width = static_cast<float>(picture_.width);
        const float height = static_cast<float>(picture_.height);
        result.is_before_camera = true;
        result.at = {(0.5f + 0.5f * clip.x / clip.w) * width, (0.5f - 0.5f * clip.y / clip.w) * height};
        if (result.at.x >= 0.0f && result.at.x < width && result.at.y >= 0.0f && result.at.y < height) {
            const std::size_t row =
                static_cast<std::size_t>(picture_.height - 1 - static_cast<int>(result.at.y));
            const float before = picture_.depth[row * static_cast<std::size_t>(picture_.width) +
                                                static_cast<std::size_t>(result.at.x)];
            result.is_visible = clip.z / clip.w >= before * (1.0f - depth_tolerance);
        }
        return result;
    }

    /// A line through points of the world, over a darker rim; hidden parts are faint. `alpha`: by the number
    /// of a point.
    template <class Alpha>
    void stroke(Canvas& canvas, std::span<const glm::vec3> points, Pen pen, const Alpha& alpha) const {
        // Pieces of one opacity.
        std::vector<std::pair<float, std::vector<glm::vec2>>> runs;
        std::vector<glm::vec2> run;
        float run_alpha = 0.0f;
        const auto finish = [&] {
            if (run.size() > 1) {
                runs.emplace_back(run_alpha, run);
            }
            run.clear();
        };
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Place now = place(points[i]);
            if (!now.is_before_camera) {
                finish();
                continue;
            }
            run.push_back(now.at);
            const float here = alpha(i) * (now.is_visible ? 1.0f : hidden_alpha);
            if (here != run_alpha) {
                finish();
                run.push_back(now.at);
                run_alpha = here;
            }
        }
        finish();
        for (const auto& [opacity, line] : runs) {
            if (opacity > hidden_alpha) {
                canvas.stroke(line, {{dark, 0.5f * opacity}, pen.width * 1.9f, 0.0f});
            }
        }
        for (const auto& [opacity, line] : runs) {
            pen.paint.alpha = opacity;
            canvas.stroke(line, pen);
        }
    }

private:
    const DepthPicture& picture_;
    float scale_;
};

struct WorldLayer::Arrow {
    glm::vec3 from; ///< [m]
    glm::vec3 along;
    glm::vec3 color;
};

WorldLayer::WorldLayer(const sim::SceneDef& scene)
    : scene_(scene),
      has_contacts_(scene.overlay.shows(Shown::points) || scene.overlay.shows(Shown::normals) ||
                    scene.overlay.shows(Shown::impulses)),
      has_paths_(scene.overlay.shows(Shown::trails) || scene.overlay.shows(Shown::contact_paths)),
      arrow_scale_(scene.overlay.arrow_scale) {
    view_ = view_scale(find_camera(scene, scene.output.camera));
    double mass = 0.0;
    double count = 0.0;
    for (const sim::BodyDef& body : scene.bodies) {
        mass += body.mass.mass;
        count += body.is_static() ? 0.0 : 1.0;
    }
    const double mean = mass / std::max(count, 1.0);
    const double gravity = scene.step.gravity.norm();
    const double length = arrow_in_views * view_;
    const auto scale_for = [&](double impulse) { return impulse > 0.0 ? length / impulse : 0.0; };
    if (arrow_scale_ == 0.0) {
        const double load = std::cbrt(std::max(count, 1.0)) * mean * gravity;
        arrow_scale_ = scale_for(load * scene.step.time_step.value());
    }
    impact_scale_ = scale_for(mean * std::sqrt(2.0 * gravity * length));
}

std::vector<LegendEntry> WorldLayer::legend() const {
    const bool has_impulses = scene_.overlay.shows(Shown::impulses);
    std::vector<LegendEntry> entries;
    if (scene_.overlay.shows(Shown::contact_paths)) {
        entries = {{path_in_world_color, "path of the contact"}, {path_on_body_color, "the same on the body"}};
    }
    if (scene_.overlay.shows(Shown::points) || has_impulses) {
        entries.insert(entries.end(), {{sticking_color, "sticking"}, {sliding_color, "sliding"}});
    }
    if (has_impulses) {
        entries.push_back({impact_color, "impact"});
    }
    return entries;
}

void WorldLayer::draw(Canvas& canvas, const sim::Snapshot& snapshot, const Notes& notes, const DepthPicture& depth,
                      float scale) const {
    const Projection projection(depth, scale);
    draw_paths(canvas, projection, snapshot, notes);
    draw_contacts(canvas, projection, snapshot);
    if (scene_.overlay.shows(Shown::impulses)) {
        draw_impacts(canvas, projection, snapshot);
    }
}

void WorldLayer::draw_paths(Canvas& canvas, const Projection& projection, const sim::Snapshot& snapshot,
                         const Notes& notes) const {
    const float scale = projection.scale();
    const auto full = [](std::size_t) { return 1.0f; };
    std::vector<glm::vec3> points;
    const std::vector<int> bodies = path_bodies(scene_);
    for (std::size_t i = 0; i < notes.trails.size(); ++i) {
        const Path& trail = notes.trails[i];
        points.clear();
        for (const PathPoint& point : trail) {
            points.push_back(to_glm(point.at));
        }
        const double length = scene_.overlay.trail_time;
        const auto fade = [&](std::size_t k) {
            const double age = length > 0.0 ? (snapshot.time - trail[k].time) / length : 0.0;
            return static_cast<float>(std::ceil((1.0 - std::min(age, 1.0)) * fade_steps) / fade_steps);
        };
        const sim::BodyDef& body = scene_.bodies[static_cast<std::size_t>(bodies[i])];
        projection.stroke(canvas, points, {{panel_color(body), 1.0f}, 2.2f * scale, 0.0f}, fade);
    }
    for (const ContactPath& path : notes.contact_paths) {
        const auto faint = [](std::size_t) { return hop_alpha; };
        const Pen in_world{{path_in_world_color, 1.0f}, 1.5f * scale, 0.0f};
        const Pen on_body{{path_on_body_color, 1.0f}, 2.2f * scale, 0.0f};
        for (std::size_t i = 0; i < path.in_world.size(); ++i) {
            points.clear();
            for (const PathPoint& point : path.in_world[i]) {
                points.push_back(to_glm(point.at));
            }
            projection.stroke(canvas, points, in_world, full);
            if (i > 0 && is_hop_in_world(path, i)) {
                points = {to_glm(path.in_world[i - 1].back().at), to_glm(path.in_world[i].front().at)};
                projection.stroke(canvas, points, in_world, faint);
            }
        }
        const sim::BodySnapshot& body = snapshot.bodies[static_cast<std::size_t>(path.body)];
        const auto in_the_world = [&](const Vec3& at) {
            return to_glm(Vec3(body.position + body.orientation * at));
        };
        for (std::size_t i = 0; i < path.on_body.size(); ++i) {
            points.clear();
            for (const PathPoint& point : path.on_body[i]) {
                points.push_back(in_the_world(point.at));
            }
            projection.stroke(canvas, points, on_body, full);
            if (i > 0 && is_hop(path.on_body[i - 1], path.on_body[i])) {
                points.clear();
                for (const Vec3& at : hop(path.on_body[i - 1], path.on_body[i])) {
                    points.push_back(in_the_world(at));
                }
                projection.stroke(canvas, points, on_body, faint);
            }
        }
    }
}

/// Arrows show what acts on the body that moves; on the first of two: -1 if that is the second.
float WorldLayer::side_of(const sim::ContactSnapshot& contact) const {
    return scene_.bodies[static_cast<std::size_t>(contact.bodies[0])].is_static() ? -1.0f : 1.0f;
}

/// Over a darker rim; fainter where its start is hidden.
void WorldLayer::draw_arrow(Canvas& canvas, const Projection& projection, const Arrow& arrow) const {
    const Projection::Place from = projection.place(arrow.from);
    const Projection::Place to = projection.place(arrow.from + arrow.along);
    if (!from.is_before_camera || !to.is_before_camera) {
        return;
    }
    const float scale = projection.scale();
    const float alpha = from.is_visible ? 1.0f : 0.5f;
    canvas.arrow(from.at, to.at, 11.0f * scale, {{dark, 0.45f * alpha}, 3.6f * scale, 0.0f});
    canvas.arrow(from.at, to.at, 9.0f * scale, {{arrow.color, alpha}, 2.0f * scale, 0.0f});
}

void WorldLayer::draw_impacts(Canvas& canvas, const Projection& projection, const sim::Snapshot& snapshot) const {
    for (const sim::ContactSnapshot& impact : snapshot.impacts) {
        const float factor = side_of(impact) * static_cast<float>(impact_scale_);
        draw_arrow(canvas, projection, {vec3_of(impact.point), factor * vec3_of(impact.impulse), impact_color});
    }
}

void WorldLayer::draw_contacts(Canvas& canvas, const Projection& projection,
                               const sim::Snapshot& snapshot) const {
    const float scale = projection.scale();
    const bool has_points = scene_.overlay.shows(Shown::points);
    const bool has_normals = scene_.overlay.shows(Shown::normals);
    const bool has_impulses = scene_.overlay.shows(Shown::impulses);
    for (const sim::ContactSnapshot& contact : snapshot.contacts) {
        const float side = side_of(contact);
        const glm::vec3 point = vec3_of(contact.point);
        const Projection::Place from = projection.place(point);
        if (!from.is_before_camera) {
            continue;
        }
        const glm::vec3 color = contact.is_sticking ? sticking_color : sliding_color;
        const float alpha = from.is_visible ? 1.0f : hidden_alpha;
        if (has_normals) {
            const Projection::Place end = projection.place(
                point + side * static_cast<float>(normal_in_views * view_) * vec3_of(contact.normal));
            if (end.is_before_camera) {
                canvas.arrow(from.at, end.at, 0.0f, {{{1.0f, 1.0f, 1.0f}, 0.9f * alpha}, 1.3f * scale, 0.0f});
            }
        }
        if (has_impulses) {
            const glm::vec3 along = side * static_cast<float>(arrow_scale_) * vec3_of(contact.impulse);
            draw_arrow(canvas, projection, {point, along, color});
        }
        if (has_points) {
            canvas.disc(from.at, 4.4f * scale, {dark, 0.7f * alpha});
            canvas.disc(from.at, 3.2f * scale, {color, alpha});
        }
    }
}

} // namespace render
