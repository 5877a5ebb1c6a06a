// ISO-TP: a V8 frame is one PDU.
#include "can.hpp"

#include <fstream>

namespace anogate::vm {
namespace {

TEST_F(Can, isotp_sends_and_receives_one_frame_per_pdu_with_the_tools) {
    for (const std::string fd : {"", ",fd"}) {
        const std::string tools = fd.empty() ? "" : " -L 72:64:0";
        RunningGateway gateway{loop, {"can:vcan0,framing=isotp,tx=0x7E0,rx=0x7E8" + fd, app.link("app")}};
        ASSERT_TRUE(gateway.up("vcan0")) << gateway.link("vcan0")["error"];
        for (const std::size_t size : {0u, 54u, 300u}) {
            const Bytes sent = frame(0xDC, 0xFE, 0x03, data_of(size));
            std::string text;
            for (const std::uint8_t byte : sent) text += hex({&byte, 1}) + " ";
            Shell sender{"echo " + text + " | isotpsend -s 7E8 -d 7E0" + tools + " vcan0"};
            EXPECT_EQ(received(app, 1), Frames{sent}) << size << fd;

            EXPECT_TRUE(loop.until([&] { return !sender.is_running(); }));
            const auto bound = [] {
                std::ifstream list{"/proc/self/net/can/rcvlist_sff"};
                std::size_t ours = 0;
                for (std::string word; list >> word;) ours += word == "7e0";
                return ours;
            };
            const std::size_t before = bound();
            Shell receiver{"isotprecv -s 7E8 -d 7E0" + tools + " vcan0"};
            EXPECT_TRUE(loop.until([&] { return bound() > before; }));
            const Bytes back = frame(0xFE, 0xDC, 0xB0, data_of(size));
            app.send(gateway.port("app"), back);
            std::string got;
            EXPECT_TRUE(loop.until([&] {
                got += receiver.new_output();
                return got.find('\n') != std::string::npos;
            })) << size
                << fd;
            std::string digits;
            for (const char c : got)
                if (c != ' ' && c != '\n') digits += c;
            EXPECT_EQ(digits, hex(back));
        }
    }
}

TEST_F(Can, isotp_extended_ids_are_29_bit) {
    RunningGateway gateway{loop, {"can:vcan0,framing=isotp,extended,tx=0x18DA10F1,rx=0x18DAF110", app.link("app")}};
    auto bus = dump();
    app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03));
    EXPECT_EQ(dumped(*bus, 1).at(0).substr(0, 13), "18DA10F1#1008");
}

TEST_F(Can, isotp_between_two_gateways_is_in_order_and_complete) {
    UdpPeer far;
    RunningGateway a{loop, {"can:vcan0,framing=isotp,tx=1,rx=2", app.link("app")}};
    RunningGateway b{loop, {"can:vcan0,framing=isotp,tx=2,rx=1", far.link("app")}};
    std::vector<Bytes> sent;
    for (std::uint8_t n = 0; n < 100; ++n) {
        sent.push_back(frame(0xFE, 0xFF, 0xB0, data_of(n * 2u, n)));
        app.send(a.port("app"), sent.back());
    }
    EXPECT_EQ(received(far, sent.size()), sent);
    EXPECT_EQ(a.count("vcan0", "frames_out"), 100u);
}

TEST_F(Can, isotp_refuses_frames_above_4095_bytes) {
    UdpPeer far;
    RunningGateway a{loop, {"can:vcan0,framing=isotp,tx=1,rx=2,max_data=5000", app.link("app") + ",max_data=5000"}};
    RunningGateway b{loop, {"can:vcan0,framing=isotp,tx=2,rx=1,max_data=5000", far.link("app") + ",max_data=5000"}};
    const Bytes largest = frame(0xFE, 0xFF, 0xB0, data_of(4087));
    app.send(a.port("app"), frame(0xFE, 0xFF, 0xB0, data_of(4088)));
    app.send(a.port("app"), largest);
    EXPECT_EQ(received(far, 1), Frames{largest});
    EXPECT_EQ(a.count("vcan0", "too_big"), 1u);
    EXPECT_EQ(a.count("vcan0", "frames_out"), 1u);
}

TEST_F(Can, isotp_without_a_receiver_is_reported_and_blocks_nothing) {
    const auto start = std::chrono::steady_clock::now();
    {
        UdpPeer other;
        RunningGateway gateway{loop, {"can:vcan0,framing=isotp,tx=1,rx=2", app.link("app"), other.link("other")}};
        app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03, data_of(50)));
        EXPECT_EQ(received(other, 1).size(), 1u);
        EXPECT_TRUE(loop.until([&] { return gateway.count("vcan0", "transfer_errors") == 1; }));
        EXPECT_EQ(gateway.link("vcan0")["error"].get<std::string>().find("the peer does not answer"), 0u);
        EXPECT_TRUE(gateway.up("vcan0"));
        app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03, data_of(50)));
        EXPECT_TRUE(loop.until([&] { return gateway.count("vcan0", "frames_out") == 2; }));
        const auto before = std::chrono::steady_clock::now();
        EXPECT_EQ(run("ip link set vcan0 down"), 0);    // in the middle of a transfer
        EXPECT_TRUE(loop.until([&] { return !gateway.up("vcan0"); }));
        loop.turn();
        RecordProperty("ms_to_notice", static_cast<int>((std::chrono::steady_clock::now() - before) / 1ms));
    }
    RecordProperty("ms", static_cast<int>((std::chrono::steady_clock::now() - start) / 1ms));
}

TEST_F(Can, isotp_stays_up_while_many_frames_wait_without_a_receiver) {
    RunningGateway gateway{loop, {"can:vcan0,framing=isotp,tx=1,rx=2", app.link("app")}};
    for (std::uint8_t n = 0; n < 3; ++n) app.send(gateway.port("app"), frame(0xFE, 0xFF, 0xE1, data_of(50, n)));
    bool went_down = false;
    EXPECT_TRUE(loop.until([&] {
        went_down = went_down || !gateway.up("vcan0");
        return gateway.count("vcan0", "transfer_errors") == 3;
    })) << gateway.link("vcan0");
    EXPECT_FALSE(went_down);
    EXPECT_EQ(gateway.count("vcan0", "frames_out"), 3u) << gateway.link("vcan0");
    EXPECT_EQ(gateway.link("vcan0")["error"].get<std::string>().find("the peer does not answer"), 0u);
}

TEST_F(Can, a_kernel_without_isotp_is_reported_and_waited_for) {
    if (!std::getenv("ANOGATE_IN_VM")) GTEST_SKIP() << "unloads a kernel module: only in tests/vm/machine";
    ASSERT_EQ(run("echo 'install can-isotp /bin/false' >/etc/modprobe.d/no-isotp.conf"), 0);
    ASSERT_TRUE(loop.until([] { return run("rmmod can-isotp 2>/dev/null") == 0; })) << "sockets of earlier tests close late";
    UdpPeer other;
    RunningGateway gateway{loop,
                           {"can:vcan0,framing=isotp,tx=1,rx=2", "can:vcan0,name=stream", app.link("app"), other.link("other")}};
    EXPECT_EQ(gateway.link("vcan0")["state"], "waiting");
    EXPECT_EQ(gateway.link("vcan0")["error"], "the kernel has no support for ISO-TP (module can-isotp)");
    EXPECT_TRUE(gateway.up("stream"));
    app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03));
    EXPECT_EQ(received(other, 1).size(), 1u) << "the rest runs";
    ASSERT_EQ(run("rm /etc/modprobe.d/no-isotp.conf && modprobe can-isotp"), 0);
    EXPECT_TRUE(loop.until([&] { return gateway.up("vcan0"); }));
}

}    // namespace
}    // namespace anogate::vm
