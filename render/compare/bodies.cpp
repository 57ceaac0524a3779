#include "render/compare/bodies.h"

#include "render/compare/displacement.h"
#include "render/compare/scene_change.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace diff {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_bodies = 16;
constexpr std::size_t most_names = 3;
/// Pixels beyond an edge's noise by this much [levels] are a body's change.
constexpr int changed_levels = 4;
/// A body that covers fewer pixels is not said to be missing: an edge's noise may hide it.
constexpr std::int64_t least_pixels = 4;
constexpr double least_distance = 1e-9; ///< [m] positions are written with all digits; this is rounding
constexpr double least_angle = 1e-6;    ///< [degrees] the same
/// A body of which so much more is seen in one picture [-] has been partly hidden: the middle of the rest tells no shift.
constexpr double most_hidden = 0.1;

/// What one body covers in one image.
struct Cover {
    std::int64_t pixels = 0;
    double x = 0.0; ///< sum [px]
    double y = 0.0;
    int left = 1 << 30, top = 1 << 30, right = -1, bottom = -1;

    void add(int px, int py) {
        ++pixels;
        x += px;
        y += py;
        left = std::min(left, px);
        top = std::min(top, py);
        right = std::max(right, px);
        bottom = std::max(bottom, py);
    }
    Box box() const { return {left, top, right - left + 1, bottom - top + 1}; }
};

struct Body {
    Cover before;
    Cover after;
    std::int64_t changed = 0;        ///< pixels that it covers before or after, beyond an edge's noise
    std::set<std::int32_t> cells;    ///< that it covers before or after
    std::int32_t last_cell = -1;

    void add_cell(std::int32_t cell) {
        if (cell != last_cell) {
            cells.insert(cell);
            last_cell = cell;
        }
    }
};

std::string name_in(const BodyImage& image, std::uint32_t id) {
    return id > 0 && id <= image.names.size() ? image.names[id - 1] : std::string();
}

/// Of position or orientation; none if the image does not have it.
template <std::size_t n>
std::optional<std::array<double, n>> value_in(const std::vector<std::array<double, n>>& values, const BodyImage& image,
                                              const std::string& name) {
    const auto found = std::find(image.names.begin(), image.names.end(), name);
    const auto index = static_cast<std::size_t>(found - image.names.begin());
    return index < values.size() ? std::optional(values[index]) : std::nullopt;
}

/// What both states say of a body.
struct Motion {
    std::optional<double> distance; ///< [m]
    std::optional<double> angle;    ///< [degrees]

    bool is_still() const {
        return distance && *distance <= least_distance && (!angle || *angle <= least_angle);
    }
};

Motion motion_of(const BodyImage& a, const BodyImage& b, const std::string& name) {
    Motion motion;
    const auto x = value_in(a.positions, a, name);
    const auto y = value_in(b.positions, b, name);
    if (x && y) {
        motion.distance = std::hypot((*x)[0] - (*y)[0], (*x)[1] - (*y)[1], (*x)[2] - (*y)[2]);
    }
    const auto p = value_in(a.orientations, a, name);
    const auto q = value_in(b.orientations, b, name);
    if (p && q) {
        // Sine and cosine of half the angle: |p - q| and |p + q|, whichever of q and -q is nearer.
        double sum = 0.0;
        double difference = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
            sum += std::pow((*p)[i] + (*q)[i], 2);
            difference += std::pow((*p)[i] - (*q)[i], 2);
        }
        constexpr double degrees = 180.0 / 3.14159265358979323846;
        motion.angle = 4.0 * degrees * std::atan2(std::sqrt(std::min(sum, difference)), std::sqrt(std::max(sum, difference)));
    }
    return motion;
}

/// All bodies that are seen.
std::map<std::string, Body> find_bodies(const BodyImage& reference, const BodyImage& candidate,
                                        const DifferenceMap& map) {
    std::map<std::string, Body> bodies;
    std::map<std::uint32_t, Body*> of_reference;
    std::map<std::uint32_t, Body*> of_candidate;
    const auto body_of = [&bodies](const BodyImage& image, std::uint32_t id, auto& known) {
        const auto [entry, is_new] = known.try_emplace(id, nullptr);
        if (is_new) {
            const std::string name = name_in(image, id);
            entry->second = name.empty() ? nullptr : &bodies[name];
        }
        return entry->second;
    };
    const int columns = cell_count(map.width);
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                                      static_cast<std::size_t>(x);
            Body* before = body_of(reference, reference.ids[pixel], of_reference);
            Body* after = body_of(candidate, candidate.ids[pixel], of_candidate);
            const bool is_changed = map.excess[pixel] > changed_levels;
            const std::int32_t cell = y / cell_size * columns + x / cell_size;
            if (before != nullptr) {
                before->before.add(x, y);
                before->changed += is_changed;
                before->add_cell(cell);
            }
            if (after != nullptr) {
                after->after.add(x, y);
                after->changed += is_changed && after != before;
                after->add_cell(cell);
            }
        }
    }
    return bodies;
}

/// What happened to a body; none if only what it shows of others changed.
std::optional<BodyChange> change_of(const std::string& name, const Body& body, const Motion& motion, const DifferenceMap& map) {
    BodyChange change;
    change.name = name;
    change.distance = motion.distance;
    change.angle = motion.angle;
    const Cover& shown = body.before.pixels > 0 ? body.before : body.after;
    change.pixels = shown.pixels;
    change.box = shown.box();
    if (body.before.pixels == 0 || body.after.pixels == 0) {
        change.kind = body.before.pixels > 0 ? BodyChange::Kind::missing : BodyChange::Kind::appeared;
        return shown.pixels >= least_pixels ? std::optional(change) : std::nullopt;
    }
    Area area;
    area.cells.assign(body.cells.begin(), body.cells.end());
    change.displacement = fit_displacement(map, area, search_reach);
    const bool is_shift = change.displacement.explained >= least_explained;
    if (!is_shift) {
        const auto n = static_cast<double>(body.before.pixels);
        const auto m = static_cast<double>(body.after.pixels);
        const bool is_hidden = std::abs(n - m) > most_hidden * std::max(n, m);
        change.displacement = is_hidden ? Displacement{}
                                        : Displacement{body.after.x / m - body.before.x / n, body.after.y / m - body.before.y / n, 0.0};
    }
    if (motion.distance ? *motion.distance > least_distance : is_shift) {
        change.kind = BodyChange::Kind::moved;
        return change;
    }
    if (motion.angle && *motion.angle > least_angle) {
        change.kind = BodyChange::Kind::turned;
        return change;
    }
    change.kind = BodyChange::Kind::recoloured;
    // A body whose neighbour changes has changed pixels at its edge only.
    const std::int64_t least_changed = std::max(least_pixels, shown.pixels / 4);
    return body.changed >= least_changed ? std::optional(change) : std::nullopt;
}

/// Bodies that cover most of a cluster's changed pixels.
std::vector<std::string> names_in(const Box& box, const BodyImage& reference, const BodyImage& candidate,
                                  const DifferenceMap& map) {
    std::map<std::string, std::int64_t> counts;
    for (int y = box.y; y < box.y + box.height; ++y) {
        for (int x = box.x; x < box.x + box.width; ++x) {
            const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                                      static_cast<std::size_t>(x);
            if (map.excess[pixel] > changed_levels) {
                ++counts[name_in(reference, reference.ids[pixel])];
                ++counts[name_in(candidate, candidate.ids[pixel])];
            }
        }
    }
    counts.erase("");
    std::vector<std::pair<std::int64_t, std::string>> order;
    for (const auto& [name, count] : counts) {
        order.emplace_back(-count, name);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::string> names;
    for (std::size_t i = 0; i < std::min(order.size(), most_names); ++i) {
        names.push_back(order[i].second);
    }
    return names;
}

} // namespace

std::optional<BodyImage> read_body_image(const fs::path& picture, const PictureLimits& accepted) {
    const fs::path stem = fs::path(picture).replace_extension();
    const fs::path image_path = stem.string() + ".bodies.png";
    const fs::path names_path = stem.string() + ".bodies.json";
    std::error_code error;
    if (!fs::exists(image_path, error) || !fs::exists(names_path, error)) {
        return std::nullopt;
    }
    Bytes bytes;
    read_file(image_path, accepted, bytes);
    Picture numbers;
    ReaderMemory memory;
    decode_picture(bytes, image_path.string(), accepted, numbers, memory);
    BodyImage image;
    image.width = numbers.width;
    image.height = numbers.height;
    for (std::size_t i = 0; i + 2 < numbers.rgb.size(); i += 3) {
        image.ids.push_back(numbers.rgb[i] | std::uint32_t{numbers.rgb[i + 1]} << 8 |
                            std::uint32_t{numbers.rgb[i + 2]} << 16);
    }
    try {
        const nlohmann::json json = nlohmann::json::parse(sim::read_text_file(names_path));
        json.at("names").get_to(image.names);
        json.at("positions").get_to(image.positions);
        image.orientations = json.value("orientations", image.orientations);
        read_scene(json, image);
    } catch (const nlohmann::json::exception&) {
        throw sim::Error(sim::ExitCode::io, "cannot read " + names_path.string() + ": it is damaged");
    }
    return image;
}

void mask_bodies(const BodyImage& image, const std::vector<std::string>& names, Picture& pixels) {
    std::vector<bool> is_left_out(image.names.size() + 1);
    for (std::size_t i = 0; i < image.names.size(); ++i) {
        is_left_out[i + 1] = std::find(names.begin(), names.end(), image.names[i]) != names.end();
    }
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const std::uint32_t id = image.ids[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                               static_cast<std::size_t>(x)];
            if (id >= is_left_out.size() || !is_left_out[id]) {
                continue;
            }
            for (int row = std::max(y - 1, 0); row <= std::min(y + 1, image.height - 1); ++row) {
                for (int column = std::max(x - 1, 0); column <= std::min(x + 1, image.width - 1); ++column) {
                    const std::size_t pixel = static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                                              static_cast<std::size_t>(column);
                    std::fill_n(&pixels.rgb[pixel * 3], 3, std::uint8_t{255});
                }
            }
        }
    }
}

void name_bodies(const BodyImage& reference, const BodyImage& candidate, const DifferenceMap& map, Frame& frame) {
    for (Cluster& cluster : frame.clusters) {
        cluster.bodies = names_in(cluster.box, reference, candidate, map);
    }
    const std::map<std::string, Body> bodies = find_bodies(reference, candidate, map);
    frame.scene_change = scene_change(reference, candidate);
    std::vector<std::pair<std::int64_t, BodyChange>> order;
    for (const auto& [name, body] : bodies) {
        const Motion motion = motion_of(reference, candidate, name);
        const bool is_said = body.changed == 0 || (!frame.scene_change.empty() && motion.is_still());
        const auto change = is_said ? std::nullopt : change_of(name, body, motion, map);
        if (change) {
            order.emplace_back(body.changed, *change);
        }
    }
    std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (std::size_t i = 0; i < std::min(order.size(), most_bodies); ++i) {
        frame.bodies.push_back(order[i].second);
    }
}

} // namespace diff
