#include "render/cmd/progress.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <unistd.h>
#include <utility>

namespace cmd {

namespace {

using namespace std::chrono_literals;

constexpr auto terminal_interval = 200ms; // readable, and not a burden for a slow connection
constexpr auto log_interval = 5s;
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

Progress::Progress(std::string label, std::string unit, std::int64_t total, bool is_quiet)
    : label_(std::move(label)), unit_(std::move(unit)), total_(total), is_quiet_(is_quiet),
      is_terminal_(isatty(STDERR_FILENO) == 1), last_print_(Clock::now()), samples_{{last_print_, 0}} {}

std::string Progress::line(std::int64_t done) const {
    std::string text =
        fmt::format("{}: {} of {} {} ({} %)", label_, done, total_, unit_, 100 * done / total_);
    const Sample& first = samples_.front();
    const double seconds = std::chrono::duration<double>(Clock::now() - first.time).count();
    const auto progress = static_cast<double>(done - first.done);
    if (progress > 0 && seconds > 0) {
        const double rate = progress / seconds;
        text +=
            fmt::format(", {:.3g} {}/s, {} left", rate, unit_, duration_text(double(total_ - done) / rate));
    }
    return text;
}

void Progress::update(std::int64_t done, const std::string& note) {
    const Clock::time_point now = Clock::now();
    if (is_quiet_ || now - last_print_ < (is_terminal_ ? Clock::duration(terminal_interval) : log_interval)) {
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
    const std::string text = line(done) + note;
    if (is_terminal_) {
        std::fprintf(stderr, "\r%s\x1b[K", text.c_str());
    } else {
        std::fprintf(stderr, "%s\n", text.c_str());
    }
    std::fflush(stderr);
}

void Progress::clear() {
    if (is_terminal_ && !is_quiet_) {
        std::fputs("\r\x1b[K", stderr);
        std::fflush(stderr);
    }
}

} // namespace cmd
