#pragma once
/// Hands values from one thread to another, a few at a time: who is ahead waits.
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace render {

template <class T>
class BoundedQueue {
public:
    /// capacity: values held at most, >= 1.
    explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

    /// Waits while the queue is full. False, and the value is dropped, once it is closed or cancelled.
    bool push(T value) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return is_closed_ || values_.size() < capacity_; });
        if (is_closed_) {
            return false;
        }
        values_.push_back(std::move(value));
        changed_.notify_all();
        return true;
    }

    /// Waits for a value. None once the queue is cancelled, or closed and empty.
    std::optional<T> pop() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return is_closed_ || !values_.empty(); });
        if (values_.empty()) {
            return std::nullopt;
        }
        std::optional<T> value(std::move(values_.front()));
        values_.pop_front();
        changed_.notify_all();
        return value;
    }

    /// No more values come; those inside can still be taken.
    void close() {
        const std::scoped_lock lock(mutex_);
        is_closed_ = true;
        changed_.notify_all();
    }

    /// Drops all values and wakes everyone.
    void cancel() {
        const std::scoped_lock lock(mutex_);
        is_closed_ = true;
        values_.clear();
        changed_.notify_all();
    }

private:
    std::size_t capacity_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<T> values_;
    bool is_closed_ = false;
};

} // namespace render
