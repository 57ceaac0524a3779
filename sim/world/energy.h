#pragma once
/// Does a run gain energy? Contacts and joints only take it, and what kinematic bodies and motors give and what
/// bodies bring that are released is known, so what rises above the lowest value so far comes from nothing.
#include "sim/base/step_report.h"
#include "sim/block/blocks.h"
#include "sim/model/scene_def.h"

#include <limits>
#include <span>

namespace sim {

/// Contacts may give until a run has gained this share [-] of what it may. By trial with random scenes: at 1 two intervals make a run
/// that gains too much, at a tenth films change, and more steps do not converge.
inline constexpr double gain_share = 0.5;

class EnergyWatch {
public:
    /// As a run begins. velocity [body_count]: of the instant, after its collisions; in_springs [J].
    void start(const Bodies& bodies, std::span<const Velocity> velocity, const StepSettings& settings, double in_springs);

    /// What kinematic bodies and motors do: by an instant's collisions [J], and by the impulses planned there.
    void add_work(double work) { work_ += work; }
    void plan_work(const DriveWork& planned) {
        work_ += planned.all;
        ahead_ = planned.ahead;
    }

    /// A body is released: what it brings is no gain.
    void admit(const Bodies& bodies, std::size_t body, const StepSettings& settings);

    /// After each step, with the same of its end. Returns by how much the energy now exceeds the
    /// lowest so far, as a share [-] of what the run turned over: its largest kinetic energy so far, and what it lost.
    double gain(const Bodies& bodies, std::span<const Velocity> velocity, double in_springs);

    /// May an interval's contacts do so much work [J] on bodies? velocity, in_springs: as it begins, after collisions.
    bool allows(double work, const Bodies& bodies, std::span<const Velocity> velocity, double in_springs) const;

private:
    struct Energy {
        double kinetic = 0.0;   ///< [J]
        double potential = 0.0; ///< [J] from the world's origin
    };
    Energy energy_of(const Bodies& bodies, std::span<const Velocity> velocity) const;
    double total(const Bodies& bodies, std::span<const Velocity> velocity);

    Vec3 gravity_ = Vec3::Zero();
    double slack_ = 0.0;           ///< [J] that bodies gain where overlaps within the tolerance are pushed apart
    double first_ = 0.0;           ///< [J]
    double lowest_ = 0.0;          ///< [J]
    double largest_kinetic_ = std::numeric_limits<double>::infinity(); ///< [J]; the plan that a run begins with has none to exceed
    double work_ = 0.0;            ///< [J] done by kinematic bodies and motors, and brought by bodies released
    double ahead_ = 0.0;           ///< [J] of that, after the present instant
};

} // namespace sim
