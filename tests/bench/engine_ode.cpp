/// ODE as Debian builds it: double precision, QuickStep, sweep-and-prune space.
#include "tests/bench/engine.h"

#include "sim/error.h"

#include <ode/ode.h>

#include <array>
#include <memory>

namespace bench {
namespace {

constexpr int most_contacts = 8;             // points a pair: a face clipped by a face
constexpr double contact_layer = 1e-5;       // [m] overlap ODE leaves so that contacts persist
constexpr double error_reduction = 0.2;      // [-] ERP, ODE's default
constexpr double least_bounce_speed = 0.044; // [m/s] sqrt(2 g 1e-4 m), the threshold of our scene

struct OdeLibrary {
    OdeLibrary() { dInitODE2(0); }
    ~OdeLibrary() { dCloseODE(); }
};

struct OdeWorld {
    OdeLibrary library;
    dWorldID world = dWorldCreate();
    dSpaceID space = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
    dJointGroupID contacts = dJointGroupCreate(0);
    std::vector<dGeomID> geoms;
    std::vector<dBodyID> bodies;  ///< null for a static body
    std::vector<sim::Pose> fixed; ///< of the scene
    Surface surface;
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

void add_body(OdeWorld& ode, const sim::BodyDef& body) {
    dGeomID geom = nullptr;
    if (const auto* box = std::get_if<sim::Box>(&body.shape)) {
        const sim::Vec3 size = 2.0 * box->half_extents;
        geom = dCreateBox(ode.space, size.x(), size.y(), size.z());
    } else if (const auto* sphere = std::get_if<sim::Sphere>(&body.shape)) {
        geom = dCreateSphere(ode.space, sphere->radius);
    } else if (std::holds_alternative<sim::Plane>(body.shape)) {
        const sim::Vec3 n = body.pose.orientation * sim::Vec3::UnitZ();
        geom = dCreatePlane(ode.space, n.x(), n.y(), n.z(), n.dot(body.pose.position));
    } else {
        throw sim::Error(sim::ExitCode::usage, "the benchmark has no compound for ODE: '" + body.name + "'");
    }
    dQuaternion q;
    set_orientation(body.pose.orientation, q);
    const sim::Vec3& p = body.pose.position;
    dBodyID id = nullptr;
    if (!body.is_static()) {
        id = dBodyCreate(ode.world);
        dMass mass;
        const sim::Mat3& j = body.mass.inertia;
        dMassSetParameters(&mass, body.mass.mass, 0, 0, 0, j(0, 0), j(1, 1), j(2, 2), j(0, 1), j(0, 2),
                           j(1, 2));
        dBodySetMass(id, &mass);
        dBodySetPosition(id, p.x(), p.y(), p.z());
        dBodySetQuaternion(id, q);
        dBodySetLinearVel(id, body.velocity.x(), body.velocity.y(), body.velocity.z());
        dBodySetAngularVel(id, body.angular_velocity.x(), body.angular_velocity.y(),
                           body.angular_velocity.z());
        dGeomSetBody(geom, id);
    } else if (!std::holds_alternative<sim::Plane>(body.shape)) {
        dGeomSetPosition(geom, p.x(), p.y(), p.z());
        dGeomSetQuaternion(geom, q);
    }
    ode.geoms.push_back(geom);
    ode.bodies.push_back(id);
    ode.fixed.push_back(body.pose);
}

/// Called by ODE for each near pair of geoms.
void near_pair(void* data, dGeomID a, dGeomID b) noexcept {
    OdeWorld& ode = *static_cast<OdeWorld*>(data);
    dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (!body_a && !body_b) {
        return;
    }
    std::array<dContact, most_contacts> contacts{};
    const int count = dCollide(a, b, most_contacts, &contacts[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
        dSurfaceParameters& surface = contacts[i].surface;
        surface.mode = dContactBounce | dContactApprox1;
        surface.mu = ode.surface.friction;
        surface.bounce = ode.surface.restitution;
        surface.bounce_vel = least_bounce_speed;
        dJointAttach(dJointCreateContact(ode.world, ode.contacts, &contacts[i]), body_a, body_b);
    }
    ode.contact_count += count;
}

} // namespace

Engine make_ode(const sim::SceneDef& scene, int iterations) {
    const auto ode = std::make_shared<OdeWorld>();
    ode->surface = common_surface(scene);
    const sim::Vec3& g = scene.step.gravity;
    dWorldSetGravity(ode->world, g.x(), g.y(), g.z());
    dWorldSetERP(ode->world, error_reduction);
    dWorldSetContactSurfaceLayer(ode->world, contact_layer);
    dWorldSetQuickStepNumIterations(ode->world, iterations);
    dWorldSetAutoDisableFlag(ode->world, 0);
    for (const sim::BodyDef& body : scene.bodies) {
        add_body(*ode, body);
    }
    const double h = scene.step.time_step.value();
    Engine engine;
    engine.name = "ODE 0.16, " + std::to_string(iterations) + " iterations";
    engine.step = [ode, h] {
        ode->contact_count = 0;
        dSpaceCollide(ode->space, ode.get(), &near_pair);
        dWorldQuickStep(ode->world, h);
        dJointGroupEmpty(ode->contacts);
    };
    engine.counts = [ode] { return StepCounts{.contacts = ode->contact_count}; };
    engine.placements = [ode] {
        std::vector<reference::Placement> all;
        for (std::size_t i = 0; i < ode->bodies.size(); ++i) {
            if (!ode->bodies[i]) {
                all.push_back({ode->fixed[i].position, ode->fixed[i].orientation});
                continue;
            }
            const dReal* p = dBodyGetPosition(ode->bodies[i]);
            const dReal* q = dBodyGetQuaternion(ode->bodies[i]);
            all.push_back({{p[0], p[1], p[2]}, Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized()});
        }
        return all;
    };
    return engine;
}

} // namespace bench
