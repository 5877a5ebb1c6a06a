#include <watch/watch_queue.hpp>

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace watch_queue_tests {

using namespace anogate;
using namespace std::chrono_literals;

namespace {

constexpr ano::TimePoint start{1h};

WatchQueue::Batch batch(std::size_t size) { return std::make_shared<const std::string>(size, 'x'); }

WatchQueue::Tables tables(const std::string& text) { return std::make_shared<const WatchTables>(WatchTables{{}, {}, {}, text}); }

// "3": a batch of that size; "t": tables; "!2": lost frames.
std::string next(WatchQueue& queue, ano::TimePoint now = start) {
    const auto item = queue.next(now);
    if (!item) return "";
    if (const auto* all = std::get_if<WatchQueue::Tables>(&*item)) return (*all)->text;
    if (const auto* lost = std::get_if<LostFrames>(&*item)) return "!" + std::to_string(lost->count);
    return std::to_string(std::get<WatchQueue::Batch>(*item)->size());
}

TEST(WatchQueue, returns_items_in_their_order) {
    WatchQueue queue{100};
    queue.push(tables("t"));
    EXPECT_TRUE(queue.push(batch(3)));
    queue.push(tables("u"));
    EXPECT_TRUE(queue.push(batch(4)));
    EXPECT_EQ(queue.bytes(), 7u);
    for (const char* wanted : {"t", "3", "u", "4", ""}) EXPECT_EQ(next(queue), wanted);
    EXPECT_EQ(queue.bytes(), 0u);
}

TEST(WatchQueue, the_limit_applies_to_the_waiting_bytes) {
    WatchQueue queue{10};
    EXPECT_TRUE(queue.push(batch(10)));
    EXPECT_EQ(next(queue), "10");
    EXPECT_TRUE(queue.push(batch(4)));
    EXPECT_TRUE(queue.push(batch(6)));
    EXPECT_FALSE(queue.push(batch(1)));
    EXPECT_EQ(next(queue), "4");
    EXPECT_TRUE(queue.push(batch(4))) << "nothing was counted as lost";
}

TEST(WatchQueue, a_loss_is_reported_after_waiting_frames_and_before_new_ones) {
    WatchQueue queue{10};
    EXPECT_TRUE(queue.push(batch(8)));
    EXPECT_FALSE(queue.push(batch(8)));
    queue.lose(3, start);
    queue.lose(3, start + 200ms);
    queue.lose(7, start + 300ms);
    EXPECT_FALSE(queue.is_open());
    EXPECT_FALSE(queue.push(batch(1))) << "though there is room for it";
    EXPECT_EQ(next(queue), "8");
    EXPECT_FALSE(queue.push(batch(1))) << "the loss is not told yet";
    const auto item = queue.next(start + 500ms);
    ASSERT_TRUE(item && std::holds_alternative<LostFrames>(*item));
    const LostFrames& lost = std::get<LostFrames>(*item);
    EXPECT_EQ(lost.count, 3u);
    EXPECT_EQ(lost.by_id[3], 2u);
    EXPECT_EQ(lost.by_id[7], 1u);
    EXPECT_EQ(lost.since, 500ms);
    EXPECT_TRUE(queue.is_open());
    EXPECT_TRUE(queue.push(batch(1)));
    EXPECT_EQ(next(queue), "1");
    EXPECT_EQ(next(queue), "");
    queue.lose(1, start + 2s);
    const auto again = queue.next(start + 3s);
    ASSERT_TRUE(again && std::holds_alternative<LostFrames>(*again));
    EXPECT_EQ(std::get<LostFrames>(*again).count, 1u) << "each is told once";
    EXPECT_EQ(std::get<LostFrames>(*again).since, 1s);
}

TEST(WatchQueue, only_the_latest_of_the_tables_changed_during_a_loss_follow_it) {
    WatchQueue queue{10};
    queue.push(tables("t"));
    queue.lose(3, start);
    queue.push(tables("u"));
    queue.push(tables("v"));
    EXPECT_EQ(next(queue), "t");
    EXPECT_EQ(next(queue), "!1");
    EXPECT_TRUE(queue.push(batch(5)));
    EXPECT_EQ(next(queue), "v");
    EXPECT_EQ(next(queue), "5");
}

TEST(LostFrames, two_losses_are_added_for_every_id) {
    LostFrames lost, later;
    lost.count = lost.by_id[3] = 2;
    later.by_id[3] = 1;
    later.by_id[7] = 4;
    later.count = 5;
    lost.add(later);
    EXPECT_EQ(lost.count, 7u);
    EXPECT_EQ(lost.by_id[3], 3u);
    EXPECT_EQ(lost.by_id[7], 4u);
}

}    // namespace
}    // namespace watch_queue_tests
