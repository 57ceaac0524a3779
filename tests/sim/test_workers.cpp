#include "sim/base/workers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

using namespace sim;

TEST(workers, every_index_is_visited_once_for_any_number_of_threads) {
    for (int threads = 1; threads <= 4; ++threads) {
        Workers workers(threads);
        for (const std::size_t count : {0u, 1u, 2u, 3u, 5u, 97u, 1000u}) {
            std::vector<int> visits(count, 0);
            std::atomic<bool> in_range = true;
            workers.run(count, [&](std::size_t first, std::size_t last) {
                in_range = in_range && first <= last && last <= count;
                for (std::size_t i = first; i < last; ++i) {
                    ++visits[i];
                }
            });
            EXPECT_TRUE(in_range);
            EXPECT_EQ(visits, std::vector<int>(count, 1)) << threads << " threads";
        }
    }
}

/// The caller sees what all threads wrote, loop after loop.
TEST(workers, loops_in_a_row_build_on_each_other) {
    Workers workers(3);
    std::vector<int> values(50, 0);
    for (int loop = 0; loop < 500; ++loop) {
        const std::vector<int> before = values;
        workers.run(values.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                values[i] = before[values.size() - 1 - i] + 1;
            }
        });
    }
    EXPECT_EQ(values, std::vector<int>(50, 500));
}

/// A thread that comes too late for the last loop must not take the end for one: it would do that loop again, and wait for ever.
TEST(workers, end_as_soon_as_a_loop_has) {
    std::atomic<std::size_t> done = 0;
    const auto work = [&](std::size_t first, std::size_t last) { done += last - first; };
    constexpr std::size_t times = 5000, count = 20;
    for (std::size_t i = 0; i < times; ++i) {
        Workers(4).run(count, work);
    }
    EXPECT_EQ(done, times * count);
}

/// A short loop wakes no more threads than have enough to do in it, and gives none of them less.
TEST(workers, a_short_loop_is_shared_by_few_threads) {
    Workers workers(8);
    constexpr std::size_t least = 5;
    for (const std::size_t count : {4u, 9u, 10u, 16u, 21u, 40u, 1000u}) {
        std::mutex mutex;
        std::set<std::thread::id> threads;
        std::size_t shortest = count;
        for (int loop = 0; loop < 200; ++loop) {
            workers.run(
                count,
                [&](std::size_t first, std::size_t last) {
                    const std::lock_guard lock(mutex);
                    threads.insert(std::this_thread::get_id());
                    shortest = std::min(shortest, last - first);
                },
                least);
        }
        EXPECT_LE(threads.size(), std::max<std::size_t>(1, count / least)) << count;
        EXPECT_GE(shortest, std::min(least, count)) << count;
    }
}

TEST(workers, threads_that_never_worked_end) {
    for (int threads = 1; threads <= 4; ++threads) {
        const Workers workers(threads);
    }
    SUCCEED();
}
