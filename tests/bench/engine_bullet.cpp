/// Bullet as Debian builds it: single precision, sequential impulses with split impulse, dynamic tree broad
/// phase.
#include "tests/bench/engine.h"

#include "sim/base/error.h"
#include "sim/model/polytope.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace bench {
namespace {

constexpr double box_margin = 0.01; // [m] of the boxes' collision margin; Bullet's default is 0.04
constexpr double margin_share = 0.1; // [-] of the least half extent: the margin of smaller ones

btVector3 to_bullet(const sim::Vec3& v) {
    return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btQuaternion to_bullet(const sim::Quat& q) {
    return {static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()), static_cast<btScalar>(q.z()),
            static_cast<btScalar>(q.w())};
}

btTransform to_bullet(const sim::Pose& pose) {
    return btTransform(to_bullet(pose.orientation), to_bullet(pose.position));
}

sim::Vec3 from_bullet(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
}

using Shapes = std::vector<std::unique_ptr<btCollisionShape>>;

std::unique_ptr<btCollisionShape> make_shape(const sim::Box& box, Shapes&) {
    auto shape = std::make_unique<btBoxShape>(to_bullet(box.half_extents));
    shape->setMargin(static_cast<btScalar>(std::min(box_margin, margin_share * box.half_extents.minCoeff())));
    return shape;
}
std::unique_ptr<btCollisionShape> make_shape(const sim::Sphere& sphere, Shapes&) {
    return std::make_unique<btSphereShape>(static_cast<btScalar>(sphere.radius));
}
std::unique_ptr<btCollisionShape> make_shape(const sim::Cylinder& cylinder, Shapes&) {
    auto shape = std::make_unique<btCylinderShapeZ>(
        to_bullet(sim::Vec3(cylinder.radius, cylinder.radius, cylinder.half_length)));
    shape->setMargin(static_cast<btScalar>(
        std::min(box_margin, margin_share * std::min(cylinder.radius, cylinder.half_length))));
    return shape;
}
std::unique_ptr<btCollisionShape> make_shape(const sim::Capsule& capsule, Shapes&) {
    return std::make_unique<btCapsuleShapeZ>(static_cast<btScalar>(capsule.radius),
                                             static_cast<btScalar>(2.0 * capsule.half_length));
}
std::unique_ptr<btCollisionShape> make_shape(const sim::Hull& hull, Shapes&) {
    auto shape = std::make_unique<btConvexHullShape>();
    for (const sim::Vec3& vertex : hull.polytope->vertices) {
        shape->addPoint(to_bullet(vertex), false);
    }
    shape->recalcLocalAabb();
    shape->setMargin(static_cast<btScalar>(box_margin));
    return shape;
}
std::unique_ptr<btCollisionShape> make_shape(const sim::Plane&, Shapes&) {
    return std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0));
}
std::unique_ptr<btCollisionShape> make_shape(const sim::Compound& compound, Shapes& shapes) {
    auto whole = std::make_unique<btCompoundShape>();
    for (const sim::CompoundPart& part : compound.parts) {
        shapes.push_back(std::visit([&](const auto& shape) { return make_shape(shape, shapes); }, part.shape));
        whole->addChildShape(to_bullet(part.body_from_part), shapes.back().get());
    }
    return whole;
}

/// Destroyed in the reverse order of the members.
struct BulletWorld {
    sim::SceneDef scene; ///< bodies point into it
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broad_phase;
    btSequentialImpulseConstraintSolver solver;
    Shapes shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
    btDiscreteDynamicsWorld world{&dispatcher, &broad_phase, &solver, &configuration};

    ~BulletWorld() {
        for (const auto& joint : joints) {
            world.removeConstraint(joint.get());
        }
        for (const auto& body : bodies) {
            world.removeRigidBody(body.get());
        }
    }
};

/// Bullet multiplies the coefficients of a pair; this sets those of the scene.
bool set_surface(btManifoldPoint& point, const btCollisionObjectWrapper* a, int, int,
                 const btCollisionObjectWrapper* b, int, int) {
    const auto def = [](const btCollisionObjectWrapper* object) {
        return static_cast<const sim::BodyDef*>(object->getCollisionObject()->getUserPointer());
    };
    const Surface surface = surface_of(def(a)->material, def(b)->material);
    point.m_combinedFriction = static_cast<btScalar>(surface.friction);
    point.m_combinedRestitution = static_cast<btScalar>(surface.restitution);
    return true;
}

void add_body(BulletWorld& bullet, sim::BodyDef& body) {
    bullet.shapes.push_back(
        std::visit([&](const auto& shape) { return make_shape(shape, bullet.shapes); }, body.shape));
    const sim::Mat3& inertia = body.mass.inertia;
    if ((inertia - sim::Mat3(inertia.diagonal().asDiagonal())).norm() > 1e-6 * inertia.norm()) {
        throw sim::Error(sim::ExitCode::usage,
                         "Bullet knows moments about the axes of a body only: '" + body.name + "' has others");
    }
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(body.mass.mass), nullptr,
                                                  bullet.shapes.back().get(), to_bullet(sim::Vec3(inertia.diagonal())));
    info.m_startWorldTransform = to_bullet(body.pose);
    bullet.bodies.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& added = *bullet.bodies.back();
    added.setUserPointer(&body);
    added.setCollisionFlags(added.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    added.setActivationState(DISABLE_DEACTIVATION);
    if (!body.is_static()) {
        added.setLinearVelocity(to_bullet(body.velocity));
        added.setAngularVelocity(to_bullet(body.angular_velocity));
    }
    bullet.world.addRigidBody(&added);
}

void add_joint(BulletWorld& bullet, const sim::JointDef& joint) {
    const auto body = [&](int index) { return bullet.bodies[static_cast<std::size_t>(index)].get(); };
    const auto place = [&](int index) { return body(index)->getWorldTransform().inverse(); };
    const btVector3 anchor = to_bullet(joint.anchor), axis = to_bullet(joint.axis);
    btRigidBody& a = *body(joint.body_a);
    const btVector3 on_a = place(joint.body_a) * anchor, axis_a = place(joint.body_a).getBasis() * axis;
    const bool is_hinge = joint.kind == sim::JointKind::hinge;
    std::unique_ptr<btTypedConstraint> added;
    if (joint.body_b < 0) {
        added = is_hinge ? std::unique_ptr<btTypedConstraint>(std::make_unique<btHingeConstraint>(a, on_a, axis_a))
                         : std::make_unique<btPoint2PointConstraint>(a, on_a);
    } else {
        btRigidBody& b = *body(joint.body_b);
        const btVector3 on_b = place(joint.body_b) * anchor, axis_b = place(joint.body_b).getBasis() * axis;
        added = is_hinge ? std::unique_ptr<btTypedConstraint>(
                               std::make_unique<btHingeConstraint>(a, b, on_a, on_b, axis_a, axis_b))
                         : std::make_unique<btPoint2PointConstraint>(a, b, on_a, on_b);
    }
    bullet.world.addConstraint(added.get(), true); // the two do not collide
    bullet.joints.push_back(std::move(added));
}

std::vector<sim::BodySnapshot> bodies_of(const BulletWorld& bullet) {
    std::vector<sim::BodySnapshot> all;
    for (const auto& body : bullet.bodies) {
        const btTransform& t = body->getWorldTransform();
        const btQuaternion q = t.getRotation();
        all.push_back({from_bullet(t.getOrigin()), sim::Quat(q.w(), q.x(), q.y(), q.z()).normalized(),
                       from_bullet(body->getLinearVelocity()), from_bullet(body->getAngularVelocity())});
    }
    return all;
}

} // namespace

Engine make_bullet(const sim::SceneDef& scene, const PeerSettings& settings) {
    check_peer_can(scene);
    const auto bullet = std::make_shared<BulletWorld>();
    bullet->scene = scene;
    gContactAddedCallback = set_surface;
    bullet->world.setGravity(to_bullet(scene.step.gravity));
    btContactSolverInfo& info = bullet->world.getSolverInfo();
    info.m_numIterations = settings.iterations;
    info.m_splitImpulse = std::isfinite(settings.split_depth) ? 1 : 0;
    info.m_splitImpulsePenetrationThreshold = static_cast<btScalar>(-settings.split_depth);
    if (!settings.warm_start) {
        info.m_solverMode &= ~SOLVER_USE_WARMSTARTING;
    }
    for (sim::BodyDef& body : bullet->scene.bodies) {
        add_body(*bullet, body);
    }
    for (const sim::JointDef& joint : bullet->scene.joints) {
        add_joint(*bullet, joint);
    }
    const auto h = static_cast<btScalar>(scene.step.time_step.value());
    Engine engine;
    engine.name = "Bullet 3.24, " + std::to_string(settings.iterations) + " iterations";
    engine.step = [bullet, h] { bullet->world.stepSimulation(h, 0); };
    engine.counts = [bullet] {
        StepCounts counts;
        for (int i = 0; i < bullet->dispatcher.getNumManifolds(); ++i) {
            counts.contacts += bullet->dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
        }
        return counts;
    };
    engine.bodies = [bullet] { return bodies_of(*bullet); };
    engine.placements = [bullet] {
        std::vector<reference::Placement> all;
        for (const sim::BodySnapshot& body : bodies_of(*bullet)) {
            all.push_back({body.position, body.orientation});
        }
        return all;
    };
    return engine;
}

} // namespace bench
