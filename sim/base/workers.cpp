#include "sim/base/workers.h"

#include <span>

namespace sim {
namespace {

/// Looks at a value that another thread will change: so often without and then with leave to other programs, about a
/// millisecond together, as long as what only one thread does between loops; then this thread goes to sleep.
constexpr int looks = 1000;
constexpr int polite_looks = 2000;

/// A loop is one word: its number times the one, the threads that take part times the other, and the ranges of each. That of a share
/// has the number, and the ranges left.
constexpr std::size_t number_unit = 1u << 24;
constexpr std::size_t parts_unit = 1u << 8;

std::size_t number_of(std::size_t loop) {
    return loop / number_unit;
}
std::size_t parts_of(std::size_t loop) {
    return loop % number_unit / parts_unit;
}
std::size_t ranges_of(std::size_t loop) {
    return loop % parts_unit;
}

/// Waits until `value` is no longer `old`; returns what it is then.
std::size_t wait_for_change(const std::atomic<std::size_t>& value, std::size_t old) {
    for (int i = 0; i < looks + polite_looks; ++i) {
        if (const std::size_t now = value.load(std::memory_order_acquire); now != old) {
            return now;
        }
        if (i >= looks) {
            std::this_thread::yield();
        }
#if defined(__x86_64__)
        __builtin_ia32_pause();
#endif
    }
    value.wait(old, std::memory_order_acquire);
    return value.load(std::memory_order_acquire);
}

} // namespace

Workers::Workers(int threads) : shares_(static_cast<std::size_t>(threads)) {
    for (int i = 1; i < threads; ++i) {
        threads_.emplace_back([this, i] { serve(static_cast<std::size_t>(i)); });
    }
}

Workers::~Workers() {
    stop_ = true;
    for (Share& share : shares_) {
        share.loop += number_unit;
        share.loop.notify_one();
    }
    for (std::thread& thread : threads_) {
        thread.join();
    }
}

/// Begins one of the ranges left of thread `part` in a loop; returns how many there were, 0 if none. Until it is done
/// the loop goes on, so who begins a range has its task; who comes late finds nothing left.
std::size_t Workers::begin_range(std::size_t part, std::size_t loop) {
    std::atomic<std::size_t>& share = shares_[part].left;
    std::size_t before = share.load(std::memory_order_acquire);
    while (number_of(before) <= number_of(loop)) {
        const std::size_t left = ranges_of(number_of(before) == number_of(loop) ? before : loop);
        if (left == 0 ||
            share.compare_exchange_weak(before, number_of(loop) * number_unit + left - 1, std::memory_order_acq_rel)) {
            return left;
        }
    }
    return 0;
}

/// Does what is left of the ranges of thread `part`, then of the others; returns how many it did.
std::size_t Workers::work_on(const Task& task, std::size_t part, std::size_t loop) {
    const std::size_t parts = parts_of(loop);
    std::size_t done = 0;
    for (std::size_t i = 0; i < parts; ++i) {
        const std::size_t owner = (part + i) % parts;
        while (const std::size_t left = begin_range(owner, loop)) {
            const std::size_t all = parts * ranges_of(loop);
            const std::size_t range = (owner + 1) * ranges_of(loop) - left;
            const std::size_t first = task.count * range / all;
            const std::size_t last = task.count * (range + 1) / all;
            if (first < last) {
                task.call(task.work, first, last);
            }
            ++done;
        }
    }
    return done;
}

void Workers::serve(std::size_t part) {
    for (std::size_t seen = 0;;) {
        seen = wait_for_change(shares_[part].loop, seen);
        if (stop_) { // asked after the look: what the destructor changes is no loop
            return;
        }
        if (const std::size_t done = work_on(shares_[part].task, part, seen); done > 0) {
            finished_ += done;
            finished_.notify_one();
        }
    }
}

void Workers::run_task(const Task& task, std::size_t parts, std::size_t ranges) {
    if (threads_.empty()) {
        task.call(task.work, 0, task.count);
        return;
    }
    const std::size_t loop = ++loops_ * number_unit + parts * parts_unit + ranges;
    for (Share& share : std::span(shares_).subspan(1, parts - 1)) {
        share.task = task;
        share.loop = loop;
        share.loop.notify_one();
    }
    done_ += parts * ranges - work_on(task, 0, loop);
    for (std::size_t finished = finished_; finished != done_;) {
        finished = wait_for_change(finished_, finished);
    }
}

} // namespace sim
