#include "sim/block/contact_block.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sim {
namespace {

/// Rounds of the point-by-point loop where the active-set search of a block fails.
constexpr int fallback_rounds = 20;

/// Targets that a rigid motion misses by more than this share [-] of the velocities asked for are
/// inconsistent.
constexpr double inconsistent = 1e-6;

/// Velocities this share [-] of their terms below the target are at it.
constexpr double rounding = 1e-12;

/// Points nearer to a line than this share [-] of their extent count as lying on it.
constexpr double collinear = 1e-7;

using Points = std::span<ContactPoint>;
using Values = std::array<double, block_size>;

/// What a normal impulse at a point does to (P_n, L_1, L_2), and what (u_n, w_1, w_2) does at the point.
Vec3 normal_row(const ContactPoint& p) {
    return {1.0, p.y, -p.x};
}

/// Smallest normal impulses of the points in `active` (a bit mask) that bring their normal velocity changes
/// to -excess, in the least-squares sense where the points are redundant. w: response of (u_n, w_1, w_2) to
/// (P_n, L_1, L_2). excess [m/s]: velocity above target with these points' impulses at zero. Results in
/// `impulse` [N s]. Returns false if the points are three or more on one line.
bool normal_impulses(Points points, unsigned active, const Mat3& w, const Values& excess, Values& impulse) {
    std::array<std::size_t, block_size> index{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        impulse[i] = 0.0;
        if ((active >> i & 1u) != 0) {
            index[count++] = i;
        }
    }
    if (count == 1) {
        const Vec3 row = normal_row(points[index[0]]);
        impulse[index[0]] = normal_impulse(excess[index[0]], 0.0, row.dot(w * row));
        return true;
    }
    if (count == 2) {
        const Vec3 row0 = normal_row(points[index[0]]);
        const Vec3 row1 = normal_row(points[index[1]]);
        const Vec3 w0 = w * row0;
        const double k00 = row0.dot(w0);
        const double k01 = row1.dot(w0);
        const double k11 = row1.dot(w * row1);
        const double determinant = k00 * k11 - k01 * k01;
        if (determinant <= collinear * collinear * k00 * k11) {
            return false;
        }
        impulse[index[0]] = (k01 * excess[index[1]] - k11 * excess[index[0]]) / determinant;
        impulse[index[1]] = (k01 * excess[index[0]] - k00 * excess[index[1]]) / determinant;
        return true;
    }
    Mat3 gram = Mat3::Zero();
    Vec3 fit = Vec3::Zero();
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 row = normal_row(points[index[k]]);
        gram += row * row.transpose();
        fit += excess[index[k]] * row;
    }
    // Second moments about the centroid: their determinant vanishes for points on a line.
    const double n = gram(0, 0);
    const double yy = gram(1, 1) - gram(0, 1) * gram(0, 1) / n;
    const double xx = gram(2, 2) - gram(0, 2) * gram(0, 2) / n;
    const double xy = gram(1, 2) - gram(0, 1) * gram(0, 2) / n;
    if (xx * yy - xy * xy <= collinear * (xx + yy) * (xx + yy)) {
        return false;
    }
    const Mat3 gram_inverse = gram.inverse();
    const Vec3 wrench = -(w.inverse() * (gram_inverse * fit));
    const Vec3 share = gram_inverse * wrench;
    for (std::size_t k = 0; k < count; ++k) {
        impulse[index[k]] = normal_row(points[index[k]]).dot(share);
    }
    return true;
}

/// The points of `active` farthest apart along their line.
unsigned line_ends(Points points, unsigned active) {
    std::size_t first = block_size;
    std::size_t last = 0;
    std::size_t origin = static_cast<std::size_t>(std::countr_zero(active));
    const auto farthest = [&](std::size_t from) {
        std::size_t best = from;
        double distance = -1.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double d = std::hypot(points[i].x - points[from].x, points[i].y - points[from].y);
            if ((active >> i & 1u) != 0 && d > distance) {
                best = i;
                distance = d;
            }
        }
        return best;
    };
    first = farthest(origin);
    last = farthest(first);
    return 1u << first | 1u << last;
}

/// (P_n, L_1, L_2) of normal impulses.
Vec3 normal_wrench(Points points, const Values& impulse) {
    Vec3 total = Vec3::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
        total += impulse[i] * normal_row(points[i]);
    }
    return total;
}

/// Active-set search for non-negative impulses with velocities at or above their targets, from the set
/// `active` on. Returns false if it comes to no end, which nearly coincident points can cause.
bool search_active_set(Points points, const Mat3& w, const Values& excess, unsigned active, Values& impulse) {
    const int limit = 4 * static_cast<int>(points.size());
    for (int pivot = 0; pivot < limit; ++pivot) {
        if (active == 0) {
            impulse.fill(0.0);
        } else if (!normal_impulses(points, active, w, excess, impulse)) {
            const unsigned ends = line_ends(points, active);
            active = ends == active ? ends & (ends - 1) : ends;
            continue;
        }
        const auto least =
            std::min_element(impulse.begin(), impulse.begin() + static_cast<std::ptrdiff_t>(points.size()));
        if (*least < 0.0) {
            active &= ~(1u << (least - impulse.begin()));
            continue;
        }
        const Vec3 change = w * normal_wrench(points, impulse);
        std::size_t worst = block_size;
        double lowest = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double u = excess[i] + normal_row(points[i]).dot(change);
            if ((active >> i & 1u) == 0 && u < std::min(lowest, -rounding * std::abs(excess[i]))) {
                lowest = u;
                worst = i;
            }
        }
        if (worst == block_size) {
            return true;
        }
        active |= 1u << worst;
    }
    return false;
}

/// Do all loaded points reach their targets? Points of faces that are not quite parallel can ask for more
/// than a rigid motion can give; then only some of them carry, and the least-squares answer is none.
bool is_consistent(Points points, const Mat3& w, const Values& excess, const Values& impulse) {
    const Vec3 change = w * normal_wrench(points, impulse);
    double scale = 0.0;
    double worst = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        scale = std::max(scale, std::abs(excess[i]));
        if (impulse[i] > 0.0) {
            worst = std::max(worst, std::abs(excess[i] + normal_row(points[i]).dot(change)));
        }
    }
    return worst <= inconsistent * scale;
}

/// The same by projected sweeps over the points (eq. 1-3 as they stand), which always converge.
void iterate_normals(Points points, const Mat3& w, const Values& excess, Values& impulse) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        impulse[i] = points[i].p_n;
    }
    Vec3 change = w * normal_wrench(points, impulse);
    for (int round = 0; round < fallback_rounds; ++round) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3 row = normal_row(points[i]);
            const Vec3 response = w * row;
            const double p =
                clamped_sum(impulse[i], normal_impulse(excess[i] + row.dot(change), 0.0, row.dot(response)));
            change += (p - impulse[i]) * response;
            impulse[i] = p;
        }
    }
}

/// Normal impulses of a block: non-negative (eq. 2, 3), velocities at their targets or above; the search
/// starts from the points that carry load. Returns the largest change of a point's normal velocity [m/s].
double solve_normals(Points points, const Mat6& w, Vec6& twist, Vec6& wrench) {
    const Mat3 w_nn = w.block<3, 3>(2, 2);
    Values impulse{};
    unsigned active = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        impulse[i] = points[i].p_n;
        active |= static_cast<unsigned>(points[i].p_n > 0.0) << i;
    }
    const Vec3 held = normal_wrench(points, impulse); // (P_n, L_1, L_2) of the impulses so far
    const Vec3 lifted = w_nn * held;
    Values excess{};
    unsigned approaching = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        excess[i] =
            normal_velocity(points[i], twist) - normal_row(points[i]).dot(lifted) - points[i].u_n_target;
        approaching |= static_cast<unsigned>(excess[i] < 0.0) << i;
    }
    active = active != 0 ? active : approaching;
    if (active == 0) {
        return 0.0;
    }
    if (!search_active_set(points, w_nn, excess, active, impulse) ||
        !is_consistent(points, w_nn, excess, impulse)) {
        iterate_normals(points, w_nn, excess, impulse);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i].p_n = impulse[i];
    }
    const Vec3 added = normal_wrench(points, impulse) - held;
    wrench.segment<3>(2) += added;
    const Vec6 before = twist;
    twist += w.middleCols<3>(2) * added;
    double largest = 0.0;
    for (const ContactPoint& p : points) {
        largest = std::max(largest, std::abs(normal_velocity(p, twist) - normal_velocity(p, before)));
    }
    return largest;
}

/// Friction impulses (P_1, P_2, L_n) of the points.
Vec3 friction_wrench(Points points) {
    Vec3 wrench = Vec3::Zero();
    for (const ContactPoint& p : points) {
        wrench += Vec3(p.p_t.x(), p.p_t.y(), p.x * p.p_t.y() - p.y * p.p_t.x());
    }
    return wrench;
}

/// The friction impulses that stop the slip of all loaded points (eq. 5 for the block), shared in proportion
/// to the normal impulses. Returns false if a point would exceed mu_s p_n (eq. 6).
bool stop_slip(Points points, const Mat6& w, const Vec6& twist, double mu,
               std::array<Vec2, block_size>& impulse) {
    double load = 0.0;
    Vec2 centre = Vec2::Zero();
    for (const ContactPoint& p : points) {
        load += p.p_n;
        centre += p.p_n * Vec2(p.x, p.y);
    }
    centre /= load;
    // Weighted least squares: slip of the centre and turning about it.
    Vec2 slip = Vec2::Zero();
    double inertia = 0.0;
    double turning = 0.0;
    for (const ContactPoint& p : points) {
        const Vec2 arm = Vec2(p.x, p.y) - centre;
        const Vec2 u = tangential_velocity(p, twist) - p.u_t_target;
        slip += p.p_n * u;
        inertia += p.p_n * arm.squaredNorm();
        turning += p.p_n * (arm.x() * u.y() - arm.y() * u.x());
    }
    slip /= load;
    // Response of (u_1, u_2 at the pressure centre, w_n) to (P_1, P_2, L_n about it).
    Mat3 k;
    k << w(0, 0), w(0, 1), w(0, 5), w(1, 0), w(1, 1), w(1, 5), w(5, 0), w(5, 1), w(5, 5);
    Mat3 shift = Mat3::Identity();
    shift(0, 2) = -centre.y();
    shift(1, 2) = centre.x();
    k = shift * k * shift.transpose();
    Vec3 held = friction_wrench(points);
    held.z() -= centre.x() * held.y() - centre.y() * held.x();
    Vec3 total;
    double twisting = 0.0; // impulse per unit arm and unit load
    if (inertia > collinear * collinear * load * (centre.squaredNorm() + inertia / load)) {
        total = held - k.inverse() * Vec3(slip.x(), slip.y(), turning / inertia);
        twisting = total.z() / inertia;
    } else {
        total << Vec2(held.head<2>() - Mat2(k.topLeftCorner<2, 2>()).inverse() * slip), 0.0;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec2 arm = Vec2(points[i].x, points[i].y) - centre;
        impulse[i] = points[i].p_n * (total.head<2>() / load + twisting * Vec2(-arm.y(), arm.x()));
        if (!can_stick(impulse[i], points[i].p_n, mu)) {
            return false;
        }
    }
    return true;
}

/// Puts new friction impulses in place; returns the largest change of a point's tangential velocity [m/s].
double set_friction(Points points, const std::array<Vec2, block_size>& impulse, const Mat6& w, Vec6& twist,
                    Vec6& wrench) {
    const Vec3 before = friction_wrench(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i].p_t = impulse[i];
    }
    const Vec3 added = friction_wrench(points) - before;
    const Vec6 old = twist;
    twist += w.col(0) * added[0] + w.col(1) * added[1] + w.col(5) * added[2];
    wrench[0] += added[0];
    wrench[1] += added[1];
    wrench[5] += added[2];
    double largest = 0.0;
    for (const ContactPoint& p : points) {
        largest = std::max(largest, (tangential_velocity(p, twist) - tangential_velocity(p, old)).norm());
    }
    return largest;
}

/// Friction impulse of a point that slides, or is about to stop, projected onto its friction disc. k_t_load: response of
/// the block [1/kg] times its load [N s].
Vec2 slid_impulse(const ContactBlock& block, const ContactPoint& p, const Vec6& twist, double k_t_load) {
    if (p.p_n == 0.0) {
        return Vec2::Zero();
    }
    const double k_t = k_t_load / p.p_n; // steps in proportion to the load: together they are one step of the whole block
    const double mu = block.is_sticking ? block.mu_s : block.mu_d;
    const Vec2 u_t = tangential_velocity(p, twist);
    const Vec2 slip = u_t - p.u_t_target;
    // A marked contact at its limit still holds against the slip of this step. A sliding one acts against the sliding
    // velocity at t0, between those before and after the impulses: its direction stays second order. The nearer it comes
    // to stopping in this step, the more its slip tells the direction, as for sticking.
    const Vec2 before = tangential_before(block, p);
    const Vec2 u_t0 = before + block.node_weight * (u_t - before);
    const double stopped = (u_t0 - slip).squaredNorm();
    const double moving = slip.squaredNorm();
    const Vec2 u_sliding = block.is_sticking || stopped == 0.0
                               ? slip
                               : Vec2(slip + (moving / (moving + stopped)) * (u_t0 - slip));
    const Vec2 stopping = p.p_t - slip / k_t;
    return can_stick(stopping, p.p_n, mu) ? stopping : sliding_sum(p.p_t, u_sliding, k_t, mu * p.p_n);
}

/// Friction impulses of a block for its present normal impulses. Returns the largest velocity change at a
/// point [m/s].
double solve_friction(const ContactBlock& block, const BlockResponse& response, Points points, int projections,
                      Vec6& twist, Vec6& wrench) {
    const Mat6& w = response.twist;
    std::array<Vec2, block_size> impulse;
    double load = 0.0;
    for (const ContactPoint& p : points) {
        load += p.p_n;
    }
    if (load == 0.0) {
        impulse.fill(Vec2::Zero());
        return set_friction(points, impulse, w, twist, wrench);
    }
    const double mu = block.is_sticking ? block.mu_s : block.mu_d;
    if (stop_slip(points, w, twist, mu, impulse)) {
        return set_friction(points, impulse, w, twist, wrench);
    }
    double largest = 0.0;
    for (int round = 0; round < projections; ++round) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            impulse[i] = slid_impulse(block, points[i], twist, response.k_t * load);
        }
        largest = std::max(largest, set_friction(points, impulse, w, twist, wrench));
    }
    return largest;
}

} // namespace

Vec6 block_wrench(const ContactBlock& block, const BlockResponse& response, std::span<ContactPoint> points, Vec6 twist,
                  double& change, int projections) {
    Vec6 wrench = Vec6::Zero();
    change = solve_normals(points, response.twist, twist, wrench);
    if (block.has_friction()) {
        change = std::max(change, solve_friction(block, response, points, projections, twist, wrench));
    }
    return wrench;
}

double solve_block(const ContactBlock& block, const BlockResponse& response, std::span<ContactPoint> points,
                   const Bodies& bodies, std::span<Velocity> velocity, int projections, bool hold_a, bool hold_b) {
    const auto a = static_cast<std::size_t>(block.a);
    const auto b = static_cast<std::size_t>(block.b);
    double change = 0.0;
    const Vec6 wrench = block_wrench(block, response, points, relative_twist(block, velocity), change, projections);
    if (!wrench.isZero(0.0)) {
        const Velocity kept_a = velocity[a];
        const Velocity kept_b = velocity[b];
        apply_wrench(block, wrench, bodies.props, bodies.inverse_inertia, velocity);
        if (hold_a) {
            velocity[a] = kept_a;
        }
        if (hold_b) {
            velocity[b] = kept_b;
        }
    }
    return change;
}

} // namespace sim
