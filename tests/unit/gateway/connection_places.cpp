#include <gateway/peers/connection_places.hpp>

#include <gtest/gtest.h>

#include <vector>

namespace connection_places_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
using Connection = ConnectionPlaces::Connection;

IpAddress address(std::uint8_t last) { return IpAddress::v4(10, 0, 0, last); }
ano::TimePoint at(std::chrono::seconds time) { return ano::TimePoint{} + 1h + time; }

TEST(ConnectionPlaces, are_free_until_all_are_taken) {
    const ConnectionPlaces places{2, 2, 0};
    std::vector<Connection> all;
    EXPECT_TRUE(places.place_for(all, address(1), false, at(0s)).free);
    all.push_back({address(1), at(0s), true, false});
    EXPECT_TRUE(places.place_for(all, address(2), false, at(0s)).free);
    all.push_back({address(2), at(0s), true, false});
    EXPECT_FALSE(places.place_for(all, address(3), false, at(0s)).free);
    EXPECT_FALSE(places.place_for(all, address(3), false, at(3600s)).free) << "those that have sent a frame stay";
}

TEST(ConnectionPlaces, connections_without_a_frame_within_ten_seconds_are_replaced_oldest_first) {
    const ConnectionPlaces places{3, 3, 0};
    const std::vector<Connection> all{
        {address(1), at(0s), true, false}, {address(2), at(2s), false, false}, {address(3), at(1s), false, false}};
    EXPECT_FALSE(places.place_for(all, address(4), false, at(10s)).free);
    const auto place = places.place_for(all, address(4), false, at(11s));
    EXPECT_TRUE(place.free);
    EXPECT_EQ(place.evicted, 2u);
}

TEST(ConnectionPlaces, an_address_has_a_share_and_replaces_only_silent_connections_of_the_same_address) {
    const ConnectionPlaces places{8, 2, 0};
    std::vector<Connection> all{
        {address(1), at(0s), true, false}, {address(1), at(0s), true, false}, {address(2), at(0s), false, false}};
    EXPECT_FALSE(places.place_for(all, address(1), false, at(60s)).free);
    all[1].has_sent_frame = false;
    EXPECT_EQ(places.place_for(all, address(1), false, at(60s)).evicted, 1u);
    const auto loopback = IpAddress::v4(127, 0, 0, 1);
    const std::vector<Connection> own{{loopback, at(0s), true, false}, {loopback, at(0s), true, false}};
    EXPECT_TRUE(places.place_for(own, loopback, false, at(0s)).free);
}

TEST(ConnectionPlaces, some_are_reserved_for_trusted_connections) {
    const ConnectionPlaces places{4, 4, 1};
    const std::vector<Connection> all{
        {address(1), at(0s), true, false}, {address(2), at(0s), true, false}, {address(3), at(0s), true, false}};
    EXPECT_FALSE(places.place_for(all, address(4), false, at(0s)).free);
    EXPECT_TRUE(places.place_for(all, address(5), true, at(0s)).free);
}

TEST(ConnectionPlaces, a_silent_trusted_connection_is_replaced_only_by_a_trusted_one) {
    const ConnectionPlaces places{2, 2, 0};
    const std::vector<Connection> all{{address(1), at(0s), true, false}, {address(2), at(0s), false, true}};
    EXPECT_FALSE(places.place_for(all, address(3), false, at(60s)).free);
    EXPECT_EQ(places.place_for(all, address(4), true, at(60s)).evicted, 1u);
}

}    // namespace
}    // namespace connection_places_tests
