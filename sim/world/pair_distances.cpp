#include "sim/world/pair_distances.h"

#include "sim/base/grow.h"
#include "sim/collide/box_box.h"
#include "sim/collide/narrow_phase.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

namespace sim {
namespace {

/// The same as no pose.
const Pose nowhere{Vec3::Constant(std::numeric_limits<double>::quiet_NaN()), Quat::Identity()};

bool is_same(const Pose& a, const Pose& b) {
    return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

} // namespace

PairDistances::PairDistances(const Bodies& bodies, std::size_t count, Workers& workers)
    : bodies_(bodies), workers_(workers), box_rows_(count), looked_at_(count, nowhere), moved_(count) {
    for (std::size_t i = 0; i < count; ++i) {
        is_box_.push_back(std::holds_alternative<Box>(bodies.props[i].shape));
    }
}

/// Where the bodies of the candidates that are boxes stand, at `poses`; is_moved(i): has body i moved since
/// its pairs were looked at?
template <typename F>
void PairDistances::place(const Candidates& candidates, std::span<const Pose> poses, F&& is_moved) {
    grow(axes_, candidates.slot_count(true));
    grow(separations_, candidates.slot_count(false));
    const std::span<const std::size_t> members = candidates.bodies();
    const auto place_some = [&](std::size_t first, std::size_t last) {
        for (const std::size_t i : members.subspan(first, last - first)) {
            moved_[i] = is_moved(i);
            if (moved_[i] == 0) {
                continue;
            }
            looked_at_[i] = poses[i];
            if (is_box_[i] != 0) {
                box_rows_[i] = box_row(std::get<Box>(bodies_.props[i].shape), poses[i]);
            }
        }
    };
    workers_.run(members.size(), place_some, least_shared);
}

bool PairDistances::has_moved(const Candidate& candidate) const {
    const auto [a, b] = candidate.bodies;
    return candidate.is_new || moved_[static_cast<std::size_t>(a)] != 0 ||
           moved_[static_cast<std::size_t>(b)] != 0;
}

/// Separating axes of the pairs of boxes among these candidates that have moved.
void PairDistances::update_axes(std::span<const Candidate> candidates) {
    AxesSearch search{.boxes = box_rows_.data()};
    const auto find_these = [&] {
        find_axes(search);
        search.count = 0;
    };
    for (const Candidate& candidate : candidates) {
        if (candidate.are_boxes && has_moved(candidate)) {
            search.a[search.count] = candidate.bodies.a;
            search.b[search.count] = candidate.bodies.b;
            search.axes[search.count++] = &axes_[candidate.slot];
        }
        if (search.count == lane_count) {
            find_these();
        }
    }
    if (search.count > 0) {
        find_these();
    }
}

/// A lower bound of the distance of two bodies, no boxes, at these poses [m]: what the last look found, less what they have moved
/// since; where that is no more than `enough`, along the features that were nearest then.
double PairDistances::least_separation(const Candidate& candidate, std::span<const Pose> poses, double enough) {
    Separation& found = separations_[candidate.slot];
    if (candidate.is_new) {
        found = Separation{};
    }
    const auto a = static_cast<std::size_t>(candidate.bodies.a);
    const auto b = static_cast<std::size_t>(candidate.bodies.b);
    const double left = found.distance - moved_by(bodies_.props[a], found.a, poses[a], Vec3::Zero()) -
                        moved_by(bodies_.props[b], found.b, poses[b], Vec3::Zero());
    if (left > enough || std::isinf(left) || (is_same(found.a, poses[a]) && is_same(found.b, poses[b]))) {
        return left;
    }
    const std::optional<double> apart =
        separation_along({bodies_.props[a].shape, poses[a]}, {bodies_.props[b].shape, poses[b]}, found.nearest);
    if (!apart) {
        return left;
    }
    found.distance = *apart;
    found.a = poses[a];
    found.b = poses[b];
    found.is_exact = false;
    return *apart;
}

/// Looks at a pair, no boxes, at these poses, unless it was looked at there last.
void PairDistances::look(const Candidate& candidate, std::span<const Pose> poses) {
    const auto a = static_cast<std::size_t>(candidate.bodies.a);
    const auto b = static_cast<std::size_t>(candidate.bodies.b);
    Separation& found = separations_[candidate.slot];
    if (!found.is_exact || !is_same(found.a, poses[a]) || !is_same(found.b, poses[b])) {
        found = Separation{};
        found.a = poses[a];
        found.b = poses[b];
        found.is_exact = true;
        found.distance = separation({bodies_.props[a].shape, poses[a]}, {bodies_.props[b].shape, poses[b]}, &found.nearest);
    }
    found.penetration = -found.distance;
}

/// Of a pair at the present poses: within the step?
bool PairDistances::may_touch(const Candidates& candidates, const Candidate& candidate) {
    const BodyPair& pair = candidate.bodies;
    const double farthest = candidates.farthest(pair);
    const double apart = candidate.are_boxes ? axes_[candidate.slot].separation()
                                             : least_separation(candidate, bodies_.pose, farthest);
    // Most are farther than they can get, which is told without their velocities.
    return !(apart > farthest) && !(apart > candidates.margin_of(pair));
}

std::span<const std::uint32_t> PairDistances::find_near(Candidates& candidates) {
    place(candidates, bodies_.pose,
          [&](std::size_t i) { return is_box_[i] != 0 && !is_same(looked_at_[i], bodies_.pose[i]); });
    const std::span<Candidate> all = candidates.all();
    const auto find = [&](std::size_t first, std::size_t last) {
        update_axes(all.subspan(first, last - first));
        for (std::size_t k = first; k < last; ++k) {
            all[k].is_near = may_touch(candidates, all[k]);
            all[k].is_new = false;
        }
    };
    workers_.run(all.size(), find, least_shared);
    grow(near_, all.size());
    std::size_t count = 0;
    for (std::size_t k = 0; k < all.size(); ++k) {
        near_[count] = static_cast<std::uint32_t>(k);
        count += all[k].is_near ? 1 : 0;
    }
    near_.resize(count);
    return near_;
}

void PairDistances::clip(std::span<const Candidate* const> near, std::span<FaceCorners> corners) const {
    FaceClip clip{.boxes = box_rows_.data()};
    for (std::size_t i = 0; i < near.size(); ++i) {
        if (near[i]->are_boxes) {
            add_to(clip, near[i]->bodies.a, near[i]->bodies.b, axes_[near[i]->slot], corners[i]);
        }
    }
    if (clip.count > 0) {
        clip_faces(clip);
    }
}

void PairDistances::find_box_contacts(const Candidate& candidate, const FaceCorners& corners, double margin,
                                      std::vector<FoundContact>& contacts) const {
    const auto placed = [&](int body) {
        const auto i = static_cast<std::size_t>(body);
        return PlacedBox{box_rows_[i], bodies_.pose[i], Pose{}};
    };
    const auto [a, b] = candidate.bodies;
    box_box_contacts(placed(a), placed(b), axes_[candidate.slot], corners, {margin, 0, contacts});
}

void PairDistances::set_found(const Candidate& candidate, std::span<const FoundContact> contacts) {
    if (contacts.empty()) {
        look(candidate, bodies_.pose);
        return;
    }
    const FoundContact* lowest = &contacts.front(); // the last of those: crossing edges tell more than what lies on a face beside them
    for (const FoundContact& contact : contacts) {
        lowest = contact.at.gap <= lowest->at.gap ? &contact : lowest;
    }
    separations_[candidate.slot].nearest = lowest->feature;
}

void PairDistances::check(Candidates& candidates, std::span<const Pose> planned, double enough, bool is_first) {
    place(candidates, planned, [&](std::size_t i) {
        return is_first || !is_same(looked_at_[i], planned[i]);
    });
    const std::span<Candidate> all = candidates.all();
    const auto check_some = [&](std::size_t first, std::size_t last) {
        update_axes(all.subspan(first, last - first));
        for (Candidate& candidate : all.subspan(first, last - first)) {
            if (!candidate.are_boxes && has_moved(candidate)) {
                separations_[candidate.slot].penetration = -least_separation(candidate, planned, 0.0);
                penetration(candidate, planned, enough);
            }
            candidate.is_new = false;
        }
    };
    workers_.run(all.size(), check_some, least_shared);
}

double PairDistances::penetration(const Candidate& candidate, std::span<const Pose> planned, double enough) {
    if (candidate.are_boxes) {
        return -axes_[candidate.slot].separation();
    }
    if (!(separations_[candidate.slot].penetration <= enough)) { // of a turning plane nothing is known without a look
        look(candidate, planned);
    }
    return separations_[candidate.slot].penetration;
}

} // namespace sim
