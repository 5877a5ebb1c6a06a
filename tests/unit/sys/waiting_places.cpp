#include <sys/waiting_places.hpp>

#include <gtest/gtest.h>

#include <vector>

namespace waiting_places_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
using Stage = WaitingConnection::Stage;

ano::TimePoint at(std::chrono::milliseconds time) { return ano::TimePoint{} + 1h + time; }

TEST(WaitingPlaces, the_oldest_connection_of_the_address_with_the_most_is_dropped) {
    std::vector<WaitingConnection> all{{1, at(0ms), Stage::begun}};
    for (int i = 1; i <= 10; ++i) all.push_back({2, at(i * 1ms), Stage::begun});
    EXPECT_EQ(next_evicted(all, false), 1u);
    all[1].stage = Stage::at_work;
    EXPECT_EQ(next_evicted(all, false), 2u) << "one that is worked at stays";
}

TEST(WaitingPlaces, silent_connections_of_a_flood_are_dropped_first) {
    std::vector<WaitingConnection> all{{1000, at(0ms), Stage::begun}, {1000, at(0ms), Stage::its_turn}};
    for (std::uint64_t i = 1; i <= 100; ++i) all.push_back({i, at(1ms), Stage::silent});
    EXPECT_EQ(next_evicted(all, false), 2u);
}

TEST(WaitingPlaces, connections_of_a_flood_of_first_messages_are_dropped_before_a_new_connection) {
    std::vector<WaitingConnection> all{{1000, at(0ms), Stage::silent}};
    for (std::uint64_t i = 1; i <= 100; ++i) all.push_back({i, at(1ms), Stage::begun});
    EXPECT_EQ(next_evicted(all, false), 1u);
}

// The answer needs 100 ms to a distant client: meanwhile many others send a single byte each.
TEST(WaitingPlaces, a_connection_with_a_processed_message_outlasts_a_flood_of_incomplete_ones) {
    std::vector<WaitingConnection> all{{1000, at(0ms), Stage::begun, false, true}};
    for (std::uint64_t i = 1; i <= 100; ++i) all.push_back({i, at(1ms), Stage::begun});
    EXPECT_EQ(next_evicted(all, false), 1u);
    for (std::uint64_t i = 1; i <= 101; ++i) all.push_back({200 + i, at(2ms), Stage::begun, false, true});
    EXPECT_EQ(next_evicted(all, false), 0u) << "a flood that has its messages processed";
}

TEST(WaitingPlaces, a_few_connections_of_one_address_count_as_one) {
    std::vector<WaitingConnection> all;
    for (int i = 0; i < 4; ++i) all.push_back({1000, at(10ms), Stage::begun});
    for (std::uint64_t i = 1; i <= 100; ++i) all.push_back({i, at(1ms), Stage::begun});
    EXPECT_EQ(next_evicted(all, false), 4u);
    all.push_back({1000, at(20ms), Stage::begun});
    EXPECT_EQ(next_evicted(all, false), 0u);
}

TEST(WaitingPlaces, a_trusted_connection_is_replaced_only_by_trusted_ones) {
    std::vector<WaitingConnection> all(3, {1, at(0ms), Stage::silent, true});
    EXPECT_EQ(next_evicted(all, false), std::nullopt);
    EXPECT_EQ(next_evicted(all, true), 0u);
    all.push_back({2, at(5ms), Stage::begun});
    EXPECT_EQ(next_evicted(all, false), 3u);
    EXPECT_EQ(next_evicted({}, false), std::nullopt);
}

TEST(WaitingPlaces, only_a_few_connections_of_one_address_have_priority) {
    std::vector<WaitingConnection> all;
    for (int i = 0; i < 4; ++i) all.push_back({1, at(i * 1ms), Stage::its_turn, true});
    all.push_back({2, at(5ms), Stage::its_turn});
    EXPECT_EQ(next_evicted(all, false), 4u);
    EXPECT_EQ(next_turn(all, 100), 0u);
    all.push_back({1, at(6ms), Stage::its_turn, true});
    EXPECT_EQ(next_evicted(all, false), 0u) << "a flood from the address of somebody trusted";
    EXPECT_EQ(next_turn(all, 100), 4u);
    std::vector<WaitingConnection> crowd(300, {1, at(0ms), Stage::silent, true});
    EXPECT_EQ(next_evicted(crowd, false), 0u) << "others get in";
}

TEST(WaitingPlaces, turns_follow_trust_then_answers_then_fewest_connections_then_age) {
    std::vector<WaitingConnection> all{{1, at(0ms), Stage::begun}};
    EXPECT_EQ(next_turn(all, 100), std::nullopt);
    for (int i = 0; i < 10; ++i) all.push_back({2, at(i * 1ms), Stage::its_turn});
    EXPECT_EQ(next_turn(all, 100), 1u);
    all.push_back({3, at(20ms), Stage::its_turn});
    EXPECT_EQ(next_turn(all, 100), 11u);
    all.push_back({2, at(20ms), Stage::its_turn, false, true});
    EXPECT_EQ(next_turn(all, 100), 12u);
    all.push_back({4, at(20ms), Stage::its_turn, true, false});
    EXPECT_EQ(next_turn(all, 100), 13u);
}

TEST(WaitingPlaces, the_newest_connection_has_its_turn_while_nearly_all_are_used) {
    std::vector<WaitingConnection> all;
    for (std::uint64_t i = 0; i < 74; ++i) all.push_back({i, at(1ms * i), Stage::its_turn});
    EXPECT_EQ(next_turn(all, 100), 0u);
    all.push_back({74, at(74ms), Stage::its_turn});
    EXPECT_EQ(next_turn(all, 100), 74u);
}

}    // namespace
}    // namespace waiting_places_tests
