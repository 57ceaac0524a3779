#include "sim/base/workers.h"

namespace sim {
namespace {

/// Looks at a value that another thread will change: so often without and then with leave to other programs, about a
/// millisecond together, as long as what only one thread does between loops; then this thread goes to sleep.
constexpr int looks = 1000;
constexpr int polite_looks = 2000;

/// A share holds the number of its loop times this, and the ranges left.
constexpr std::size_t loop_unit = 16;

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

Workers::Workers(int threads) : shares_(static_cast<std::size_t>(threads)) {
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

/// Begins one of the ranges left of thread `part` in a loop; returns how many there were, 0 if none. Until it is done
/// the loop goes on, so who begins a range finds its task.
std::size_t Workers::begin_range(std::size_t part, std::size_t loop) {
    std::atomic<std::size_t>& left = shares_[part].left;
    std::size_t before = left.load(std::memory_order_acquire);
    while (before / loop_unit == loop && before % loop_unit > 0) {
        if (left.compare_exchange_weak(before, before - 1, std::memory_order_acq_rel)) {
            return before % loop_unit;
        }
    }
    return 0;
}

/// Does what is left of the ranges of thread `part`, then of the others; returns how many it did.
std::size_t Workers::work_on(std::size_t part, std::size_t loop) {
    const std::size_t parts = thread_count();
    std::size_t done = 0;
    for (std::size_t i = 0; i < parts; ++i) {
        const std::size_t owner = (part + i) % parts;
        while (const std::size_t left = begin_range(owner, loop)) {
            const std::size_t all = parts * task_.ranges;
            const std::size_t range = (owner + 1) * task_.ranges - left;
            const std::size_t first = task_.count * range / all;
            const std::size_t last = task_.count * (range + 1) / all;
            if (first < last) {
                task_.call(task_.work, first, last);
            }
            ++done;
        }
    }
    return done;
}

void Workers::serve(std::size_t part) {
    for (std::size_t seen = 0;;) {
        wait_for_change(loop_, seen);
        if (stop_) {
            return;
        }
        seen = loop_;
        const std::size_t done = work_on(part, seen);
        if (done > 0 && (running_ -= done) == 0) {
            running_.notify_one();
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
    const std::size_t parts = thread_count();
    task_ = task;
    running_ = parts * task.ranges;
    const std::size_t loop = loop_ + 1;
    for (Share& share : shares_) {
        share.left.store(loop * loop_unit + task.ranges, std::memory_order_release);
    }
    loop_ = loop;
    loop_.notify_all();
    std::size_t left = running_ -= work_on(0, loop);
    for (; left != 0; left = running_) {
        wait_for_change(running_, left);
    }
}

} // namespace sim
