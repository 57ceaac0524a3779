#include "render/compare/pair.h"

#include "render/compare/bodies.h"
#include "render/compare/edge_shift.h"
#include "render/compare/rows.h"
#include "sim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace diff {

namespace {

/// Palette of a difference picture: four ramps of 64 colours.
constexpr int ramp = 64;
constexpr int first_noise = ramp;
constexpr int first_counted = 2 * ramp;
constexpr int only_one = 3 * ramp;

/// Excess [levels] from which on a pixel is shown as more than an edge's noise.
constexpr int counted_levels = 8;

Bytes make_palette() {
    Bytes palette(256 * 3);
    const auto set = [&palette](int index, int r, int g, int b) {
        palette[static_cast<std::size_t>(index) * 3] = static_cast<std::uint8_t>(r);
        palette[static_cast<std::size_t>(index) * 3 + 1] = static_cast<std::uint8_t>(g);
        palette[static_cast<std::size_t>(index) * 3 + 2] = static_cast<std::uint8_t>(b);
    };
    for (int i = 0; i < ramp; ++i) {
        set(i, 176 + i, 176 + i, 176 + i);
        set(first_noise + i, 150 - 2 * i, 180 - i, 255);
        set(first_counted + i, 255 - i, 150 - 2 * i, 0);
        set(only_one + i, 110 + 2 * i, 60 + 2 * i, 150 + i);
    }
    return palette;
}

/// Pictures of two sizes: what both have in grey, what only one has in violet.
void show_areas(const Picture& a, const Picture& b, IndexedPicture& out) {
    for (int y = 0; y < out.height; ++y) {
        for (int x = 0; x < out.width; ++x) {
            const bool is_in_a = x < a.width && y < a.height;
            const bool is_in_b = x < b.width && y < b.height;
            const Picture& shown = is_in_b ? b : a;
            if (is_in_a || is_in_b) {
                std::uint8_t grey = 0;
                quarter_grey(row_of(shown, y) + 3 * x, 1, &grey);
                out.indices[static_cast<std::size_t>(y) * static_cast<std::size_t>(out.width) +
                            static_cast<std::size_t>(x)] =
                    static_cast<std::uint8_t>(grey + (is_in_a && is_in_b ? 0 : only_one));
            }
        }
    }
}

/// Reads and decodes one side. False, with status and message, if it cannot be.
bool read_side(const std::optional<std::filesystem::path>& path, const PictureLimits& accepted, Bytes& bytes,
               Frame& frame) {
    if (!path) {
        return false;
    }
    try {
        read_file(*path, accepted, bytes);
        return true;
    } catch (const sim::Error& error) {
        frame.status = Status::unreadable;
        frame.message = error.what();
        return false;
    }
}

/// A file that was read, and what it shows.
struct Side {
    const Bytes& bytes;
    const std::filesystem::path& path;
    Picture& picture;
};

bool decode_side(const Side& side, const PictureLimits& accepted, ReaderMemory& memory, Frame& frame) {
    try {
        decode_picture(side.bytes, side.path.string(), accepted, side.picture, memory);
        return true;
    } catch (const sim::Error& error) {
        frame.status = Status::unreadable;
        frame.message = error.what();
        return false;
    }
}

/// The images beside both pictures, if both are there and of the pictures' size.
std::optional<std::pair<BodyImage, BodyImage>>
read_bodies(const PairPaths& paths, const PairSettings& settings, const PairMemory& memory) {
    std::optional<BodyImage> a = read_body_image(*paths.reference, settings.accepted);
    std::optional<BodyImage> b = a ? read_body_image(*paths.candidate, settings.accepted) : std::nullopt;
    const auto fits = [&memory](const BodyImage& image) {
        return image.width == memory.a.width && image.height == memory.a.height;
    };
    if (!a || !b || !fits(*a) || !fits(*b)) {
        return std::nullopt;
    }
    return std::pair(std::move(*a), std::move(*b));
}

/// What texts, and the panels around them, cover shows no body.
void hide_bodies(const std::vector<TextLine>& texts, BodyImage& image) {
    for (const TextLine& line : texts) {
        const int panel = line.height; // beyond the text
        const int left = std::clamp(line.x - panel, 0, image.width);
        const int right = std::clamp(line.x + line.width + panel, left, image.width);
        const int bottom = std::min(line.y + line.height + panel, image.height);
        for (int y = std::max(line.y - panel, 0); y < bottom; ++y) {
            const auto row = image.ids.begin() + static_cast<std::ptrdiff_t>(y) * image.width;
            std::fill(row + left, row + right, 0u);
        }
    }
}

/// settings.mask, and the bodies to be ignored. Throws Error (usage) if they are not known.
Mask mask_of(const PairPaths& paths, const PairSettings& settings, const PairMemory& memory) {
    Mask mask = settings.mask;
    if (settings.ignored_bodies.empty()) {
        return mask;
    }
    const auto bodies = read_bodies(paths, settings, memory);
    if (!bodies) {
        throw sim::Error(
            sim::ExitCode::usage,
            fmt::format("--ignore-body: {} and {} have no images of bodies beside them; see --body-ids",
                        paths.reference->string(), paths.candidate->string()));
    }
    for (const std::string& name : settings.ignored_bodies) {
        const auto has = [&name](const BodyImage& image) {
            return std::find(image.names.begin(), image.names.end(), name) != image.names.end();
        };
        if (!has(bodies->first) && !has(bodies->second)) {
            throw sim::Error(sim::ExitCode::usage,
                             fmt::format("--ignore-body '{}': {} has no body of that name", name,
                                         paths.reference->string()));
        }
    }
    Picture pixels;
    pixels.width = memory.a.width;
    pixels.height = memory.a.height;
    pixels.rgb.assign(memory.a.rgb.size(), 0);
    mask_bodies(bodies->first, settings.ignored_bodies, pixels);
    mask_bodies(bodies->second, settings.ignored_bodies, pixels);
    mask.pictures.push_back(std::move(pixels));
    return mask;
}

/// "cube_412 moved by (+1.0, +0.0) px, 2.4 mm"
std::string text_of(const BodyChange& change) {
    const Displacement& u = change.displacement;
    const std::string turned = change.angle && *change.angle >= 0.05 ? fmt::format("turned by {:.3g} degrees", *change.angle) : "";
    switch (change.kind) {
    case BodyChange::Kind::moved: {
        std::string how = u.x != 0.0 || u.y != 0.0 ? fmt::format(" by ({:+.1f}, {:+.1f}) px", u.x, u.y) : "";
        if (change.distance) {
            how += fmt::format("{} {:.3g} mm", how.empty() ? " by" : ",", 1e3 * *change.distance);
        }
        return change.name + " moved" + how + (turned.empty() ? "" : ", " + turned);
    }
    case BodyChange::Kind::turned:
        return change.name + " " + (turned.empty() ? "turned" : turned);
    case BodyChange::Kind::missing:
        return change.name + " is missing";
    case BodyChange::Kind::appeared:
        return change.name + " has appeared";
    case BodyChange::Kind::recoloured:
        return change.name + " has other colours";
    }
    return {};
}

void add_bodies(const PairPaths& paths, const PairSettings& settings, const PairMemory& memory,
                Frame& frame) {
    constexpr std::size_t most_named = 3;
    auto bodies = read_bodies(paths, settings, memory);
    if (!bodies) {
        return;
    }
    for (const std::vector<TextLine>* texts : {&memory.a.texts, &memory.b.texts}) {
        hide_bodies(*texts, bodies->first);
        hide_bodies(*texts, bodies->second);
    }
    name_bodies(bodies->first, bodies->second, memory.map, frame);
    std::string text = frame.scene_change.empty() ? "" : frame.scene_change + "; ";
    for (std::size_t i = 0; i < std::min(frame.bodies.size(), most_named); ++i) {
        text += text_of(frame.bodies[i]) + "; ";
    }
    if (frame.bodies.size() > most_named) {
        text += fmt::format("and {} more; ", frame.bodies.size() - most_named);
    }
    frame.message = text + frame.message;
}

/// False, with status and message, if the two sizes differ.
bool set_sizes(const PairMemory& memory, Frame& frame) {
    frame.width = memory.a.width;
    frame.height = memory.a.height;
    frame.candidate_width = memory.b.width;
    frame.candidate_height = memory.b.height;
    if (frame.width == frame.candidate_width && frame.height == frame.candidate_height) {
        return true;
    }
    frame.status = Status::size_differs;
    frame.tier = Tier::changed;
    frame.message = fmt::format("the reference has {}x{} pixels, the candidate {}x{}", frame.width,
                                frame.height, frame.candidate_width, frame.candidate_height);
    return false;
}

void clear(Picture& picture) {
    picture.width = picture.height = 0;
}

void judge_or_measure(const PairSettings& settings, PairMemory& memory, Frame& frame) {
    if (settings.judges) {
        const Limits limits = settings.is_lossy ? lossy_limits(settings.limits, settings.is_jpeg) : settings.limits;
        judge(memory.a, memory.b, limits, memory.map, frame);
        return;
    }
    measure_excess(memory.a, memory.b, memory.map);
    frame.tier = memory.map.largest == 0 ? Tier::identical : Tier::changed;
}

bool is_jpeg(const Bytes& bytes) {
    return bytes.size() > 2 && bytes[0] == 0xff && bytes[1] == 0xd8;
}

void mask_pair(const Mask& mask, PairMemory& memory) {
    clear(memory.unmasked);
    forget_hidden(memory.map);
    if (!mask.is_empty()) {
        memory.unmasked = memory.b;
        apply_mask(mask, memory.a, memory.b);
        measure_hidden(memory.a, memory.unmasked, memory.b, memory.map);
        measure(memory.a, memory.unmasked, memory.map);
        memory.map.whole_shift = find_edge_shift(memory.map).usual;
    }
}

} // namespace

void compare_pictures(const PairSettings& settings, PairMemory& memory, Frame& frame) {
    if (set_sizes(memory, frame)) {
        mask_pair(settings.mask, memory);
        judge_or_measure(settings, memory, frame);
    }
}

void compare_files(const PairPaths& paths, const PairSettings& settings, PairMemory& memory, Frame& frame) {
    frame.tier = Tier::changed;
    clear(memory.a);
    clear(memory.b);
    memory.thumbnail_a.reset();
    memory.thumbnail_b.reset();
    const bool has_a = read_side(paths.reference, settings.accepted, memory.file_a, frame);
    const bool has_b = read_side(paths.candidate, settings.accepted, memory.file_b, frame);
    // What is wrong with masks is told of equal pictures too.
    const bool is_masked = !settings.mask.is_empty() || !settings.ignored_bodies.empty();
    if (has_a && has_b && !is_masked && memory.file_a == memory.file_b) {
        try {
            const auto [width, height] =
                size_of_picture(memory.file_a, paths.reference->string(), settings.accepted);
            frame.width = frame.candidate_width = width;
            frame.height = frame.candidate_height = height;
            frame.tier = Tier::identical;
            frame.message = "the same bytes";
        } catch (const sim::Error& error) {
            frame.status = Status::unreadable;
            frame.message = error.what();
        }
        return;
    }
    const auto decode = [&](const Side& side) { return decode_side(side, settings.accepted, memory.reader, frame); };
    const bool is_whole_a = has_a && decode({memory.file_a, *paths.reference, memory.a});
    const bool is_whole_b = has_b && decode({memory.file_b, *paths.candidate, memory.b});
    if (settings.takes_thumbnails) {
        memory.thumbnail_a = is_whole_a ? std::optional(thumbnail_of(memory.a)) : std::nullopt;
        memory.thumbnail_b = is_whole_b ? std::optional(thumbnail_of(memory.b)) : std::nullopt;
    }
    if (is_whole_a && is_whole_b) {
        if (!set_sizes(memory, frame)) {
            return;
        }
        PairSettings judging = settings;
        judging.is_jpeg = settings.is_jpeg || is_jpeg(memory.file_a) || is_jpeg(memory.file_b);
        judging.is_lossy = settings.is_lossy || judging.is_jpeg;
        mask_pair(mask_of(paths, settings, memory), memory);
        judge_or_measure(judging, memory, frame);
        if (settings.judges && frame.tier == Tier::changed) {
            add_bodies(paths, settings, memory, frame);
        }
        return;
    }
    if (is_whole_a) {
        frame.width = memory.a.width;
        frame.height = memory.a.height;
    }
    if (is_whole_b) {
        frame.candidate_width = memory.b.width;
        frame.candidate_height = memory.b.height;
    }
    if (frame.status == Status::compared) {
        frame.status = paths.reference ? Status::candidate_missing : Status::reference_missing;
        frame.message = paths.reference ? "the reference has this picture, the candidate has not"
                                        : "the candidate has this picture, the reference has not";
    }
}

IndexedPicture difference_picture(const PairMemory& memory) {
    IndexedPicture picture;
    picture.palette = make_palette();
    const Picture& a = memory.a;
    const Picture& b = memory.b;
    picture.width = std::max(a.width, b.width);
    picture.height = std::max(a.height, b.height);
    picture.indices.resize(static_cast<std::size_t>(picture.width) *
                           static_cast<std::size_t>(picture.height));
    if (a.width != b.width || a.height != b.height) {
        show_areas(a, b, picture);
        return picture;
    }
    quarter_grey(b.rgb.data(), picture.indices.size(), picture.indices.data());
    const auto show = [&](const std::vector<std::uint8_t>& values, int above, int first) {
        replace_above(values.data(), {memory.map.raw.data(), static_cast<std::uint8_t>(above), static_cast<std::uint8_t>(first)},
                      picture.indices.size(), picture.indices.data());
    };
    show(memory.map.raw, rounding_levels, first_noise);
    show(memory.map.excess, counted_levels, first_counted);
    return picture;
}

} // namespace diff
