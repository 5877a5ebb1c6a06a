// A bus that accepts less than it is offered, and a bus between gateways.
#include "can.hpp"
#include "can_rate.hpp"

#include <fstream>
#include <numeric>

namespace anogate::vm {
namespace {

TEST_F(Can, a_full_queue_never_cuts_a_frame) {
    ASSERT_EQ(run("ip link set vcan0 txqueuelen 4"), 0);
    ASSERT_EQ(run("tc qdisc add dev vcan0 root tbf rate 400kbit burst 200 limit 400"), 0);    // a slow bus
    UdpPeer far;
    RunningGateway gateway{loop, {"can:vcan0,name=near", app.link("app")}};
    RunningGateway there{loop, {"can:vcan0,name=far", far.link("app")}};
    Shell beside{"cangen vcan0 -g 1 -i -I 123 -L 8"};    // fills the queue too: ENOBUFS
    for (std::uint8_t n = 0; n < 200; ++n) {
        for (int k = 0; k < 5; ++k) app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03, data_of(60, n)));
        loop.turn();
    }
    EXPECT_TRUE(loop.until([&] { return gateway.count("near", "waiting") == 0; }, 60s));
    beside.end();
    const std::uint64_t out = gateway.count("near", "frames_out");
    EXPECT_GT(out, 20u);
    EXPECT_TRUE(loop.until([&] { return there.count("far", "frames_in") == out; }));
    EXPECT_EQ(there.count("far", "frames_in"), out);
    EXPECT_EQ(there.count("far", "skipped_bytes"), 0u);
}

TEST_F(Can, a_frame_interrupted_by_the_loss_of_the_bus_is_dropped_completely) {
    ASSERT_EQ(run("tc qdisc add dev vcan0 root tbf rate 100kbit burst 200 limit 400"), 0);
    UdpPeer far;
    RunningGateway near{loop, {"can:vcan0,max_data=5000", app.link("app") + ",max_data=5000"}};
    RunningGateway there{loop, {"can:vcan0,max_data=5000", far.link("app")}};
    app.send(near.port("app"), frame(0xFE, 0xFF, 0xB0, data_of(5000)));
    ASSERT_TRUE(loop.until([&] { return there.count("vcan0", "bytes_in") > 100; }));
    ASSERT_EQ(run("ip link set vcan0 down"), 0);
    EXPECT_TRUE(loop.until([&] { return !near.up("vcan0") && !there.up("vcan0"); }));
    EXPECT_EQ(near.count("vcan0", "link_down"), 1u) << near.link("vcan0");
    EXPECT_EQ(near.count("vcan0", "frames_out"), 0u);
    ASSERT_EQ(run("ip link set vcan0 up"), 0);
    EXPECT_TRUE(loop.until([&] { return near.up("vcan0") && there.up("vcan0"); }));
    const Bytes next = frame(0x11, 0xFF, 0x03, data_of(17));
    app.send(near.port("app"), next);
    EXPECT_EQ(received(far, 1), Frames{next});
    EXPECT_EQ(there.count("vcan0", "wrong_source"), 0u);
    EXPECT_EQ(there.count("vcan0", "frames_in"), 1u);
}

// A slow bus that another program keeps full; images wait, with commands among them.
TEST_F(Can, urgent_frames_are_sent_first_on_a_saturated_bus) {
    ASSERT_EQ(run("ip link set vcan0 txqueuelen 4"), 0);
    ASSERT_EQ(run("tc qdisc add dev vcan0 root tbf rate 400kbit burst 200 limit 400"), 0);
    UdpPeer far;
    RunningGateway near{loop, {"can:vcan0,queue=65536", app.link("app")}};
    RunningGateway there{loop, {"can:vcan0", far.link("app")}};
    Shell beside{"cangen vcan0 -g 1 -i -I 123 -L 8"};
    for (std::uint8_t n = 0; n < 200; ++n) app.send(near.port("app"), frame(0xDF, 0xFF, 0xB0, data_of(200, n)));
    EXPECT_TRUE(loop.until([&] { return near.count("vcan0", "waiting") > 100; }));
    app.send(near.port("app"), frame(0xFE, 0xFF, 0xC0, data_of(11)));
    std::size_t images = 0;
    bool commanded = false;
    loop.until(
        [&] {
            for (const Bytes& f : far.frames()) {
                if (f[3] == 0xC0) commanded = true;
                else if (!commanded) ++images;
            }
            return commanded;
        },
        60s);
    EXPECT_TRUE(commanded);
    EXPECT_GT(near.count("vcan0", "waiting"), 100u) << images << " images came before it";
}

TEST_F(Can, two_gateways_forward_frames_over_one_bus) {
    for (const std::string options : {"", ",fd", ",extended", ",fd,extended"}) {
        UdpPeer far;
        RunningGateway a{loop, {"can:vcan0" + options, app.link("app")}};
        RunningGateway b{loop, {"can:vcan0" + options, far.link("app")}};
        const Bytes there = frame(0xFE, 0xDC, 0xC0, data_of(11)), back = frame(0xDC, 0xFE, 0xB0, data_of(200));
        app.send(a.port("app"), there);
        EXPECT_EQ(received(far, 1), Frames{there});
        far.send(b.port("app"), back);
        EXPECT_EQ(received(app, 1), Frames{back});
        app.send(a.port("app"), frame(0xFE, 0xFF, 0x03));    // a broadcast: sent once, without a loop
        EXPECT_EQ(received(far, 1).size(), 1u);
        EXPECT_EQ(a.count("vcan0", "frames_in"), 1u);
        EXPECT_EQ(b.count("vcan0", "frames_in"), 2u);
    }
}

TEST_F(Can, frames_pass_from_pty_to_can_to_udp_and_back) {
    const std::string path = testing::TempDir() + "can-test-pty";
    UdpPeer far;
    RunningGateway a{loop, {"can:vcan0", "pty:" + path + ",name=pty"}};
    RunningGateway b{loop, {"can:vcan0", far.link("app")}};
    const int pty = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(pty, 0);
    const Bytes there = frame(0xDC, 0xFF, 0xA0, data_of(100)), back = frame(0xFE, 0xDC, 0xE1, data_of(6));
    EXPECT_EQ(::write(pty, there.data(), there.size()), static_cast<ssize_t>(there.size()));
    EXPECT_EQ(received(far, 1), Frames{there});
    far.send(b.port("app"), back);
    Bytes got(200);
    std::size_t size = 0;
    EXPECT_TRUE(loop.until([&] {
        const ssize_t n = ::read(pty, got.data() + size, got.size() - size);
        if (n > 0) size += static_cast<std::size_t>(n);
        return size >= back.size();
    }));
    got.resize(size);
    EXPECT_EQ(got, back);
    ::close(pty);
}

// The table of src/link/README.md is based on these counts.
TEST_F(Can, the_bus_carries_as_many_frames_and_bytes_as_computed) {
    for (const bool fd : {false, true}) {
        for (const bool isotp : {false, true}) {
            const std::string options = std::string{fd ? ",fd" : ""} + (isotp ? ",framing=isotp" : "");
            UdpPeer far;
            RunningGateway a{loop, {"can:vcan0" + options + (isotp ? ",tx=1,rx=2" : ""), app.link("app")}};
            RunningGateway b{loop, {"can:vcan0" + options + (isotp ? ",tx=2,rx=1" : ""), far.link("app")}};
            for (const std::size_t size : {0u, 4u, 13u, 50u, 54u, 55u, 200u}) {
                const auto counted = [] {
                    std::array<std::uint64_t, 2> counts{};    // frames and bytes of vcan0
                    std::ifstream list{"/proc/self/net/dev"};
                    for (std::string word; list >> word;)
                        if (word == "vcan0:") list >> counts[1] >> counts[0];
                    return counts;
                };
                const auto before = counted();
                app.send(a.port("app"), frame(0xFE, 0xFF, 0xB0, data_of(size)));
                EXPECT_EQ(received(far, 1).size(), 1u);
                const auto after = counted();
                const auto sizes = isotp ? can_rate::isotp(size + 8, fd) : can_rate::stream(size + 8, fd);
                EXPECT_EQ(after[0] - before[0], sizes.size()) << size << options;
                EXPECT_EQ(after[1] - before[1], std::accumulate(sizes.begin(), sizes.end(), std::size_t{0})) << size << options;
            }
        }
    }
}

// Senders with a window of frames in flight: UDP to A, CAN to B, UDP to the far app. The frames of each sender stay in order;
// between senders of one class the outbox takes turns.
TEST_F(Can, a_hundred_thousand_frames_arrive_without_a_loss_or_change) {
    UdpPeer far;
    RunningGateway a{loop, {"can:vcan0,fd", app.link("app")}};
    RunningGateway b{loop, {"can:vcan0,fd", far.link("app")}};
    const std::uint16_t to = a.port("app");
    constexpr std::uint32_t all = 100'000, window = 200, senders = 20;
    std::uint32_t sent = 0, got = 0;
    const auto made = [](std::uint32_t n) {
        Bytes data(4 + n % 90);
        for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(n >> (8 * (i % 4)));
        return frame(static_cast<std::uint8_t>(1 + n % senders), 0xFF, 0xB0, data);
    };
    std::array<std::uint32_t, senders> next{};    // of each sender: the next expected frame
    std::iota(next.begin(), next.end(), 0u);
    const auto arrived = [&](const Bytes& f) {
        const std::uint32_t sender = f.at(1) - 1u;
        ASSERT_LT(sender, senders);
        EXPECT_EQ(f, made(next[sender]));
        next[sender] += senders;
        ++got;
    };
    const bool done = loop.until(
        [&] {
            for (; sent < all && sent - got < window; ++sent) app.send(to, made(sent));
            for (const Bytes& f : far.frames()) arrived(f);
            return got >= all || testing::Test::HasFailure();
        },
        400s);
    EXPECT_TRUE(done) << "sent " << sent << ", got " << got;
    EXPECT_EQ(b.count("vcan0", "frames_in"), all);
    EXPECT_EQ(b.count("vcan0", "skipped_bytes"), 0u);
    EXPECT_EQ(b.count("vcan0", "kernel_drops"), 0u);
}

}    // namespace
}    // namespace anogate::vm
