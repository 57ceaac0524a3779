#pragma once
/// A few threads that share the parts of a loop whose results do not depend on each other.
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sim {

/// Threads that wait for work between loops. The caller's thread works too, so one thread starts none.
class Workers {
public:
    /// threads >= 1.
    explicit Workers(int threads);
    ~Workers();
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    /// Calls work(first, last) for ranges that cover 0..count once, and returns when all are done. The ranges
    /// run in any order, so `work` may write only to its own elements. It must not throw.
    void run(std::size_t count, const std::function<void(std::size_t, std::size_t)>& work);

private:
    void serve(std::size_t part);
    void do_part(std::size_t part) const;

    std::vector<std::thread> threads_;
    std::mutex mutex_;
    std::condition_variable begin_;
    std::condition_variable end_;
    const std::function<void(std::size_t, std::size_t)>* work_ = nullptr;
    std::size_t count_ = 0;
    std::size_t loop_ = 0;    ///< number of the loop under way
    std::size_t running_ = 0; ///< threads still in it
    bool stop_ = false;
};

} // namespace sim
