// Objects passed from one thread to another.
#include <sys/thread_queue.hpp>

#include <gtest/gtest.h>

#include <memory>
#include <optional>

namespace thread_queue_tests {
namespace {

using anogate::ThreadQueue;

TEST(ThreadQueue, returns_items_in_their_order) {
    ThreadQueue<int> queue{4};
    EXPECT_TRUE(queue.empty());
    EXPECT_EQ(queue.pop(), std::nullopt);
    for (int turn = 0; turn < 5; ++turn) {
        for (int i = 0; i < 3; ++i) ASSERT_TRUE(queue.push(10 * turn + i));
        EXPECT_FALSE(queue.empty());
        for (int i = 0; i < 3; ++i) EXPECT_EQ(queue.pop(), 10 * turn + i);
    }
    EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(ThreadQueue, accepts_no_more_items_than_its_capacity) {
    ThreadQueue<int> queue{2};
    EXPECT_TRUE(queue.push(1));
    EXPECT_TRUE(queue.has_room());
    EXPECT_TRUE(queue.push(2));
    EXPECT_FALSE(queue.has_room());
    EXPECT_FALSE(queue.push(3));
    EXPECT_EQ(queue.pop(), 1);
    EXPECT_TRUE(queue.push(4));
    EXPECT_EQ(queue.pop(), 2);
    EXPECT_EQ(queue.pop(), 4);
}

TEST(ThreadQueue, keeps_no_reference_to_a_removed_item) {
    ThreadQueue<std::shared_ptr<int>> queue{2};
    const auto item = std::make_shared<int>(1);
    queue.push(item);
    queue.pop();
    EXPECT_EQ(item.use_count(), 1);
}

}    // namespace
}    // namespace thread_queue_tests
