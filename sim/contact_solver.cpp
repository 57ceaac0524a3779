#include "sim/contact_solver.h"

#include "sim/contact_graph.h"
#include "sim/integrate.h"
#include "sim/time_of_impact.h"

#include <cmath>
#include <limits>

namespace sim {
namespace {

/// Within this share [-] of the tolerance a gap is not closed at once but by `gap_relaxation` a step: closing
/// an error of d in one step needs the velocity d / h, which the next step has to take away again.
constexpr double soft_band = 0.5;
constexpr double gap_relaxation = 0.1;

/// The iteration stops when no contact changed by more than this share [-] of the tolerance over h, or by the
/// velocity tolerance, whichever is smaller.
constexpr double iteration_share = 0.1;

/// The gap errors left by one linear solve may be this share [-] of the tolerance before it is repeated at
/// the predicted poses.
constexpr double accepted_share = 0.5;

/// Linear solves of one step before it counts as not converged.
constexpr int outer_limit = 12;

/// Gravity on a less that on b [m/s^2]; a static body has none.
Vec3 relative_gravity(const Bodies& bodies, const Manifold& manifold, const StepSettings& settings) {
    const bool a = bodies.props[static_cast<std::size_t>(manifold.body_a)].is_static();
    const bool b = bodies.props[static_cast<std::size_t>(manifold.body_b)].is_static();
    return (static_cast<double>(!a) - static_cast<double>(!b)) * settings.gravity;
}

} // namespace

void match_memory(const std::vector<ContactMemory>& old, PairContacts& pair, double reach) {
    const std::vector<Contact>& contacts = pair.manifold.contacts;
    pair.memory.assign(contacts.size(), {});
    std::vector<char> used(old.size(), 0);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        pair.memory[i].id = contacts[i].feature.id;
        pair.memory[i].core_a = contacts[i].feature.core_a;
    }
    const auto take = [&](std::size_t i, std::size_t j) {
        const ContactMemory fresh = pair.memory[i];
        pair.memory[i] = old[j];
        pair.memory[i].id = fresh.id;
        pair.memory[i].core_a = fresh.core_a;
        used[j] = 1;
    };
    std::vector<std::size_t> unmatched;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        std::size_t j = 0;
        while (j < old.size() && (used[j] != 0 || old[j].id != contacts[i].feature.id)) {
            ++j;
        }
        j < old.size() ? take(i, j) : unmatched.push_back(i);
    }
    for (const std::size_t i : unmatched) {
        std::size_t nearest = old.size();
        double distance = reach;
        for (std::size_t j = 0; j < old.size(); ++j) {
            const double d = (old[j].core_a - contacts[i].feature.core_a).norm();
            if (used[j] == 0 && d < distance) {
                nearest = j;
                distance = d;
            }
        }
        if (nearest < old.size()) {
            take(i, nearest);
        }
    }
}

void ContactSolver::prepare(const Bodies& bodies, std::vector<PairContacts>& pairs,
                            std::span<const Joint> joints, std::span<const double> node_weight,
                            const StepSettings& settings, double h) {
    settings_ = settings;
    stop_at_impacts_ = settings.impacts == ImpactHandling::stop;
    h_ = h;
    step_share_ = std::min(h / settings.time_step.value(), 1.0);
    node_weight_.assign(node_weight.begin(), node_weight.end());
    velocity_ = bodies.velocity;
    predicted_ = bodies.pose;
    rows_.clear();
    contacts_.clear();
    joints_.prepare(bodies, joints);
    for (int pair = 0; pair < static_cast<int>(pairs.size()); ++pair) {
        add_contacts(bodies, pairs, pair, 0);
    }
}

void ContactSolver::add_contacts(const Bodies& bodies, std::vector<PairContacts>& pairs, int pair,
                                 std::size_t first) {
    PairContacts& p = pairs[static_cast<std::size_t>(pair)];
    const auto a = static_cast<std::size_t>(p.manifold.body_a);
    const auto b = static_cast<std::size_t>(p.manifold.body_b);
    const double band = soft_band * settings_.tolerance;
    for (std::size_t i = first; i < p.manifold.contacts.size(); ++i) {
        const Contact& contact = p.manifold.contacts[i];
        const ContactMemory& memory = p.memory[i];
        if (stop_at_impacts_ && is_impact(bodies, p.manifold, contact, settings_)) {
            continue;
        }
        ContactRow row = make_row(bodies, p.manifold.body_a, p.manifold.body_b, contact.at, p.material);
        RestingContact resting;
        resting.pair = pair;
        resting.index = static_cast<int>(i);
        resting.is_ahead = contact.at.gap > settings_.tolerance;
        resting.is_persistent = memory.p_n > 0.0;
        resting.u_n_before = normal_velocity(row, bodies.velocity);
        const double gained =
            2.0 * contact.at.gap * relative_gravity(bodies, p.manifold, settings_).dot(-contact.at.n);
        resting.approach_speed =
            std::max(std::sqrt(std::max(std::pow(std::max(-resting.u_n_before, 0.0), 2) + gained, 0.0)),
                     memory.approach_speed);
        if (contact.at.gap <= band) {
            resting.gap_target = std::max((1.0 - gap_relaxation * step_share_) * contact.at.gap, -band);
        }
        const Pose& pose_a = bodies.pose[a];
        const Pose& pose_b = bodies.pose[b];
        resting.point_a = pose_a.orientation.conjugate() * (contact.at.a - pose_a.position);
        resting.point_b = pose_b.orientation.conjugate() * (contact.at.b - pose_b.position);
        row.node_weight = std::min(bodies.props[a].is_static() ? 1.0 : node_weight_[a],
                                   bodies.props[b].is_static() ? 1.0 : node_weight_[b]);
        if (row.has_friction()) {
            row.u_t_before = tangential_velocity(row, bodies.velocity);
        }
        if (settings_.warm_start && memory.p_n > 0.0) {
            // The impulse of an interval stands for the time from the middle of the last one to its own
            // middle.
            const double interval = row.node_weight < 1.0 ? 0.5 * h_ / (1.0 - row.node_weight) : h_;
            const double scale = memory.interval > 0.0 ? interval / memory.interval : 1.0;
            row.p_n = scale * memory.p_n;
            if (row.has_friction()) {
                row.p_t = scale *
                          Vec2(memory.p_t.dot(row.direction[1].axis), memory.p_t.dot(row.direction[2].axis));
                row.is_sticking = memory.is_sticking;
            }
            apply_sums(row, velocity_);
        }
        rows_.push_back(row);
        contacts_.push_back(resting);
    }
}

void ContactSolver::predict(const Bodies& bodies) {
    for (std::size_t i = 0; i < bodies.props.size(); ++i) {
        predicted_[i] = free_motion(bodies.props[i], bodies.pose[i], velocity_[i], settings_.gravity, h_);
    }
}

/// Gaps and displacements at the predicted poses, and the row targets that close them (eq. 8: the velocity
/// change d_n / h). Returns the largest error [m] of a gap, two-sided where the contact carries load.
double ContactSolver::measure(const Bodies& bodies, std::vector<PairContacts>& pairs) {
    double worst = 0.0;
    for (std::size_t k = 0; k < rows_.size(); ++k) {
        ContactRow& row = rows_[k];
        RestingContact& contact = contacts_[k];
        const PairContacts& pair = pairs[static_cast<std::size_t>(contact.pair)];
        const auto i = static_cast<std::size_t>(contact.index);
        const Pose& pose_a = predicted_[static_cast<std::size_t>(row.a)];
        const Pose& pose_b = predicted_[static_cast<std::size_t>(row.b)];
        const ContactFeature& feature = pair.manifold.contacts[i].feature;
        const ContactGeometry at = contact_geometry(feature, pose_a, pose_b);
        contact.gap = at.gap;
        const double missing = contact.gap_target - at.gap;
        worst = std::max(worst, row.p_n > 0.0 ? std::abs(missing) : missing);
        row.u_n_target = normal_velocity(row, velocity_) + missing / h_;
        if (!row.has_friction()) {
            continue;
        }
        const Vec2 u_t = tangential_velocity(row, velocity_);
        if (is_curved(feature)) {
            // A point fixed to a turning ball leaves the surface: rolling is measured by the velocity at
            // mid-step.
            const Vec3 fall = 0.5 * h_ * relative_gravity(bodies, pair.manifold, settings_);
            contact.d_t = h_ * (u_t + Vec2(fall.dot(row.direction[1].axis), fall.dot(row.direction[2].axis)));
        } else {
            const Vec3 d = pose_a * contact.point_a - pose_b * contact.point_b;
            const Vec3 d_t = d - d.dot(at.n) * at.n;
            contact.d_t = Vec2(d_t.dot(row.direction[1].axis), d_t.dot(row.direction[2].axis));
        }
        const Vec3& slip = pair.memory[i].slip;
        const Vec2 carried(slip.dot(row.direction[1].axis), slip.dot(row.direction[2].axis));
        row.u_t_target = u_t - (contact.d_t + gap_relaxation * step_share_ * carried) / h_;
    }
    return worst;
}

/// Sweeps over joints and contacts until nothing changes by more than `tolerance` [m/s]. Returns their
/// number.
int ContactSolver::iterate(double tolerance, int budget, bool& converged) {
    const double joint_tolerance = settings_.joint_tolerance / h_;
    int count = 0;
    for (converged = false; count < budget && !converged; ++count) {
        const double missing = joints_.solve(velocity_);
        converged = rows_.empty() || sweep(rows_, velocity_) <= tolerance;
        converged =
            converged && (rows_.empty() || joints_.empty() || (count > 0 && missing <= joint_tolerance));
    }
    return count;
}

/// Eq. 6 on converged sums. A marked contact that is at its limit and slips loses its mark; a sliding one
/// that the step would reverse has stopped within it, and sticks if static friction can hold it. Returns true
/// if a mark changed.
bool ContactSolver::update_marks(const std::vector<PairContacts>& pairs) {
    const double slip_tolerance = iteration_share * settings_.tolerance;
    bool changed = false;
    for (std::size_t k = 0; k < rows_.size(); ++k) {
        ContactRow& row = rows_[k];
        if (!row.has_friction() || row.p_n == 0.0) {
            continue;
        }
        const Vec2 slip = tangential_velocity(row, velocity_) - row.u_t_target;
        const bool slips = slip.norm() * h_ > slip_tolerance;
        if (row.is_sticking) {
            if (slips && row.p_t.norm() >= (1.0 - 1e-9) * row.mu_s * row.p_n) {
                row.is_sticking = false;
                changed = changed || row.mu_d < row.mu_s;
            }
        } else if (row.mu_d < row.mu_s && slips) {
            const RestingContact& contact = contacts_[k];
            const Vec3& sliding = pairs[static_cast<std::size_t>(contact.pair)]
                                      .memory[static_cast<std::size_t>(contact.index)]
                                      .sliding;
            const Vec2 before(sliding.dot(row.direction[1].axis), sliding.dot(row.direction[2].axis));
            if (slip.dot(before) < 0.0 &&
                can_stick(stopping_sum(row.p_t, slip, row.K_tt_inverse), row.p_n, row.mu_s)) {
                row.is_sticking = true;
                changed = true;
            }
        }
    }
    return changed;
}

ContactSolveReport ContactSolver::solve(const Bodies& bodies, std::vector<PairContacts>& pairs,
                                        std::span<const Joint> joints) {
    ContactSolveReport report;
    const double iteration_tolerance =
        std::min(iteration_share * settings_.tolerance / h_, settings_.velocity_tolerance);
    predict(bodies);
    for (int outer = 0; outer < outer_limit; ++outer) {
        report.residual = measure(bodies, pairs);
        report.joint_residual =
            joints_.empty() ? 0.0 : joints_.target_closed(joints, predicted_, velocity_, h_, step_share_);
        if (outer > 0 && report.residual <= accepted_share * settings_.tolerance &&
            report.joint_residual <= settings_.joint_tolerance) {
            break;
        }
        const int left = settings_.iteration_limit - report.iterations;
        const int budget =
            settings_.shock_propagation ? std::min(left, settings_.shock_propagation_after) : left;
        bool converged = true;
        if (budget > 0 && !(rows_.empty() && joints_.empty())) {
            report.iterations += iterate(iteration_tolerance, budget, converged);
            while (update_marks(pairs) && report.iterations < settings_.iteration_limit) {
                report.iterations +=
                    iterate(iteration_tolerance, settings_.iteration_limit - report.iterations, converged);
            }
        }
        if (settings_.shock_propagation && !converged) {
            shock_propagation(bodies);
        }
        predict(bodies);
        if (rows_.empty() && joints_.empty()) {
            break;
        }
    }
    report.converged =
        report.residual <= settings_.tolerance && report.joint_residual <= settings_.joint_tolerance;
    compute_kick(bodies);
    return report;
}

/// Velocity change of each body by joints and by contacts that touched already: the impulses of continuous
/// forces.
void ContactSolver::compute_kick(const Bodies& bodies) {
    kick_.resize(velocity_.size());
    for (std::size_t i = 0; i < velocity_.size(); ++i) {
        kick_[i] = {velocity_[i].v - bodies.velocity[i].v, velocity_[i].w - bodies.velocity[i].w};
    }
    for (std::size_t k = 0; k < rows_.size(); ++k) {
        if (contacts_[k].is_ahead && rows_[k].p_n > 0.0) {
            ContactRow negative = rows_[k];
            negative.p_n = -negative.p_n;
            negative.p_t = -negative.p_t;
            apply_sums(negative, kick_);
        }
    }
}

void ContactSolver::remember(std::vector<PairContacts>& pairs) const {
    for (std::size_t k = 0; k < rows_.size(); ++k) {
        const ContactRow& row = rows_[k];
        const RestingContact& contact = contacts_[k];
        ContactMemory& memory =
            pairs[static_cast<std::size_t>(contact.pair)].memory[static_cast<std::size_t>(contact.index)];
        const bool loaded = row.p_n > 0.0;
        // What an impact takes away is no force: the next step does not start from it.
        memory.p_n = contact.is_ahead ? 0.0 : row.p_n;
        memory.p_t = Vec3::Zero();
        memory.interval = row.node_weight < 1.0 ? 0.5 * h_ / (1.0 - row.node_weight) : h_;
        memory.approach_speed = contact.is_ahead && loaded ? contact.approach_speed : 0.0;
        memory.energy_taken = 0.0;
        if (memory.approach_speed > 0.0) {
            // Work of the impulses: each times the mean of its velocity before and after.
            const Vec2 u_t = row.has_friction() ? tangential_velocity(row, velocity_) : Vec2(Vec2::Zero());
            memory.energy_taken = -0.5 * row.p_n * (contact.u_n_before + normal_velocity(row, velocity_)) -
                                  0.5 * row.p_t.dot(row.u_t_before + u_t);
        }
        if (!row.has_friction()) {
            continue;
        }
        if (!contact.is_ahead) {
            memory.p_t = row.p_t.x() * row.direction[1].axis + row.p_t.y() * row.direction[2].axis;
        }
        const bool at_limit = row.p_t.norm() >= (1.0 - 1e-9) * row.mu_d * row.p_n;
        memory.is_sticking = loaded && (row.is_sticking || !at_limit);
        const Vec3 d_t = contact.d_t.x() * row.direction[1].axis + contact.d_t.y() * row.direction[2].axis;
        memory.slip = memory.is_sticking ? Vec3(memory.slip + d_t) : Vec3(Vec3::Zero());
        memory.sliding = memory.is_sticking ? Vec3(Vec3::Zero()) : Vec3(d_t / h_);
    }
}

/// Guendelman et al. 2003: level by level from the static bodies upward, each level's bodies then count as
/// immovable.
void ContactSolver::shock_propagation(const Bodies& bodies) {
    const std::vector<int> level = contact_levels(rows_, bodies.props);
    int top = 0;
    for (const ContactRow& row : rows_) {
        top = std::max({top, level[static_cast<std::size_t>(row.a)], level[static_cast<std::size_t>(row.b)]});
    }
    for (int current = 1; current <= top; ++current) {
        double change = std::numeric_limits<double>::infinity();
        for (int i = 0; i < settings_.shock_propagation_after && change > 0.0; ++i) {
            change = 0.0;
            for (ContactRow& row : rows_) {
                const int level_a = level[static_cast<std::size_t>(row.a)];
                const int level_b = level[static_cast<std::size_t>(row.b)];
                if (std::max(level_a, level_b) == current) {
                    change = std::max(
                        change, iterate_with_immovable(row, velocity_, level_a < current, level_b < current));
                }
            }
        }
    }
}

} // namespace sim
