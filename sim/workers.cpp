#include "sim/workers.h"

namespace sim {
namespace {

/// Looks at a value that another thread will change: so often without and then with leave to other programs, about a
/// millisecond together, as long as what only one thread does between loops; then this thread goes to sleep.
constexpr int looks = 1000;
constexpr int polite_looks = 2000;

/// Waits until `value` is no longer `old`.
void wait_for_change(const std::atomic<std::size_t>& value, std::size_t old) {
    for (int i = 0; i < looks + polite_looks; ++i) {
        if (value.load(std::memory_order_acquire) != old) {
            return;
        }
        if (i >= looks) {
            std::this_thread::yield();
        }
#if defined(__x86_64__)
        __builtin_ia32_pause();
#endif
    }
    value.wait(old, std::memory_order_acquire);
}

} // namespace

Workers::Workers(int threads) : begun_(static_cast<std::size_t>(threads)) {
    for (int i = 1; i < threads; ++i) {
        threads_.emplace_back([this, i] { serve(static_cast<std::size_t>(i)); });
    }
}

Workers::~Workers() {
    stop_ = true;
    ++loop_;
    loop_.notify_all();
    for (std::thread& thread : threads_) {
        thread.join();
    }
}

/// The range of thread `part`: equal shares, whatever the order in which they run.
void Workers::do_part(std::size_t part) const {
    const std::size_t parts = thread_count();
    const std::size_t first = task_.count * part / parts;
    const std::size_t last = task_.count * (part + 1) / parts;
    if (first < last) {
        task_.call(task_.work, first, last);
    }
}

/// Each part of a loop is begun once: by its own thread or, where that is late, by the caller's. Until then the loop
/// goes on, so a thread that begins a part finds its task.
bool Workers::begin_part(std::size_t part, std::size_t loop) {
    std::size_t before = loop - 1;
    return begun_[part].compare_exchange_strong(before, loop, std::memory_order_acq_rel);
}

void Workers::serve(std::size_t part) {
    for (std::size_t seen = 0;;) {
        wait_for_change(loop_, seen);
        if (stop_) {
            return;
        }
        seen = loop_;
        if (begin_part(part, seen)) {
            do_part(part);
            if (--running_ == 0) {
                running_.notify_one();
            }
        }
    }
}

void Workers::run_task(const Task& task) {
    if (threads_.empty()) {
        if (task.count > 0) {
            task.call(task.work, 0, task.count);
        }
        return;
    }
    task_ = task;
    running_ = threads_.size();
    const std::size_t loop = ++loop_;
    loop_.notify_all();
    do_part(0);
    for (std::size_t part = threads_.size(); part > 0; --part) {
        if (begin_part(part, loop)) {
            do_part(part);
            --running_;
        }
    }
    for (std::size_t left = running_; left != 0; left = running_) {
        wait_for_change(running_, left);
    }
}

} // namespace sim
