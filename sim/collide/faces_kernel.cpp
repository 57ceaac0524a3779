/// What two faces of boxes cover of each other, for eight pairs. Compiled once for each instruction set; KERNEL names it.
#include "sim/collide/box_lanes.h"

namespace sim {
namespace {

/// Share [-] of a face's half width by which a corner may stick out and still count as inside the face: boxes exactly on top
/// of each other keep their features.
constexpr double aligned = 1e-6;

/// Corners of two faces that may be corners of what they cover: four of the incident one, two ends of what is left of each of
/// its edges, four of the reference.
constexpr int slot_count = 16;

/// Sides of the reference face, where they cut.
enum Side { positive_u, negative_u, positive_v, negative_v, side_count };

/// A box whose axis n is that of a face; u, v: the next two.
struct Faces {
    Real3 u, v, n;
    Real half_u, half_v, half_n;

    LANES_INLINE Faces(const Boxes& box, const Mask& first, const Mask& second) {
        const auto pick = [&](const auto& one, const auto& two, const auto& three) {
            return select(first, one, select(second, two, three));
        };
        n = pick(box.axes[0], box.axes[1], box.axes[2]);
        u = pick(box.axes[1], box.axes[2], box.axes[0]);
        v = pick(box.axes[2], box.axes[0], box.axes[1]);
        half_n = pick(box.half[0], box.half[1], box.half[2]);
        half_u = pick(box.half[1], box.half[2], box.half[0]);
        half_v = pick(box.half[2], box.half[0], box.half[1]);
    }
};

/// One coordinate over the incident face: at its point (s, t), both within -1..1, centre + s u + t v.
struct Slope {
    Real centre, u, v;

    /// along: axis of the coordinate. offset: of the incident box's centre; side: of its face.
    LANES_INLINE Slope(const Real3& along, const Real3& offset, const Faces& incident, const Real& side)
        : centre(dot(offset, along) + side * incident.half_n * dot(incident.n, along)),
          u(incident.half_u * dot(incident.u, along)), v(incident.half_v * dot(incident.v, along)) {}

    LANES_INLINE Real at(const Real& s, const Real& t) const { return centre + s * u + t * v; }
};

/// What of an edge of the incident face lies over the reference: from `low` to `high`, and the sides that cut there.
struct Stretch {
    Real low = real(-1.0);
    Real high = real(1.0);
    Real low_side = real(0.0);
    Real high_side = real(0.0);

    /// Keeps where a coordinate, `middle` + slope * place, is within -limit..limit. Where the slope is 0, per_slope is infinite:
    /// all or nothing is kept; 0 * infinity, on the limit itself, cuts nothing as no comparison with it holds.
    LANES_INLINE void cut(const Real& middle, const Real& per_slope, const Real& limit, Side positive, Side negative) {
        const Real at_positive = (limit - middle) * per_slope;
        const Real at_negative = (-limit - middle) * per_slope;
        const Mask rises = per_slope > 0.0;
        const Real begin = select(rises, at_negative, at_positive);
        const Real end = select(rises, at_positive, at_negative);
        const Mask later = begin > low;
        const Mask sooner = end < high;
        low = select(later, begin, low);
        high = select(sooner, end, high);
        low_side = select(later, select(rises, real(negative), real(positive)), low_side);
        high_side = select(sooner, select(rises, real(positive), real(negative)), high_side);
    }
};

/// On the incident face.
struct Place {
    Real s, t;
};

/// The corners found, by slots.
struct Slots {
    unsigned there[slot_count]; ///< a bit for each lane
    Real s[slot_count], t[slot_count], x[slot_count], y[slot_count], gap[slot_count];
    Real side[slot_count];
};

/// Both faces of eight pairs.
struct FacePair {
    Faces incident;
    Real incident_axis;
    Real side;     ///< sign of the incident face's normal along that axis
    Slope x, y, z; ///< along u, v, n of the reference; z: above its face
    Real limit_x, limit_y;

    /// The place (s, t) on the incident face, where it is there; cut_by: the side of the reference that makes it a corner.
    LANES_INLINE void put(Slots& slots, int slot, const Mask& there, const Place& place, const Real& cut_by) const {
        const auto& [s, t] = place;
        slots.there[slot] = bits_of(there);
        slots.s[slot] = s;
        slots.t[slot] = t;
        slots.x[slot] = x.at(s, t);
        slots.y[slot] = y.at(s, t);
        slots.gap[slot] = z.at(s, t);
        slots.side[slot] = cut_by;
    }

    LANES_INLINE void find_corners(Slots& slots) const {
        const Real zero = real(0.0);
        Mask inside[2][2]; // [s > 0][t > 0]
        for (int i = 0; i < 2; ++i) {
            for (int j = 0; j < 2; ++j) {
                const Real s = real(2.0 * i - 1.0);
                const Real t = real(2.0 * j - 1.0);
                inside[i][j] = (abs(x.at(s, t)) <= limit_x) & (abs(y.at(s, t)) <= limit_y);
                put(slots, 2 * i + j, inside[i][j], {s, t}, zero);
            }
        }
        for (int i = 0; i < 2; ++i) {
            const Real across = real(2.0 * i - 1.0);
            Stretch along_u;
            along_u.cut(x.centre + across * x.v, 1.0 / x.u, limit_x, positive_u, negative_u);
            along_u.cut(y.centre + across * y.v, 1.0 / y.u, limit_y, positive_v, negative_v);
            const Mask has_u = along_u.low < along_u.high;
            put(slots, 4 + 2 * i, has_u & ~inside[0][i], {along_u.low, across}, along_u.low_side);
            put(slots, 5 + 2 * i, has_u & ~inside[1][i], {along_u.high, across}, along_u.high_side);
            Stretch along_v;
            along_v.cut(x.centre + across * x.u, 1.0 / x.v, limit_x, positive_u, negative_u);
            along_v.cut(y.centre + across * y.u, 1.0 / y.v, limit_y, positive_v, negative_v);
            const Mask has_v = along_v.low < along_v.high;
            put(slots, 8 + 2 * i, has_v & ~inside[i][0], {across, along_v.low}, along_v.low_side);
            put(slots, 9 + 2 * i, has_v & ~inside[i][1], {across, along_v.high}, along_v.high_side);
        }
        const Real per_area = 1.0 / (x.u * y.v - y.u * x.v);
        for (int i = 0; i < 2; ++i) {
            for (int j = 0; j < 2; ++j) {
                const Real dx = (2.0 * i - 1.0) * limit_x - x.centre;
                const Real dy = (2.0 * j - 1.0) * limit_y - y.centre;
                const Real s = (dx * y.v - dy * x.v) * per_area;
                const Real t = (dy * x.u - dx * y.u) * per_area;
                put(slots, 12 + 2 * i + j, (abs(s) < 1.0) & (abs(t) < 1.0), {s, t}, zero);
            }
        }
    }
};

LANES_INLINE FacePair face_pair(const FaceClip& clip, Window lanes) {
    const Boxes a = gather_boxes(clip.boxes, clip.reference + lanes.first);
    const Boxes b = gather_boxes(clip.boxes, clip.incident + lanes.first);
    const Real axis = lanes.load(clip.axis);
    const Faces reference(a, axis == 0.0, axis == 1.0);
    const Real3 normal = lanes.load(clip.outward) * reference.n;
    Real along[3];
    for (int i = 0; i < 3; ++i) {
        along[i] = abs(dot(b.axes[i], normal));
    }
    const Mask first = (along[0] >= along[1]) & (along[0] >= along[2]);
    const Mask second = ~first & (along[1] >= along[2]);
    const Faces incident(b, first, second);
    const Real side = select(dot(incident.n, normal) > 0.0, real(-1.0), real(1.0));
    const Real3 offset = b.centre - a.centre;
    Slope z(normal, offset, incident, side);
    z.centre = z.centre - reference.half_n;
    return {incident,
            select(first, real(0.0), select(second, real(1.0), real(2.0))),
            side,
            Slope(reference.u, offset, incident, side),
            Slope(reference.v, offset, incident, side),
            z,
            (1.0 + aligned) * reference.half_u,
            (1.0 + aligned) * reference.half_v};
}

/// Copies what lane l of these found, in the boxes' own frames.
void take_lane(const FaceClip& clip, const FacePair& faces, const Slots& slots, Window lanes, int l) {
    const int pair = lanes.first + l;
    const auto incident_axis = static_cast<int>(faces.incident_axis[l]);
    const double side = faces.side[l];
    const PlacedBoxRow& reference = clip.boxes[clip.reference[pair]];
    const PlacedBoxRow& incident = clip.boxes[clip.incident[pair]];
    const auto axis = static_cast<int>(clip.axis.x[pair]);
    FaceCorners& out = *clip.corners[pair];
    out.incident_face = 2 * incident_axis + (side > 0.0 ? 0 : 1);
    out.count = 0;
    // More than the most are the same point again, by rounding.
    for (unsigned slot = 0; slot < slot_count && out.count < most_face_corners; ++slot) {
        if ((slots.there[slot] >> l & 1u) == 0) {
            continue;
        }
        FaceCorner& corner = out.corners[out.count++];
        corner.on_reference[axis] = clip.outward.x[pair] * reference.half[axis];
        corner.on_reference[(axis + 1) % 3] = slots.x[slot][l];
        corner.on_reference[(axis + 2) % 3] = slots.y[slot][l];
        corner.on_incident[incident_axis] = side * incident.half[incident_axis];
        corner.on_incident[(incident_axis + 1) % 3] = slots.s[slot][l] * incident.half[(incident_axis + 1) % 3];
        corner.on_incident[(incident_axis + 2) % 3] = slots.t[slot][l] * incident.half[(incident_axis + 2) % 3];
        corner.gap = slots.gap[slot][l];
        corner.id = side_count * slot + static_cast<unsigned>(slots.side[slot][l]);
    }
}

} // namespace

void KERNEL(const FaceClip& clip) {
    for (Window lanes; lanes.first < clip.count; lanes.first += width) {
        const FacePair pair = face_pair(clip, lanes);
        Slots slots;
        pair.find_corners(slots);
        for (int l = 0; l < width && lanes.first + l < clip.count; ++l) {
            take_lane(clip, pair, slots, lanes, l);
        }
    }
}

} // namespace sim
