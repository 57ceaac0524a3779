#include "render/study/motion.h"

#include "sim/base/error.h"

#include <algorithm>
#include <cmath>

namespace study {

namespace {

using sim::BodySnapshot;
using sim::Vec3;

double size_of(const sim::BodyDef& body) {
    const sim::Bounds box = sim::bounds(body.shape, body.pose);
    return (box.upper - box.lower).maxCoeff();
}

double energy_of(const sim::SceneDef& scene, const sim::Snapshot& state) {
    const sim::Mechanics mechanics = sim::mechanics(scene, state);
    return mechanics.kinetic_energy + mechanics.potential_energy;
}

} // namespace

double displacement(const sim::MassProperties& mass, const BodySnapshot& one, const BodySnapshot& other) {
    const sim::Mat3 turn = one.orientation.toRotationMatrix() - other.orientation.toRotationMatrix();
    const sim::Mat3 second_moment =
        (0.5 * mass.inertia.trace() * sim::Mat3::Identity() - mass.inertia) / mass.mass;
    const double turned = (turn * second_moment * turn.transpose()).trace();
    return std::sqrt((one.position - other.position).squaredNorm() + std::max(0.0, turned));
}

Difference difference(const sim::SceneDef& scene, const Motion& motion, const Motion& reference) {
    CHECK(motion.states.size() == reference.states.size());
    Difference found;
    double sum = 0.0;
    std::size_t count = 0;
    bool agrees = true;
    const double scale = energy_scale(scene, reference);
    std::vector<double> energies;
    for (const sim::Snapshot& state : reference.states) {
        energies.push_back(energy_of(scene, state));
    }
    for (std::size_t k = 0; k < motion.states.size(); ++k) {
        const sim::Snapshot& now = motion.states[k];
        for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
            const sim::BodyDef& body = scene.bodies[i];
            if (body.is_static()) {
                continue;
            }
            const double d = displacement(body.mass, now.bodies[i], reference.states[k].bodies[i]);
            agrees = agrees && d <= agreement * size_of(body);
            found.largest = std::max(found.largest, d);
            sum += d * d;
            ++count;
        }
        found.agree_until = agrees ? now.time : found.agree_until;
        const double energy = energy_of(scene, now);
        double nearest = std::abs(energy - energies[k]);
        found.energy = std::max(found.energy, nearest / scale);
        for (std::size_t j = k - std::min<std::size_t>(k, 1); j < std::min(k + 2, energies.size()); ++j) {
            nearest = std::min(nearest, std::abs(energy - energies[j]));
        }
        found.heights = std::max(found.heights, nearest / scale);
    }
    found.rms = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, count)));
    return found;
}

double energy_scale(const sim::SceneDef& scene, const Motion& motion) {
    double kinetic = 0.0;
    for (const sim::Snapshot& state : motion.states) {
        kinetic = std::max(kinetic, sim::mechanics(scene, state).kinetic_energy);
    }
    double fall = 0.0;
    for (const sim::BodyDef& body : scene.bodies) {
        fall += body.is_static() ? 0.0 : 0.1 * body.mass.mass * scene.step.gravity.norm() * size_of(body);
    }
    const double scale = std::max(kinetic, fall);
    return scale > 0.0 ? scale : 1.0;
}

std::vector<double> values_of(const Statistics& statistics) {
    return {statistics.throughput, statistics.height, statistics.spread, statistics.energy};
}

Statistics statistics(const sim::SceneDef& scene, const sim::Snapshot& state, double gate) {
    Statistics found;
    found.energy = energy_of(scene, state);
    Vec3 sum = Vec3::Zero();
    double squares = 0.0, passed = 0.0, dynamic = 0.0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].is_static()) {
            continue;
        }
        ++dynamic;
        const Vec3& at = state.bodies[i].position;
        if (at.z() < gate) {
            ++passed;
            sum += at;
            squares += at.head<2>().squaredNorm();
        }
    }
    if (passed > 0.0) {
        const Vec3 mean = sum / passed;
        found.throughput = passed / dynamic;
        found.height = mean.z();
        found.spread = std::sqrt(std::max(0.0, squares / passed - mean.head<2>().squaredNorm()));
    }
    return found;
}

} // namespace study
