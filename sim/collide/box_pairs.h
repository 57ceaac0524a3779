#pragma once
/// Box against box, eight pairs at a time. This header knows no library: the kernels are compiled once for each
/// instruction set.
#include "sim/base/lane_count.h"

namespace sim {

/// A box in the world: what the search for axes needs, in rows of 64 bytes.
struct alignas(64) PlacedBoxRow {
    double axes[9];    ///< rotation matrix, column by column
    double centre[3];  ///< [m]
    double half[3];    ///< half extents [m]
    double unused = 0.0;
};

/// The axis of the largest separation among its kind: of the faces of a or b, or of the cross products of edges.
struct AxisChoice {
    double separation; ///< [m]
    int index;         ///< face: axis 0..2; edges: 3 * axis of a + axis of b; -1: none
    int side;          ///< +1: n is along the axis, -1: against it
};

/// Of a pair of boxes, one of each kind: a face of a, of b, edges.
struct BoxAxes {
    double separations[3];
    signed char indices[3];
    signed char sides[3];

    AxisChoice of_kind(int kind) const { return {separations[kind], indices[kind], sides[kind]}; }
    AxisChoice face_a() const { return of_kind(0); }
    AxisChoice face_b() const { return of_kind(1); }
    AxisChoice edges() const { return of_kind(2); }
    double separation() const {
        const double faces = separations[0] > separations[1] ? separations[0] : separations[1];
        return faces > separations[2] ? faces : separations[2];
    }
};

/// Pair k is of boxes[a[k]] and boxes[b[k]]; its axes become *axes[k].
struct AxesSearch {
    const PlacedBoxRow* boxes = nullptr;
    int count = 0; ///< up to lane_count
    int a[lane_count] = {};
    int b[lane_count] = {};
    BoxAxes* axes[lane_count] = {};
};
void find_axes(const AxesSearch& search);

/// A corner of what two faces cover of each other, seen along the normal of one of them, the reference.
struct FaceCorner {
    double on_reference[3]; ///< [m] on that face, in the frame of its box
    double on_incident[3];  ///< [m] on the other one, in the frame of its box
    double gap;             ///< [m] between these points
    unsigned id;            ///< 0..63: the features that cross there
};

/// Most corners [-] of what two rectangles have in common.
inline constexpr int most_face_corners = 8;

/// All corners, by ascending ids.
struct FaceCorners {
    bool is_of_a = true;   ///< the reference face, not one of b
    int incident_face = 0; ///< of the incident box, most opposed to the reference: 2 * axis + (outward is + ? 0 : 1)
    int count = 0;
    FaceCorner corners[most_face_corners];
};

/// Pair k is of a face of boxes[reference[k]], with the normal outward.x[k] along its axis axis.x[k], and of boxes[incident[k]];
/// its corners become *corners[k].
struct FaceClip {
    const PlacedBoxRow* boxes = nullptr;
    int count = 0; ///< up to lane_count
    int reference[lane_count] = {};
    int incident[lane_count] = {};
    Lanes axis = {};    ///< 0, 1, 2
    Lanes outward = {}; ///< 1, -1
    FaceCorners* corners[lane_count] = {};
};
void clip_faces(const FaceClip& clip);

} // namespace sim
