#pragma once
/// A few threads that share the parts of a loop whose results do not depend on each other.
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
    /// threads >= 1.
    explicit Workers(int threads);
    ~Workers();
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    /// Calls work(first, last) for ranges that cover 0..count once, and returns when all are done. The ranges
    /// run in any order, so `work` may write only to its own elements. It must not throw. Fewer than `least` are not
    /// worth while to be shared: the caller's thread does them, as it does the range of a thread that has not begun
    /// when its own is done (where other programs keep that thread waiting).
    template <typename Work>
    void run(std::size_t count, Work&& work, std::size_t least = 1) {
        if (count < least) {
            if (count > 0) {
                work(std::size_t{0}, count);
            }
            return;
        }
        using Called = std::remove_reference_t<Work>;
        run_task({&work,
                  [](const void* called, std::size_t first, std::size_t last) {
                      (*static_cast<Called*>(const_cast<void*>(called)))(first, last);
                  },
                  count});
    }

    std::size_t thread_count() const { return threads_.size() + 1; }

private:
    struct Task {
        const void* work = nullptr;
        void (*call)(const void* work, std::size_t first, std::size_t last) = nullptr;
        std::size_t count = 0;
    };

    void run_task(const Task& task);
    void serve(std::size_t part);
    void do_part(std::size_t part) const;
    bool begin_part(std::size_t part, std::size_t loop);

    std::vector<std::thread> threads_;
    Task task_;
    std::atomic<std::size_t> loop_ = 0;    ///< number of the loop under way
    std::atomic<std::size_t> running_ = 0; ///< parts of it, but for the caller's, that are not done
    std::vector<std::atomic<std::size_t>> begun_; ///< [thread] last loop whose part has been begun; 0: the caller's, not used
    std::atomic<bool> stop_ = false;
};

/// Raises `most` to x, whichever thread comes first.
inline void raise_to(std::atomic<double>& most, double x) {
    double seen = most.load(std::memory_order_relaxed);
    while (seen < x && !most.compare_exchange_weak(seen, x, std::memory_order_relaxed)) {
    }
}

} // namespace sim
