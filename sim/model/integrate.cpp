#include "sim/model/integrate.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>

namespace sim {
namespace {

/// Moments that differ by less than this share [-] count as equal; the error is the same share of the spin.
constexpr double equal_moments = 1e-13;

bool nearly_equal(double x, double y) {
    return std::abs(x - y) <= equal_moments * std::max(std::abs(x), std::abs(y));
}

/// Angle [rad] a substep of an asymmetric body may turn: the terms of its series become small soon.
constexpr double substep_angle = 0.1;
/// Substeps [-] at most: what turns further in a step is no motion, but a solve that came to no end.
constexpr double most_substeps = 1e5;
/// Terms of the series below this [-] are rounding; of that angle there are no more than most_terms.
constexpr double least_term = 1e-17;
constexpr std::size_t most_terms = 12;

/// Rotation about the body's own z axis.
Quat about_z(double angle) {
    return Quat(std::cos(0.5 * angle), 0.0, 0.0, std::sin(0.5 * angle));
}

/// Torque-free rotation of a body with moments (A, A, C): it precesses about the constant L with L / A and
/// turns about its own axis with (1/C - 1/A) L_z. Exact.
Quat symmetric_rotation(const Quat& world_from_principal, const Vec3& momentum, double inverse_a,
                        double inverse_c, double h) {
    const double l_z = (world_from_principal.conjugate() * momentum).z();
    return turned(world_from_principal, momentum * (inverse_a * h)) *
           about_z((inverse_c - inverse_a) * l_z * h);
}

/// Torque-free rotation of an asymmetric body by the Taylor series of q' = q w / 2 and L' = L x w, in the frame of its principal
/// axes, where w = L / I. Exact to rounding. momentum: L, world.
Quat asymmetric_rotation(const BodyProps& props, Quat world_from_principal, const Vec3& momentum, double h) {
    const Vec3& inverse = props.inverse_principal_inertia;
    const double angle = momentum.norm() * inverse.maxCoeff() * h; // at most
    const int substeps = static_cast<int>(std::clamp(std::ceil(angle / substep_angle), 1.0, most_substeps));
    const double s = h / substeps;
    for (int i = 0; i < substeps; ++i) {
        // Terms of degree k in the time, of the whole substep: q[k], l[k], and of s w, w[k].
        std::array<Quat, most_terms> q{world_from_principal};
        std::array<Vec3, most_terms> l{world_from_principal.conjugate() * momentum};
        std::array<Vec3, most_terms> w;
        Eigen::Vector4d sum = q[0].coeffs();
        double size = 1.0; // of a term, at most
        for (std::size_t k = 0; k + 1 < most_terms && size > least_term; ++k) {
            const double per = 1.0 / static_cast<double>(k + 1);
            w[k] = s * inverse.cwiseProduct(l[k]);
            Vec3 l_next = Vec3::Zero();
            Vec3 axis = Vec3::Zero();
            double real = 0.0;
            for (std::size_t j = 0; j <= k; ++j) {
                l_next += l[j].cross(w[k - j]);
                axis += q[j].w() * w[k - j] + q[j].vec().cross(w[k - j]);
                real -= q[j].vec().dot(w[k - j]);
            }
            l[k + 1] = per * l_next;
            q[k + 1].vec() = 0.5 * per * axis;
            q[k + 1].w() = 0.5 * per * real;
            sum += q[k + 1].coeffs();
            size *= angle / substeps * per;
        }
        world_from_principal = Quat(sum).normalized();
    }
    return world_from_principal;
}

} // namespace

Quat turned(const Quat& orientation, const Vec3& angle) {
    const double square = 0.25 * angle.squaredNorm(); // of half the angle [rad^2]
    double sinc;
    double cosine;
    if (square < 0.01) { // by their series: what is left out is less than 1e-20
        sinc = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0 * (1.0 - square / 110.0))));
        cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0 * (1.0 - square / 90.0))));
    } else {
        const double half = std::sqrt(square);
        sinc = std::sin(half) / half;
        cosine = std::cos(half);
    }
    const Vec3 axis = 0.5 * sinc * angle;
    return (Quat(cosine, axis.x(), axis.y(), axis.z()) * orientation).normalized();
}

BodyProps make_body_props(const BodyDef& def) {
    BodyProps props;
    props.shape = def.shape;
    props.restitution = def.material.restitution.value_or(-1.0);
    props.mu_s = def.material.mu_s.value_or(-1.0);
    props.mu_d = def.material.mu_d.value_or(-1.0);
    props.is_kinematic = def.is_kinematic();
    const Bounds box = bounds(def.shape, Pose{});
    props.bounding_radius = box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm();
    if (def.is_static()) {
        return props;
    }
    props.inverse_mass = 1.0 / def.mass.mass;
    Vec3 moments = def.mass.inertia.diagonal();
    Mat3 axes = Mat3::Identity();
    const Mat3 off_diagonal = def.mass.inertia - Mat3(moments.asDiagonal());
    if (off_diagonal.cwiseAbs().maxCoeff() > equal_moments * moments.maxCoeff()) {
        const Eigen::SelfAdjointEigenSolver<Mat3> solver(def.mass.inertia);
        moments = solver.eigenvalues();
        axes = solver.eigenvectors();
    }
    // Order the axes so that the two closest moments come first: z is the axis of (near) symmetry.
    const std::array gaps{std::abs(moments.y() - moments.z()), std::abs(moments.z() - moments.x()),
                          std::abs(moments.x() - moments.y())};
    const int z = gaps[2] <= gaps[0] && gaps[2] <= gaps[1] ? 2 : (gaps[0] <= gaps[1] ? 0 : 1);
    const int x = (z + 1) % 3;
    const int y = (z + 2) % 3;
    Mat3 principal;
    principal << axes.col(x), axes.col(y), axes.col(z);
    if (principal.determinant() < 0.0) {
        principal.col(2) = -principal.col(2);
    }
    props.principal_inertia = Vec3(moments[x], moments[y], moments[z]);
    props.inverse_principal_inertia = props.principal_inertia.cwiseInverse();
    props.body_from_principal = Quat(principal).normalized();
    if (!nearly_equal(moments[x], moments[y])) {
        props.inertia_kind = InertiaKind::asymmetric;
    } else if (!nearly_equal(moments[x], moments[z])) {
        props.inertia_kind = InertiaKind::symmetric;
    } else {
        props.inertia_kind = InertiaKind::spherical;
    }
    return props;
}

Pose free_motion(const BodyProps& props, const Pose& pose, const Velocity& velocity, const Vec3& gravity,
                 double h) {
    if (props.is_static()) {
        return props.is_kinematic ? Pose{pose.position + h * velocity.v, turned(pose.orientation, h * velocity.w)} : pose;
    }
    Pose after;
    after.position = pose.position + h * velocity.v + (0.5 * h * h) * gravity;
    if (props.inertia_kind == InertiaKind::spherical) {
        after.orientation = turned(pose.orientation, h * velocity.w);
        return after;
    }
    const Vec3 momentum = angular_momentum(props, pose.orientation, velocity.w);
    const Quat world_from_principal = pose.orientation * props.body_from_principal;
    const Quat moved =
        props.inertia_kind == InertiaKind::symmetric
            ? symmetric_rotation(world_from_principal, momentum, props.inverse_principal_inertia.x(),
                                 props.inverse_principal_inertia.z(), h)
            : asymmetric_rotation(props, world_from_principal, momentum, h);
    after.orientation = (moved * props.body_from_principal.conjugate()).normalized();
    return after;
}

Velocity velocity_after(const BodyProps& props, const Pose& before, const Pose& after, const Velocity& velocity,
                        const Vec3& fall) {
    if (props.is_static()) {
        return {};
    }
    Velocity result{velocity.v + fall, velocity.w};
    if (props.inertia_kind != InertiaKind::spherical) {
        const Vec3 momentum = angular_momentum(props, before.orientation, velocity.w);
        const Quat world_from_principal = after.orientation * props.body_from_principal;
        const Vec3 l_principal = world_from_principal.conjugate() * momentum;
        result.w = world_from_principal * props.inverse_principal_inertia.cwiseProduct(l_principal);
    }
    return result;
}

} // namespace sim
