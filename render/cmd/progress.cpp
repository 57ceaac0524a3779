#include "render/cmd/progress.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <unistd.h>
#include <utility>

namespace cmd {

namespace {

using namespace std::chrono_literals;

constexpr auto terminal_interval = 200ms; // readable, and not a burden for a slow connection
constexpr auto log_interval = 5s;
constexpr auto json_interval = 1s;
constexpr auto rate_window = 20s; // the rate is that of this time: steps grow dearer as a pile grows

} // namespace

std::string duration_text(double seconds) {
    if (seconds < 10) {
        return fmt::format("{:.1f} s", seconds);
    }
    const auto whole = static_cast<long long>(std::llround(seconds));
    if (whole < 100) {
        return fmt::format("{} s", whole);
    }
    if (whole < 6000) {
        return fmt::format("{} min {:02} s", whole / 60, whole % 60);
    }
    return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

Progress::Progress(std::string label, std::string unit, std::int64_t total, ProgressStyle style)
    : label_(std::move(label)), unit_(std::move(unit)), total_(total), style_(style),
      is_terminal_(isatty(STDERR_FILENO) == 1), last_print_(Clock::now()), samples_{{last_print_, 0}} {}

std::string Progress::line(std::int64_t done) const {
    std::string text =
        fmt::format("{}: {} of {} {} ({} %)", label_, done, total_, unit_, 100 * done / total_);
    if (const double per_second = rate(done); per_second > 0.0) {
        text += fmt::format(", {:.3g} {}/s, {} left", per_second, unit_,
                            duration_text(static_cast<double>(total_ - done) / per_second));
    }
    return text;
}

double Progress::rate(std::int64_t done) const {
    const Sample& first = samples_.front();
    const double seconds = std::chrono::duration<double>(Clock::now() - first.time).count();
    return seconds > 0.0 ? static_cast<double>(done - first.done) / seconds : 0.0;
}

std::string Progress::json(std::int64_t done, const std::string& note) const {
    nlohmann::json line{{"scene", label_}, {"unit", unit_}, {"done", done}, {"total", total_}};
    if (const double per_second = rate(done); per_second > 0.0) {
        line["rate_per_s"] = per_second;
        line["left_s"] = static_cast<double>(total_ - done) / per_second;
    }
    if (!note.empty()) {
        line["note"] = note;
    }
    return line.dump();
}

void Progress::update(std::int64_t done, const std::string& note) {
    const Clock::time_point now = Clock::now();
    done_ = done;
    const auto interval = style_ == ProgressStyle::json ? Clock::duration(json_interval)
                          : is_terminal_                ? Clock::duration(terminal_interval)
                                                        : log_interval;
    if (style_ == ProgressStyle::quiet || now - last_print_ < interval) {
        return;
    }
    if (samples_.back().done < done) {
        samples_.push_back({now, done});
    }
    // The rate needs an earlier sample than the newest, however long that takes.
    while (samples_.size() > 2 && now - samples_.front().time > rate_window) {
        samples_.pop_front();
    }
    last_print_ = now;
    // "\r" to the line's beginning, "\x1b[K" clears what was longer.
    const std::string text = style_ == ProgressStyle::json ? json(done, note) : line(done) + note;
    if (is_terminal_ && style_ == ProgressStyle::text) {
        std::fprintf(stderr, "\r%s\x1b[K", text.c_str());
    } else {
        std::fprintf(stderr, "%s\n", text.c_str());
    }
    std::fflush(stderr);
}

void Progress::clear() {
    if (style_ == ProgressStyle::json) {
        std::fprintf(stderr, "%s\n", json(done_, "").c_str());
    } else if (is_terminal_ && style_ == ProgressStyle::text) {
        std::fputs("\r\x1b[K", stderr);
        std::fflush(stderr);
    }
}

} // namespace cmd
