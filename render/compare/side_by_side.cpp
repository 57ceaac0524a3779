#include "render/compare/side_by_side.h"

#include "render/compare/rows.h"
#include "render/compare/utf8.h"

#include <algorithm>

namespace diff {

namespace {

constexpr int most_width = 1920; ///< [px] of the film
constexpr double default_fps = 30.0;

/// The film's pictures: three panels of one size.
class Panels {
public:
    Panels(int width, int height) {
        const int factor = std::max(1, (3 * width + most_width - 1) / most_width);
        factor_ = static_cast<std::size_t>(factor);
        panel_width_ = std::max(1, width / factor);
        film_.width = 3 * panel_width_;
        film_.height = std::max(1, height / factor);
        clear();
    }

    void clear() {
        film_.rgb.assign(static_cast<std::size_t>(film_.width) * static_cast<std::size_t>(film_.height) * 3, 0);
    }

    /// panel: 0, 1 or 2 from the left. Means of factor x factor pixels.
    void set(int panel, const Picture& picture) {
        const Size size = size_of(picture.width, picture.height);
        const std::size_t step = factor_ * 3;
        const auto count = static_cast<std::uint64_t>(factor_ * factor_);
        // Divides sums of up to 256 times count exactly, for factors of up to 63.
        const std::uint64_t inverse = ((std::uint64_t{1} << 32) + count - 1) / count;
        for (int y = 0; y < size.height; ++y) {
            sums_.assign(size.width * step, 0);
            for (std::size_t k = 0; k < factor_; ++k) {
                add_row(row_of(picture, first_row(y) + static_cast<int>(k)), sums_.size(), sums_.data());
            }
            std::uint8_t* out = place_of(panel, y);
            const std::uint32_t* first = sums_.data();
            for (std::size_t x = 0; x < size.width; ++x, first += step) {
                for (std::size_t c = 0; c < 3; ++c) {
                    std::uint64_t sum = count / 2;
                    for (std::size_t k = 0; k < step; k += 3) {
                        sum += first[k + c];
                    }
                    *out++ = static_cast<std::uint8_t>(sum * inverse >> 32);
                }
            }
        }
    }

    /// What differs most of factor x factor pixels, so that nothing small vanishes.
    void set(int panel, const IndexedPicture& picture) {
        const Size size = size_of(picture.width, picture.height);
        const auto width = static_cast<std::size_t>(picture.width);
        for (int y = 0; y < size.height; ++y) {
            worst_.assign(size.width * factor_, 0);
            for (std::size_t k = 0; k < factor_; ++k) {
                raise_to(picture.indices.data() + (static_cast<std::size_t>(first_row(y)) + k) * width, worst_.size(),
                         worst_.data());
            }
            std::uint8_t* out = place_of(panel, y);
            for (std::size_t x = 0; x < size.width; ++x, out += 3) {
                const auto first = worst_.begin() + static_cast<std::ptrdiff_t>(x * factor_);
                const std::size_t index = *std::max_element(first, first + static_cast<std::ptrdiff_t>(factor_));
                std::copy_n(&picture.palette[3 * index], 3, out);
            }
        }
    }

    const Picture& film() const { return film_; }

private:
    /// [px] of a picture's panel.
    struct Size {
        std::size_t width;
        int height;
    };
    Size size_of(int width, int height) const {
        const int factor = static_cast<int>(factor_);
        return {static_cast<std::size_t>(std::min(panel_width_, width / factor)), std::min(film_.height, height / factor)};
    }
    int first_row(int y) const { return y * static_cast<int>(factor_); }
    std::uint8_t* place_of(int panel, int y) {
        return &film_.rgb[static_cast<std::size_t>(y * film_.width + panel * panel_width_) * 3];
    }

    std::size_t factor_ = 1;
    int panel_width_ = 1;
    Picture film_;
    std::vector<std::uint32_t> sums_; ///< of factor rows
    Bytes worst_;                     ///< indices of a row
};

} // namespace

void write_side_by_side(const Sides& sides, const Settings& settings, const FilmTools& films,
                        const std::filesystem::path& folder, Case& result) {
    const Source& reference = sides.reference;
    const Source& candidate = sides.candidate;
    if (!result.is_sequence || (result.status == Status::compared && result.tier == Tier::identical)) {
        return;
    }
    int width = 0;
    int height = 0;
    for (const Frame& frame : result.frames) {
        width = std::max({width, frame.width, frame.candidate_width});
        height = std::max({height, frame.height, frame.candidate_height});
    }
    if (width == 0) {
        return; // no picture could be read
    }
    result.fps = default_fps;
    for (const Source* source : {&candidate, &reference}) {
        if (source->kind == SourceKind::film) {
            result.fps = films.open(source->path)->fps();
        }
    }
    result.film = as_utf8(result.name) + ".mp4";
    std::replace(result.film.begin(), result.film.end(), '/', '_');
    Panels panels(width, height);
    const auto film = films.create(folder / result.film, panels.film().width, panels.film().height, result.fps);
    visit_pairs(reference, candidate, settings, &films,
                [&](const PairMemory& memory, bool has_a, bool has_b, const Frame& frame) {
                    panels.clear();
                    if (has_a) {
                        panels.set(0, memory.a);
                    }
                    if (has_b) {
                        panels.set(1, memory.b);
                    }
                    if (has_a && has_b) {
                        frame.tier == Tier::identical ? panels.set(2, memory.b) : panels.set(2, difference_picture(memory));
                    }
                    film->add(panels.film());
                });
    film->finish();
}

} // namespace diff
