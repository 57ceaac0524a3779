#include "sim/collide/convex.h"

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

/// Index of the farthest vertex along u (in the part's frame, scaled).
int farthest_vertex(const Polytope& polytope, const Vec3& u) {
    std::size_t best = 0;
    double height = polytope.vertices[0].dot(u);
    for (std::size_t i = 1; i < polytope.vertices.size(); ++i) {
        const double h = polytope.vertices[i].dot(u);
        best = h > height ? i : best;
        height = std::max(h, height);
    }
    return static_cast<int>(best);
}

/// u in the part's frame, scaled as the vertices are.
Vec3 in_part(const Convex& convex, const Vec3& u) {
    const Mat3& turn = convex.turn;
    return Vec3(turn.col(0).dot(u), turn.col(1).dot(u), turn.col(2).dot(u)).cwiseProduct(convex.scale);
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
    std::ranges::sort(all);
    all.erase(std::unique(all.begin(), all.end()), all.end());
    std::ranges::for_each(all, f);
}

void add_polytope_features(const Convex& convex, const Vec3& u, std::vector<CoreFeature>& features, bool with_edges) {
    const Polytope& polytope = *convex.polytope;
    const Vec3 local = in_part(convex, u);
    const double limit = polytope.vertices[static_cast<std::size_t>(farthest_vertex(polytope, local))].dot(local) -
                         equally_far * convex.size;
    for (int v = 0; v < static_cast<int>(polytope.vertices.size()); ++v) {
        if (polytope.vertices[static_cast<std::size_t>(v)].dot(local) >= limit) {
            features.push_back({Kind::vertex, v, convex.vertex(v), Vec3::Zero(), 0.0, 0.0});
        }
    }
    const std::size_t vertex_count = features.size();
    for_each_around(polytope.faces_around, vertex_count, features, [&](int f) {
        const Polytope::Face& face = polytope.faces[static_cast<std::size_t>(f)];
        features.push_back({Kind::face, f, convex.vertex(face.corner), convex.turned(face.normal), 0.0, 0.0});
    });
    if (!with_edges) {
        return;
    }
    for_each_around(polytope.edges_around, vertex_count, features, [&](int e) {
        const Polytope::Edge& edge = polytope.edges[static_cast<std::size_t>(e)];
        features.push_back({Kind::edge, e, convex.placed(edge.middle), convex.turned(edge.direction), 0.0,
                            convex.scale.cwiseProduct(edge.direction).norm() * edge.half_length});
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
    const Vec3 local = in_part(convex, u);
    double height = convex.polytope->vertices[0].dot(local);
    for (const Vec3& vertex : convex.polytope->vertices) {
        height = std::max(height, vertex.dot(local));
    }
    return height;
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
    return farthest_vertex(*convex.polytope, in_part(convex, u));
}

Vec3 support_middle(const Convex& convex, const Vec3& u, double slack) {
    if (convex.kind == CoreKind::polytope) {
        const std::vector<Vec3>& vertices = convex.polytope->vertices;
        const Vec3 local = in_part(convex, u);
        const double limit = support_height(convex, u) - slack;
        Vec3 sum = Vec3::Zero();
        int count = 0;
        for (const Vec3& vertex : vertices) {
            if (vertex.dot(local) >= limit) {
                sum += vertex;
                ++count;
            }
        }
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

} // namespace sim
