#include <http/send_queue.hpp>

#include <gtest/gtest.h>

namespace anogate::http::send_queue_tests {
namespace {

using enum WebSocket::Kind;

WebSocket::Message message(std::size_t size) { return std::make_shared<const std::string>(size, 'x'); }

TEST(SendQueue, returns_messages_in_order) {
    SendQueue queue{100};
    EXPECT_TRUE(queue.empty());
    EXPECT_TRUE(queue.push(message(10), text));
    EXPECT_TRUE(queue.push(message(20), binary));
    EXPECT_EQ(queue.bytes(), 30u);
    EXPECT_EQ(queue.front().message->size(), 10u);
    EXPECT_EQ(queue.front().kind, text);
    queue.pop();
    EXPECT_EQ(queue.front().kind, binary);
    EXPECT_EQ(queue.bytes(), 20u);
    queue.pop();
    EXPECT_TRUE(queue.empty());
    EXPECT_EQ(queue.bytes(), 0u);
}

TEST(SendQueue, rejects_a_message_that_does_not_fit_and_keeps_the_others) {
    SendQueue queue{100};
    EXPECT_FALSE(queue.push(message(101), text));
    EXPECT_TRUE(queue.push(message(60), text));
    EXPECT_FALSE(queue.push(message(41), text));
    EXPECT_TRUE(queue.push(message(40), text));
    EXPECT_FALSE(queue.push(message(1), text));
    EXPECT_EQ(queue.bytes(), 100u);
    queue.pop();
    EXPECT_TRUE(queue.push(message(60), text));
    queue.clear();
    EXPECT_TRUE(queue.empty());
    EXPECT_TRUE(queue.push(message(100), text));
}

}    // namespace
}    // namespace anogate::http::send_queue_tests
