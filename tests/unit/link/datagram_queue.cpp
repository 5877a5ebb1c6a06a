// The datagrams of a peer that wait for their turn: order, limit, and which are dropped.
#include <link/udp/datagram_queue.hpp>

#include <support/random.hpp>

#include <gtest/gtest.h>

#include <deque>
#include <vector>

namespace anogate::datagram_queue_tests {
namespace {

using namespace std::chrono_literals;

TEST(DatagramQueue, keeps_bytes_and_times_in_order_and_drops_the_oldest) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        support::Random random{seed};
        DatagramQueue queue;
        std::deque<std::vector<std::uint8_t>> model;
        std::uint8_t next = 0;
        for (int step = 0; step < 2000; ++step) {
            if (!random.one_in(3)) {
                const std::size_t size = random.one_in(20) ? random.below(65'536u) : random.below(1500u);
                model.emplace_back(size, next);
                const std::size_t dropped = queue.push(model.back(), ano::TimePoint{std::chrono::seconds{next++}});
                for (std::size_t i = 0; i < dropped; ++i) model.pop_front();
                std::size_t waiting = 0;
                for (const auto& one : model) waiting += one.size();
                ASSERT_LE(waiting, DatagramQueue::max_bytes) << seed;
            } else if (!queue.empty()) {
                const auto first = queue.pop();
                ASSERT_TRUE(std::equal(first.bytes.begin(), first.bytes.end(), model.front().begin(), model.front().end()))
                    << seed;
                if (!model.front().empty()) {
                    ASSERT_EQ(first.arrived_at, ano::TimePoint{std::chrono::seconds{model.front()[0]}});
                }
                model.pop_front();
            }
            ASSERT_EQ(queue.count(), model.size()) << seed;
        }
    }
}

TEST(DatagramQueue, has_room_for_the_largest_datagram) {
    DatagramQueue queue;
    queue.push(std::vector<std::uint8_t>(1000), {});
    EXPECT_LE(queue.push(std::vector<std::uint8_t>(65'507), {}), 1u);
    EXPECT_FALSE(queue.empty());
    while (queue.count() > 1) queue.pop();
    EXPECT_EQ(queue.pop().bytes.size(), 65'507u);
}

}    // namespace
}    // namespace anogate::datagram_queue_tests
