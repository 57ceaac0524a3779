#include "sim/block/contact_block.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

/// Normals that differ by less than this [-] belong to one block.
constexpr double same_normal = 1e-9;

double combined(double x, double y) {
    if (x < 0.0 || y < 0.0) {
        return std::max({x, y, 0.0});
    }
    return std::sqrt(x * y);
}

/// A unit vector across n: from the world axis that is least along n, so it turns continuously with n.
Vec3 tangent_of(const Vec3& n) {
    int axis = 0;
    n.cwiseAbs().minCoeff(&axis);
    return n.cross(Vec3::Unit(axis)).normalized();
}

/// Adds a body's share to the response of a block: K and its angular parts. inverse_inertia and r in the block's
/// frame.
void add_response(Mat6& response, double inverse_mass, const Mat3& inverse_inertia, const Vec3& r) {
    const Mat3 turn = inverse_inertia * cross_matrix(r);
    response.topLeftCorner<3, 3>() += inverse_mass * Mat3::Identity() - cross_matrix(r) * turn;
    response.bottomLeftCorner<3, 3>() += turn;
    response.topRightCorner<3, 3>() += turn.transpose();
    response.bottomRightCorner<3, 3>() += inverse_inertia;
}

/// K_tt of one point [1/kg].
Mat2 tangential_response(const Mat6& w, const ContactPoint& p) {
    Mat2 k;
    k(0, 0) = w(0, 0) - 2.0 * p.y * w(0, 5) + p.y * p.y * w(5, 5);
    k(1, 1) = w(1, 1) + 2.0 * p.x * w(1, 5) + p.x * p.x * w(5, 5);
    k(0, 1) = k(1, 0) = w(0, 1) + p.x * w(0, 5) - p.y * w(1, 5) - p.x * p.y * w(5, 5);
    return k;
}

double largest_eigenvalue(const Mat2& k) {
    const double half_trace = 0.5 * k.trace();
    return half_trace + std::sqrt(std::max(half_trace * half_trace - k.determinant(), 0.0));
}

const ContactGeometry& geometry_of(const ContactGeometry& at) {
    return at;
}
const ContactGeometry& geometry_of(const Contact& contact) {
    return contact.at;
}

/// Length of the block that begins with the first of these contacts.
template <typename Any>
std::size_t length_of_block(std::span<const Any> contacts) {
    const Vec3& n = geometry_of(contacts[0]).n;
    std::size_t length = 1;
    while (length < contacts.size() && length < block_size &&
           (geometry_of(contacts[length]).n - n).squaredNorm() < same_normal * same_normal) {
        ++length;
    }
    return length;
}

template <typename Any>
std::size_t count_blocks(std::span<const Any> contacts) {
    std::size_t count = 0;
    for (; !contacts.empty(); ++count) {
        contacts = contacts.subspan(length_of_block(contacts));
    }
    return count;
}

} // namespace

BlockResponse block_response(const ContactBlock& block, std::span<const ContactPoint> points, const Bodies& bodies,
                             bool hold_a, bool hold_b) {
    BlockResponse response;
    const auto add = [&](int body, const Vec3& r) {
        const auto i = static_cast<std::size_t>(body);
        if (bodies.props[i].is_static()) {
            return;
        }
        const Mat3& inertia = bodies.inverse_inertia[i];
        const Mat3 turned = bodies.props[i].inertia_kind == InertiaKind::spherical
                                ? inertia
                                : Mat3(block.frame.transpose() * inertia * block.frame);
        add_response(response.twist, bodies.props[i].inverse_mass, turned, block.frame.transpose() * r);
    };
    if (!hold_a) {
        add(block.a, block.r_a);
    }
    if (!hold_b) {
        add(block.b, block.r_b);
    }
    for (const ContactPoint& point : points) {
        response.k_t = std::max(response.k_t, largest_eigenvalue(tangential_response(response.twist, point)));
    }
    return response;
}

PairMaterial pair_material(const BodyProps& a, const BodyProps& b) {
    return {combined(a.restitution, b.restitution), combined(a.mu_s, b.mu_s), combined(a.mu_d, b.mu_d)};
}

std::size_t block_count(std::span<const ContactGeometry> contacts) {
    return count_blocks(contacts);
}
std::size_t block_count(std::span<const Contact> contacts) {
    return count_blocks(contacts);
}
std::size_t block_length(std::span<const Contact> contacts) {
    return length_of_block(contacts);
}

void ContactBlocks::append(const Bodies& bodies, int a, int b, std::span<const ContactGeometry> contacts,
                           const PairMaterial& material) {
    const std::size_t first_block = blocks.size();
    const std::size_t first_point = points.size();
    blocks.resize(first_block + block_count(contacts));
    points.resize(first_point + contacts.size());
    place(first_block, first_point, bodies, a, b, contacts, material);
}

void ContactBlocks::place(std::size_t first_block, std::size_t first_point, const Bodies& bodies, int a, int b,
                          std::span<const ContactGeometry> contacts, const PairMaterial& material) {
    const auto ia = static_cast<std::size_t>(a);
    const auto ib = static_cast<std::size_t>(b);
    for (; !contacts.empty(); ++first_block) {
        const std::span<const ContactGeometry> own = contacts.first(length_of_block(contacts));
        contacts = contacts.subspan(own.size());
        ContactBlock block;
        block.a = a;
        block.b = b;
        block.first = static_cast<int>(first_point);
        block.count = static_cast<int>(own.size());
        block.mu_s = material.mu_s;
        block.mu_d = material.mu_d;
        Vec3 mean = Vec3::Zero();
        std::size_t nearest = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
            mean += own[i].a / block.count;
            nearest = own[i].gap < own[nearest].gap ? i : nearest;
        }
        // The plane in which the impulses act is that of the contact that touches first; others are still
        // apart.
        const Vec3& n = own[0].n;
        const Vec3 centre_a = mean + n * n.dot(own[nearest].a - mean);
        const Vec3 centre_b = centre_a - n * own[nearest].gap;
        block.r_a = centre_a - bodies.pose[ia].position;
        block.r_b = centre_b - bodies.pose[ib].position;
        const Vec3 t = tangent_of(n);
        block.frame << t, n.cross(t), n;
        for (const ContactGeometry& contact : own) {
            const Vec3 arm = contact.a - mean;
            ContactPoint point;
            point.x = block.frame.col(0).dot(arm);
            point.y = block.frame.col(1).dot(arm);
            points[first_point++] = point;
        }
        blocks[first_block] = block;
    }
}

void apply_wrench(const ContactBlock& block, const Vec6& wrench, std::span<const BodyProps> props,
                  std::span<const Mat3> inverse_inertia, std::span<Velocity> velocity) {
    const Vec3 p = block.frame * wrench.head<3>();
    const Vec3 l = block.frame * wrench.tail<3>();
    const auto a = static_cast<std::size_t>(block.a);
    const auto b = static_cast<std::size_t>(block.b);
    velocity[a].v += props[a].inverse_mass * p;
    velocity[a].w += inverse_inertia[a] * (block.r_a.cross(p) + l);
    velocity[b].v -= props[b].inverse_mass * p;
    velocity[b].w -= inverse_inertia[b] * (block.r_b.cross(p) + l);
}

Vec6 wrench_of(std::span<const ContactPoint> points) {
    Vec6 wrench = Vec6::Zero();
    for (const ContactPoint& point : points) {
        wrench += wrench_of_point(point);
    }
    return wrench;
}

} // namespace sim
