#include "sim/collide/convex_pair.h"

#include "sim/collide/feature_contacts.h"
#include "sim/model/polytope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace sim {
namespace {

/// Points fixed to a rim that stand for it where a cylinder's end lies flat.
constexpr int rim_points = 8;

/// A cylinder's end counts as flat [rad] where its fixed points alone say the gap to 1e-8 of its radius: of a stack at rest, which
/// leans by less, the lowest point of the rim is another one in every step, and at 1e-9 eight cylinders that stand take nine sweeps a
/// step, not one. Its end faces the other body, rather than its side, up to 45 degrees.
constexpr double flat_end = 1e-7;
constexpr double end_cosine = 0.70710678;

/// Share [-] of the size by which a point may stick out of a face and still count as inside.
constexpr double aligned_features = 1e-6;

/// Of more corners than a block holds the lowest is kept where it is that by more than this share [-] of the margin: at 0 stacks of
/// coins and drums shake (`law_stack.cylinders_turned...`).
constexpr double lowest_share = 0.1;

/// Contacts nearer to each other than this share [-] of the sizes are at one place.
constexpr double same_place = 1e-3;

/// Well apart: by this share [-] of both bodies' sizes.
constexpr double well_apart = 1e-3;

/// A cylinder that leans by more [-] (sine) rolls on the lowest point of its rim. The fixed points beside that are left out: they reach
/// the ground without a speed, but would hit it within the tolerance above it (`law_cylinder.eulers_disk_keeps...`). As small as
/// flat_end, they would go and come in each step of a stack (`law_stack.cylinders_turned...`); at 1e-5 they do not.
constexpr double rolling_lean = 1e-3;

using Kind = CoreFeature::Kind;

/// A flat surface that another body lies on: a face of a convex part, or a half space without rim.
struct Ground {
    Pose world_from_body;
    Vec3 point;  ///< [m], world
    Vec3 normal; ///< unit, outwards, world
    bool is_a = false;
    int index = 0;
    std::vector<Vec3> rim; ///< corners [m], counter-clockwise seen from outside; empty: no rim

    double height(const Vec3& x) const { return normal.dot(x - point); }
};

/// A point of the body on the ground, with the ball around it, or a rim.
struct Foot {
    Vec3 core;              ///< [m], world
    double radius = 0.0;    ///< [m]
    std::uint64_t code = 0; ///< what it is: the same from step to step
    Vec3 axis = Vec3::Zero(); ///< unit, world, of a rim
    double rim_radius = 0.0;  ///< [m]; 0: no rim
};

Vec3 rim_point(const Convex& cylinder, int end, int k) {
    const double angle = 2.0 * std::numbers::pi * k / rim_points;
    return cylinder.world_from_part * Vec3(cylinder.radius * std::cos(angle), cylinder.radius * std::sin(angle),
                                           end == 0 ? cylinder.half_length : -cylinder.half_length);
}

Ground face_ground(const Convex& convex, const CoreFeature& face, bool is_a) {
    Ground ground{convex.world_from_body, convex.world_from_part.position, face.direction, is_a, face.index, {}};
    ground.point += support_height(convex, face.direction) * face.direction;
    if (convex.kind == CoreKind::polytope) {
        const std::vector<int>& loop = convex.polytope->faces[static_cast<std::size_t>(face.index)].loop;
        ground.rim.reserve(loop.size());
        for (const int v : loop) {
            ground.rim.push_back(convex.vertex(v));
        }
    } else {
        for (int k = 0; k < rim_points; ++k) {
            ground.rim.push_back(rim_point(convex, face.index, face.index == 0 ? k : rim_points - k));
        }
    }
    return ground;
}

/// Collects the feet of one body on a ground.
class Footing {
public:
    Footing(const Ground& ground, const Convex& convex)
        : ground_(ground), convex_(convex), slack_(aligned_features * convex.size) {
        sides_.reserve(ground.rim.size());
        feet_.reserve(usual_feet);
        for (std::size_t i = 0; i < ground.rim.size(); ++i) {
            const Vec3& from = ground.rim[i];
            const Vec3& to = ground.rim[(i + 1) % ground.rim.size()];
            const Vec3 outwards = (to - from).cross(ground.normal).stableNormalized();
            sides_.push_back({outwards, outwards.dot(from)});
            slack_ = std::max(slack_, aligned_features * (to - from).norm());
        }
    }

    std::vector<Foot> find() {
        switch (convex_.kind) {
        case CoreKind::point:
            add_point(convex_.world_from_part.position, 0);
            break;
        case CoreKind::segment:
            add_segment(0.0);
            break;
        case CoreKind::cylinder:
            add_cylinder();
            break;
        case CoreKind::polytope:
            add_polytope();
            break;
        }
        return std::move(feet_);
    }

private:
    struct Side {
        Vec3 outwards;
        double offset; ///< [m]
    };
    struct Corner {
        Vec3 x;
        std::uint64_t before; ///< edge that ends here
        std::uint64_t after;  ///< edge that starts here
    };

    static constexpr std::size_t usual_feet = 8; ///< for time only

    /// Edges of the clipping face are numbered from here.
    static constexpr std::uint64_t clipping = 1u << 20;

    bool is_inside(const Vec3& x) const {
        return std::ranges::all_of(sides_, [&](const Side& side) {
            return side.outwards.dot(x) - side.offset <= slack_;
        });
    }

    void add_point(const Vec3& x, std::uint64_t code) {
        if (is_inside(x)) {
            feet_.push_back({.core = x, .radius = convex_.rounding, .code = code});
        }
    }

    /// A cylinder's cross-section at t [m] along its axis.
    Foot rim_foot(double t, std::uint64_t code) const {
        const Vec3 axis = convex_.axis();
        return {.core = convex_.world_from_part.position + t * axis, .code = code, .axis = axis, .rim_radius = convex_.radius};
    }

    /// Both ends of the lowest segment of a capsule (radius 0) or a cylinder's side, as far as it lies over the ground.
    void add_segment(double radius) {
        const Vec3 axis = convex_.axis();
        const Vec3& middle = convex_.world_from_part.position;
        const Vec3 down = (ground_.normal - axis * axis.dot(ground_.normal)).stableNormalized() * radius;
        double from = -convex_.half_length;
        double to = convex_.half_length;
        for (const Side& side : sides_) {
            const double slope = side.outwards.dot(axis);
            const double at_middle = side.outwards.dot(middle - down) - side.offset - slack_;
            if (slope == 0.0) {
                to = at_middle > 0.0 ? -std::abs(to) - 1.0 : to;
            } else if (slope > 0.0) {
                to = std::min(to, -at_middle / slope);
            } else {
                from = std::max(from, -at_middle / slope);
            }
        }
        if (from > to) {
            return;
        }
        for (const double t : {to, from}) {
            const std::uint64_t code = (t == to ? 0u : 1u) + (std::abs(t) < convex_.half_length ? 2u : 0u);
            if (radius > 0.0) {
                feet_.push_back(rim_foot(t, code));
            } else {
                feet_.push_back({.core = middle + t * axis, .radius = convex_.rounding, .code = code});
            }
        }
    }

    void add_cylinder() {
        const double along = convex_.axis().dot(ground_.normal);
        if (std::abs(along) < end_cosine) {
            add_segment(convex_.radius);
            return;
        }
        const int end = along < 0.0 ? 0 : 1;
        const Foot rim = rim_foot(end == 0 ? convex_.half_length : -convex_.half_length, static_cast<std::uint64_t>(end));
        const Vec3 lowest = lowest_rim_point(rim.core, rim.axis, rim.rim_radius, ground_.normal);
        const double lean = convex_.axis().cross(ground_.normal).norm();
        const bool has_lowest = lean > flat_end && is_inside(lowest);
        const double beside = 2.0 * std::sin(std::numbers::pi / rim_points) * convex_.radius; // [m] from one fixed point to the next
        std::vector<Corner> corners;
        for (int k = 0; k < rim_points; ++k) {
            const Vec3 at = rim_point(convex_, end, k);
            const auto code = static_cast<std::uint64_t>(rim_points * end + k);
            if (!has_lowest || lean <= rolling_lean || (at - lowest).norm() >= beside) {
                corners.push_back({at, 16 + code, 16 + (code + 1) % rim_points});
            }
        }
        add_clipped(std::move(corners));
        if (has_lowest) {
            feet_.push_back(rim);
        }
    }

    void add_polytope() {
        const Polytope& polytope = *convex_.polytope;
        if (sides_.empty()) {
            for (int v = 0; v < static_cast<int>(polytope.vertices.size()); ++v) {
                add_point(convex_.vertex(v), static_cast<std::uint64_t>(v));
            }
            return;
        }
        // The face at the lowest vertex that lies flattest; an edge of it is called after the vertex it starts at.
        const Vec3 up = convex_.world_from_part.orientation.conjugate() * ground_.normal;
        const std::span<const int> faces = polytope.faces_around.of(support_vertex(convex_, -ground_.normal));
        const int face = *std::ranges::min_element(faces, {}, [&](int f) {
            return polytope.faces[static_cast<std::size_t>(f)].normal.dot(up);
        });
        const std::vector<int>& loop = polytope.faces[static_cast<std::size_t>(face)].loop;
        std::vector<Corner> corners;
        corners.reserve(loop.size() + sides_.size());
        for (std::size_t i = 0; i < loop.size(); ++i) {
            corners.push_back({convex_.vertex(loop[i]), static_cast<std::uint64_t>(loop[(i + loop.size() - 1) % loop.size()]),
                               static_cast<std::uint64_t>(loop[i])});
        }
        add_clipped(std::move(corners));
    }

    /// Keeps the part of a polygon over the ground (Sutherland & Hodgman 1974).
    void add_clipped(std::vector<Corner> polygon) {
        std::vector<Corner> kept;
        kept.reserve(polygon.size() + sides_.size());
        for (std::size_t s = 0; s < sides_.size(); ++s) {
            const Side& side = sides_[s];
            kept.clear();
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Corner& p = polygon[i];
                const Corner& q = polygon[(i + 1) % polygon.size()];
                const double out_p = side.outwards.dot(p.x) - side.offset - slack_;
                const double out_q = side.outwards.dot(q.x) - side.offset - slack_;
                if (out_p <= 0.0) {
                    kept.push_back(p);
                }
                if ((out_p < 0.0 && out_q > 0.0) || (out_p > 0.0 && out_q < 0.0)) {
                    const Vec3 x = p.x + (q.x - p.x) * (out_p / (out_p - out_q));
                    const std::uint64_t cut = clipping + s;
                    kept.push_back(out_p < 0.0 ? Corner{x, p.after, cut} : Corner{x, cut, p.after});
                }
            }
            std::swap(polygon, kept);
        }
        for (const Corner& corner : polygon) {
            feet_.push_back({.core = corner.x, .code = (corner.before << 24) + corner.after + 64});
        }
    }

    const Ground& ground_;
    const Convex& convex_;
    double slack_; ///< [m]
    std::vector<Side> sides_;
    std::vector<Foot> feet_;
};

/// The contact of a foot with a ground.
FoundContact foot_contact(const Ground& ground, const Convex& convex, const Foot& foot, std::uint64_t id) {
    FoundContact contact;
    ContactFeature& f = contact.feature;
    f.id = id;
    const bool is_rim = foot.rim_radius > 0.0;
    f.kind = ground.is_a ? (is_rim ? FeatureKind::rim_on_face_a : FeatureKind::face_a)
                         : (is_rim ? FeatureKind::rim_on_face_b : FeatureKind::face_b);
    (ground.is_a ? f.core_a : f.core_b) =
        in_frame(ground.world_from_body, foot.core - ground.height(foot.core) * ground.normal);
    (ground.is_a ? f.direction_a : f.direction_b) = ground.world_from_body.orientation.conjugate() * ground.normal;
    (ground.is_a ? f.core_b : f.core_a) = in_frame(convex.world_from_body, foot.core);
    (ground.is_a ? f.direction_b : f.direction_a) = convex.world_from_body.orientation.conjugate() * foot.axis;
    (ground.is_a ? f.radius_b : f.radius_a) = is_rim ? foot.rim_radius : foot.radius;
    contact.at = ground.is_a ? contact_geometry(f, ground.world_from_body, convex.world_from_body)
                             : contact_geometry(f, convex.world_from_body, ground.world_from_body);
    return contact;
}

/// All feet of a body on a ground with gap <= margin. least [m]: see add_raised().
void ground_contacts(const Ground& ground, const Convex& convex, const ContactList& list,
                     double least = -std::numeric_limits<double>::infinity()) {
    std::vector<FoundContact>& contacts = list.contacts;
    const std::size_t first = contacts.size();
    for (const Foot& foot : Footing(ground, convex).find()) {
        if (ground.height(foot.core) - foot.radius - foot.rim_radius > 2.0 * list.margin) {
            continue; // far beyond it
        }
        // Rims first: what a block's first contact is decides how the others are measured.
        const std::uint64_t group = (ground.is_a ? 1 : 3) + (foot.rim_radius > 0.0 ? 0u : 1u);
        const std::uint64_t id = contact_id(group, static_cast<std::uint64_t>(ground.index), foot.code, 0);
        add_raised(foot_contact(ground, convex, foot, list.id_base + id), least, list);
    }
    keep_outermost(contacts, first, lowest_share * list.margin);
}

/// Takes out the contacts from number `feet` on that lie at one of those from `first` on: the corner of a clipped face where the
/// edges cross is their contact once more, with another normal, and iterations over two such normals at one point come to no end.
void drop_at(std::size_t first, std::size_t feet, double distance, std::vector<FoundContact>& contacts) {
    const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
    const auto from = contacts.begin() + static_cast<std::ptrdiff_t>(feet);
    const auto is_there = [&](const FoundContact& foot) {
        return std::any_of(begin, from, [&](const FoundContact& at) { return (foot.at.a - at.at.a).norm() <= distance; });
    };
    contacts.erase(std::remove_if(from, contacts.end(), is_there), contacts.end());
}

} // namespace

void convex_contacts(const Convex& a, const Convex& b, const ContactList& list, const Vec3* near) {
    const double rounding = a.rounding + b.rounding;
    const Separation found = find_separation(a, b, list.margin + rounding, near);
    const double gap = found.best.core_gap - rounding;
    if (found.is_beyond || gap > list.margin) {
        return;
    }
    const std::size_t first = list.contacts.size();
    if (!found.best.is_face()) {
        feature_contacts(a, b, found.best, gap, list);
        const bool cross = found.best.a.kind != Kind::vertex && found.best.b.kind != Kind::vertex;
        if (cross && found.best_face.is_face() && found.best_face.n.dot(found.best.n) > nearly_flat) {
            // The crossing edges keep the face's feet apart, which lie beyond its rim.
            const bool is_a = found.best_face.is_face_of_a;
            const std::size_t feet = list.contacts.size();
            ground_contacts(face_ground(is_a ? a : b, is_a ? found.best_face.a : found.best_face.b, is_a),
                            is_a ? b : a, list, gap);
            drop_at(first, feet, same_place * (a.size + b.size), list.contacts);
        }
        return;
    }
    const bool is_a = found.best.is_face_of_a;
    const Ground ground = face_ground(is_a ? a : b, is_a ? found.best.a : found.best.b, is_a);
    const Convex& other = is_a ? b : a;
    std::vector<FoundContact>& contacts = list.contacts;
    ground_contacts(ground, other, list);
    const double lowest = std::transform_reduce(
        contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(),
        std::numeric_limits<double>::infinity(), [](double x, double y) { return std::min(x, y); },
        [](const FoundContact& c) { return c.at.gap; });
    if (lowest > gap + same_gap * other.size) {
        // The lowest point lies on the ground's rim, or on the arc that the fixed points of a cylinder's end leave out.
        Foot foot{.core = support_point(other, -ground.normal), .radius = other.rounding};
        contacts.push_back(foot_contact(ground, other, foot, list.id_base + contact_id(0, 0, 0, 0)));
    }
}

Vec3 separating_direction(const Convex& a, const Convex& b) {
    const double rounding = a.rounding + b.rounding;
    return find_direction(a, b, rounding + well_apart * (a.size + b.size + rounding));
}

double convex_separation(const Convex& a, const Convex& b, const Vec3& n) {
    return core_gap(a, b, n) - a.rounding - b.rounding;
}

void convex_plane_contacts(const Convex& convex, const Pose& plane, bool plane_is_b, const ContactList& list) {
    const Ground ground{plane, plane.position, plane.orientation * Vec3::UnitZ(), !plane_is_b, 0, {}};
    ground_contacts(ground, convex, list);
}

double convex_plane_separation(const Convex& convex, const Pose& plane) {
    const Vec3 normal = plane.orientation * Vec3::UnitZ();
    return normal.dot(convex.world_from_part.position - plane.position) - support_height(convex, -normal) -
           convex.rounding;
}

} // namespace sim
