// Devices with the oldest libraries, which act on every frame that reaches their port, next to others.
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

namespace old_devices_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

const Bytes take_off = {0x10, 0, 1, 50, 0};

struct OldDevices : testing::Test {
    void start(std::vector<std::string> links, anogate::Duration forget_after = 30s) {
        links.push_back("udp-listen:127.0.0.1:0,name=ground");
        anogate::Settings settings = settings_of_texts(std::move(links));
        settings.gateway.forget_after = forget_after;
        daemon.emplace(std::move(settings));
        send(0xFF, 0xE0, {0, 0, 0});
    }
    void send(std::uint8_t to, std::uint8_t id, const Bytes& data) {
        host.send(daemon->port("ground"), frame(0xFE, to, id, data));
    }
    /// Whether a frame with this id from `source` for which `fits` holds was received since forget().
    template <class Fits>
    bool came(std::uint8_t source, std::uint8_t id, Fits fits) {
        for (const Bytes& f : split(host.heard()).frames)
            if (f[1] == source && f[3] == id && fits(f)) return true;
        return false;
    }
    bool came(std::uint8_t source, std::uint8_t id) {
        return came(source, id, [](const Bytes&) { return true; });
    }
    bool acknowledged(std::uint8_t source, std::uint8_t id) {
        return came(source, 0x00, [&](const Bytes& f) { return f[6] == id; });
    }
    bool is_airborne(std::uint8_t source) {
        return came(source, 0x06, [](const Bytes& f) { return f[7] == 2; });
    }
    bool until_heard(std::uint8_t source) {
        return daemon->until([&] { return came(source, 0x06); });
    }
    std::uint64_t no_route() { return daemon->count("ground", "no_route"); }

    std::optional<RunningGateway> daemon;
    UdpPeer host;
};

// It acts when it is alone, as its link is the only one with devices: it takes off although the command is for another address.
TEST_F(OldDevices, the_simulated_one_acts_on_frames_for_other_addresses) {
    start({"sim:fc,dev_id=1,any_address"});
    ASSERT_TRUE(until_heard(1));
    send(0x44, 0xC0, take_off);
    EXPECT_TRUE(daemon->until([&] { return acknowledged(1, 0xC0) && is_airborne(1); }));
    EXPECT_TRUE(daemon->until([&] {
        return daemon->link("fc").at("hint") == "device 0x01 acts on frames for other addresses: set profile=old on this link";
    }));
    EXPECT_EQ(daemon->link("fc").at("hint_id"), "answers_for_others");
    const auto before = no_route();
    send(0x44, 0xC0, take_off);
    EXPECT_TRUE(daemon->until([&] { return no_route() == before + 1; })) << "now that it is known, it gets no more of them";
}

// The control link is made for the first request to the gateway.
TEST_F(OldDevices, the_only_link_with_devices_is_still_the_only_one_beside_the_control_link) {
    start({"sim:fc,dev_id=1,any_address"});
    ASSERT_TRUE(until_heard(1));
    ASSERT_NE(daemon->gateway().control(), nullptr);
    send(0x44, 0xC0, take_off);
    EXPECT_TRUE(daemon->until([&] { return acknowledged(1, 0xC0); }));
}

TEST_F(OldDevices, a_command_for_an_unknown_address_reaches_none_of_several) {
    start({"sim:fc,dev_id=1,any_address,name=old", "sim:imu"});
    ASSERT_TRUE(until_heard(1));
    ASSERT_TRUE(daemon->until([&] { return came(0xDD, 0x01); }));
    host.forget();
    const auto sent = daemon->count("old", "frames_out");
    send(0x44, 0xC0, take_off);
    send(0x44, 0xE1, {0, 0, 1});
    send(0x44, 0xE0, {0x10, 0xAA, 0});
    ASSERT_TRUE(daemon->until([&] { return no_route() == 3; }));
    EXPECT_EQ(daemon->count("old", "frames_out"), sent);
    EXPECT_EQ(daemon->link("ground").at("hint_id"), "unknown_device");
    EXPECT_EQ(daemon->link("ground").at("hint"),
              "commands and writes to 0x44 are not sent: no link has received a frame from it, and other devices might act on "
              "them; add --route 0x44=LINK");
    send(0x44, 0xE0, {0, 0, 0});
    EXPECT_TRUE(daemon->until([&] { return came(1, 0xE3); })) << "questions are flooded as before";
    send(1, 0xC0, take_off);
    EXPECT_TRUE(daemon->until([&] { return acknowledged(1, 0xC0) && is_airborne(1); })) << "its own";
}

TEST_F(OldDevices, with_their_profile_receive_no_frames_for_other_addresses) {
    start({"sim:fc,dev_id=1,any_address,name=old,profile=old"});
    ASSERT_TRUE(until_heard(1));
    const auto before = no_route();
    send(0x44, 0xC0, take_off);
    ASSERT_TRUE(daemon->until([&] { return no_route() == before + 1; }));
    send(0x44, 0xE0, {0, 0, 0});
    ASSERT_TRUE(daemon->until([&] { return no_route() == before + 2; }));
    send(1, 0xE1, Bytes(100, 0));
    EXPECT_TRUE(daemon->until([&] { return daemon->count("old", "too_big") == 1; }));
    send(1, 0xC0, take_off);
    EXPECT_TRUE(daemon->until([&] { return acknowledged(1, 0xC0); }));
    EXPECT_EQ(daemon->link("old").at("hint"), "");
}

// The device was silent for longer than forget_after; the other device would act in its place.
TEST_F(OldDevices, a_command_for_a_silent_device_is_sent_to_the_link_where_it_was_last_heard) {
    TempDir dir;
    PtyDevice silent{dir / "fc"};
    start({"sim:fc,dev_id=1,any_address,name=old", "serial:" + silent.path() + ",name=silent"}, 1s);
    ASSERT_TRUE(daemon->until_up("silent"));
    silent.write(frame(0x44, 0xFE, 0x06, {0, 0, 0, 0, 0}));
    ASSERT_TRUE(until_heard(0x44));
    ASSERT_TRUE(daemon->until([&] { return daemon->route("0x44").is_null(); })) << "expired";
    silent.heard();
    const auto sent = daemon->count("old", "frames_out");
    const Bytes command = frame(0xFE, 0x44, 0xC0, take_off);
    host.send(daemon->port("ground"), command);
    EXPECT_TRUE(daemon->until([&] {
        const auto frames = split(silent.heard()).frames;
        return std::find(frames.begin(), frames.end(), command) != frames.end();
    }));
    EXPECT_EQ(daemon->count("old", "frames_out"), sent);
}

TEST_F(OldDevices, frames_for_a_host_that_was_never_seen_are_not_sent_to_them) {
    TempDir dir;
    PtyDevice listener{dir / "listener"};
    daemon.emplace(
        settings_of_texts({"sim:imu", "sim:fc,dev_id=1,any_address,name=old", "serial:" + listener.path() + ",name=nobody"}));
    const auto until_more = [&](std::uint64_t count) {
        return daemon->until(
            [&, to = daemon->count("nobody", "frames_out") + count] { return daemon->count("nobody", "frames_out") > to; });
    };
    const auto sum = [&](const char* counter) { return daemon->count("old", counter) + daemon->count("imu", counter); };
    ASSERT_TRUE(daemon->until([&] { return daemon->count("old", "frames_in") > 0 && daemon->count("imu", "frames_in") > 0; }));
    ASSERT_TRUE(daemon->until([&] { return sum("waiting") == 0; }));    // frames of the other that each received
    const auto before = sum("frames_out");
    ASSERT_TRUE(until_more(50));
    EXPECT_EQ(sum("frames_out"), before);
}

}    // namespace
}    // namespace old_devices_tests
