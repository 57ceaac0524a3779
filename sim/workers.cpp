#include "sim/workers.h"

namespace sim {

Workers::Workers(int threads) {
    for (int i = 1; i < threads; ++i) {
        threads_.emplace_back([this, i] { serve(static_cast<std::size_t>(i)); });
    }
}

Workers::~Workers() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    begin_.notify_all();
    for (std::thread& thread : threads_) {
        thread.join();
    }
}

/// The range of thread `part`: equal shares, whatever the order in which they run.
void Workers::do_part(std::size_t part) const {
    const std::size_t parts = threads_.size() + 1;
    (*work_)(count_ * part / parts, count_ * (part + 1) / parts);
}

void Workers::serve(std::size_t part) {
    std::size_t done = 0;
    std::unique_lock lock(mutex_);
    while (true) {
        begin_.wait(lock, [&] { return stop_ || loop_ != done; });
        if (stop_) {
            return;
        }
        done = loop_;
        lock.unlock();
        do_part(part);
        lock.lock();
        if (--running_ == 0) {
            end_.notify_one();
        }
    }
}

void Workers::run(std::size_t count, const std::function<void(std::size_t, std::size_t)>& work) {
    if (threads_.empty()) {
        work(0, count);
        return;
    }
    {
        const std::lock_guard lock(mutex_);
        work_ = &work;
        count_ = count;
        running_ = threads_.size();
        ++loop_;
    }
    begin_.notify_all();
    do_part(0);
    std::unique_lock lock(mutex_);
    end_.wait(lock, [&] { return running_ == 0; });
}

} // namespace sim
