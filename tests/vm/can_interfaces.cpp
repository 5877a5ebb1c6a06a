// The state that an interface reports, and interfaces that are down, absent, or not CAN.
#include "can.hpp"

#include <fstream>
#include <thread>

namespace anogate::vm {
namespace {

TEST_F(Can, frames_dropped_by_the_kernel_are_in_the_status) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    BusSocket bus{"vcan0"};
    for (int i = 0; i < 20000; ++i) bus.send(frame(0xDC, 0xFE, 0x03));    // the gateway's loop stalls
    EXPECT_GT(gateway.count("vcan0", "kernel_drops"), 0u);
    received(app, 20000 - gateway.count("vcan0", "kernel_drops"), 60s);
    EXPECT_EQ(gateway.count("vcan0", "kernel_drops") + gateway.count("vcan0", "frames_in"), 20000u);
}

TEST_F(Can, error_frames_are_in_the_status_with_their_times) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    EXPECT_EQ(gateway.link("vcan0")["bus"], "error-active");
    const auto bus_becomes = [&](const char* error, const char* state) {
        EXPECT_EQ(run(std::string{"cansend vcan0 "} + error), 0);
        EXPECT_TRUE(loop.until([&] { return gateway.link("vcan0")["bus"] == state; })) << state;
    };
    bus_becomes("20000004#0008000000000000", "error-warning");
    EXPECT_NE(gateway.link("vcan0")["error"], "");
    bus_becomes("20000004#0020000000000000", "error-passive");
    bus_becomes("20000040#0000000000000000", "bus-off");
    bus_becomes("20000100#0000000000000000", "error-active");
    const auto link = gateway.link("vcan0");
    for (const char* event : {"error_warning", "error_passive", "bus_off", "restarted"}) {
        EXPECT_EQ(link[event], 1) << event;
        EXPECT_LE(link[std::string{event} + "_s"], 60) << event;
    }
    EXPECT_EQ(link["state"], "up");
    EXPECT_EQ(link["error"], "");
}

TEST_F(Can, error_frames_are_counted_by_kind) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    // TX timeout; arbitration lost; protocol violation with a bus error; transceiver; no acknowledgement, twice.
    for (const char* error : {"20000001", "20000002", "20000088", "20000010", "20000020", "20000020"})
        EXPECT_EQ(run(std::string{"cansend vcan0 "} + error + "#0000000000000000"), 0);
    EXPECT_TRUE(loop.until([&] { return gateway.link("vcan0")["error_frames"] == 6; }));
    const auto link = gateway.link("vcan0");
    for (const char* kind :
         {"errors_tx_timeout", "errors_lost_arbitration", "errors_protocol", "errors_transceiver", "errors_bus"})
        EXPECT_EQ(link[kind], 1) << kind;
    EXPECT_EQ(link["errors_no_ack"], 2);
    EXPECT_EQ(link["bus"], "error-active");
}

TEST_F(Can, a_bus_off_is_shown_with_a_remedy_and_ends_when_a_frame_is_received) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    EXPECT_EQ(run("cansend vcan0 20000004#0020000000000000"), 0);
    EXPECT_TRUE(loop.until([&] { return gateway.link("vcan0")["bus"] == "error-passive"; }));
    EXPECT_NE(gateway.link("vcan0")["error"].get<std::string>().find("termination"), std::string::npos);
    EXPECT_EQ(run("cansend vcan0 20000040#0000000000000000"), 0);
    EXPECT_TRUE(loop.until([&] { return gateway.link("vcan0")["bus"] == "bus-off"; }));
    const std::string error = gateway.link("vcan0")["error"];
    EXPECT_NE(error.find("restart-ms"), std::string::npos) << error;
    EXPECT_NE(error.find("termination"), std::string::npos) << error;
    BusSocket{"vcan0"}.send(frame(0xDC, 0xFE, 0x03));
    EXPECT_EQ(received(app, 1).size(), 1u);
    EXPECT_EQ(gateway.link("vcan0")["bus"], "error-active");
    EXPECT_EQ(gateway.link("vcan0")["error"], "");
}

// A vxcan whose other end is down has no carrier, like a controller in bus-off.
TEST_F(Can, a_bus_that_recovers_is_used_at_once) {
    if (run("ip link add dev vxcan0 type vxcan peer name vxcan1 2>/dev/null") != 0) GTEST_SKIP() << "no vxcan";
    ASSERT_EQ(run("ip link set vxcan0 up && ip link set vxcan1 up"), 0);
    {
        RunningGateway gateway{loop, {"can:vxcan0", app.link("app")}};
        ASSERT_TRUE(loop.until([&] { return gateway.up("vxcan0"); }));
        // It is read when the carrier is lost; an interface without carrier delivers nothing.
        ASSERT_EQ(run("cansend vxcan0 20000040#0000000000000000 && ip link set vxcan1 down"), 0);
        EXPECT_TRUE(loop.until([&] { return !gateway.up("vxcan0"); }));
        EXPECT_NE(gateway.link("vxcan0")["error"].get<std::string>().find("restart-ms"), std::string::npos);
        loop.until([] { return false; }, 3s);    // until the pauses between attempts are the longest
        ASSERT_EQ(run("ip link set vxcan1 up; cansend vxcan0 20000100#0000000000000000"), 0);
        EXPECT_TRUE(loop.until([&] { return gateway.up("vxcan0"); }));
        BusSocket{"vxcan1"}.send(frame(0xDC, 0xFE, 0x03));
        EXPECT_EQ(received(app, 1).size(), 1u);
    }
    run("ip link del vxcan0");
}

TEST_F(Can, an_interface_can_be_down_or_absent_and_return_and_nothing_else_is_disturbed) {
    UdpPeer other;
    RunningGateway gateway{loop, {"can:vcan0,fd", app.link("app"), other.link("other")}};
    const auto passes = [&] {
        BusSocket bus{"vcan0"};
        CanSettings can;
        can.fd = true;
        bus.send(frame(0xDC, 0xFE, 0x03), can);
        return received(app, 1).size() == 1;
    };
    const auto waits_for = [&](const char* change, const char* why) {
        EXPECT_EQ(run(change), 0);
        EXPECT_TRUE(loop.until([&] {
            return !gateway.up("vcan0") && gateway.link("vcan0")["error"].get<std::string>().find(why) == 0;
        })) << why;
        other.send(gateway.port("other"), frame(0x05, 0xFE, 0x03));
        EXPECT_EQ(received(app, 1).size(), 1u);
        const auto refused = gateway.count("vcan0", "link_down");
        app.send(gateway.port("app"), frame(0xFE, 0xDC, 0x03));    // for the link that is down: counted there
        EXPECT_TRUE(loop.until([&] { return gateway.count("vcan0", "link_down") == refused + 1; }));
    };
    const auto comes_back = [&](const char* change) {
        EXPECT_EQ(run(change), 0);
        EXPECT_TRUE(loop.until([&] { return gateway.up("vcan0"); }, 10s));
        EXPECT_TRUE(passes());
    };
    ASSERT_TRUE(passes());
    waits_for("ip link set vcan0 down", "vcan0 is down");
    comes_back("ip link set vcan0 up");
    waits_for("ip link del vcan0", "network interface vcan0 not found");
    waits_for("ip link add dev vcan0 type vcan && ip link set vcan0 mtu 16 up", "vcan0 is not set up for CAN FD");
    waits_for("ip link set vcan0 down", "vcan0 is down");
    comes_back("ip link set vcan0 mtu 72 up");
    EXPECT_EQ(gateway.count("vcan0", "link_down"), 4u);
}

TEST_F(Can, an_interface_that_is_not_can_is_rejected_with_an_explanation) {
    RunningGateway gateway{loop, {"can:lo", app.link("app")}};
    EXPECT_EQ(gateway.link("lo")["error"], "lo is not a CAN interface");
}

TEST_F(Can, absent_interfaces_cost_few_wake_ups) {
    Shell daemon{std::string{"exec "} + ANOGATED +
                 " --control none --log-level error can:nocan0 can:nocan1,fd can:nocan2,framing=isotp,tx=1,rx=2"};
    const auto wake_ups = [&] {
        std::ifstream status{"/proc/" + std::to_string(daemon.pid()) + "/status"};
        for (std::string word; status >> word;)
            if (word == "voluntary_ctxt_switches:") return status >> word, std::stoi(word);
        return -1;
    };
    std::this_thread::sleep_for(5s);    // after the first, shorter pauses
    const int before = wake_ups();
    std::this_thread::sleep_for(5s);
    EXPECT_GE(before, 0);
    EXPECT_LE(wake_ups() - before, 15);
}

}    // namespace
}    // namespace anogate::vm
