/// Bullet as Debian builds it: single precision, sequential impulses with split impulse, dynamic tree broad
/// phase.
#include "tests/bench/engine.h"

#include "sim/error.h"

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <memory>

namespace bench {
namespace {

constexpr float box_margin = 0.01F; // [m] of the boxes' collision margin; Bullet's default is 0.04

btVector3 to_bullet(const sim::Vec3& v) {
    return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btTransform to_bullet(const sim::Pose& pose) {
    const sim::Quat& q = pose.orientation;
    const btQuaternion turn(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                            static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w()));
    return btTransform(turn, to_bullet(pose.position));
}

std::unique_ptr<btCollisionShape> make_shape(const sim::BodyDef& body) {
    std::unique_ptr<btCollisionShape> shape;
    if (const auto* box = std::get_if<sim::Box>(&body.shape)) {
        shape = std::make_unique<btBoxShape>(to_bullet(box->half_extents));
        shape->setMargin(box_margin);
    } else if (const auto* sphere = std::get_if<sim::Sphere>(&body.shape)) {
        shape = std::make_unique<btSphereShape>(static_cast<btScalar>(sphere->radius));
    } else if (std::holds_alternative<sim::Plane>(body.shape)) {
        shape = std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0));
    } else {
        throw sim::Error(sim::ExitCode::usage,
                         "the benchmark has no compound for Bullet: '" + body.name + "'");
    }
    return shape;
}

/// Destroyed in the reverse order of the members.
struct BulletWorld {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broad_phase;
    btSequentialImpulseConstraintSolver solver;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    btDiscreteDynamicsWorld world{&dispatcher, &broad_phase, &solver, &configuration};

    ~BulletWorld() {
        for (const auto& body : bodies) {
            world.removeRigidBody(body.get());
        }
    }
};

void add_body(BulletWorld& bullet, const sim::BodyDef& body, const Surface& surface) {
    bullet.shapes.push_back(make_shape(body));
    const auto mass = static_cast<btScalar>(body.mass.mass);
    const btVector3 inertia = body.is_static() ? btVector3(0, 0, 0) : to_bullet(body.mass.inertia.diagonal());
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, bullet.shapes.back().get(), inertia);
    info.m_startWorldTransform = to_bullet(body.pose);
    // Bullet multiplies the coefficients of a pair.
    info.m_restitution = static_cast<btScalar>(std::sqrt(surface.restitution));
    info.m_friction = static_cast<btScalar>(std::sqrt(surface.friction));
    bullet.bodies.push_back(std::make_unique<btRigidBody>(info));
    bullet.bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    if (!body.is_static()) {
        bullet.bodies.back()->setLinearVelocity(to_bullet(body.velocity));
        bullet.bodies.back()->setAngularVelocity(to_bullet(body.angular_velocity));
    }
    bullet.world.addRigidBody(bullet.bodies.back().get());
}

} // namespace

Engine make_bullet(const sim::SceneDef& scene, int iterations) {
    const auto bullet = std::make_shared<BulletWorld>();
    bullet->world.setGravity(to_bullet(scene.step.gravity));
    bullet->world.getSolverInfo().m_numIterations = iterations;
    const Surface surface = common_surface(scene);
    for (const sim::BodyDef& body : scene.bodies) {
        add_body(*bullet, body, surface);
    }
    const auto h = static_cast<btScalar>(scene.step.time_step.value());
    Engine engine;
    engine.name = "Bullet 3.24, " + std::to_string(iterations) + " iterations";
    engine.step = [bullet, h] { bullet->world.stepSimulation(h, 0); };
    engine.counts = [bullet] {
        StepCounts counts;
        for (int i = 0; i < bullet->dispatcher.getNumManifolds(); ++i) {
            counts.contacts += bullet->dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
        }
        return counts;
    };
    engine.placements = [bullet] {
        std::vector<reference::Placement> all;
        for (const auto& body : bullet->bodies) {
            const btTransform& t = body->getWorldTransform();
            const btQuaternion q = t.getRotation();
            all.push_back({{t.getOrigin().x(), t.getOrigin().y(), t.getOrigin().z()},
                           Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized()});
        }
        return all;
    };
    return engine;
}

} // namespace bench
