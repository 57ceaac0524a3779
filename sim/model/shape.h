#pragma once
/// Collision shapes and their mass properties.
#include "sim/base/math.h"

#include <limits>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace sim {

/// Half space z <= 0 of the body frame; its surface normal is +z. Static bodies only.
struct Plane {};

/// Axis-aligned in the body frame, centred at its origin.
struct Box {
    Vec3 half_extents = Vec3::Constant(0.5); ///< [m] > 0
};

/// Centred at the origin of its frame.
struct Sphere {
    double radius = 0.5; ///< [m] > 0
};

/// Axis along z of the body frame, centred at its origin.
struct Cylinder {
    double radius = 0.5;      ///< [m] > 0
    double half_length = 0.5; ///< [m] > 0
};

/// All points within `radius` of a segment along z, centred at the origin of the body frame.
struct Capsule {
    double radius = 0.5;      ///< [m] > 0
    double half_length = 0.5; ///< [m] > 0, of the segment
};

struct Polytope;

/// A convex body with flat faces, see polytope.h. Copies share it.
struct Hull {
    std::shared_ptr<const Polytope> polytope; ///< not null
};

/// One part of a compound, placed in the compound's frame.
using PrimitiveShape = std::variant<Box, Sphere, Cylinder, Capsule, Hull>;
struct CompoundPart {
    PrimitiveShape shape;
    Pose body_from_part;
};

/// Union of parts that move together (a top: bowl and stem). Parts may overlap.
struct Compound {
    std::vector<CompoundPart> parts; ///< at least one
};

using Shape = std::variant<Plane, Box, Sphere, Cylinder, Capsule, Hull, Compound>;

/// About the centre of mass. mass == 0 for a static body.
struct MassProperties {
    double mass = 0.0;                  ///< [kg]
    Vec3 centre_of_mass = Vec3::Zero(); ///< [m], in the frame the shape was given in
    Mat3 inertia = Mat3::Zero();        ///< [kg m^2], about the centre of mass, axes of that frame
};

/// Mass properties of a homogeneous shape. density [kg/m^3] > 0. Parts of a compound are summed as if they
/// did not overlap. A plane has none: CHECK.
MassProperties mass_properties(const Shape& shape, double density);

/// The same shape, given in a frame whose origin lies at `origin` [m] of the old one.
/// A hull stays one; another single shape that moves off its centre becomes a compound of one part.
Shape shifted(const Shape& shape, const Vec3& origin);

/// Axis-aligned bounding box in the world. An unbounded shape gives infinities.
struct Bounds {
    Vec3 lower = Vec3::Constant(-std::numeric_limits<double>::infinity()); ///< [m]
    Vec3 upper = Vec3::Constant(std::numeric_limits<double>::infinity());  ///< [m]
};
Bounds bounds(const Shape& shape, const Pose& world_from_body);

/// Of what is not there: overlaps nothing.
inline const Bounds no_bounds{Vec3::Constant(std::numeric_limits<double>::infinity()),
                              Vec3::Constant(-std::numeric_limits<double>::infinity())};

/// {"kind":"box","half_extents":[x,y,z]}, {"kind":"sphere","radius":r}, {"kind":"plane"},
/// {"kind":"cylinder" or "capsule","radius":r,"half_length":l}, {"kind":"hull","points":[[x,y,z],...],
/// "faces":[[i,j,k,...],...]} (indices of points, counter-clockwise from outside),
/// {"kind":"compound","parts":[{...,"position":[x,y,z],"orientation":[w,x,y,z]},...]}.
std::string shape_to_json(const Shape& shape);

} // namespace sim
