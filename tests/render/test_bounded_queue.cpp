#include "render/film/bounded_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

using render::BoundedQueue;

TEST(bounded_queue, values_arrive_in_order_and_never_more_wait_than_the_capacity) {
    BoundedQueue<int> queue(3);
    std::atomic<int> pushed = 0;
    std::thread producer([&] {
        for (int i = 0; i < 1000; ++i) {
            ASSERT_TRUE(queue.push(i));
            ++pushed;
        }
        queue.close();
    });
    for (int i = 0; i < 1000; ++i) {
        const std::optional<int> value = queue.pop();
        ASSERT_EQ(value, i);
        EXPECT_LE(pushed, i + 1 + 3);
    }
    EXPECT_EQ(queue.pop(), std::nullopt);
    producer.join();
}

TEST(bounded_queue, what_is_inside_a_closed_queue_can_still_be_taken) {
    BoundedQueue<int> queue(2);
    queue.push(1);
    queue.push(2);
    queue.close();
    EXPECT_FALSE(queue.push(3));
    EXPECT_EQ(queue.pop(), 1);
    EXPECT_EQ(queue.pop(), 2);
    EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(bounded_queue, cancelling_drops_the_values_and_wakes_who_waits) {
    BoundedQueue<int> full(1);
    BoundedQueue<int> empty(1);
    full.push(1);
    std::atomic<bool> pushed = true;
    std::thread producer([&] { pushed = full.push(2); });
    std::optional<int> value = 7;
    std::thread consumer([&] { value = empty.pop(); });
    full.cancel();
    empty.cancel();
    producer.join();
    consumer.join();
    EXPECT_FALSE(pushed);
    EXPECT_EQ(value, std::nullopt);
    EXPECT_EQ(full.pop(), std::nullopt);
}
