#include "render/film/thread_group.h"

#include "render/film/bounded_queue.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

using namespace render;
using namespace std::chrono_literals;

TEST(thread_group, joining_waits_for_all_threads) {
    std::atomic<int> done = 0;
    ThreadGroup group;
    for (int i = 0; i < 8; ++i) {
        group.start([&] { ++done; });
    }
    group.join();
    EXPECT_EQ(done, 8);
    EXPECT_TRUE(group.wait_for(0ms));
    EXPECT_FALSE(group.is_stopping());
}

TEST(thread_group, the_first_exception_stops_the_others_and_comes_out_of_join) {
    BoundedQueue<int> queue(1); // nothing ever comes
    std::atomic<bool> was_woken = false;
    ThreadGroup group;
    group.on_stop([&] { queue.cancel(); });
    group.start([&] {
        queue.pop();
        was_woken = true;
    });
    group.start([] { throw std::runtime_error("first"); });
    try {
        group.join();
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_EQ(error.what(), std::string("first"));
    }
    EXPECT_TRUE(was_woken);
    EXPECT_TRUE(group.is_stopping());
}

TEST(thread_group, a_running_thread_is_not_waited_for_beyond_the_limit) {
    ThreadGroup group;
    group.start([&] {
        while (!group.is_stopping()) {
            std::this_thread::sleep_for(1ms);
        }
    });
    EXPECT_FALSE(group.wait_for(5ms));
    group.stop();
    group.join();
}

TEST(thread_group, destruction_stops_and_waits) {
    std::atomic<bool> has_ended = false;
    {
        ThreadGroup group;
        group.start([&] {
            while (!group.is_stopping()) {
                std::this_thread::sleep_for(1ms);
            }
            has_ended = true;
        });
    }
    EXPECT_TRUE(has_ended);
}
