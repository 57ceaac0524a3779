#include "render/picture/edges.h"

#include "render/picture/edge_finder.h"
#include "render/picture/round_part.h"
#include "render/scene/float4.h"
#include "render/scene/mesh.h"
#include "sim/base/error.h"

#include <glm/gtc/matrix_access.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

namespace render {

namespace {

constexpr int sample_count = 8;
/// Places of the samples about the pixel's centre [px]: one in each row and column of 8 x 8.
constexpr std::array<Float4, 2> sample_x{Float4{0.0625f, -0.0625f, 0.3125f, -0.1875f},
                                         Float4{-0.3125f, -0.4375f, 0.1875f, 0.4375f}};
constexpr std::array<Float4, 2> sample_y{Float4{-0.1875f, 0.1875f, 0.0625f, -0.3125f},
                                         Float4{0.3125f, -0.0625f, 0.4375f, -0.4375f}};

/// A face that is as thin on the picture [px] may hold no pixel's centre in some rows: a pixel, and half of
/// one for the far end of a long face.
constexpr float thin_face = 1.5f;

/// A flat part in the picture. At window position p = (x, y, 1) the dot products of p with the three vectors
/// are 1 / w, u / w and v / w: w is the distance along the view, and u, v in -1..1 are inside the face.
struct FlatPart {
    glm::vec3 inverse_w;
    glm::vec3 u;
    glm::vec3 v;
    bool is_bounded;
};

/// What a part number stands for.
struct PartRef {
    enum class Kind { sky, flat, round } kind = Kind::sky;
    std::uint32_t index = 0;
    std::uint32_t thin = 0; ///< of a face whose box has thin ones: index into these, plus 1
};

/// The largest 1 / w at which each sample's ray has met a part, and which one.
struct Samples {
    std::array<Float4, 2> inverse_w{};
    std::array<Int4, 2> winner{};

    /// Takes part k where `is_hit` holds and it lies before all parts so far.
    void meet(std::size_t half, Int4 is_hit, Float4 at_inverse_w, int k) {
        const Int4 is_first = is_hit & (at_inverse_w > inverse_w[half]);
        inverse_w[half] = chosen(is_first, at_inverse_w, inverse_w[half]);
        winner[half] = chosen(is_first, all(k), winner[half]);
    }
};

/// The parts of 3 x 3 pixels and the colours they have there.
struct Candidates {
    int count = 0;
    std::array<std::uint32_t, 9> id;
    std::array<Int4, 9> color; ///< sum over the pixels; the fourth means nothing
    std::array<int, 9> pixels;

    bool contains(std::uint32_t part) const {
        return std::find(id.begin(), id.begin() + count, part) != id.begin() + count;
    }

    void add(std::uint32_t part, Int4 here) {
        int k = 0;
        while (k < count && id[k] != part) {
            ++k;
        }
        if (k == count) {
            id[k] = part;
            color[k] = here;
            pixels[k] = 1;
            ++count;
        } else if (k > 0) { // the part at the pixel's own centre keeps the colour it has there
            color[k] += here;
            ++pixels[k];
        }
    }
};

/// Window homogeneous coordinates (x w, y w, w) of a direction from the eye.
glm::mat3 window_from_direction(const CameraBlock& camera, int width, int height) {
    const glm::vec3 x(glm::row(camera.clip_from_world, 0));
    const glm::vec3 y(glm::row(camera.clip_from_world, 1));
    const glm::vec3 w(glm::row(camera.clip_from_world, 3));
    return glm::transpose(glm::mat3(0.5f * static_cast<float>(width) * (x + w),
                                    0.5f * static_cast<float>(height) * (y + w), w));
}

/// All parts of a picture by number.
class PartTable {
public:
    PartTable(const Viewport& viewport, const SceneGeometry& geometry, const DrawList& list)
        : window_(window_from_direction(list.camera, viewport.width, viewport.height)),
          eye_(list.camera.eye) {
        refs_.push_back({});
        for (const Face& face : list.faces) {
            add_flat(face.center, face.half_u, face.half_v, true);
        }
        note_thin_faces(list.faces);
        for (const std::vector<glm::vec2>& profile : geometry.profiles) {
            bands_.push_back(make_lathe_bands(profile));
        }
        hulls_ = &geometry.hulls;
        rod_bands_ = make_lathe_bands(rod_profile());
        for (const RoundBatch& batch : list.round_batches) {
            for (int i = 0; i < batch.count; ++i) {
                add_round(list.rounds[static_cast<std::size_t>(batch.first + i)], batch.mesh);
            }
        }
        for (const Floor& floor : list.floors) {
            add_flat(floor.frame.origin, floor.frame.tangent, floor.frame.across(), false);
        }
    }

    std::size_t size() const { return refs_.size(); }

    /// Whether of the box that part `id` is a face of the camera sees faces so thin that pixels may miss them.
    bool has_thin_faces(std::uint32_t id) const { return refs_[id].thin != 0; }

    /// Follows these faces as if they were part k, those aside that are found themselves. Seldom called: apart from the rest.
    [[gnu::noinline]] void follow_thin_faces(const Candidates& found, int k, const glm::vec2& pixel, Samples& samples) const {
        for (const std::uint32_t id : thin_faces_[refs_[found.id[k]].thin - 1]) {
            if (id != 0 && !found.contains(id)) {
                follow_flat(flats_[refs_[id].index], k, pixel, samples);
            }
        }
    }

    /// Marks with k the samples of the pixel at (x, y) whose ray meets part `id` before anything else so far.
    void follow(std::uint32_t id, int k, const glm::vec2& pixel, Samples& samples) const {
        const PartRef ref = refs_[id];
        switch (ref.kind) {
        case PartRef::Kind::sky:
            for (std::size_t half = 0; half < 2; ++half) {
                samples.winner[half] =
                    chosen(samples.inverse_w[half] <= all(0.0f), all(k), samples.winner[half]);
            }
            break;
        case PartRef::Kind::flat:
            follow_flat(flats_[ref.index], k, pixel, samples);
            break;
        case PartRef::Kind::round:
            follow_round(rounds_[ref.index], k, pixel, samples);
            break;
        }
    }

private:
    void add_flat(const glm::vec3& center, const glm::vec3& half_u, const glm::vec3& half_v,
                  bool is_bounded) {
        // w p = C + u U + v V in window coordinates, so (1, u, v) / w = [C U V]^-1 p.
        const glm::mat3 inverse =
            glm::inverse(glm::mat3(window_ * (center - eye_), window_ * half_u, window_ * half_v));
        refs_.push_back({PartRef::Kind::flat, static_cast<std::uint32_t>(flats_.size()), 0});
        flats_.push_back({glm::row(inverse, 0), glm::row(inverse, 1), glm::row(inverse, 2), is_bounded});
    }

    void note_thin_faces(const std::vector<Face>& faces) {
        std::vector<std::uint32_t> of_box; // as PartRef::thin
        for (const Face& face : faces) {
            of_box.resize(std::max<std::size_t>(of_box.size(), face.box + 1));
            if (is_thin(face)) {
                if (of_box[face.box] == 0) {
                    thin_faces_.push_back({});
                    of_box[face.box] = static_cast<std::uint32_t>(thin_faces_.size());
                }
                *std::ranges::find(thin_faces_[of_box[face.box] - 1], 0u) = face.id;
            }
        }
        for (const Face& face : faces) {
            refs_[face.id].thin = of_box[face.box];
        }
    }

    bool is_thin(const Face& face) const {
        const auto across = [&](const glm::vec3& half) {
            const glm::vec3 a = window_ * (face.center - half - eye_);
            const glm::vec3 b = window_ * (face.center + half - eye_);
            return a.z > 0.0f && b.z > 0.0f ? glm::vec2(b) / b.z - glm::vec2(a) / a.z : glm::vec2(0.0f);
        };
        const glm::vec2 u = across(face.half_u);
        const glm::vec2 v = across(face.half_v);
        const float longest = std::max(glm::length(u), glm::length(v));
        return longest > 0.0f && std::abs(u.x * v.y - u.y * v.x) < thin_face * longest;
    }

    void add_round(const Instance& instance, int mesh) {
        CHECK(instance.id == refs_.size());
        RoundPart part{};
        part.origin = turned_back(instance.orientation, eye_ - instance.position) / instance.scale;
        const glm::mat3 direction_from_window = glm::inverse(window_);
        for (int i = 0; i < 3; ++i) {
            part.ray_from_window[i] =
                turned_back(instance.orientation, direction_from_window[i]) / instance.scale;
        }
        const auto add = [&](const LatheBand* first, const LatheBand* last) {
            part.first = first;
            part.last = last;
            part.radius = 0.0f;
            for (const LatheBand* band = first; band != last; ++band) {
                part.radius = std::max({part.radius, 1.02f * band->lower.x, 1.02f * band->upper.x});
            }
            refs_.push_back({PartRef::Kind::round, static_cast<std::uint32_t>(rounds_.size()), 0});
            rounds_.push_back(part);
        };
        if (mesh < mesh_id::sphere_first + mesh_id::sphere_count) {
            add(nullptr, nullptr);
            return;
        }
        const auto own = static_cast<std::size_t>(mesh - mesh_id::lathe_first);
        if (mesh >= mesh_id::lathe_first && own >= bands_.size()) {
            for (const HullFace& face : (*hulls_)[own - bands_.size()]) {
                part.face = &face;
                add(nullptr, nullptr);
            }
            return;
        }
        const std::vector<LatheBand>& bands =
            mesh == mesh_id::rod ? rod_bands_ : bands_[static_cast<std::size_t>(mesh - mesh_id::lathe_first)];
        const LatheBand* end = bands.data() + bands.size();
        for (const LatheBand* first = bands.data(); first != end;) {
            const LatheBand* last =
                std::find_if(first, end, [&](const LatheBand& b) { return b.group != first->group; });
            add(first, last);
            first = last;
        }
    }

    static void follow_flat(const FlatPart& part, int k, const glm::vec2& pixel, Samples& samples) {
        const auto at_center = [&](const glm::vec3& f) { return f.x * pixel.x + f.y * pixel.y + f.z; };
        const auto at_samples = [](const glm::vec3& f, float center, std::size_t half) {
            return all(center) + all(f.x) * sample_x[half] + all(f.y) * sample_y[half];
        };
        const float w0 = at_center(part.inverse_w);
        const float u0 = at_center(part.u);
        const float v0 = at_center(part.v);
        for (std::size_t half = 0; half < 2; ++half) {
            const Float4 inverse_w = at_samples(part.inverse_w, w0, half);
            Int4 is_hit = all(-1);
            if (part.is_bounded) {
                const Float4 u = at_samples(part.u, u0, half);
                const Float4 v = at_samples(part.v, v0, half);
                is_hit = (u <= inverse_w) & (-u <= inverse_w) & (v <= inverse_w) & (-v <= inverse_w);
            }
            samples.meet(half, is_hit, inverse_w, k);
        }
    }

    static void follow_round(const RoundPart& part, int k, const glm::vec2& pixel, Samples& samples) {
        for (std::size_t half = 0; half < 2; ++half) {
            const Float4 x = all(pixel.x) + sample_x[half];
            const Float4 y = all(pixel.y) + sample_y[half];
            const glm::mat3& from = part.ray_from_window;
            const auto along = [&](int axis) {
                return all(from[0][axis]) * x + all(from[1][axis]) * y + all(from[2][axis]);
            };
            const Rays rays{part.origin, along(0), along(1), along(2)};
            const Float4 t = meet(part, rays);
            samples.meet(half, all(-1), all(1.0f) / t, k);
        }
    }

    glm::mat3 window_;
    glm::vec3 eye_;
    std::vector<PartRef> refs_;
    std::vector<FlatPart> flats_;
    std::vector<std::array<std::uint32_t, 3>> thin_faces_; ///< of a box: the camera sees three of its faces at most
    std::vector<RoundPart> rounds_;
    std::vector<std::vector<LatheBand>> bands_;
    std::vector<LatheBand> rod_bands_;
    const std::vector<std::vector<HullFace>>* hulls_ = nullptr;
};

/// Colours and part numbers of one row and its neighbours; the picture's border repeats.
template <class Sample>
struct RowWindow {
    std::array<const std::uint32_t*, 3> ids;
    std::array<const Sample*, 3> rgba;
    int width;
};

/// Four samples as they lie in memory.
template <class Vector, class Sample>
Int4 widened(const Sample* rgba) {
    Vector samples;
    std::memcpy(&samples, rgba, sizeof(samples));
    return __builtin_convertvector(samples, Int4);
}
Int4 color_at(const std::uint8_t* rgba) {
    return widened<std::uint8_t __attribute__((vector_size(4)))>(rgba);
}
Int4 color_at(const std::uint16_t* rgba) {
    return widened<std::uint16_t __attribute__((vector_size(8)))>(rgba);
}

template <class Sample>
Candidates collect(const RowWindow<Sample>& rows, int x) {
    Candidates found;
    const auto add = [&](int row, int column) {
        found.add(rows.ids[row][column], color_at(rows.rgba[row] + 4 * static_cast<std::size_t>(column)));
    };
    const int left = std::max(x - 1, 0);
    const int right = std::min(x + 1, rows.width - 1);
    add(1, x);
    add(1, left);
    add(1, right);
    for (const int row : {0, 2}) {
        add(row, x);
        add(row, left);
        add(row, right);
    }
    return found;
}

/// Mean of the eight samples of the pixel whose centre is at `pixel`.
template <class Sample>
void smooth_pixel(const PartTable& parts, const Candidates& found, const glm::vec2& pixel, Sample* to) {
    Samples samples;
    for (int k = 0; k < found.count; ++k) {
        parts.follow(found.id[k], k, pixel, samples);
    }
    for (int k = 0; k < found.count; ++k) {
        if (parts.has_thin_faces(found.id[k])) {
            parts.follow_thin_faces(found, k, pixel, samples);
        }
    }
    Float4 sum = all(0.0f);
    for (int k = 0; k < found.count; ++k) {
        const Int4 hits = (samples.winner[0] == all(k)) + (samples.winner[1] == all(k)); // -1 each
        const int count = -(hits[0] + hits[1] + hits[2] + hits[3]);
        const float share = static_cast<float>(count) / static_cast<float>(found.pixels[k] * sample_count);
        sum += all(share) * __builtin_convertvector(found.color[k], Float4);
    }
    const Int4 mean = __builtin_convertvector(sum + all(0.5f), Int4);
    for (int c = 0; c < 3; ++c) {
        to[c] = static_cast<Sample>(mean[c]);
    }
}

/// A row without alpha: some pixels at a time. What is written beyond them is overwritten by the next.
template <class Sample>
[[gnu::always_inline]] inline void drop_alpha(const Sample* from, int width, Sample* to) {
    int x = 0;
    if constexpr (sizeof(Sample) == 1) {
        using Bytes = std::uint8_t __attribute__((vector_size(16)));
        for (; x + 5 < width; x += 4) {
            Bytes pixels;
            std::memcpy(&pixels, from + 4 * x, sizeof(pixels));
            pixels =
                __builtin_shufflevector(pixels, pixels, 0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11, 15);
            std::memcpy(to + 3 * x, &pixels, sizeof(pixels));
        }
    }
    for (; x + 1 < width; ++x) {
        std::memcpy(to + 3 * x, from + 4 * x, 4 * sizeof(Sample));
    }
    std::memcpy(to + 3 * x, from + 4 * x, 3 * sizeof(Sample));
}

/// Without alpha, top row first.
template <class Sample>
FOR_ALL_AND_AVX2 std::vector<Sample> flipped_samples(const RawPicture& raw, const std::vector<Sample>& rgba) {
    std::vector<Sample> rgb(static_cast<std::size_t>(raw.width) * static_cast<std::size_t>(raw.height) * 3);
    for (int y = 0; y < raw.height; ++y) {
        drop_alpha(rgba.data() + static_cast<std::size_t>(raw.height - 1 - y) * raw.width * 4, raw.width,
                   rgb.data() + static_cast<std::size_t>(y) * raw.width * 3);
    }
    return rgb;
}

template <class Sample>
[[gnu::flatten]] FOR_ALL_AND_AVX2 std::vector<Sample>
smooth_samples(const RawPicture& raw, const std::vector<Sample>& rgba, const PartTable& parts) {
    std::vector<Sample> rgb = flipped_samples(raw, rgba);
    EdgeFinder edges(raw.width);
    for (int y = 0; y < raw.height; ++y) {
        RowWindow<Sample> rows{{}, {}, raw.width};
        for (int k = 0; k < 3; ++k) {
            const auto row = static_cast<std::size_t>(std::clamp(y + k - 1, 0, raw.height - 1)) * raw.width;
            rows.ids[k] = raw.ids.data() + row;
            rows.rgba[k] = rgba.data() + 4 * row;
        }
        Sample* to = rgb.data() + static_cast<std::size_t>(raw.height - 1 - y) * raw.width * 3;
        const std::vector<std::uint8_t>& is_edge = edges.find(rows.ids);
        // Most pixels are none: memchr finds the next that is.
        const std::uint8_t* end = is_edge.data() + raw.width;
        for (const std::uint8_t* at = is_edge.data();
             (at = static_cast<const std::uint8_t*>(
                  std::memchr(at, 1, static_cast<std::size_t>(end - at)))) != nullptr;
             ++at) {
            const auto x = static_cast<int>(at - is_edge.data());
            const Candidates found = collect(rows, x);
            const glm::vec2 pixel(static_cast<float>(raw.x + x) + 0.5f, static_cast<float>(raw.y + y) + 0.5f);
            smooth_pixel(parts, found, pixel, to + 3 * x);
        }
    }
    return rgb;
}

Image image_of(const RawPicture& raw, std::vector<std::uint8_t> rgb) {
    Image image;
    image.width = raw.width;
    image.height = raw.height;
    image.rgb = std::move(rgb);
    return image;
}

} // namespace

Image flipped(const RawPicture& raw) {
    return image_of(raw, flipped_samples(raw, raw.rgba));
}

std::vector<std::uint16_t> flipped_deep(const RawPicture& raw) {
    return flipped_samples(raw, raw.deep);
}

Image smooth_edges(const RawPicture& raw, const SceneGeometry& geometry, const DrawList& list,
                   const Viewport& viewport) {
    return image_of(raw, smooth_samples(raw, raw.rgba, PartTable(viewport, geometry, list)));
}

std::vector<std::uint16_t> smooth_edges_deep(const RawPicture& raw, const SceneGeometry& geometry,
                                             const DrawList& list, const Viewport& viewport) {
    return smooth_samples(raw, raw.deep, PartTable(viewport, geometry, list));
}

} // namespace render
