#include "sim/collide/convex.h"

#include "sim/base/sort_once.h"
#include "sim/model/polytope.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

using Kind = CoreFeature::Kind;

/// Vertices within this share [-] of the size of the farthest count as equally far.
constexpr double equally_far = 1e-9;

/// A cylinder's rim is left out where the direction leans towards the other end by more than this [-] (cosine),
/// its side where the direction is this near to its axis.
constexpr double rim_reach = 0.3;
constexpr double side_reach = 0.95;

void set_core(Convex& convex, const Box& box) {
    convex.kind = CoreKind::polytope;
    convex.polytope = &unit_cube();
    convex.scale = box.half_extents;
    convex.size = box.half_extents.norm();
}

void set_core(Convex& convex, const Sphere& sphere) {
    convex.rounding = sphere.radius;
}

void set_core(Convex& convex, const Cylinder& cylinder) {
    convex.kind = CoreKind::cylinder;
    convex.radius = cylinder.radius;
    convex.half_length = cylinder.half_length;
    convex.size = std::hypot(cylinder.radius, cylinder.half_length);
}

void set_core(Convex& convex, const Capsule& capsule) {
    convex.kind = CoreKind::segment;
    convex.rounding = capsule.radius;
    convex.half_length = convex.size = capsule.half_length;
}

void set_core(Convex& convex, const Hull& hull) {
    convex.kind = CoreKind::polytope;
    convex.polytope = hull.polytope.get();
    convex.size = hull.polytope->radius;
}

using Two = double __attribute__((vector_size(16)));

/// Heights of two vertices along u (in the part's frame, scaled).
Two heights(const Polytope::TwoVertices& of, const Vec3& u) {
    const auto load = [](const double* from) { return Two{from[0], from[1]}; };
    return load(of.x) * u.x() + load(of.y) * u.y() + load(of.z) * u.z();
}

double largest_height(const Polytope& polytope, const Vec3& u) {
    Two largest = heights(polytope.by_twos[0], u);
    for (const Polytope::TwoVertices& vertices : polytope.by_twos) {
        const Two h = heights(vertices, u);
        largest = largest < h ? h : largest;
    }
    return std::max(largest[0], largest[1]);
}

/// f(index) for the vertices that are at least so high, ascending, until it returns true.
template <typename F>
void for_each_as_high(const Polytope& polytope, const Vec3& u, double height, F&& f) {
    for (std::size_t i = 0; i < polytope.vertices.size(); i += 2) {
        const Two h = heights(polytope.by_twos[i / 2], u);
        if ((h[0] >= height && f(static_cast<int>(i))) ||
            (h[1] >= height && i + 1 < polytope.vertices.size() && f(static_cast<int>(i + 1)))) {
            return;
        }
    }
}

Vec3 in_frame_of_part(const Convex& convex, const Vec3& u) {
    const Mat3& turn = convex.turn;
    return {turn.col(0).dot(u), turn.col(1).dot(u), turn.col(2).dot(u)};
}

/// The same, scaled as the vertices are.
Vec3 in_part(const Convex& convex, const Vec3& u) {
    return in_frame_of_part(convex, u).cwiseProduct(convex.scale);
}

CoreFeature& add(std::vector<CoreFeature>& features, Kind kind, int index) {
    CoreFeature& feature = features.emplace_back();
    feature.kind = kind;
    feature.index = index;
    return feature;
}

void add_face(const Convex& convex, int index, std::vector<CoreFeature>& features) {
    const Polytope::Face& face = convex.polytope->faces[static_cast<std::size_t>(index)];
    CoreFeature& feature = add(features, Kind::face, index);
    feature.point = convex.vertex(face.corner);
    feature.direction = convex.turned(face.normal);
}

void add_axis_features(const Convex& convex, const Vec3& u, std::vector<CoreFeature>& features) {
    const Vec3 axis = convex.axis();
    const Vec3& middle = convex.world_from_part.position;
    const double along = axis.dot(u);
    const double l = convex.half_length;
    for (const int end : {0, 1}) {
        const double side = end == 0 ? 1.0 : -1.0;
        const Vec3 tip = middle + side * l * axis;
        if (convex.kind == CoreKind::segment) {
            features.push_back({Kind::vertex, end, tip, Vec3::Zero(), 0.0, 0.0});
        } else if (side * along > -rim_reach) {
            features.push_back({Kind::rim, end, tip, axis, convex.radius, 0.0});
            features.push_back({Kind::face, end, tip, side * axis, convex.radius, 0.0});
        }
    }
    if (convex.kind == CoreKind::segment || std::abs(along) < side_reach) {
        features.push_back({Kind::edge, 0, middle, axis, convex.radius, l});
    }
}

/// Calls f for what meets in any of the vertices, these features, each once, in the order of the indices. f adds features.
template <typename F>
void for_each_around(const Polytope::Around& around, std::size_t vertex_count, const std::vector<CoreFeature>& features, F&& f) {
    if (vertex_count == 1) {
        std::ranges::for_each(around.of(features[0].index), f);
        return;
    }
    std::vector<int> all;
    for (const CoreFeature& vertex : std::span(features).first(vertex_count)) {
        const std::span<const int> own = around.of(vertex.index);
        all.insert(all.end(), own.begin(), own.end());
    }
    sort_once(all);
    std::ranges::for_each(all, f);
}

void add_polytope_features(const Convex& convex, const Vec3& u, std::vector<CoreFeature>& features, bool with_edges) {
    const Polytope& polytope = *convex.polytope;
    const Vec3 local = in_part(convex, u);
    for_each_as_high(polytope, local, largest_height(polytope, local) - equally_far * convex.size, [&](int v) {
        add(features, Kind::vertex, v).point = convex.vertex(v);
        return false;
    });
    const std::size_t vertex_count = features.size();
    for_each_around(polytope.faces_around, vertex_count, features, [&](int f) { add_face(convex, f, features); });
    if (!with_edges) {
        return;
    }
    for_each_around(polytope.edges_around, vertex_count, features, [&](int e) {
        const Polytope::Edge& edge = polytope.edges[static_cast<std::size_t>(e)];
        CoreFeature& feature = add(features, Kind::edge, e);
        feature.point = convex.placed(edge.middle);
        feature.direction = convex.turned(edge.direction);
        feature.length = convex.scale.cwiseProduct(edge.direction).norm() * edge.half_length;
    });
}

} // namespace

Vec3 Convex::vertex(int i) const {
    return placed(polytope->vertices[static_cast<std::size_t>(i)]);
}

Vec3 Convex::centre() const {
    return polytope != nullptr ? placed(polytope->centre) : world_from_part.position;
}

Convex placed(const PrimitiveShape& shape, const Pose& world_from_body, const Pose& body_from_part) {
    Convex convex;
    convex.world_from_body = world_from_body;
    convex.body_from_part = body_from_part;
    convex.world_from_part = world_from_body * body_from_part;
    convex.turn = convex.world_from_part.orientation.toRotationMatrix();
    std::visit([&](const auto& s) { set_core(convex, s); }, shape);
    return convex;
}

double support_height(const Convex& convex, const Vec3& u) {
    switch (convex.kind) {
    case CoreKind::point:
        return 0.0;
    case CoreKind::segment:
        return convex.half_length * std::abs(convex.axis().dot(u));
    case CoreKind::cylinder: {
        const double along = convex.axis().dot(u);
        return convex.half_length * std::abs(along) + convex.radius * (u - along * convex.axis()).norm();
    }
    case CoreKind::polytope:
        break;
    }
    return largest_height(*convex.polytope, in_part(convex, u));
}

Vec3 support_point(const Convex& convex, const Vec3& u) {
    const Vec3& origin = convex.world_from_part.position;
    if (convex.kind == CoreKind::point) {
        return origin;
    }
    if (convex.kind == CoreKind::polytope) {
        return convex.vertex(support_vertex(convex, u));
    }
    const Vec3 axis = convex.axis();
    const Vec3 tip = origin + (axis.dot(u) >= 0.0 ? convex.half_length : -convex.half_length) * axis;
    return convex.kind == CoreKind::segment ? tip : lowest_rim_point(tip, axis, convex.radius, -u);
}

int support_vertex(const Convex& convex, const Vec3& u) {
    const Vec3 local = in_part(convex, u);
    int farthest = 0;
    for_each_as_high(*convex.polytope, local, largest_height(*convex.polytope, local), [&](int v) {
        farthest = v;
        return true;
    });
    return farthest;
}

Vec3 support_middle(const Convex& convex, const Vec3& u, double slack) {
    if (convex.kind == CoreKind::polytope) {
        const Polytope& polytope = *convex.polytope;
        const Vec3 local = in_part(convex, u);
        Vec3 sum = Vec3::Zero();
        int count = 0;
        for_each_as_high(polytope, local, largest_height(polytope, local) - slack, [&](int v) {
            sum += polytope.vertices[static_cast<std::size_t>(v)];
            ++count;
            return false;
        });
        return convex.placed(sum / count);
    }
    const Vec3 axis = convex.axis();
    const double along = axis.dot(u);
    const Vec3 across = u - along * axis;
    const bool is_level = 2.0 * convex.half_length * std::abs(along) <= slack; // its side, not an end
    const bool is_upright = 2.0 * convex.radius * across.norm() <= slack;
    return convex.world_from_part.position + (is_level ? 0.0 : std::copysign(convex.half_length, along)) * axis +
           (is_upright ? 0.0 : convex.radius) * across.stableNormalized();
}

void near_features(const Convex& convex, const Vec3& u, std::vector<CoreFeature>& features, bool with_edges) {
    features.clear();
    if (convex.kind == CoreKind::point) {
        features.push_back({CoreFeature::Kind::vertex, 0, convex.world_from_part.position, Vec3::Zero(), 0.0, 0.0});
    } else if (convex.kind == CoreKind::polytope) {
        add_polytope_features(convex, u, features, with_edges);
    } else {
        add_axis_features(convex, u, features);
    }
}

void faces_along(const Convex& convex, const Vec3& u, double cosine, std::vector<CoreFeature>& features) {
    features.clear();
    if (convex.kind == CoreKind::cylinder) {
        add_axis_features(convex, u, features);
        std::erase_if(features, [&](const CoreFeature& f) { return f.kind != Kind::face || f.direction.dot(u) <= cosine; });
    } else if (convex.kind == CoreKind::polytope) {
        const Vec3 local = in_frame_of_part(convex, u);
        for (std::size_t f = 0; f < convex.polytope->faces.size(); ++f) {
            if (convex.polytope->faces[f].normal.dot(local) > cosine) {
                add_face(convex, static_cast<int>(f), features);
            }
        }
    }
}

} // namespace sim
