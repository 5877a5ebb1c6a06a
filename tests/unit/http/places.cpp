#include <http/places.hpp>
#include <http/request.hpp>

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace anogate::http::places_tests {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t places = 32;
constexpr std::uint32_t alice = 1000, bob = 1001;

ClientConnection by(std::uint64_t client, Asking asking, int second = 1) {
    return {{unknown_user, client}, asking, ano::TimePoint{} + std::chrono::seconds{second}};
}
ClientConnection with(ClientConnection connection, std::optional<Access> may) {
    connection.may = may;
    return connection;
}
ClientConnection views(std::uint64_t client, int second = 1) { return with(by(client, Asking::whole, second), Access::view); }
ClientConnection controls(std::uint64_t client, int second = 1) {
    return with(by(client, Asking::whole, second), Access::control);
}
ClientConnection idle(std::uint64_t client, int second) { return by(client, Asking::nothing, second); }
ClientConnection half(std::uint64_t client, int second) { return by(client, Asking::half, second); }
ClientConnection unheard(std::uint64_t client, int second) { return by(client, Asking::unheard, second); }

std::vector<ClientConnection> fill(std::vector<ClientConnection> connections, ClientConnection rest) {
    connections.resize(places, rest);
    return connections;
}

TEST(Places, close_the_connection_of_a_client_that_is_idle_the_longest) {
    EXPECT_EQ(next_evicted(fill({idle(1, 9), views(1), idle(1, 3)}, idle(1, 5))), 2u);
}

TEST(Places, close_an_incomplete_request_before_a_connection_without_data) {
    EXPECT_EQ(next_evicted(fill({unheard(1, 1), views(1), half(1, 3), half(1, 2)}, half(1, 5))), 3u);
    EXPECT_EQ(next_evicted(fill({unheard(1, 2), half(1, 9)}, views(1))), 1u);
    EXPECT_EQ(next_evicted(fill({unheard(1, 2), unheard(1, 1)}, views(1))), 1u) << "and then he does";
}

TEST(Places, keep_a_new_connection_open_for_a_moment) {
    std::vector<ClientConnection> connections = fill({unheard(1, 7), unheard(1, 6)}, controls(1));
    EXPECT_EQ(next_evicted(connections, ano::TimePoint{7s}), 1u);
    EXPECT_EQ(next_evicted(connections, ano::TimePoint{6s}), std::nullopt);
    connections[9] = half(2, 8);
    EXPECT_EQ(next_evicted(connections, ano::TimePoint{6s}), 9u) << "others do not";
    connections[9] = views(2);
    EXPECT_EQ(next_evicted(connections, ano::TimePoint{6s}), 9u);
}

TEST(Places, close_a_connection_of_the_more_frequent_kind_of_the_client) {
    EXPECT_EQ(next_evicted(fill({idle(1, 1), half(1, 2), views(1)}, half(1, 3))), 1u) << "who floods by halves";
    EXPECT_EQ(next_evicted(fill({half(1, 1), idle(1, 2), views(1)}, idle(1, 3))), 1u) << "who floods and is silent";
    EXPECT_EQ(next_evicted(fill({half(1, 1), idle(1, 2)}, views(1))), 1u);
    EXPECT_EQ(next_evicted(fill({half(2, 1), idle(1, 3), idle(1, 2)}, views(1))), 2u) << "others' are not counted";
}

// The head of a request was received but not its body, while many silent connections of the same address are opened.
TEST(Places, keep_an_incomplete_request_open_among_many_connections_without_data) {
    EXPECT_EQ(next_evicted(fill({half(1, 1), idle(1, 1)}, unheard(1, 3))), 2u);
}

TEST(Places, close_connections_with_a_token_after_those_with_only_its_address) {
    ClientConnection silent = with(unheard(1, 5), Access::control);
    silent.by_address = true;
    EXPECT_EQ(next_evicted(fill({with(half(1, 1), Access::control), with(idle(1, 1), Access::control)}, silent)), 2u);
}

TEST(Places, close_idle_connections_first_and_those_of_the_client_with_most_before_others) {
    std::vector<ClientConnection> connections = fill({idle(2, 1)}, views(1));
    EXPECT_EQ(next_evicted(connections), 0u);
    connections[5] = idle(3, 4);
    connections[6] = idle(3, 3);
    EXPECT_EQ(next_evicted(connections), 6u);
    connections[6].may = Access::control;
    connections[7] = unheard(3, 9);
    EXPECT_EQ(next_evicted(connections), 5u);
    connections[5] = connections[0] = connections[7] = connections[8];
    EXPECT_EQ(next_evicted(connections), 6u) << "who may control is the last of them";
}

// The rule: as long as a client without control rights holds a place, every new client gets one.
TEST(Places, close_a_complete_request_only_if_it_has_no_control_rights) {
    std::vector<ClientConnection> connections;
    for (std::uint64_t client = 0; client < places; ++client)
        connections.push_back(views(client, 100 - static_cast<int>(client)));
    EXPECT_NE(next_evicted(connections), std::nullopt) << "though nobody has more than another";
    connections[9] = views(4, 200);
    EXPECT_EQ(next_evicted(connections), 4u) << "first of the client that has most: the oldest";
    connections = fill({}, controls(1));
    EXPECT_EQ(next_evicted(connections), std::nullopt);
    connections[7] = with(by(2, Asking::whole), Access::open);
    EXPECT_EQ(next_evicted(connections), 7u);
}

TEST(Places, close_a_request_with_control_rights_only_if_its_response_takes_long) {
    std::vector<ClientConnection> connections = fill({}, controls(1));
    connections[3] = controls(2, 5);
    connections[3].lasts = true;
    EXPECT_EQ(next_evicted(connections), 3u);
    connections[8] = views(3);
    EXPECT_EQ(next_evicted(connections), 8u);
    connections[8] = idle(3, 9);
    connections[8].lasts = true;
    EXPECT_EQ(next_evicted(connections), 8u);
}

TEST(Places, identify_a_client_by_its_ipv4_address_or_the_first_half_of_its_ipv6_address) {
    const auto client_at = [](const std::string& peer) {
        ConnectionInfo connection_info;
        connection_info.is_network = true;
        connection_info.peer = peer;
        const ClientId client_id = client_id_of(unknown_user, connection_info);
        EXPECT_EQ(client_id.user, unknown_user);
        return client_id.client;
    };
    EXPECT_NE(client_at("192.168.1.5"), client_at("192.168.1.6"));
    EXPECT_EQ(client_at("fd00::1"), client_at("fd00::2:3:4:5"));
    EXPECT_EQ(client_at("fe80::1%eth0"), client_at("fe80::2%eth0"));
    EXPECT_NE(client_at("fd00::1"), client_at("fd00:0:0:1::1"));
    EXPECT_EQ(client_id_of(alice, ConnectionInfo{}).user, alice);
    EXPECT_EQ(client_id_of(alice, ConnectionInfo{}).client, client_id_of(bob, ConnectionInfo{}).client);
}

TEST(Places, reserve_one_in_eight_for_clients_with_control_rights) {
    std::vector<ClientConnection> connections;
    for (std::uint64_t client = 0; client < 28; ++client) connections.push_back(views(client));
    const ClientId last{unknown_user, 27}, next{unknown_user, 28};
    EXPECT_TRUE(request_place(connections, places, last, Access::view).is_free);
    connections.push_back(views(28));
    EXPECT_FALSE(request_place(connections, places, next, Access::view).is_free) << "nobody has more";
    EXPECT_FALSE(request_place(connections, places, next, Access::open).is_free);
    EXPECT_TRUE(request_place(connections, places, next, Access::control).is_free);
    for (const Asking asking : {Asking::nothing, Asking::half, Asking::unheard}) {
        connections[0].asking = asking;
        EXPECT_TRUE(request_place(connections, places, next, Access::view).is_free) << "this one gives way";
    }
    connections[0] = controls(0);
    EXPECT_TRUE(request_place(connections, places, next, Access::view).is_free);
    EXPECT_TRUE(request_place({connections.data() + 1, 7}, 7, next, Access::open).is_free) << "of so few none";
}

TEST(Places, share_the_remaining_quota_equally_among_clients) {
    std::vector<ClientConnection> connections(28, views(1, 5));
    connections[4].since -= 2s;
    connections.push_back(views(2));
    PlaceFor place = request_place(connections, places, {unknown_user, 2}, Access::view);
    EXPECT_TRUE(place.is_free);
    EXPECT_EQ(place.leaves, 4u);
    EXPECT_FALSE(request_place(connections, places, {unknown_user, 1}, Access::view).is_free) << "who has most gets no more";
    for (std::size_t i = 10; i < 24; ++i) connections[i] = views(2);
    EXPECT_FALSE(request_place(connections, places, {unknown_user, 2}, Access::view).is_free) << "15 of 29";
    place = request_place(connections, places, {unknown_user, 3}, Access::view);
    EXPECT_TRUE(place.is_free && place.leaves);
}

}    // namespace
}    // namespace anogate::http::places_tests
