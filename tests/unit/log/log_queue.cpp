#include <log/log_queue.hpp>

#include <gtest/gtest.h>

namespace anogate::log_queue_tests {
namespace {

const spdlog::log_clock::time_point noon{std::chrono::hours{12}};
constexpr int many = 100'000;

void push_line(LogQueue& queue, const std::string& text) { queue.push(spdlog::level::info, noon, text); }

TEST(LogQueue, returns_messages_unchanged) {
    LogQueue queue;
    EXPECT_TRUE(queue.empty());
    queue.push(spdlog::level::warn, noon, "one");
    queue.push(spdlog::level::err, {}, "two\nthree\n", true);
    EXPECT_FALSE(queue.empty());
    const LogQueue::Batch batch = queue.pop_all();
    ASSERT_EQ(batch.messages.size(), 2u);
    EXPECT_EQ(batch.messages[0].text, "one");
    EXPECT_EQ(batch.messages[0].level, spdlog::level::warn);
    EXPECT_EQ(batch.messages[0].at, noon);
    EXPECT_FALSE(batch.messages[0].plain);
    EXPECT_EQ(batch.messages[1].text, "two\nthree\n");
    EXPECT_TRUE(batch.messages[1].plain);
    EXPECT_EQ(batch.lost, 0u);
    EXPECT_TRUE(queue.empty());
}

TEST(LogQueue, keeps_the_first_and_counts_the_rest) {
    LogQueue queue;
    for (int i = 0; i < many; ++i) push_line(queue, std::to_string(i));
    const LogQueue::Batch batch = queue.pop_all();
    const std::size_t kept = batch.messages.size();
    EXPECT_GT(kept, 100u);
    EXPECT_LE(kept * sizeof(LogMessage), LogQueue::room);
    EXPECT_EQ(kept + batch.lost, static_cast<std::uint64_t>(many));
    for (std::size_t i = 0; i < kept; ++i) ASSERT_EQ(batch.messages[i].text, std::to_string(i));
}

TEST(LogQueue, has_one_gap_and_accepts_nothing_after_it_until_all_is_read) {
    LogQueue queue;
    push_line(queue, std::string(LogQueue::room, 'x'));    // it begins below the limit
    push_line(queue, "lost");
    push_line(queue, "");
    LogQueue::Batch batch = queue.pop_all();
    EXPECT_EQ(batch.messages.size(), 1u);
    EXPECT_EQ(batch.lost, 2u);
    push_line(queue, "again");
    batch = queue.pop_all();
    ASSERT_EQ(batch.messages.size(), 1u);
    EXPECT_EQ(batch.messages[0].text, "again");
    EXPECT_EQ(batch.lost, 0u);
}

TEST(LogQueue, accepts_nothing_when_it_is_exactly_full) {
    LogQueue queue;
    push_line(queue, std::string(LogQueue::room - sizeof(LogMessage), 'x'));
    push_line(queue, "lost");
    const LogQueue::Batch batch = queue.pop_all();
    EXPECT_EQ(batch.messages.size(), 1u);
    EXPECT_EQ(batch.lost, 1u);
}

TEST(LogQueue, counts_lines_not_messages) {
    LogQueue queue;
    queue.lose();
    EXPECT_FALSE(queue.empty());
    push_line(queue, "status\na: up\nb: up\n");
    push_line(queue, "status\na: up");
    EXPECT_EQ(queue.pop_all().lost, 1u + 3 + 2);
}

}    // namespace
}    // namespace anogate::log_queue_tests
