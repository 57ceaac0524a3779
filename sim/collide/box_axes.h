#pragma once
/// Separating axes of box against box, eight pairs at a time: the fast form of the search in box_box.cpp. This header
/// knows no library: axes_kernel.cpp is compiled once for each instruction set.
#include <cstddef>

namespace sim {

/// A box in the world: what the search for axes needs, in rows of 64 bytes.
struct alignas(64) PlacedBoxRow {
    double axes[9];    ///< rotation matrix, column by column
    double centre[3];  ///< [m]
    double half[3];    ///< half extents [m]
    double unused = 0.0;
};

/// The axis of the largest separation among its kind; see BestAxis in box_box.cpp.
struct AxisChoice {
    double separation; ///< [m]
    int index;         ///< face: axis 0..2; edges: 3 * axis of a + axis of b; -1: none
    int side;          ///< +1: n is along the axis, -1: against it
};

/// Of a pair of boxes.
struct BoxAxes {
    AxisChoice face_a, face_b, edges;

    double separation() const {
        const double faces = face_a.separation > face_b.separation ? face_a.separation : face_b.separation;
        return faces > edges.separation ? faces : edges.separation;
    }
};

/// Pair k is of boxes[first[k]] and boxes[second[k]]; its axes become axes[result[k]].
struct AxesSearch {
    const PlacedBoxRow* boxes = nullptr;
    const int* first = nullptr;
    const int* second = nullptr;
    const int* result = nullptr;
    std::size_t count = 0;
    BoxAxes* axes = nullptr;
};
void find_axes(const AxesSearch& search);

} // namespace sim
