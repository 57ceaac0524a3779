#include "render/compare/sequence.h"

#include "render/compare/cases.h"
#include "render/compare/report.h"
#include "render/compare/shift.h"
#include "render/compare/utf8.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/base/workers.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <utility>

namespace diff {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

bool is_bad(const Frame& frame, Tier fail_on) {
    return frame.status != Status::compared || frame.tier >= fail_on;
}

[[noreturn]] void fail_interrupted() {
    throw Error(ExitCode::interrupted, "interrupted; no report was made");
}

/// Folders or pictures; the case's thumbnails as well.
void compare_files_of(const Sides& sides, const Settings& settings, const SeePair& see, Case& result, Thumbnails& thumbnails) {
    const Source& reference = sides.reference;
    const Source& candidate = sides.candidate;
    PairSettings pair = settings.pair;
    pair.takes_thumbnails = result.is_sequence;
    thumbnails.reference.resize(reference.names.size());
    thumbnails.candidate.resize(candidate.names.size());
    const auto keep = [&](const std::string& name, const PairMemory& memory) {
        if (memory.thumbnail_a) {
            thumbnails.reference[place_in(reference, name)] = memory.thumbnail_a;
        }
        if (memory.thumbnail_b) {
            thumbnails.candidate[place_in(candidate, name)] = memory.thumbnail_b;
        }
    };
    const std::vector<std::string> names = frame_names(sides);
    result.frames.resize(names.size());
    const std::vector<std::int64_t> numbers = frame_numbers(names);
    std::atomic<std::size_t> next = 0;
    const auto parts = static_cast<std::size_t>(std::min<std::size_t>(static_cast<std::size_t>(settings.threads),
                                                                      names.size()));
    std::vector<std::exception_ptr> errors(parts);
    sim::Workers workers(static_cast<int>(parts));
    const auto compare_frame = [&](std::size_t i, PairMemory& memory) {
        Frame& frame = result.frames[i];
        frame.name = names[i];
        frame.index = numbers.empty() || !result.is_sequence ? static_cast<std::int64_t>(i) : numbers[i];
        compare_files({path_in(reference, names[i]), path_in(candidate, names[i])}, pair, memory, frame);
        keep(names[i], memory);
        if (see) {
            see(i, memory, frame);
        }
    };
    workers.run(parts, [&](std::size_t first, std::size_t last) {
        for (std::size_t part = first; part < last; ++part) {
            try {
                PairMemory memory;
                for (std::size_t i = next++; i < names.size() && !settings.is_interrupted(); i = next++) {
                    compare_frame(i, memory);
                }
            } catch (...) {
                errors[part] = std::current_exception();
            }
        }
    });
    for (const std::exception_ptr& error : errors) {
        if (error != nullptr) {
            std::rethrow_exception(error);
        }
    }
    if (settings.is_interrupted()) {
        fail_interrupted();
    }
}

/// Pictures of a folder, one after the other.
class FolderReader : public FilmReader {
public:
    FolderReader(const Source& source, const PictureLimits& accepted)
        : folder_(source.path), names_(source.names), accepted_(accepted) {
        sort_frames(names_);
    }

    bool read(Picture& picture) override {
        if (next_ == names_.size()) {
            return false;
        }
        const fs::path path = folder_ / names_[next_++];
        read_file(path, accepted_, bytes_);
        decode_picture(bytes_, path.string(), accepted_, picture, memory_);
        return true;
    }
    double fps() const override { return 0.0; }

private:
    fs::path folder_;
    std::vector<std::string> names_;
    PictureLimits accepted_;
    std::size_t next_ = 0;
    Bytes bytes_;
    ReaderMemory memory_;
};

/// Null if there is no such side.
std::unique_ptr<FilmReader> open_side(const Source& source, const FilmTools& films, const PictureLimits& accepted) {
    if (source.kind == SourceKind::frames) {
        return std::make_unique<FolderReader>(source, accepted);
    }
    return source.kind == SourceKind::film ? films.open(source.path) : nullptr;
}

/// Frames of two sequences side by side, of which one is a film, as long as one of them lasts.
void visit_films(const Source& reference, const Source& candidate, const FilmTools& films, PairMemory& memory,
                 const std::function<void(std::int64_t, bool has_a, bool has_b)>& use) {
    const auto a = open_side(reference, films, {});
    const auto b = open_side(candidate, films, {});
    bool has_a = a != nullptr;
    bool has_b = b != nullptr;
    for (std::int64_t i = 0;; ++i) {
        has_a = has_a && a->read(memory.a);
        has_b = has_b && b->read(memory.b);
        if (!has_a && !has_b) {
            return;
        }
        use(i, has_a, has_b);
    }
}

void compare_films(const Sides& sides, const Settings& settings, const FilmTools& films, const SeePair& see, Case& result) {
    const Source& reference = sides.reference;
    const Source& candidate = sides.candidate;
    PairMemory memory;
    PairSettings lossy = settings.pair;
    lossy.is_lossy = true;
    visit_films(reference, candidate, films, memory, [&](std::int64_t i, bool has_a, bool has_b) {
        if (settings.is_interrupted()) {
            fail_interrupted();
        }
        Frame frame;
        frame.name = fmt::format("frame {}", i);
        frame.index = i;
        if (has_a && has_b) {
            compare_pictures(lossy, memory, frame);
        } else {
            frame.tier = Tier::changed;
            frame.status = has_a ? Status::candidate_missing : Status::reference_missing;
            frame.message = has_a ? "the candidate has ended" : "the reference has ended";
        }
        if (see) {
            see(static_cast<std::size_t>(i), memory, frame);
        }
        result.frames.push_back(std::move(frame));
    });
    if (result.frames.empty()) {
        throw Error(ExitCode::io, "no frames in " + reference.path.string());
    }
}

/// What the frames say together.
void find_runs(const Settings& settings, Case& result) {
    double worst = 0.0;
    bool was_bad = false;
    for (const Frame& frame : result.frames) {
        const bool is_in_run = std::exchange(was_bad, is_bad(frame, settings.fail_on));
        result.tier = std::max(result.tier, frame.tier);
        if (result.status == Status::compared) {
            result.status = frame.status;
        }
        if (frame.status == Status::candidate_missing) {
            result.missing_frames.push_back(frame.index);
        }
        if (frame.status == Status::reference_missing) {
            result.extra_frames.push_back(frame.index);
        }
        if (frame.curve > worst) {
            worst = frame.curve;
            result.worst_frame = frame.index;
        }
        if (!was_bad) {
            continue;
        }
        result.is_failed = true;
        if (!result.first_bad_frame) {
            result.first_bad_frame = frame.index;
        }
        if (is_in_run) {
            result.bad_runs.back().end = frame.index + 1;
        } else {
            result.bad_runs.push_back({frame.index, frame.index + 1});
        }
    }
}

const Frame& frame_of(const Case& result, std::int64_t index) {
    const auto found = std::find_if(result.frames.begin(), result.frames.end(),
                                    [index](const Frame& frame) { return frame.index == index; });
    CHECK(found != result.frames.end());
    return *found;
}

/// "frame 12 (frame_000012.png)"
std::string name_in_text(const Frame& frame) {
    const bool is_file = !fs::path(frame.name).extension().empty();
    return fmt::format("frame {}", frame.index) + (is_file ? " (" + frame.name + ")" : "");
}

std::string sequence_message(const Case& result) {
    std::size_t of_tier[3] = {};
    std::size_t not_compared = 0;
    for (const Frame& frame : result.frames) {
        frame.status == Status::compared ? ++of_tier[static_cast<int>(frame.tier)] : ++not_compared;
    }
    std::string text = fmt::format("{} frames: {} identical, {} noise, {} changed", result.frames.size(), of_tier[0],
                                   of_tier[1], of_tier[2]);
    if (not_compared > 0) {
        text += fmt::format(", {} not compared ({} missing, {} extra)", not_compared, result.missing_frames.size(),
                            result.extra_frames.size());
    }
    if (result.first_bad_frame) {
        const Frame& first = frame_of(result, *result.first_bad_frame);
        text += fmt::format("; first bad {}: {}", name_in_text(first), first.message);
    }
    if (result.worst_frame && result.worst_frame != result.first_bad_frame) {
        const Frame& worst = frame_of(result, *result.worst_frame);
        text += fmt::format("; worst {} at {:.3g} times the limit", name_in_text(worst), worst.curve);
    }
    if (result.shift) {
        text += fmt::format("; the same frames shifted by {:+}", *result.shift);
    }
    return text;
}

// --- pictures for review --------------------------------------------------------------------------------------

/// Frames that get pictures: the first bad one and the worst.
std::vector<bool> chosen_frames(const Case& result, std::size_t most) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < result.frames.size(); ++i) {
        const Frame& frame = result.frames[i];
        if (frame.status != Status::compared || frame.tier != Tier::identical) {
            order.push_back(i);
        }
    }
    const auto rank = [&result](std::size_t i) {
        const Frame& frame = result.frames[i];
        const bool is_first = result.first_bad_frame == frame.index;
        return is_first || frame.status != Status::compared ? std::numeric_limits<double>::max() : frame.curve;
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
    order.resize(std::min(order.size(), most));
    std::vector<bool> chosen(result.frames.size());
    for (const std::size_t i : order) {
        chosen[i] = true;
    }
    return chosen;
}

class Reviewer {
public:
    Reviewer(const Settings& settings, const ReviewSettings& review, Case& result)
        : measuring_(settings.pair), review_(review), result_(result), folder_(fs::path(pictures_folder) / as_utf8(result.name)) {
        measuring_.judges = false;
        std::error_code error;
        fs::create_directories(review.folder / folder_, error);
        if (error) {
            throw Error(ExitCode::io,
                        "cannot make the folder " + (review.folder / folder_).string() + ": " + error.message());
        }
    }

    /// Pictures of files: copies, and what differs.
    void add_files(const PairPaths& paths, PairMemory& memory, std::size_t i) {
        Frame& frame = result_.frames[i];
        Frame again; // fills the memory with the pictures and what differs
        compare_files(paths, measuring_, memory, again);
        // What is damaged shows nothing.
        frame.reference_picture = again.width > 0 ? copy(paths.reference, frame, "reference") : "";
        frame.candidate_picture = again.candidate_width > 0 ? copy(paths.candidate, frame, "candidate") : "";
        add_difference(memory, frame);
    }

    const PairSettings& measuring() const { return measuring_; }

    void add_difference(const PairMemory& memory, Frame& frame) {
        if (memory.a.width > 0 && memory.b.width > 0) {
            frame.difference_picture = write(encode_png(difference_picture(memory)), frame, "difference", ".png");
        }
    }

    void add_decoded(const PairMemory& memory, bool has_a, bool has_b, Frame& frame) {
        if (has_a) {
            frame.reference_picture = write(encode_png(memory.a), frame, "reference", ".png");
        }
        if (has_b) {
            frame.candidate_picture = write(encode_png(memory.b), frame, "candidate", ".png");
        }
        if (has_a && has_b) {
            add_difference(memory, frame);
        }
    }

private:
    std::string write(const Bytes& bytes, const Frame& frame, const char* what, const std::string& extension) {
        const fs::path name = folder_ / as_utf8(fs::path(frame.name).stem().string() + "." + what + extension);
        sim::write_file_unsynced(review_.folder / name, bytes);
        return name.generic_string();
    }

    /// Empty if there is no file, or it cannot be read. What lies in the report's folder stays where it is.
    std::string copy(const std::optional<fs::path>& path, const Frame& frame, const char* what) {
        if (path) {
            const std::string inside = path->lexically_relative(review_.folder).generic_string();
            if (inside.starts_with(candidates_folder)) {
                return inside;
            }
        }
        try {
            Bytes bytes;
            if (path) {
                read_file(*path, measuring_.accepted, bytes);
            }
            return path ? write(bytes, frame, what, path->extension().string()) : std::string();
        } catch (const Error&) {
            return {};
        }
    }

    PairSettings measuring_; ///< the verdict is known
    const ReviewSettings& review_;
    Case& result_;
    fs::path folder_;
};

} // namespace

std::vector<std::string> frame_names(const Sides& sides) {
    if (sides.reference.kind == SourceKind::picture || sides.candidate.kind == SourceKind::picture) {
        return {sides.reference.path.filename().string()};
    }
    std::vector<std::string> names;
    std::set_union(sides.reference.names.begin(), sides.reference.names.end(), sides.candidate.names.begin(),
                   sides.candidate.names.end(), std::back_inserter(names));
    sort_frames(names);
    return names;
}

std::optional<fs::path> path_in(const Source& source, const std::string& name) {
    if (source.kind == SourceKind::picture) {
        return source.path;
    }
    if (place_in(source, name) == source.names.size()) {
        return std::nullopt;
    }
    return source.path / name;
}

Case compare_sources(const std::string& name, const Sides& sides, const Settings& settings, const FilmTools* films,
                     const SeePair& see) {
    const Source& reference = sides.reference;
    const Source& candidate = sides.candidate;
    Case result;
    result.name = name;
    result.reference_origin = reference.origin;
    result.candidate_origin = candidate.origin;
    SourceKind kind = reference.kind != SourceKind::missing ? reference.kind : candidate.kind;
    if (kind == SourceKind::missing) {
        throw Error(ExitCode::missing_or_size, "neither " + reference.path.string() + " nor " +
                                                   candidate.path.string() + " is there");
    }
    const bool are_sequences = kind != SourceKind::picture && candidate.kind != SourceKind::picture;
    if (are_sequences && candidate.kind == SourceKind::film) {
        kind = SourceKind::film; // of a run its film and its frames may be compared
    }
    if (!are_sequences && candidate.kind != kind && candidate.kind != SourceKind::missing) {
        throw Error(ExitCode::usage, reference.path.string() + " and " + candidate.path.string() +
                                         " are not of one kind: pictures, folders of frames, or films");
    }
    result.is_sequence = kind != SourceKind::picture;
    Thumbnails thumbnails;
    if (kind == SourceKind::film) {
        CHECK(films != nullptr);
        compare_films(sides, settings, *films, see, result);
    } else {
        compare_files_of(sides, settings, see, result, thumbnails);
    }
    find_runs(settings, result);
    if (result.is_sequence && result.is_failed && kind == SourceKind::frames &&
        candidate.kind == SourceKind::frames && reference.kind == SourceKind::frames) {
        result.shift = find_shift(reference, candidate, settings, thumbnails);
    }
    find_cause(reference, candidate, result);
    result.message = result.is_sequence ? sequence_message(result) : result.frames.front().message;
    return result;
}

void write_review(const Sides& sides, const Settings& settings, const ReviewSettings& review, const FilmTools* films,
                  Case& result) {
    const Source& reference = sides.reference;
    const Source& candidate = sides.candidate;
    const std::vector<bool> chosen = chosen_frames(result, review.most_frames);
    if (std::find(chosen.begin(), chosen.end(), true) == chosen.end()) {
        return;
    }
    Reviewer reviewer(settings, review, result);
    PairMemory memory;
    if (reference.kind == SourceKind::film || candidate.kind == SourceKind::film) {
        CHECK(films != nullptr);
        visit_films(reference, candidate, *films, memory, [&](std::int64_t i, bool has_a, bool has_b) {
            const auto index = static_cast<std::size_t>(i);
            if (index < chosen.size() && chosen[index]) {
                Frame again;
                if (has_a && has_b) {
                    compare_pictures(reviewer.measuring(), memory, again);
                }
                reviewer.add_decoded(memory, has_a, has_b, result.frames[index]);
            }
        });
        return;
    }
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        if (chosen[i]) {
            const std::string& name = result.frames[i].name;
            reviewer.add_files({path_in(reference, name), path_in(candidate, name)}, memory, i);
        }
    }
}

void sum_up(Comparison& comparison) {
    comparison.cases_of_tier = {};
    comparison.failed_cases = 0;
    ExitCode code = ExitCode::good;
    for (const Case& result : comparison.cases) {
        if (result.status == Status::compared) {
            ++comparison.cases_of_tier[static_cast<std::size_t>(result.tier)];
        }
        comparison.failed_cases += result.is_failed;
        if (!result.is_failed) {
            continue;
        }
        const ExitCode now = result.status == Status::compared     ? ExitCode::changed
                             : result.status == Status::unreadable ? ExitCode::io
                                                                   : ExitCode::missing_or_size;
        code = std::max(code, result.error_code > 0 ? static_cast<ExitCode>(result.error_code) : now);
    }
    comparison.exit_code = static_cast<int>(code);
}

} // namespace diff
