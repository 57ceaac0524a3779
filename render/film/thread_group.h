#pragma once
/// Threads that work on one thing and stop together: the first exception ends all.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace render {

class ThreadGroup {
public:
    ThreadGroup() = default;
    ThreadGroup(const ThreadGroup&) = delete;
    ThreadGroup& operator=(const ThreadGroup&) = delete;
    /// Stops and waits for all threads.
    ~ThreadGroup();

    /// `wake` is called when the group stops, to wake threads that wait for something. It must not throw, and
    /// what it uses must outlive the group's threads. To be called before start().
    void on_stop(std::function<void()> wake);

    /// Runs `work` in a thread of its own. An exception from it is kept and stops the group.
    void start(std::function<void()> work);

    /// Asks all threads to end: they look at is_stopping().
    void stop();
    bool is_stopping() const { return is_stopping_; }

    /// True when all threads have ended, at the latest after `limit`.
    bool wait_for(std::chrono::milliseconds limit);

    /// Waits for all threads, then throws the first exception one of them has thrown, if any.
    void join();

private:
    std::mutex mutex_;
    std::condition_variable ended_;
    std::vector<std::thread> threads_;
    std::vector<std::function<void()>> wakes_;
    std::exception_ptr first_error_;
    int running_ = 0;
    std::atomic<bool> is_stopping_ = false;
};

} // namespace render
