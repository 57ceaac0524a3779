#include "tests/laws/law_solids.h"

namespace laws {
namespace {

reference::Piece piece(const sim::PrimitiveShape& shape, const sim::Pose& pose) {
    if (const auto* box = std::get_if<sim::Box>(&shape)) {
        return {
            reference::OrientedBox{pose.position, pose.orientation.toRotationMatrix(), box->half_extents}};
    }
    return {reference::Ball{pose.position, std::get<sim::Sphere>(shape).radius}};
}

} // namespace

std::vector<reference::Solid> solids(const sim::SceneDef& scene) {
    std::vector<reference::Solid> all;
    for (const sim::BodyDef& def : scene.bodies) {
        reference::Solid solid;
        solid.is_static = def.is_static();
        if (const auto* compound = std::get_if<sim::Compound>(&def.shape)) {
            for (const sim::CompoundPart& part : compound->parts) {
                solid.pieces.push_back(piece(part.shape, part.body_from_part));
            }
        } else if (const auto* box = std::get_if<sim::Box>(&def.shape)) {
            solid.pieces.push_back(piece(*box, {}));
        } else if (const auto* sphere = std::get_if<sim::Sphere>(&def.shape)) {
            solid.pieces.push_back(piece(*sphere, {}));
        } else {
            solid.pieces.push_back({reference::HalfSpace{}});
        }
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
