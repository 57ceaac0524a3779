#include "tests/laws/law_scene.h"

#include <algorithm>
#include <cmath>

namespace laws {
namespace {

/// Inertia tensor in the world [kg m^2].
sim::Mat3 world_inertia(const sim::BodyDef& def, const sim::BodySnapshot& state) {
    const sim::Mat3 rotation = state.orientation.toRotationMatrix();
    return rotation * def.mass.inertia * rotation.transpose();
}

int add_body(sim::SceneDef& scene, sim::BodyDef body) {
    const int index = static_cast<int>(scene.bodies.size());
    if (body.name.empty()) {
        body.name = "body_" + std::to_string(index);
    }
    scene.bodies.push_back(std::move(body));
    return index;
}

} // namespace

sim::SceneDef law_scene(Rational h) {
    sim::SceneDef scene;
    scene.name = "law";
    scene.step.time_step = h;
    scene.step.gravity = Vec3(0, 0, -g);
    scene.step.tolerance = 1e-9;
    scene.step.joint_tolerance = 1e-12;
    scene.step.velocity_tolerance = 1e-10;
    return scene;
}

sim::MaterialDef material(double restitution, double mu_s, double mu_d) {
    sim::MaterialDef surface;
    surface.restitution = restitution;
    surface.mu_s = mu_s;
    surface.mu_d = mu_d;
    return surface;
}

sim::MaterialDef material(double restitution, double mu) {
    return material(restitution, mu, mu);
}

int add_plane(sim::SceneDef& scene, const Quat& turn, const sim::MaterialDef& surface) {
    sim::BodyDef body;
    body.shape = sim::Plane{};
    body.pose.orientation = turn;
    body.material = surface;
    return add_body(scene, body);
}

int add_box(sim::SceneDef& scene, const Vec3& half_extents, const sim::Pose& pose,
            const sim::MaterialDef& surface, double density) {
    sim::BodyDef body;
    body.shape = sim::Box{half_extents};
    const Vec3 square = half_extents.cwiseProduct(half_extents);
    body.mass.mass = density * 8.0 * half_extents.prod();
    body.mass.inertia = (body.mass.mass / 3.0 * (Vec3::Constant(square.sum()) - square)).asDiagonal();
    body.pose = pose;
    body.material = surface;
    return add_body(scene, body);
}

int add_sphere(sim::SceneDef& scene, double radius, const Vec3& position, const sim::MaterialDef& surface,
               double density) {
    sim::BodyDef body;
    body.shape = sim::Sphere{radius};
    body.mass.mass = density * 4.0 / 3.0 * pi * radius * radius * radius;
    body.mass.inertia = 0.4 * body.mass.mass * radius * radius * sim::Mat3::Identity();
    body.pose.position = position;
    body.material = surface;
    return add_body(scene, body);
}

int add_cylinder(sim::SceneDef& scene, const sim::Cylinder& cylinder, const sim::Pose& pose,
                 const sim::MaterialDef& surface, double density) {
    sim::BodyDef body;
    body.shape = cylinder;
    body.mass = sim::mass_properties(body.shape, density);
    body.pose = pose;
    body.material = surface;
    return add_body(scene, body);
}

int add_frame(sim::SceneDef& scene) {
    sim::BodyDef body;
    body.name = "frame";
    body.shape = sim::Sphere{0.01};
    body.pose.position = Vec3(0, 0, 1000);
    return add_body(scene, body);
}

void add_joint(sim::SceneDef& scene, sim::JointKind kind, std::pair<int, int> bodies, const Vec3& anchor,
               const Vec3& axis) {
    sim::JointDef joint;
    joint.name = "joint_" + std::to_string(scene.joints.size());
    joint.kind = kind;
    joint.body_a = bodies.first;
    joint.body_b = bodies.second;
    joint.anchor = anchor;
    joint.axis = axis;
    scene.joints.push_back(joint);
}

int add_trolley(sim::SceneDef& scene, int frame) {
    const Vec3 joint = scene.bodies[1].pose.position;
    const int carriage = add_box(scene, Vec3::Constant(0.05), {joint + Vec3(0, 0, 0.9), Quat::Identity()});
    add_joint(scene, sim::JointKind::slider, {1, carriage}, joint, Vec3::UnitX());
    add_joint(scene, sim::JointKind::slider, {carriage, frame}, joint, Vec3::UnitZ());
    return carriage;
}

void run(sim::World& world, const sim::SceneDef& scene, double duration, const Visit& visit) {
    const auto steps = std::llround(duration / scene.step.time_step.value());
    for (long long i = 0; i < steps; ++i) {
        const sim::StepReport report = world.step();
        if (!visit(world.take_snapshot(), report)) {
            return;
        }
    }
}

sim::Snapshot run_to(const sim::SceneDef& scene, double duration) {
    sim::World world(scene);
    const auto steps = std::llround(duration / scene.step.time_step.value());
    for (long long i = 0; i < steps; ++i) {
        world.step();
    }
    return world.take_snapshot();
}

double energy(const sim::SceneDef& scene, const sim::Snapshot& snapshot) {
    double sum = 0.0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const sim::BodyDef& def = scene.bodies[i];
        const sim::BodySnapshot& state = snapshot.bodies[i];
        if (!def.is_static()) {
            sum += 0.5 * def.mass.mass * state.velocity.squaredNorm() +
                   0.5 * state.angular_velocity.dot(world_inertia(def, state) * state.angular_velocity) -
                   def.mass.mass * scene.step.gravity.dot(state.position);
        }
    }
    return sum;
}

Vec3 momentum(const sim::SceneDef& scene, const sim::Snapshot& snapshot) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        sum += scene.bodies[i].mass.mass * snapshot.bodies[i].velocity;
    }
    return sum;
}

Vec3 angular_momentum(const sim::SceneDef& scene, const sim::Snapshot& snapshot) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const sim::BodyDef& def = scene.bodies[i];
        const sim::BodySnapshot& state = snapshot.bodies[i];
        if (!def.is_static()) {
            sum += world_inertia(def, state) * state.angular_velocity +
                   def.mass.mass * state.position.cross(state.velocity);
        }
    }
    return sum;
}

reference::ExcludedPairs jointed_pairs(const sim::SceneDef& scene) {
    reference::ExcludedPairs pairs;
    for (const sim::JointDef& joint : scene.joints) {
        pairs.insert(std::minmax(joint.body_a, joint.body_b));
    }
    return pairs;
}

double largest_overlap(const sim::SceneDef& scene, const sim::Snapshot& snapshot) {
    double deepest = 0.0;
    const auto is_there = [&](int body) { return scene.bodies[static_cast<std::size_t>(body)].is_there(snapshot.time); };
    for (const reference::PairGap& pair :
         reference::near_pairs(solids(scene), placements(snapshot), 0.0, jointed_pairs(scene))) {
        deepest = is_there(pair.a) && is_there(pair.b) ? std::max(deepest, -pair.gap) : deepest;
    }
    return deepest;
}

double largest_joint_gap(const sim::SceneDef& scene, const sim::Snapshot& snapshot) {
    double largest = 0.0;
    for (const sim::JointDef& joint : scene.joints) {
        const auto anchor = [&](int body) {
            const sim::Pose& start = scene.bodies[body].pose;
            const Vec3 anchor_body = start.orientation.conjugate() * (joint.anchor - start.position);
            return Vec3(snapshot.bodies[body].orientation * anchor_body + snapshot.bodies[body].position);
        };
        largest = std::max(largest, (anchor(joint.body_a) - anchor(joint.body_b)).norm());
    }
    return largest;
}

double Convergence::order() const {
    double mean_x = 0.0, mean_y = 0.0, xx = 0.0, xy = 0.0;
    const double n = static_cast<double>(steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) {
        mean_x += std::log(steps[i]) / n;
        mean_y += std::log(std::max(errors[i], 1e-300)) / n;
    }
    for (std::size_t i = 0; i < steps.size(); ++i) {
        xx += (std::log(steps[i]) - mean_x) * (std::log(steps[i]) - mean_x);
        xy += (std::log(steps[i]) - mean_x) * (std::log(std::max(errors[i], 1e-300)) - mean_y);
    }
    return xy / xx;
}

bool Convergence::is_second_order(double rounding) const {
    return std::all_of(errors.begin(), errors.end(), [&](double e) { return e <= rounding; }) ||
           order() >= 1.9;
}

Convergence converge(const std::string& law, const std::string& quantity, double goal,
                     const std::vector<Rational>& steps, const std::function<double(Rational)>& error_of) {
    Convergence result;
    for (const Rational& h : steps) {
        result.steps.push_back(h.value());
        result.errors.push_back(error_of(h));
    }
    for (std::size_t i = 0; i < steps.size(); ++i) {
        record({law, quantity, result.steps[i], result.errors[i], result.steps[i] == 1e-3 ? goal : no_value,
                i + 1 == steps.size() ? result.order() : no_value});
    }
    return result;
}

} // namespace laws
