#pragma once
/// Scenes in code for the laws, running them, and measuring errors and orders.
#include "sim/base/random.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"
#include "sim/world/world.h"
#include "tests/laws/law_solids.h"
#include "tests/laws/law_table.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

namespace laws {

using sim::Quat;
using sim::Rational;
using sim::Vec3;

inline constexpr double pi = std::numbers::pi;
inline constexpr double g = 9.81; ///< [m/s^2]

/// Uniform in [lower, upper).
inline double between(sim::Random& random, double lower, double upper) {
    return lower + (upper - lower) * random.uniform();
}

/// A scene without bodies, z up, tolerances far below what the laws ask for so that the step alone makes the
/// error.
sim::SceneDef law_scene(Rational h);

/// All coefficients set, so that the pair has them whatever the partner leaves open.
sim::MaterialDef material(double restitution, double mu);
sim::MaterialDef material(double restitution, double mu_s, double mu_d);

/// Each adds a body and returns its index. Bodies are homogeneous unless the mass properties say otherwise.
int add_plane(sim::SceneDef& scene, const Quat& turn = Quat::Identity(),
              const sim::MaterialDef& surface = {});
int add_box(sim::SceneDef& scene, const Vec3& half_extents, const sim::Pose& pose,
            const sim::MaterialDef& surface = {}, double density = 1000.0);
int add_sphere(sim::SceneDef& scene, double radius, const Vec3& position,
               const sim::MaterialDef& surface = {}, double density = 1000.0);
int add_cylinder(sim::SceneDef& scene, const sim::Cylinder& cylinder, const sim::Pose& pose,
                 const sim::MaterialDef& surface = {}, double density = 1000.0);
/// A static body far from everything, to hang joints from.
int add_frame(sim::SceneDef& scene);

void add_joint(sim::SceneDef& scene, sim::JointKind kind, std::pair<int, int> bodies, const Vec3& anchor,
               const Vec3& axis = Vec3::UnitY());

/// Holds the other end of a spring that moves body 1 along x by the scene's first joint, and bears nothing: a carriage of 1 kg that
/// slides up and down on a frame, and this joint, the body's slider on it. Its centre is 0.9 m above the joint, so that alone it would
/// turn easily. Returns its index.
int add_trolley(sim::SceneDef& scene, int frame);

/// Called after each step; returning false ends the run.
using Visit = std::function<bool(const sim::Snapshot&, const sim::StepReport&)>;

/// Advances by round(duration / h) steps. duration [s].
void run(sim::World& world, const sim::SceneDef& scene, double duration, const Visit& visit);
/// The state after `duration` [s].
sim::Snapshot run_to(const sim::SceneDef& scene, double duration);

/// Kinetic plus potential energy of the dynamic bodies [J], computed here and not by sim.
double energy(const sim::SceneDef& scene, const sim::Snapshot& snapshot);
Vec3 momentum(const sim::SceneDef& scene, const sim::Snapshot& snapshot); ///< [N s]
Vec3 angular_momentum(const sim::SceneDef& scene,
                      const sim::Snapshot& snapshot); ///< [N m s], about the origin

/// Pairs that share a joint.
reference::ExcludedPairs jointed_pairs(const sim::SceneDef& scene);
/// Largest penetration [m] >= 0 of all pairs that are there, by the independent check.
double largest_overlap(const sim::SceneDef& scene, const sim::Snapshot& snapshot);

/// Largest distance [m] between the two anchors of any joint.
double largest_joint_gap(const sim::SceneDef& scene, const sim::Snapshot& snapshot);

/// A step of n microseconds.
inline Rational microseconds(std::int64_t n) {
    return sim::make_rational(n, 1000000);
}

/// Errors at several step sizes.
struct Convergence {
    std::vector<double> steps;  ///< [s], descending
    std::vector<double> errors; ///< of the quantity's unit or relative

    /// Least-squares slope of log(error) over log(h).
    double order() const;
    /// The order is at least 1.9, or every error is at most `rounding`, where there is no order.
    bool is_second_order(double rounding) const;
};

/// Runs `error_of(h)` at each step and records a row of the table for each; `goal` is the bound at h = 1 ms.
Convergence converge(const std::string& law, const std::string& quantity, double goal,
                     const std::vector<Rational>& steps, const std::function<double(Rational)>& error_of);

} // namespace laws
