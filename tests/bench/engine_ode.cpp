/// ODE as Debian builds it: double precision, QuickStep or the direct solver, sweep-and-prune space.
#include "tests/bench/engine.h"

#include "sim/base/error.h"

#include <ode/ode.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <set>

namespace bench {
namespace {

constexpr int most_contacts = 8;             // points a pair: a face clipped by a face
constexpr double contact_layer = 1e-5;       // [m] overlap ODE leaves so that contacts persist
constexpr double error_reduction = 0.2;      // [-] ERP, ODE's default
constexpr double least_bounce_speed = 0.044; // [m/s] sqrt(2 g 1e-4 m), the threshold of our scene
constexpr int most_exact = 100;              // bodies: the direct solver's matrix grows with their square

struct OdeLibrary {
    OdeLibrary() { dInitODE2(0); }
    ~OdeLibrary() { dCloseODE(); }
};

struct OdeWorld {
    OdeLibrary library;
    sim::SceneDef scene;
    dWorldID world = dWorldCreate();
    dSpaceID space = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
    dJointGroupID contacts = dJointGroupCreate(0);
    std::vector<dBodyID> bodies; ///< null for a static body
    std::set<std::pair<std::intptr_t, std::intptr_t>> jointed; ///< ascending pairs that do not collide
    int contact_count = 0;

    OdeWorld() = default;
    OdeWorld(const OdeWorld&) = delete;
    OdeWorld& operator=(const OdeWorld&) = delete;
    ~OdeWorld() {
        dJointGroupDestroy(contacts);
        dSpaceDestroy(space);
        dWorldDestroy(world);
    }
};

void set_orientation(const sim::Quat& q, dQuaternion result) {
    result[0] = q.w();
    result[1] = q.x();
    result[2] = q.y();
    result[3] = q.z();
}

/// The geom of a shape at its body's place; null for one that ODE has no like of.
dGeomID make_geom(const sim::Box& box, dSpaceID space) {
    const sim::Vec3 size = 2.0 * box.half_extents;
    return dCreateBox(space, size.x(), size.y(), size.z());
}
dGeomID make_geom(const sim::Sphere& sphere, dSpaceID space) {
    return dCreateSphere(space, sphere.radius);
}
dGeomID make_geom(const sim::Cylinder& cylinder, dSpaceID space) {
    return dCreateCylinder(space, cylinder.radius, 2.0 * cylinder.half_length);
}
dGeomID make_geom(const sim::Capsule& capsule, dSpaceID space) {
    return dCreateCapsule(space, capsule.radius, 2.0 * capsule.half_length);
}
dGeomID make_geom(const sim::Hull&, dSpaceID) {
    return nullptr;
}

void place(dGeomID geom, const sim::Pose& pose, dBodyID body) {
    const sim::Vec3& p = pose.position;
    dQuaternion q;
    set_orientation(pose.orientation, q);
    if (body) {
        dGeomSetBody(geom, body);
        dGeomSetOffsetPosition(geom, p.x(), p.y(), p.z());
        dGeomSetOffsetQuaternion(geom, q);
    } else {
        dGeomSetPosition(geom, p.x(), p.y(), p.z());
        dGeomSetQuaternion(geom, q);
    }
}

/// A convex shape, `part` of the body.
template <class Shape>
void add_geom(OdeWorld& ode, const Shape& shape, const sim::Pose& part, std::size_t index) {
    const sim::BodyDef& body = ode.scene.bodies[index];
    dGeomID geom = make_geom(shape, ode.space);
    if (!geom) {
        throw sim::Error(sim::ExitCode::usage, "ODE is not given hulls here: '" + body.name + "'");
    }
    dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::intptr_t>(index)));
    const sim::Pose fixed{body.pose * part.position, body.pose.orientation * part.orientation};
    place(geom, body.is_static() ? fixed : part, ode.bodies[index]);
}

template <class Shape>
void add_geoms(OdeWorld& ode, const Shape& shape, std::size_t index) {
    add_geom(ode, shape, {}, index);
}
void add_geoms(OdeWorld& ode, const sim::Plane&, std::size_t index) {
    const sim::Pose& pose = ode.scene.bodies[index].pose;
    const sim::Vec3 n = pose.orientation * sim::Vec3::UnitZ();
    dGeomID geom = dCreatePlane(ode.space, n.x(), n.y(), n.z(), n.dot(pose.position));
    dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::intptr_t>(index)));
}
void add_geoms(OdeWorld& ode, const sim::Compound& compound, std::size_t index) {
    for (const sim::CompoundPart& part : compound.parts) {
        std::visit([&](const auto& shape) { add_geom(ode, shape, part.body_from_part, index); }, part.shape);
    }
}

dBodyID make_body(const OdeWorld& ode, const sim::BodyDef& body) {
    dBodyID id = dBodyCreate(ode.world);
    dMass mass;
    const sim::Mat3& j = body.mass.inertia;
    dMassSetParameters(&mass, body.mass.mass, 0, 0, 0, j(0, 0), j(1, 1), j(2, 2), j(0, 1), j(0, 2), j(1, 2));
    dBodySetMass(id, &mass);
    const sim::Vec3 &p = body.pose.position, &v = body.velocity, &w = body.angular_velocity;
    dQuaternion q;
    set_orientation(body.pose.orientation, q);
    dBodySetPosition(id, p.x(), p.y(), p.z());
    dBodySetQuaternion(id, q);
    dBodySetLinearVel(id, v.x(), v.y(), v.z());
    dBodySetAngularVel(id, w.x(), w.y(), w.z());
    return id;
}

void add_joint(OdeWorld& ode, const sim::JointDef& joint) {
    const auto body = [&](int index) {
        return index < 0 ? nullptr : ode.bodies[static_cast<std::size_t>(index)];
    };
    const sim::Vec3 &at = joint.anchor, &axis = joint.axis;
    if (joint.kind == sim::JointKind::hinge) {
        dJointID added = dJointCreateHinge(ode.world, nullptr);
        dJointAttach(added, body(joint.body_a), body(joint.body_b));
        dJointSetHingeAnchor(added, at.x(), at.y(), at.z());
        dJointSetHingeAxis(added, axis.x(), axis.y(), axis.z());
    } else {
        dJointID added = dJointCreateBall(ode.world, nullptr);
        dJointAttach(added, body(joint.body_a), body(joint.body_b));
        dJointSetBallAnchor(added, at.x(), at.y(), at.z());
    }
    ode.jointed.insert(std::minmax<std::intptr_t>(joint.body_a, joint.body_b));
}

/// Called by ODE for each near pair of geoms.
void near_pair(void* data, dGeomID a, dGeomID b) noexcept {
    OdeWorld& ode = *static_cast<OdeWorld*>(data);
    dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    const auto index_a = reinterpret_cast<std::intptr_t>(dGeomGetData(a));
    const auto index_b = reinterpret_cast<std::intptr_t>(dGeomGetData(b));
    if ((!body_a && !body_b) || index_a == index_b ||
        ode.jointed.contains(std::minmax(index_a, index_b))) {
        return;
    }
    std::array<dContact, most_contacts> contacts{};
    const int count = dCollide(a, b, most_contacts, &contacts[0].geom, sizeof(dContact));
    const Surface of_pair = surface_of(ode.scene.bodies[static_cast<std::size_t>(index_a)].material,
                                       ode.scene.bodies[static_cast<std::size_t>(index_b)].material);
    for (int i = 0; i < count; ++i) {
        dSurfaceParameters& surface = contacts[static_cast<std::size_t>(i)].surface;
        surface.mode = dContactBounce | dContactApprox1;
        surface.mu = of_pair.friction;
        surface.bounce = of_pair.restitution;
        surface.bounce_vel = least_bounce_speed;
        dJointAttach(dJointCreateContact(ode.world, ode.contacts, &contacts[static_cast<std::size_t>(i)]), body_a,
                     body_b);
    }
    ode.contact_count += count;
}

std::vector<sim::BodySnapshot> bodies_of(const OdeWorld& ode) {
    std::vector<sim::BodySnapshot> all;
    for (std::size_t i = 0; i < ode.bodies.size(); ++i) {
        if (!ode.bodies[i]) {
            all.push_back({.position = ode.scene.bodies[i].pose.position,
                           .orientation = ode.scene.bodies[i].pose.orientation});
            continue;
        }
        const dReal* p = dBodyGetPosition(ode.bodies[i]);
        const dReal* q = dBodyGetQuaternion(ode.bodies[i]);
        const dReal* v = dBodyGetLinearVel(ode.bodies[i]);
        const dReal* w = dBodyGetAngularVel(ode.bodies[i]);
        all.push_back({{p[0], p[1], p[2]},
                       sim::Quat(q[0], q[1], q[2], q[3]).normalized(),
                       {v[0], v[1], v[2]},
                       {w[0], w[1], w[2]}});
    }
    return all;
}

void fill(OdeWorld& ode, const PeerSettings& settings) {
    const sim::Vec3& g = ode.scene.step.gravity;
    dWorldSetGravity(ode.world, g.x(), g.y(), g.z());
    dWorldSetERP(ode.world, error_reduction);
    dWorldSetContactSurfaceLayer(ode.world, contact_layer);
    dWorldSetQuickStepNumIterations(ode.world, settings.iterations);
    dWorldSetAutoDisableFlag(ode.world, 0);
    for (std::size_t i = 0; i < ode.scene.bodies.size(); ++i) {
        const sim::BodyDef& body = ode.scene.bodies[i];
        ode.bodies.push_back(body.is_static() ? nullptr : make_body(ode, body));
        std::visit([&](const auto& shape) { add_geoms(ode, shape, i); }, body.shape);
    }
    for (const sim::JointDef& joint : ode.scene.joints) {
        add_joint(ode, joint);
    }
}

} // namespace

Engine make_ode(const sim::SceneDef& scene, const PeerSettings& settings) {
    if (settings.solves_exactly && scene.bodies.size() > most_exact) {
        throw sim::Error(sim::ExitCode::usage,
                         "ODE's direct solver is not given scenes of more than " + std::to_string(most_exact) + " bodies");
    }
    check_peer_can(scene);
    const auto ode = std::make_shared<OdeWorld>();
    ode->scene = scene;
    fill(*ode, settings);
    const double h = scene.step.time_step.value();
    Engine engine;
    engine.name = "ODE 0.16, " + std::to_string(settings.iterations) + " iterations";
    engine.step = [ode, h, is_exact = settings.solves_exactly] {
        ode->contact_count = 0;
        dSpaceCollide(ode->space, ode.get(), &near_pair);
        (is_exact ? dWorldStep : dWorldQuickStep)(ode->world, h);
        dJointGroupEmpty(ode->contacts);
    };
    engine.counts = [ode] { return StepCounts{.contacts = ode->contact_count}; };
    engine.bodies = [ode] { return bodies_of(*ode); };
    engine.placements = [ode] {
        std::vector<reference::Placement> all;
        for (const sim::BodySnapshot& body : bodies_of(*ode)) {
            all.push_back({body.position, body.orientation});
        }
        return all;
    };
    return engine;
}

} // namespace bench
