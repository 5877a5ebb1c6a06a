#include <runtime/restart_state.hpp>

#include <gtest/gtest.h>

namespace anogate::stored_state_tests {
namespace {

using namespace std::chrono_literals;

const ClockReading now{ano::TimePoint{1h}, 2h, 490'000h};

RestartState sample() {
    RestartState state{{now.now - 1s, now.boot - 1s, now.real - 1s}};
    RestartState::OfLink& link = state.links.emplace_back();
    link.name = "ground \xE5\x9C\xB0 \"1\"";
    link.link.rest = {0xAB, 0xFE};
    link.link.peers.push_back({*Endpoint::parse("192.168.1.20:5000"), {now.now - 2s, true, false}, true});
    link.link.peers.push_back({*Endpoint::parse("[2001:db8::1]:6"), {now.now - 3s, false, true}, false});
    link.wire = {7, std::uint64_t{1} << 60};
    link.channels.push_back({"192.168.1.20:5000", {{0xFE, now.now - 2s}, {0xDC, now.now - 4s}}, {0xDD}});
    link.brought = {{~std::uint64_t{0}, true, now.now - 1500ms}, {5, false, now.now - 2s}};
    state.links.push_back({"empty"});
    return state;
}

TEST(RestartState, is_read_as_it_was_written) {
    const RestartState state = sample();
    const auto read = parse_restart_state(to_string(state), now);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->unread_since.now, state.unread_since.now);
    EXPECT_EQ(read->unread_since.boot, state.unread_since.boot);
    EXPECT_EQ(read->unread_since.real, state.unread_since.real);
    ASSERT_EQ(read->links.size(), 2u);
    const RestartState::OfLink &one = read->links[0], &was = state.links[0];
    EXPECT_EQ(one.name, was.name);
    EXPECT_EQ(one.link.rest, was.link.rest);
    EXPECT_EQ(one.link.unread_since.now, state.unread_since.now);
    ASSERT_EQ(one.link.peers.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(one.link.peers[i].endpoint, was.link.peers[i].endpoint);
        EXPECT_EQ(one.link.peers[i].memory.heard_at, was.link.peers[i].memory.heard_at);
        EXPECT_EQ(one.link.peers[i].memory.is_host, was.link.peers[i].memory.is_host);
        EXPECT_EQ(one.link.peers[i].memory.has_returned, was.link.peers[i].memory.has_returned);
        EXPECT_EQ(one.link.peers[i].is_proven, was.link.peers[i].is_proven);
    }
    ASSERT_EQ(one.channels.size(), 1u);
    EXPECT_EQ(one.channels[0].peer, "192.168.1.20:5000");
    ASSERT_EQ(one.channels[0].addresses.size(), 2u);
    EXPECT_EQ(one.channels[0].addresses[1].address, 0xDC);
    EXPECT_EQ(one.channels[0].addresses[1].heard_at, now.now - 4s);
    EXPECT_EQ(one.channels[0].first, std::vector<std::uint8_t>{0xDD});
    EXPECT_EQ(one.wire, was.wire);
    ASSERT_EQ(one.brought.size(), 2u);
    EXPECT_EQ(one.brought[0].key, ~std::uint64_t{0});
    EXPECT_TRUE(one.brought[0].repeats);
    EXPECT_FALSE(one.brought[1].repeats);
    EXPECT_EQ(one.brought[1].at, now.now - 2s);
    EXPECT_EQ(read->links[1].name, "empty");
}

TEST(RestartState, of_another_boot_is_not_used) {
    EXPECT_FALSE(parse_restart_state(to_string(sample()), {now.now - 2s, now.boot, now.real})) << "the machine was started since";
    EXPECT_FALSE(parse_restart_state(to_string(sample()), {now.now, now.boot - 2s, now.real}));
    EXPECT_TRUE(parse_restart_state(to_string(sample()), {now.now, now.boot, now.real - 1h})) << "somebody set the clock";
}

TEST(RestartState, limits_times_in_the_future_to_now) {
    RestartState state = sample();
    state.links[0].link.peers[0].memory.heard_at = now.now + 1h;
    state.links[0].channels[0].addresses[0].heard_at = now.now + 1h;
    state.links[0].brought[0].at = now.now + 1h;
    const auto read = parse_restart_state(to_string(state), now);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->links[0].link.peers[0].memory.heard_at, now.now);
    EXPECT_EQ(read->links[0].channels[0].addresses[0].heard_at, now.now);
    EXPECT_EQ(read->links[0].brought[0].at, now.now);
}

TEST(RestartState, is_older_by_the_time_that_the_machine_was_suspended) {
    const auto read = parse_restart_state(to_string(sample()), {now.now, now.boot + 1h, now.real + 1h});
    ASSERT_TRUE(read);
    EXPECT_EQ(read->links[0].link.peers[0].memory.heard_at, now.now - 2s - 1h);
    EXPECT_EQ(read->links[0].channels[0].addresses[1].heard_at, now.now - 4s - 1h);
    EXPECT_EQ(read->links[0].brought[1].at, now.now - 2s - 1h);
}

TEST(RestartState, that_is_damaged_is_not_used) {
    const std::string whole = to_string(sample());
    for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(parse_restart_state(whole.substr(0, size), now)) << size;
    for (const char* text :
         {"[]", "{}", "7", R"({"format": 1, "unread_since": [0, 0, 0], "links": []})",
          R"({"format": 2, "unread_since": "x", "links": []})", R"({"format": 2, "unread_since": [0, 0, 0], "links": [7]})"})
        EXPECT_FALSE(parse_restart_state(text, now)) << text;
}

}    // namespace
}    // namespace anogate::stored_state_tests
