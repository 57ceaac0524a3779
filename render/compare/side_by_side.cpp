#include "render/compare/side_by_side.h"

#include "render/compare/rows.h"
#include "render/compare/utf8.h"
#include "sim/base/error.h"

#include <algorithm>

namespace diff {

namespace {

constexpr int most_width = 1920; ///< [px] of the film, of pictures that are not larger than most_factor allows
constexpr int most_factor = 16;  ///< of its pixels a picture has factor x factor, of which sums are of 16 bits
constexpr double default_fps = 30.0;

/// The film's pictures: three panels of one size.
class Panels {
public:
    Panels(int width, int height) {
        CHECK(width > 0 && height > 0);
        const int factor = std::clamp((3 * width + most_width - 1) / most_width, 1, most_factor);
        factor_ = static_cast<std::size_t>(factor);
        panel_width_ = std::max(1, width / factor);
        film_.width = 3 * panel_width_;
        film_.height = std::max(1, height / factor);
        film_.rgb.assign(static_cast<std::size_t>(film_.width) * static_cast<std::size_t>(film_.height) * 3, 0);
    }

    /// panel: 0, 1 or 2 from the left. Means of factor x factor pixels.
    void set(int panel, const Picture& picture) {
        const Size size = size_of(picture.width, picture.height);
        const std::size_t step = factor_ * 3;
        means_.resize(size.width * step);
        for (int y = 0; y < size.height; ++y) {
            sums_.assign(means_.size() + step, 0); // beyond the last pixel too
            for (std::size_t k = 0; k < factor_; ++k) {
                add_row(row_of(picture, first_row(y) + static_cast<int>(k)), means_.size(), sums_.data());
            }
            squares_ = sums_;
            for (std::size_t k = 1; k < factor_; ++k) {
                add_sums(sums_.data() + 3 * k, means_.size(), squares_.data());
            }
            divide(squares_.data(), means_.size(), static_cast<std::uint32_t>(factor_ * factor_), means_.data());
            std::uint8_t* out = place_of(panel, y);
            for (std::size_t x = 0; x < size.width; ++x, out += 3) {
                const std::uint8_t* mean = &means_[x * step];
                out[0] = mean[0];
                out[1] = mean[1];
                out[2] = mean[2];
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
    std::vector<std::uint16_t> sums_;    ///< of factor rows
    std::vector<std::uint16_t> squares_; ///< of factor x factor pixels, from each of a row on
    Bytes means_;                        ///< of these
    Bytes worst_;                     ///< indices of a row
};

} // namespace

SideBySide::SideBySide(const Sides& sides, const FilmTools& films, const std::filesystem::path& folder, const std::string& name)
    : sides_(sides), films_(films), fps_(default_fps) {
    std::string file = as_utf8(name) + ".mp4";
    std::replace(file.begin(), file.end(), '/', '_');
    path_ = folder / file;
    is_wanted_ = false;
    for (const Source* source : {&sides.candidate, &sides.reference}) {
        if (source->kind == SourceKind::film) {
            fps_ = films.open(source->path)->fps();
            is_wanted_ = true; // perhaps; its frames cannot be read again
        }
    }
    if (!is_wanted_) {
        names_ = frame_names(sides);
    }
}

void SideBySide::set_size(const Frame& frame) {
    const std::lock_guard lock(mutex_);
    if (width_ == 0 && std::max(frame.width, frame.candidate_width) > 0) {
        width_ = std::max(frame.width, frame.candidate_width);
        height_ = std::max(frame.height, frame.candidate_height);
    }
}

Picture SideBySide::same_panels(std::size_t i) const {
    Panels panels(width_, height_);
    Picture picture;
    ReaderMemory reader;
    Bytes bytes;
    const std::filesystem::path path = *path_in(sides_.reference, names_[i]);
    read_file(path, {}, bytes);
    decode_picture(bytes, path.string(), {}, picture, reader);
    for (const int panel : {0, 1, 2}) {
        panels.set(panel, picture);
    }
    return panels.film();
}

void SideBySide::add(std::size_t i, const PairMemory& memory, const Frame& frame) {
    Part part{frame.status == Status::compared && frame.tier == Tier::identical, {}};
    is_wanted_ = is_wanted_ || !part.is_same;
    set_size(frame);
    const bool has_a = frame.status != Status::reference_missing && memory.a.width > 0;
    const bool has_b = frame.status != Status::candidate_missing && memory.b.width > 0;
    if (part.is_same && !names_.empty()) {
        // Nothing is made as long as all is the same. Files with the same bytes were not decoded.
        part.panels = is_wanted_ ? std::optional(same_panels(i)) : std::nullopt;
    } else if (has_a || has_b) {
        Panels panels(width_, height_);
        if (has_a) {
            panels.set(0, memory.a);
        }
        if (has_b) {
            panels.set(1, memory.b);
        }
        if (has_a && has_b) {
            part.is_same ? panels.set(2, memory.b) : panels.set(2, difference_picture(memory));
        }
        part.panels = panels.film();
    }
    const std::lock_guard lock(mutex_);
    waiting_.emplace(i, std::move(part));
    if (is_wanted_ && width_ > 0) {
        write_ready();
    }
}

void SideBySide::write_ready() {
    for (auto part = waiting_.find(next_); part != waiting_.end(); part = waiting_.find(++next_)) {
        const Picture picture = part->second.panels    ? std::move(*part->second.panels)
                                : part->second.is_same ? same_panels(next_)
                                                       : Panels(width_, height_).film();
        if (film_ == nullptr) {
            film_ = films_.create(path_, picture.width, picture.height, fps_);
        }
        film_->add(picture);
        waiting_.erase(part);
    }
}

void SideBySide::finish(Case& result) {
    if (film_ == nullptr || (result.status == Status::compared && result.tier == Tier::identical)) {
        return; // an unfinished film leaves no file
    }
    film_->finish();
    result.film = path_.filename().string();
    result.fps = fps_;
}

} // namespace diff
