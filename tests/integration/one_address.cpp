// Devices with one address, or none, that send the same bytes; a host and a device with one address.
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <tuple>

namespace one_address_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

std::size_t times(const Bytes& stream, const Bytes& frame) {
    const auto frames = split(stream).frames;
    return static_cast<std::size_t>(std::count(frames.begin(), frames.end(), frame));
}

struct OneAddress : testing::Test {
    /// `from` sends the frame; true: it was forwarded.
    bool send(PtyDevice& from, const std::string& link, const Bytes& bytes) {
        const auto before = daemon->count(link, "bytes_in");
        from.write(bytes);
        return daemon->until([&] { return daemon->count(link, "bytes_in") == before + bytes.size(); });
    }
    TempDir dir;
    PtyDevice one{dir / "one"}, two{dir / "two"};
    UdpPeer host;
    std::optional<RunningGateway> daemon;
};

class OfTwoBoards : public OneAddress, public testing::WithParamInterface<std::uint8_t> {};

TEST_P(OfTwoBoards, identical_frames_are_all_forwarded) {
    const std::uint8_t address = GetParam();
    daemon.emplace(settings_of({serial("one", one.path()), serial("two", two.path()), udp_listen("ground")}));
    ASSERT_TRUE(daemon->until_up("one") && daemon->until_up("two"));
    host.send(daemon->port("ground"), frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    ASSERT_TRUE(daemon->until([&] { return daemon->count("one", "frames_out") == 1; }));
    const Bytes telemetry = frame(address, 0xFE, 0x03, Bytes(7));
    for (int n = 0; n < 20; ++n) {
        ASSERT_TRUE(send(one, "one", telemetry));
        for (int often = 0; often < 3; ++often) ASSERT_TRUE(send(two, "two", telemetry));    // at another rate than the other
    }
    EXPECT_TRUE(daemon->until([&] { return times(host.heard(), telemetry) == 80; })) << times(host.heard(), telemetry);
    EXPECT_EQ(daemon->count("one", "looped") + daemon->count("two", "looped"), 0u);
    const bool is_nobody = address == 0x00 || address == 0xFF;
    for (const char* link : {"one", "two"}) {
        EXPECT_EQ(daemon->link(link).at("hint_id"), is_nobody ? "no_address" : "one_device_on_two_links") << link;
        EXPECT_NE(std::string{daemon->link(link).at("hint")}.find("id"), std::string::npos) << daemon->link(link).at("hint");
    }
    EXPECT_EQ(daemon->status().at("conflicts").empty(), is_nobody);
    EXPECT_TRUE(daemon->counters_add_up());
}
INSTANTIATE_TEST_SUITE_P(Address, OfTwoBoards, testing::Values(0x00, 0x01, 0xFD, 0xFF));

TEST_F(OneAddress, a_board_without_an_address_gets_one_by_an_alias) {
    anogate::Settings settings = settings_of({serial("one", one.path()), serial("two", two.path()), udp_listen("ground")});
    settings.aliases = {{"one", 0xFF, 31}, {"two", 0x00, 32}};
    daemon.emplace(settings);
    ASSERT_TRUE(daemon->until_up("one") && daemon->until_up("two"));
    const Bytes everybody = frame(0xFE, 0xFF, 0xE0, {0, 0, 0});
    host.send(daemon->port("ground"), everybody);
    EXPECT_TRUE(daemon->until([&] { return one.heard() == everybody && two.heard() == everybody; }));
    ASSERT_TRUE(send(one, "one", frame(0xFF, 0xFE, 0x03, Bytes(7))) && send(two, "two", frame(0x00, 0xFE, 0x03, Bytes(7))));
    EXPECT_TRUE(daemon->until([&] {
        return times(host.heard(), frame(31, 0xFE, 0x03, Bytes(7))) == 1 &&
               times(host.heard(), frame(32, 0xFE, 0x03, Bytes(7))) == 1;
    }));
    host.send(daemon->port("ground"), frame(0xFE, 31, 0xC0, {1, 2, 3}));
    host.send(daemon->port("ground"), frame(0xFE, 32, 0xC0, {1, 2, 3}));
    EXPECT_TRUE(daemon->until([&] {
        return times(one.heard(), frame(0xFE, 0xFF, 0xC0, {1, 2, 3})) == 1 &&
               times(two.heard(), frame(0xFE, 0x00, 0xC0, {1, 2, 3})) == 1;
    }));
    EXPECT_EQ(daemon->link("one").at("hint"), "");
}

// The device reads a parameter back after each write with the same bytes as the host. A second device is connected too.
class OfHostAndDevice : public OneAddress, public testing::WithParamInterface<std::tuple<std::uint8_t, bool>> {};

TEST_P(OfHostAndDevice, frames_that_the_device_returns_arrive) {
    const std::uint8_t address = std::get<0>(GetParam());
    const bool device_first = std::get<1>(GetParam());
    PtyDevice ground{dir / "ground"};
    daemon.emplace(settings_of({serial("one", one.path()), serial("two", two.path()), serial("ground", ground.path())}));
    ASSERT_TRUE(daemon->until_up("one") && daemon->until_up("two") && daemon->until_up("ground"));
    ASSERT_TRUE(send(two, "two", frame(0xDD, 0xFE, 0x03, Bytes(7))));
    if (device_first) {
        ASSERT_TRUE(send(one, "one", frame(address, 0xFF, 0x03, Bytes(7))));
    }
    const Bytes write = frame(address, address, 0xE1, {5, 0, 1, 2, 3, 4});
    for (std::size_t n = 1; n <= 10; ++n) {
        ASSERT_TRUE(send(ground, "ground", write));
        ASSERT_TRUE(daemon->until([&] { return times(one.heard(), write) == n; })) << n;
        const Bytes checks{0xE1, write[write.size() - 2], write[write.size() - 1]};
        ASSERT_TRUE(send(one, "one", frame(address, address, 0x00, checks)));
        ASSERT_TRUE(send(one, "one", write));
        ASSERT_TRUE(daemon->until([&] { return times(ground.heard(), write) == n; })) << n;
        ASSERT_TRUE(daemon->until([&] { return times(ground.heard(), frame(address, address, 0x00, checks)) == n; })) << n;
    }
    for (const char* link : {"one", "two", "ground"}) {
        const std::string hint = daemon->link(link).at("hint");
        EXPECT_EQ(hint.find("group"), std::string::npos) << link << ": that would lose the answers: " << hint;
        EXPECT_EQ(daemon->count(link, "looped"), 0u) << link;
    }
}
INSTANTIATE_TEST_SUITE_P(Address, OfHostAndDevice, testing::Combine(testing::Values(0xFE, 0x01, 0x30), testing::Bool()));

}    // namespace
}    // namespace one_address_tests
