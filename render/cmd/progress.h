#pragma once
/// How far a run is: one line that changes on a terminal, a line every few seconds elsewhere; or, for machines, an
/// object in JSON on a line each second.
#include <chrono>
#include <cstdint>
#include <deque>
#include <string>

namespace cmd {

enum class ProgressStyle { quiet, text, json };

class Progress {
public:
    /// label: the scene; unit: "frames" or "steps"; total >= 1.
    Progress(std::string label, std::string unit, std::int64_t total, ProgressStyle style);

    /// Called often; prints when it is time to. note: what follows on the line.
    void update(std::int64_t done, const std::string& note = "");
    /// The same where the total grows.
    void update(std::int64_t done, std::int64_t total) {
        total_ = total;
        update(done);
    }

    /// Takes the changing line off the terminal; in JSON: says how far it came.
    void clear();

private:
    using Clock = std::chrono::steady_clock;
    struct Sample {
        Clock::time_point time;
        std::int64_t done;
    };

    /// Of the last seconds [1/s]; 0: not known yet.
    double rate(std::int64_t done) const;
    std::string line(std::int64_t done) const;
    std::string json(std::int64_t done, const std::string& note) const;

    std::string label_;
    std::string unit_;
    std::int64_t total_;
    ProgressStyle style_;
    bool is_terminal_;
    std::int64_t done_ = 0;
    Clock::time_point last_print_;
    std::deque<Sample> samples_; // of the last seconds: the rate follows a changing cost
};

/// "0.4 s", "58 s", "3 min 05 s", "2 h 05 min".
std::string duration_text(double seconds);

} // namespace cmd
