#include "tests/laws/law_solids.h"

#include "sim/model/polytope.h"

namespace laws {
namespace {

using reference::Piece;

Piece piece(const sim::Box& box, const sim::Pose& pose) {
    return {reference::OrientedBox{pose.position, pose.orientation.toRotationMatrix(), box.half_extents}};
}
Piece piece(const sim::Sphere& sphere, const sim::Pose& pose) {
    return {reference::Ball{pose.position, sphere.radius}};
}
Piece piece(const sim::Cylinder& cylinder, const sim::Pose& pose) {
    return {reference::Rod{pose.position, pose.orientation * sim::Vec3::UnitZ(), cylinder.half_length, cylinder.radius,
                           0.0}};
}
Piece piece(const sim::Capsule& capsule, const sim::Pose& pose) {
    return {reference::Rod{pose.position, pose.orientation * sim::Vec3::UnitZ(), capsule.half_length, 0.0,
                           capsule.radius}};
}
Piece piece(const sim::Hull& hull, const sim::Pose& pose) {
    reference::Polyhedron solid;
    for (const sim::Vec3& vertex : hull.polytope->vertices) {
        solid.vertices.push_back(pose * vertex);
    }
    for (const sim::Polytope::Face& face : hull.polytope->faces) {
        solid.normals.push_back(pose.orientation * face.normal);
    }
    for (const sim::Polytope::Edge& edge : hull.polytope->edges) {
        solid.edges.push_back(pose.orientation * edge.direction);
    }
    return {solid};
}
Piece piece(const sim::Plane&, const sim::Pose&) {
    return {reference::HalfSpace{}};
}

void add_pieces(const sim::Compound& compound, reference::Solid& solid) {
    for (const sim::CompoundPart& part : compound.parts) {
        solid.pieces.push_back(
            std::visit([&](const auto& shape) { return piece(shape, part.body_from_part); }, part.shape));
    }
}

template <class Primitive>
void add_pieces(const Primitive& primitive, reference::Solid& solid) {
    solid.pieces.push_back(piece(primitive, {}));
}

} // namespace

std::vector<reference::Solid> solids(const sim::SceneDef& scene) {
    std::vector<reference::Solid> all;
    for (const sim::BodyDef& def : scene.bodies) {
        reference::Solid solid;
        solid.is_static = def.is_static();
        std::visit([&](const auto& shape) { add_pieces(shape, solid); }, def.shape);
        all.push_back(std::move(solid));
    }
    return all;
}

std::vector<reference::Placement> placements(const sim::Snapshot& snapshot) {
    std::vector<reference::Placement> all;
    for (const sim::BodySnapshot& state : snapshot.bodies) {
        all.push_back({state.position, state.orientation});
    }
    return all;
}

} // namespace laws
