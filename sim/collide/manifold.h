#pragma once
/// Contacts of a pair of bodies. Here the direction of the normal and the sign of the gap are defined:
/// **n points from b to a; gap > 0 apart, penetration = -gap.**
#include "sim/model/body.h"

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace sim {

/// What the gap of a contact is measured between. Core: a point, or the centre of a ball, fixed to its body.
enum class FeatureKind : std::uint16_t {
    face_a, ///< core of b against a face of a; direction_a is that face's outward normal
    face_b, ///< core of a against a face of b; direction_b is that face's outward normal
    cores,  ///< core against core (ball and ball, ball and corner)
    line_a, ///< core of b against an edge of a with direction_a
    line_b, ///< core of a against an edge of b with direction_b
    edges,  ///< edge of a (direction_a) against edge of b (direction_b)
    rim_on_face_a, ///< rim of b (centre core_b, axis direction_b) against a face of a; its lowest point touches
    rim_on_face_b, ///< rim of a against a face of b
};

/// The features that touch, in body frames: from them gap, normal and points follow at any pose.
struct ContactFeature {
    std::uint64_t id : 56 = 0; ///< of the features within their pair; the same from step to step
    FeatureKind kind : 8 = FeatureKind::cores;
    Vec3 core_a = Vec3::Zero();      ///< [m] body frame of a
    Vec3 core_b = Vec3::Zero();      ///< [m] body frame of b
    Vec3 direction_a = Vec3::Zero(); ///< unit, body frame of a; edges: such that n is along direction_a x direction_b
    Vec3 direction_b = Vec3::Zero(); ///< unit, body frame of b
    double radius_a = 0.0;           ///< [m] of the ball around the core of a, or of the rim whose centre it is
    double radius_b = 0.0;           ///< [m]
    /// [m] added to the gap: a point that a face would count as inside, while crossing edges keep the bodies
    /// apart.
    double allowance = 0.0;
};

/// Is it a rim that touches?
inline bool is_rim(FeatureKind kind) {
    return kind == FeatureKind::rim_on_face_a || kind == FeatureKind::rim_on_face_b;
}

/// True where the surface is curved: a point fixed to the body leaves it within a step.
inline bool is_curved(const ContactFeature& feature) {
    return feature.radius_a > 0.0 || feature.radius_b > 0.0;
}

/// Is it a point of one body at a face of the other?
inline bool is_flat(const ContactFeature& feature) {
    return (feature.kind == FeatureKind::face_a || feature.kind == FeatureKind::face_b) && !is_curved(feature);
}

/// A pose with its rotation as a matrix, for bodies whose contacts are looked at many times.
struct PlacedBody {
    Vec3 position = Vec3::Zero();
    Mat3 rotation = Mat3::Identity();

    PlacedBody() = default;
    explicit PlacedBody(const Pose& pose)
        : position(pose.position), rotation(pose.orientation.toRotationMatrix()) {}

    Vec3 operator*(const Vec3& x) const { return position + rotation * x; }
};

/// Gap, normal and contact points of a feature at given poses.
struct ContactGeometry {
    double gap = 0.0;       ///< [m]
    Vec3 n = Vec3::UnitZ(); ///< unit, from b to a
    Vec3 a = Vec3::Zero();  ///< contact point on a [m]

    Vec3 b() const { return a - gap * n; } ///< contact point on b [m]
    Vec3 middle() const { return a - 0.5 * gap * n; }
};

/// What a contact hands to the next step, in the order that rest_kernel.cpp has; nothing where it has just been found.
struct ContactMemory {
    double p_n = 0.0;            ///< [N s]
    Vec3 p_t = Vec3::Zero();     ///< [N s], world; energy_taken() where there is no p_n
    double signed_interval = 0.0; ///< time those impulses stood for [s]; negative: it sticks (eq. 6)
    double force_share = 1.0;    ///< [-] of them that was a force; the rest answered an impact
    double last_interval = 0.0;  ///< [s] moved since; 0: they lack nothing (new, or after an impact)
    double approach_speed = 0.0; ///< [m/s] that a contact placed ahead of its impact took away

    double interval() const { return std::abs(signed_interval); }
    double energy_taken() const { return p_n == 0.0 ? p_t.x() : 0.0; } ///< [J] taken away with approach_speed
    bool is_sticking() const { return signed_interval < 0.0; }
    /// Share [-] of the impulses that acts after the instant (the half kick): velocities stored before the next impulses lack it.
    double owed() const { return signed_interval != 0.0 ? force_share * 0.5 * last_interval / interval() : 0.0; }
};

/// A contact as the narrow phase finds it: the features that touch, and their geometry at the poses it was given.
struct FoundContact {
    FoundContact() {} // no zeros before what its members begin with: there are many

    ContactGeometry at;
    ContactFeature feature;
};

/// A contact from step to step: its geometry, what it remembers, and of its features what tells them from others. Without padding,
/// which checkpoints would hold.
struct Contact {
    Contact() {} // as with FoundContact
    explicit Contact(const FoundContact& found) { set(found); }

    void set(const FoundContact& found) {
        at = found.at;
        id = found.feature.id;
        core_a = found.feature.core_a.cast<float>();
        kind = found.feature.kind;
    }

    ContactGeometry at;
    mutable ContactMemory memory; ///< the solver's
    std::uint64_t id = 0;
    Eigen::Vector3f core_a = Eigen::Vector3f::Zero(); ///< [m] body frame of a
    FeatureKind kind = FeatureKind::cores;
    std::uint16_t feature = 0; ///< 0: flat; else, one less is the index of its features among those of the manifold
};
static_assert(sizeof(Contact) == sizeof(ContactGeometry) + sizeof(ContactMemory) + 24);

/// All contacts of one pair of bodies, a < b.
struct Manifold {
    int body_a = -1;
    int body_b = -1;
    std::vector<Contact> contacts;
    std::vector<ContactFeature> features; ///< of contacts that are not flat: the others' geometry tells them

    /// Keeps the features of its contacts, found as these.
    void keep_features(std::span<const FoundContact> found);
    /// One of them as it was found; a, b: the poses of the bodies then.
    FoundContact found(const Contact& contact, const Pose& a, const Pose& b) const;
};

/// Geometry of a feature at the poses of its bodies. The gap is what the *geometry* says there: a ball turns without changing it.
ContactGeometry contact_geometry(const ContactFeature& feature, const PlacedBody& a, const PlacedBody& b);
inline ContactGeometry contact_geometry(const ContactFeature& feature, const Pose& a, const Pose& b) {
    return contact_geometry(feature, PlacedBody(a), PlacedBody(b));
}

/// The point of a rim (centre, unit axis, radius [m]) that lies farthest against n; the centre if all do.
Vec3 lowest_rim_point(const Vec3& centre, const Vec3& axis, double radius, const Vec3& n);

/// Where contacts go.
struct ContactList {
    double margin;                  ///< [m] only those with gap <= margin
    std::uint64_t id_base;          ///< added to their ids (bits 32 and up)
    std::vector<FoundContact>& contacts; ///< appended to
};

/// Of more contacts from number `first` on than a block holds: keeps those that span most, and the lowest where it is that by more
/// than `slack` [m]. By less, of a body at rest, it would be another one in every step.
void keep_outermost(std::vector<FoundContact>& contacts, std::size_t first, double slack);

} // namespace sim
