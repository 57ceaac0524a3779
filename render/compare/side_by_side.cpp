#include "render/compare/side_by_side.h"

#include <algorithm>

namespace diff {

namespace {

constexpr int most_width = 1920; ///< [px] of the film
constexpr double default_fps = 30.0;

Picture to_colors(const IndexedPicture& indexed) {
    Picture picture;
    picture.width = indexed.width;
    picture.height = indexed.height;
    picture.rgb.reserve(indexed.indices.size() * 3);
    for (const std::uint8_t index : indexed.indices) {
        const std::uint8_t* color = &indexed.palette[std::size_t{index} * 3];
        picture.rgb.insert(picture.rgb.end(), color, color + 3);
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
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                for (int c = 0; c < 3; ++c) {
                    film_.rgb[static_cast<std::size_t>((y * film_.width + panel * panel_width_ + x) * 3 + c)] =
                        mean(picture, x * factor_, y * factor_, c);
                }
            }
        }
    }

    const Picture& film() const { return film_; }

private:
    std::uint8_t mean(const Picture& picture, int left, int top, int c) const {
        int sum = 0;
        for (int y = top; y < top + factor_; ++y) {
            for (int x = left; x < left + factor_; ++x) {
                sum += picture.rgb[(static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                                    static_cast<std::size_t>(x)) * 3 + static_cast<std::size_t>(c)];
            }
        }
        const int count = factor_ * factor_;
        return static_cast<std::uint8_t>((sum + count / 2) / count);
    }

    int factor_;
    int panel_width_ = 1;
    Picture film_;
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
    result.film = result.name + ".mp4";
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
