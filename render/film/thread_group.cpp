#include "render/film/thread_group.h"

#include <utility>

namespace render {

ThreadGroup::~ThreadGroup() {
    stop();
    for (std::thread& thread : threads_) {
        if (thread.joinable()) {
            thread.join();
        }
    }
}

void ThreadGroup::on_stop(std::function<void()> wake) {
    wakes_.push_back(std::move(wake));
}

void ThreadGroup::start(std::function<void()> work) {
    {
        const std::scoped_lock lock(mutex_);
        ++running_;
    }
    threads_.emplace_back([this, work = std::move(work)] {
        try {
            work();
        } catch (...) {
            {
                const std::scoped_lock lock(mutex_);
                if (first_error_ == nullptr) {
                    first_error_ = std::current_exception();
                }
            }
            stop();
        }
        const std::scoped_lock lock(mutex_);
        --running_;
        ended_.notify_all();
    });
}

void ThreadGroup::stop() {
    if (is_stopping_.exchange(true)) {
        return;
    }
    for (const std::function<void()>& wake : wakes_) {
        wake();
    }
}

bool ThreadGroup::wait_for(std::chrono::milliseconds limit) {
    std::unique_lock lock(mutex_);
    return ended_.wait_for(lock, limit, [this] { return running_ == 0; });
}

void ThreadGroup::join() {
    for (std::thread& thread : threads_) {
        if (thread.joinable()) {
            thread.join();
        }
    }
    if (first_error_ != nullptr) {
        std::rethrow_exception(std::exchange(first_error_, nullptr));
    }
}

} // namespace render
