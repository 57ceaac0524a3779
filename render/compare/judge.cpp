#include "render/compare/judge.h"

#include "render/compare/displacement.h"
#include "render/compare/edge_noise.h"
#include "render/compare/edge_shift.h"
#include "render/compare/stray.h"
#include "render/compare/texts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace diff {

namespace {

constexpr int cluster_excess = 8; ///< [levels] beyond an edge's noise, by which a pixel tells what a cluster is
/// Sharpness that a pixel has at least [levels^2], so that a dot in an empty picture does not make it sharp.
constexpr double grain_square = 4.0;

/// Clusters are pixels whose smooth difference is above this.
constexpr int cluster_levels = 8;
/// A shift counts if it explains enough of a cluster of at least so many pixels. What is large may have reflections that do
/// not move with it.
constexpr std::int64_t least_cluster_pixels = 30;
constexpr double least_explained_of_large = 0.4;
constexpr std::int64_t large_cluster_pixels = 100;
/// Of lossy pairs, where encoders' noise makes clusters that some shift explains half: so much of a large one.
constexpr double least_explained_of_lossy = 0.88;
/// Where something has moved far, edges differ more than their limit: beyond so many times it [-], a shift of a pair that
/// holds all other gates is chance, where a pattern repeats.
constexpr double most_unseen = 1.8;

bool is_explained(const Area& area, const Displacement& u, bool is_lossy) {
    if (is_lossy) {
        return area.pixels >= large_cluster_pixels && u.explained >= least_explained_of_lossy;
    }
    return area.pixels >= least_cluster_pixels &&
           u.explained >= (area.pixels >= large_cluster_pixels ? least_explained_of_large : least_explained);
}
/// Clusters larger than this [px] are fitted in parts too: one thing may have moved among noise.
constexpr int part_side = 48;
/// Fits of one picture at most. One takes 0.1 to 0.4 ms.
constexpr std::size_t most_fits = 32;
constexpr std::size_t most_fits_if_changed = 8;
constexpr std::size_t most_clusters = 16;
/// A cluster is noise that has no more pixels beyond an edge's.
constexpr int most_noise_pixels = 12;

/// Limits grow with the usual shift of all edges beyond this [px] ...
constexpr double usual_noise = 0.22;
/// ... up to so many times [-].
constexpr double most_room = 2.0;

/// Gates of one pair in the making.
class Findings {
public:
    Findings(const Picture& reference, const Picture& candidate, const DifferenceMap& map, const Limits& limits)
        : reference_(reference), candidate_(candidate), map_(map), limits_(limits), shift_(find_edge_shift(map)),
          room_(std::clamp(map.whole_shift.value_or(shift_.usual) / usual_noise, 1.0, most_room)),
          edges_(map, map.whole_raw) {}

    std::vector<Gate> gates;
    std::vector<Cluster> clusters;

    void find() {
        add(GateId::edge_shift, shift_.pixels, "px",
            fmt::format("the {0}x{0} pixels at ({1}, {2}) differ as if their edges were moved by {3:.2f} px", shift_window,
                        shift_.x, shift_.y, shift_.pixels));
        add(GateId::drift, std::abs(map_.drift.mean) * map_.drift.one_sided, "levels",
            fmt::format("pixels differ by {:+.2f} levels on average, {:.0f} % of them one way", map_.drift.mean,
                        50.0 + 50.0 * map_.drift.one_sided));
        add(GateId::block_drift, std::abs(map_.drift.block), "levels",
            fmt::format("those of the {0}x{0} pixels at ({1}, {2}) by {3:+.2f}", drift_block, map_.drift.x,
                        map_.drift.y, map_.drift.block));
        add_lone();
        add_stray();
        add_sharpness();
        add_texts();
        add(GateId::levels, map_.largest, "levels",
            fmt::format("{} pixels differ by up to {} levels", map_.differing, map_.largest));
        add_displacement();
    }

    bool is_exceeded() const {
        return std::any_of(gates.begin(), gates.end(), [](const Gate& gate) { return gate.is_exceeded; });
    }

private:
    void add(GateId id, double value, const char* unit, std::string reason) {
        Limit limit = limits_[id];
        if (limit.value == not_asked) {
            return;
        }
        limit.value *= limit.grows ? room_ : 1.0;
        gates.push_back({name_of(id), value, limit.value, unit, std::move(reason), limit.source, value > limit.value});
    }

    void add_lone() {
        const LonePeak peak = edges_.lone_peak();
        add(GateId::lone, peak.value, "px",
            fmt::format("{} pixels of the {}x{} at ({}, {}) differ, and {:.1f} % of the edges elsewhere", peak.pixels,
                        lone_size, lone_size, peak.x, peak.y, 100.0 * peak.elsewhere));
    }

    void add_stray() {
        const int most = 100 * static_cast<int>(std::clamp(limits_[GateId::stray].value, 1.0, 1e4));
        const Peak found = count_strays(reference_, candidate_, map_.raw, most);
        add(GateId::stray, found.value, "px",
            fmt::format("{} pixels differ where no edge is near, the first at ({}, {})", found.value, found.x, found.y));
    }

    void add_sharpness() {
        const double grain = grain_square * map_.width * map_.height / square_rows;
        double steps[2] = {};
        for (const SquareCell& cell : map_.squares) {
            steps[0] += cell.steps[0];
            steps[1] += cell.steps[1];
        }
        const auto [less, more] = std::minmax(steps[0], steps[1]);
        add(GateId::sharpness, 100.0 * (1.0 - (less + grain) / (more + grain)), "%",
            steps[1] < steps[0] ? "the candidate is less sharp" : "the candidate is sharper");
    }

    void add_texts() {
        if (reference_.texts.empty() || candidate_.texts.empty()) {
            return;
        }
        const TextDifference found = compare_texts(reference_.texts, candidate_.texts);
        add(GateId::text, found.lines, "lines", found.reason);
    }

    /// Clusters, and the farthest shift that explains one of them, or one of its parts.
    void add_displacement() {
        std::vector<Area> areas = find_areas(map_, cluster_levels);
        const int reach = is_exceeded() ? search_reach : 0;
        const double most = is_exceeded() ? not_asked : most_unseen * gates.front().limit;
        std::size_t fits_left = is_exceeded() ? most_fits_if_changed : most_fits;
        Displacement farthest;
        Box place;
        const auto fit = [&](const Area& area) {
            --fits_left;
            const Displacement forth = fit_displacement(map_, area, reach);
            const Displacement back = fit_backwards(map_, area, reach);
            for (const Displacement& u : {forth, back}) {
                const double length = std::hypot(u.x, u.y);
                if (is_explained(area, u, limits_.is_lossy) && length <= most && length > std::hypot(farthest.x, farthest.y)) {
                    farthest = u;
                    place = area.box;
                }
            }
            return forth.explained >= back.explained ? forth : back;
        };
        std::vector<Area> parts;
        for (const Area& area : areas) {
            const bool is_fitted = fits_left > 0 && area.pixels >= least_cluster_pixels;
            if (!is_fitted && clusters.size() >= most_clusters) {
                break;
            }
            const Displacement u = is_fitted ? fit(area) : Displacement{};
            if (clusters.size() < most_clusters) {
                clusters.push_back({area.box, area.pixels, area.largest, kind_of(area, u), u, {}});
            }
            if (area.box.width > part_side || area.box.height > part_side) {
                std::vector<Area> split = split_area(area, map_, cluster_levels, part_side);
                std::move(split.begin(), split.end(), std::back_inserter(parts));
            }
        }
        std::stable_sort(parts.begin(), parts.end(), [](const Area& a, const Area& b) { return a.pixels > b.pixels; });
        for (const Area& part : parts) {
            if (fits_left == 0 || part.pixels < least_cluster_pixels) {
                break;
            }
            fit(part);
        }
        add(GateId::displacement, std::hypot(farthest.x, farthest.y), "px",
            farthest.explained == 0.0
                ? std::string("no shift explains a cluster of differing pixels")
                : fmt::format("the shift ({:+.2f}, {:+.2f}) explains {:.0f} % of the {}x{} pixels at ({}, {})", farthest.x,
                              farthest.y, 100.0 * farthest.explained, place.width, place.height, place.x, place.y));
    }

    ClusterKind kind_of(const Area& area, const Displacement& u) const {
        if (is_explained(area, u, limits_.is_lossy) && std::hypot(u.x, u.y) > limits_[GateId::displacement].value) {
            return ClusterKind::moved;
        }
        if (excess_pixels(area) <= most_noise_pixels) {
            return ClusterKind::noise;
        }
        return has_same_edges(area) ? ClusterKind::recoloured : ClusterKind::replaced;
    }

    /// Calls use(x, y) for all pixels of the area's cells.
    template <typename Use>
    void visit(const Area& area, Use use) const {
        const int columns = cell_count(map_.width);
        for (const std::int32_t cell : area.cells) {
            const int left = cell % columns * cell_size;
            const int top = cell / columns * cell_size;
            for (int y = top; y < std::min(top + cell_size, map_.height); ++y) {
                for (int x = left; x < std::min(left + cell_size, map_.width); ++x) {
                    use(x, y);
                }
            }
        }
    }

    double excess_pixels(const Area& area) const {
        int count = 0;
        visit(area, [&](int x, int y) { count += map_.excess[pixel(x, y)] > cluster_excess; });
        return count;
    }

    /// True if the slopes of both pictures go together: the same shapes in other colours.
    bool has_same_edges(const Area& area) const {
        double aa = 0.0, bb = 0.0, ab = 0.0;
        visit(area, [&](int x, int y) {
            if (x + 1 >= map_.width || y + 1 >= map_.height) {
                return;
            }
            for (const std::size_t next : {pixel(x + 1, y), pixel(x, y + 1)}) {
                const double a = brightness(map_.reference, next) - brightness(map_.reference, pixel(x, y));
                const double b = brightness(map_.candidate, next) - brightness(map_.candidate, pixel(x, y));
                aa += a * a;
                bb += b * b;
                ab += a * b;
            }
        });
        constexpr double least_correlation = 0.5;
        return aa > 0.0 && bb > 0.0 && ab > least_correlation * std::sqrt(aa * bb);
    }

    static double brightness(const Picture& picture, std::size_t pixel) {
        const std::uint8_t* rgb = &picture.rgb[pixel * 3];
        return rgb[0] + rgb[1] + rgb[2];
    }

    std::size_t pixel(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(map_.width) + static_cast<std::size_t>(x);
    }

    const Picture& reference_;
    const Picture& candidate_;
    const DifferenceMap& map_;
    const Limits& limits_;
    EdgeShift shift_;
    double room_; ///< [-] that the noise of all edges needs
    EdgeNoise edges_;
};

void judge_colors(const Picture& reference, const Picture& candidate, const Limits& limits, DifferenceMap& map,
                  Frame& frame) {
    measure(reference, candidate, map);
    Findings findings(reference, candidate, map, limits);
    findings.find();
    frame.tier = findings.is_exceeded() ? Tier::changed : Tier::noise;
    frame.differing_pixels = map.differing;
    frame.largest_difference = map.largest;
    frame.mean_difference = map.mean;
    frame.gates = std::move(findings.gates);
    frame.clusters = std::move(findings.clusters);
    frame.curve = 0.0;
    const Gate* worst = nullptr;
    std::int64_t exceeded = 0;
    for (const Gate& gate : frame.gates) {
        const double share = gate.limit > 0.0 ? gate.value / gate.limit : gate.value > 0.0 ? 1.0 + gate.value : 0.0;
        exceeded += gate.is_exceeded;
        if (worst == nullptr || share > frame.curve) {
            worst = &gate;
            frame.curve = share;
        }
    }
    const auto is_text = [](const Gate& gate) { return gate.is_exceeded && gate.name == name_of(GateId::text); };
    if (const auto text = std::find_if(frame.gates.begin(), frame.gates.end(), is_text); text != frame.gates.end()) {
        worst = &*text; // says most
    }
    if (exceeded == 0) {
        frame.message = fmt::format("{} pixels differ by up to {} levels, all within the noise of edges and rounding",
                                    map.differing, map.largest);
        return;
    }
    // All gates are in the details. What a text says needs no number.
    const std::string numbers =
        worst->name == name_of(GateId::text)
            ? std::string()
            : fmt::format("{} {:.4g} {} (limit {:.4g}): ", worst->name, worst->value, worst->unit, worst->limit);
    frame.message = numbers + worst->reason + (exceeded > 1 ? fmt::format("; {} gates more above the limit", exceeded - 1) : "");
}

/// The picture as seen on white.
Picture on_white(const Picture& picture) {
    Picture white = picture;
    for (std::size_t i = 0; i < picture.alpha.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            white.rgb[3 * i + c] = static_cast<std::uint8_t>(picture.rgb[3 * i + c] + 255 - picture.alpha[i]);
        }
    }
    return white;
}

} // namespace

const char* name_of(GateId id) {
    constexpr const char* names[] = {"edge shift", "displacement", "drift", "block drift", "lone",
                                     "stray",       "sharpness", "text",        "levels"};
    return names[static_cast<int>(id)];
}

Limits lossy_limits(const Limits& limits, bool is_jpeg) {
    Limits lossy = limits;
    lossy.is_lossy = true;
    const auto set = [&lossy](GateId id, double value, bool grows) {
        Limit& limit = lossy.of[static_cast<std::size_t>(id)];
        if (limit.source == Limit().source || value == not_asked) {
            limit.value = value;
            limit.grows = grows;
        }
    };
    set(GateId::lone, not_asked, false);
    set(GateId::stray, not_asked, false);
    set(GateId::displacement, limits[GateId::edge_shift].value, false);
    set(GateId::edge_shift, 0.95, true); // an encoder moves edges between plain faces by more than samples do
    set(GateId::block_drift, is_jpeg ? 3.2 : 3.6, true);
    set(GateId::sharpness, 16.0, true);
    // JPEG has plain colours up to two levels off, all of a picture the same way.
    set(GateId::drift, is_jpeg ? 2.2 : 0.45, !is_jpeg);
    return lossy;
}

void judge(const Picture& reference, const Picture& candidate, const Limits& limits, DifferenceMap& map,
           Frame& frame) {
    if (is_equal(reference, candidate)) {
        frame.tier = Tier::identical;
        frame.message = "the same pixels";
        return;
    }
    if (!reference.alpha.empty() || !candidate.alpha.empty()) {
        Frame white = frame;
        judge_colors(on_white(reference), on_white(candidate), limits, map, white);
        judge_colors(reference, candidate, limits, map, frame);
        if (white.curve > frame.curve) {
            white.message += " (on white)";
            frame = std::move(white);
        }
        return;
    }
    judge_colors(reference, candidate, limits, map, frame);
}

} // namespace diff
