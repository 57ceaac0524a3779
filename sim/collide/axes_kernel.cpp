/// The separating axes of eight pairs of boxes. Compiled once for each instruction set; KERNEL names it.
#include "sim/collide/box_lanes.h"

namespace sim {
namespace {

/// Edge directions whose cross product is shorter than this [-] count as parallel: a face axis then says the same.
constexpr double parallel_edges = 1e-6;

/// The best axis so far of one kind.
struct Best {
    Real separation = real(-__builtin_inf());
    Real index = real(-1.0);
    Real side = real(1.0);

    LANES_INLINE void offer(const Mask& valid, const Real& s, int i, const Real& offset) {
        const Mask better = valid & (s > separation);
        separation = select(better, s, separation);
        index = select(better, real(i), index);
        side = select(better, select(offset >= 0.0, real(1.0), real(-1.0)), side);
    }
    LANES_INLINE void write(const AxesSearch& search, Window lanes, int kind) const {
        for (int l = 0; l < width && lanes.first + l < search.count; ++l) {
            BoxAxes& axes = *search.axes[lanes.first + l];
            axes.separations[kind] = separation[l];
            axes.indices[kind] = static_cast<signed char>(index[l]);
            axes.sides[kind] = static_cast<signed char>(side[l]);
        }
    }
};

LANES_INLINE void find_axes(const AxesSearch& search, Window lanes) {
    const Boxes a = gather_boxes(search.boxes, search.a + lanes.first);
    const Boxes b = gather_boxes(search.boxes, search.b + lanes.first);
    const Real3 b_to_a = a.centre - b.centre;
    const Mask all = ~nowhere();
    Real rotation[3][3];
    Real absolute[3][3];
    Real t_a[3];
    Real t_b[3];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            rotation[i][j] = dot(a.axes[i], b.axes[j]);
            absolute[i][j] = abs(rotation[i][j]);
        }
        t_a[i] = dot(a.axes[i], b_to_a);
        t_b[i] = dot(b.axes[i], b_to_a);
    }
    Best face_a;
    Best face_b;
    Best edges;
    for (int i = 0; i < 3; ++i) {
        const Real reach_b = absolute[i][0] * b.half[0] + absolute[i][1] * b.half[1] + absolute[i][2] * b.half[2];
        const Real reach_a = absolute[0][i] * a.half[0] + absolute[1][i] * a.half[1] + absolute[2][i] * a.half[2];
        face_a.offer(all, abs(t_a[i]) - a.half[i] - reach_b, i, t_a[i]);
        face_b.offer(all, abs(t_b[i]) - b.half[i] - reach_a, i, t_b[i]);
    }
    for (int i = 0; i < 3; ++i) {
        const int i1 = (i + 1) % 3;
        const int i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            const int j1 = (j + 1) % 3;
            const int j2 = (j + 2) % 3;
            // The axis is e_i x R e_j; in the frame of a, its components are -R(i2,j) at i1 and R(i1,j) at i2.
            const Real sine_squared = 1.0 - rotation[i][j] * rotation[i][j];
            const Mask crossing = sine_squared >= parallel_edges * parallel_edges;
            const Real offset = t_a[i2] * rotation[i1][j] - t_a[i1] * rotation[i2][j];
            const Real reach = a.half[i1] * absolute[i2][j] + a.half[i2] * absolute[i1][j] +
                               b.half[j1] * absolute[i][j2] + b.half[j2] * absolute[i][j1];
            const Real s = (abs(offset) - reach) / sqrt(select(crossing, sine_squared, real(1.0)));
            edges.offer(crossing, s, 3 * i + j, offset);
        }
    }
    face_a.write(search, lanes, 0);
    face_b.write(search, lanes, 1);
    edges.write(search, lanes, 2);
}

} // namespace

void KERNEL(const AxesSearch& search) {
    for (Window lanes; lanes.first < search.count; lanes.first += width) {
        find_axes(search, lanes);
    }
}

} // namespace sim
