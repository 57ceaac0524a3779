#include "sim/solve/time_of_impact.h"

#include "sim/model/integrate.h"
#include "sim/solve/contact_solver.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

/// Approaches up to this many times [-] the velocity tolerance are what a solve leaves, and no impacts.
constexpr double noise_factor = 2.0;

/// Gap at which a stopped impact counts as touching, as a share [-] of the tolerance; and shortest interval, of a step.
constexpr double stop_share = 1e-6;

} // namespace

double shortest_interval(const StepSettings& settings) {
    return stop_share * settings.time_step.value();
}

double resting_threshold(const StepSettings& settings) {
    return std::max({std::sqrt(2.0 * settings.gravity.norm() * settings.resting_distance),
                     settings.resting_speed_floor, noise_factor * settings.velocity_tolerance});
}

double touch_gap(const StepSettings& settings) {
    return settings.impacts == ImpactHandling::stop
               ? std::min(std::max(stop_share * settings.tolerance, gap_rounding), settings.tolerance)
               : settings.tolerance;
}

Vec3 relative_gravity(const Bodies& bodies, const Manifold& manifold, const StepSettings& settings) {
    const bool a = bodies.props[static_cast<std::size_t>(manifold.body_a)].is_static();
    const bool b = bodies.props[static_cast<std::size_t>(manifold.body_b)].is_static();
    return (static_cast<double>(!a) - static_cast<double>(!b)) * settings.gravity;
}

bool is_impact(const Bodies& bodies, const Manifold& manifold, const Contact& contact,
               const StepSettings& settings) {
    if (contact.memory.last_interval > 0.0 && contact.at.gap <= settings.tolerance) {
        return false; // what it bears still acts: the velocities lack it
    }
    const auto a = static_cast<std::size_t>(manifold.body_a);
    const auto b = static_cast<std::size_t>(manifold.body_b);
    const Vec3 u_rel = bodies.velocity[a].at(contact.at.a - bodies.pose[a].position) -
                       bodies.velocity[b].at(contact.at.b() - bodies.pose[b].position);
    const double approach = -u_rel.dot(contact.at.n);
    const double fall = -relative_gravity(bodies, manifold, settings).dot(contact.at.n);
    const double at_touch = std::sqrt(std::max(approach * approach + 2.0 * fall * contact.at.gap, 0.0));
    return std::max(approach, fall > 0.0 ? at_touch : 0.0) > resting_threshold(settings) &&
           contact.at.gap > std::max(touch_gap(settings), approach * shortest_interval(settings));
}

double impact_gap(const FoundContact& contact, const PairPoses& from, const PairPoses& to, double touch) {
    if (contact.at.gap <= touch || contact_geometry(contact.feature, from.a, from.b).gap > touch) {
        return contact_geometry(contact.feature, to.a, to.b).gap;
    }
    const Vec3 point_a = to.a * (from.a.orientation.conjugate() * (contact.at.a - from.a.position));
    const Vec3 point_b = to.b * (from.b.orientation.conjugate() * (contact.at.b() - from.b.position));
    return contact.at.n.dot(point_a - point_b);
}

double closing_time(const std::function<double(double)>& gap_at, double gap_early, double late, double gap_late) {
    double early = 0.0;
    const double rounding = 1e-15 * late;
    while (late - early > rounding && gap_early > 0.0) {
        const double width = late - early;
        const double secant = early + width * gap_early / (gap_early - gap_late);
        for (const double t : {secant, 0.5 * (early + late)}) {
            if (t <= early || t >= late || late - early < 0.5 * width) {
                continue;
            }
            const double gap = gap_at(t);
            (gap >= 0.0 ? early : late) = t;
            (gap >= 0.0 ? gap_early : gap_late) = gap;
        }
    }
    return early > 0.0 ? early : late;
}

std::optional<Impact> time_of_impact(const Bodies& bodies, std::span<const Velocity> velocity,
                                     std::span<const PairContacts> pairs, const StepSettings& settings,
                                     double h) {
    std::optional<Impact> earliest;
    for (std::size_t p = 0; p < pairs.size(); ++p) {
        const Manifold& manifold = pairs[p].manifold;
        const auto a = static_cast<std::size_t>(manifold.body_a);
        const auto b = static_cast<std::size_t>(manifold.body_b);
        for (std::size_t c = 0; c < manifold.contacts.size(); ++c) {
            const Contact& contact = manifold.contacts[c];
            if (!is_impact(bodies, manifold, contact, settings)) {
                continue;
            }
            const FoundContact found = manifold.found(contact, bodies.pose[a], bodies.pose[b]);
            const auto gap_at = [&](double t) {
                return impact_gap(found, {bodies.pose[a], bodies.pose[b]},
                                  {free_motion(bodies.props[a], bodies.pose[a], velocity[a], settings.gravity, t),
                                   free_motion(bodies.props[b], bodies.pose[b], velocity[b], settings.gravity, t)},
                                  touch_gap(settings));
            };
            const double late = earliest ? earliest->time : h;
            const double gap_late = gap_at(late);
            if (gap_late < 0.0) {
                earliest = Impact{closing_time(gap_at, contact.at.gap, late, gap_late), p, c};
            }
        }
    }
    return earliest;
}

} // namespace sim
