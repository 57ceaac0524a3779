#include "sim/model/snapshot.h"

#include "sim/base/error.h"

#include <bit>

namespace sim {

namespace {

/// Fowler, Noll, Vo: FNV-1a, 64 bits, byte by byte from the lowest.
class Fnv {
public:
    void add(std::uint64_t bits) {
        for (int i = 0; i < 8; ++i) {
            hash_ = (hash_ ^ (bits >> (8 * i) & 0xff)) * prime;
        }
    }
    void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
    void add(const Vec3& v) {
        add(v.x());
        add(v.y());
        add(v.z());
    }
    std::uint64_t value() const { return hash_; }

private:
    static constexpr std::uint64_t prime = 0x100000001b3;
    std::uint64_t hash_ = 0xcbf29ce484222325; // the offset basis
};

} // namespace

Mechanics mechanics(const SceneDef& scene, const Snapshot& snapshot) {
    CHECK(scene.bodies.size() == snapshot.bodies.size());
    Mechanics sum;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].is_static() || !scene.bodies[i].is_there(snapshot.time)) {
            continue;
        }
        const MassProperties& mass = scene.bodies[i].mass;
        const BodySnapshot& body = snapshot.bodies[i];
        const Mat3 world_from_body = body.orientation.toRotationMatrix();
        const Vec3 spin =
            world_from_body * (mass.inertia * (world_from_body.transpose() * body.angular_velocity));
        const Vec3 momentum = mass.mass * body.velocity;
        sum.kinetic_energy += 0.5 * momentum.dot(body.velocity) + 0.5 * spin.dot(body.angular_velocity);
        sum.potential_energy -= mass.mass * scene.step.gravity.dot(body.position);
        sum.momentum += momentum;
        sum.angular_momentum += body.position.cross(momentum) + spin;
    }
    return sum;
}

std::uint64_t state_hash(const Snapshot& snapshot) {
    Fnv fnv;
    fnv.add(static_cast<std::uint64_t>(snapshot.step));
    for (const BodySnapshot& body : snapshot.bodies) {
        fnv.add(body.position);
        fnv.add(body.orientation.w());
        fnv.add(Vec3(body.orientation.vec()));
        fnv.add(body.velocity);
        fnv.add(body.angular_velocity);
    }
    return fnv.value();
}

} // namespace sim
