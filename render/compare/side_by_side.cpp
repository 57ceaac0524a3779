#include "render/compare/side_by_side.h"

#include "render/compare/utf8.h"

#include <algorithm>

namespace diff {

namespace {

constexpr int most_width = 1920; ///< [px] of the film
constexpr double default_fps = 30.0;

Picture to_colors(const IndexedPicture& indexed) {
    Picture picture;
    picture.width = indexed.width;
    picture.height = indexed.height;
    picture.rgb.resize(indexed.indices.size() * 3);
    for (std::size_t i = 0; i < indexed.indices.size(); ++i) {
        const std::uint8_t* color = &indexed.palette[std::size_t{indexed.indices[i]} * 3];
        for (std::size_t c = 0; c < 3; ++c) {
            picture.rgb[3 * i + c] = color[c];
        }
    }
    return picture;
}

/// The film's pictures: three panels of one size.
class Panels {
public:
    Panels(int width, int height) : factor_(std::max(1, (3 * width + most_width - 1) / most_width)) {
        panel_width_ = std::max(1, width / factor_);
        film_.width = 3 * panel_width_;
        film_.height = std::max(1, height / factor_);
        clear();
    }

    void clear() {
        film_.rgb.assign(static_cast<std::size_t>(film_.width) * static_cast<std::size_t>(film_.height) * 3, 0);
    }

    /// panel: 0, 1 or 2 from the left. Means of factor x factor pixels.
    void set(int panel, const Picture& picture) {
        const int width = std::min(panel_width_, picture.width / factor_);
        const int height = std::min(film_.height, picture.height / factor_);
        const int count = factor_ * factor_;
        for (int y = 0; y < height; ++y) {
            sum_rows(picture, y * factor_, (y + 1) * factor_, sums_);
            std::uint8_t* out = &film_.rgb[static_cast<std::size_t>(y * film_.width + panel * panel_width_) * 3];
            for (int i = 0; i < 3 * width; ++i) {
                const std::uint32_t* first = &sums_[static_cast<std::size_t>(i / 3 * factor_ * 3 + i % 3)];
                std::uint32_t sum = static_cast<std::uint32_t>(count / 2);
                for (int k = 0; k < factor_; ++k) {
                    sum += first[3 * k];
                }
                out[i] = static_cast<std::uint8_t>(sum / static_cast<std::uint32_t>(count));
            }
        }
    }

    const Picture& film() const { return film_; }

private:
    int factor_;
    int panel_width_ = 1;
    Picture film_;
    std::vector<std::uint32_t> sums_; ///< of factor rows
};

} // namespace

void write_side_by_side(const Source& reference, const Source& candidate, const Settings& settings,
                        const FilmTools& films, const std::filesystem::path& folder, Case& result) {
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
                        panels.set(2, frame.tier == Tier::identical ? memory.b : to_colors(difference_picture(memory)));
                    }
                    film->add(panels.film());
                });
    film->finish();
}

} // namespace diff
