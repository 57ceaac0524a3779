#pragma once
/// A few threads that share the parts of a loop whose results do not depend on each other.
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <type_traits>
#include <vector>

namespace sim {

/// Threads that wait for work between loops: for the next one, which is near, without going to sleep at once. The
/// caller's thread works too, so one thread starts none.
class Workers {
public:
    /// Ranges of each thread, at most: more even the threads' work out better, and cost more.
    static constexpr std::size_t most_ranges = 4;

    /// threads >= 1.
    explicit Workers(int threads);
    ~Workers();
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    /// Calls work(first, last) for ranges that cover 0..count once, and returns when all are done. The ranges
    /// run in any order, so `work` may write only to its own elements. It must not throw. Ranges of fewer than `least` are not
    /// worth while: so many threads take part as get one each, and the caller's does what does not make two. A thread that is done
    /// with its ranges goes on with those of others, who may have more to do in theirs, or be kept waiting by other programs.
    template <typename Work>
    void run(std::size_t count, Work&& work, std::size_t least = 1) {
        if (count < 2 * least) {
            if (count > 0) {
                work(std::size_t{0}, count);
            }
            return;
        }
        using Called = std::remove_reference_t<Work>;
        const std::size_t parts = std::min(thread_count(), count / least);
        run_task({&work,
                  [](const void* called, std::size_t first, std::size_t last) {
                      (*static_cast<Called*>(const_cast<void*>(called)))(first, last);
                  },
                  count},
                 parts, std::clamp(count / (parts * least), std::size_t{1}, most_ranges));
    }

    std::size_t thread_count() const { return threads_.size() + 1; }

private:
    struct Task {
        const void* work = nullptr;
        void (*call)(const void* work, std::size_t first, std::size_t last) = nullptr;
        std::size_t count = 0;
    };
    /// Of one thread. What begins a loop for it is on one cache line, as each takes its time from core to core; who takes no part
    /// in a loop need not wake.
    struct Share {
        alignas(64) std::atomic<std::size_t> loop = 0; ///< the last one that it takes part in: number, threads, ranges of each
        Task task;                                     ///< of that loop
        /// Ranges that no one has begun, and the number of their loop: of an earlier one none is left, of the one under way all are.
        alignas(64) std::atomic<std::size_t> left = 0;
    };

    void run_task(const Task& task, std::size_t parts, std::size_t ranges);
    void serve(std::size_t part);
    std::size_t work_on(const Task& task, std::size_t part, std::size_t loop);
    std::size_t begin_range(std::size_t part, std::size_t loop);

    std::vector<std::thread> threads_;
    std::vector<Share> shares_; ///< [thread]; the caller's first
    std::atomic<bool> stop_ = false;
    std::size_t loops_ = 0; ///< number of the last one
    std::size_t done_ = 0;  ///< what finished_ is as it has ended
    alignas(64) std::atomic<std::size_t> finished_ = 0; ///< ranges that other threads than the caller's have done so far
};

/// Runs work(first, last) as Workers::run does; without workers this thread does all.
template <typename Work>
void share(Workers* workers, std::size_t count, Work&& work, std::size_t least) {
    if (workers != nullptr) {
        workers->run(count, work, least);
    } else if (count > 0) {
        work(std::size_t{0}, count);
    }
}

/// Raises `most` to x, whichever thread comes first.
inline void raise_to(std::atomic<double>& most, double x) {
    double seen = most.load(std::memory_order_relaxed);
    while (seen < x && !most.compare_exchange_weak(seen, x, std::memory_order_relaxed)) {
    }
}

} // namespace sim
