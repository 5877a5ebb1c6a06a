// `anoctl plot-udp` as PlotJuggler receives it.
#include <support/bytes.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <vector>

namespace anoctl_plot_udp_tests {
namespace {

using namespace support;
using nlohmann::json;

const Bytes euler = frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
const Bytes wind = frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});
const Bytes text = frame(0xDC, 0xFF, 0xA0, {1, 'a', 'b'});

class AnoctlPlotUdp : public testing::Test {
protected:
    std::string there() const { return plotter.local().text(); }
    /// Sends `bytes` until something is plotted; returns everything plotted by then.
    template <class Send>
    std::vector<json> plotted(Send send) {
        std::vector<json> all;
        EXPECT_TRUE(wait_until([&] {
            send();
            for (const Bytes& datagram : plotter.datagrams()) all.push_back(json::parse(datagram));
            return !all.empty();
        }));
        return all;
    }

    TempDir dir;
    UdpPeer plotter;
};

TEST_F(AnoctlPlotUdp, sends_the_numbers_in_frames_of_a_gateway_by_link_address_and_message) {
    const std::string socket = dir / "control.sock";
    UdpPeer device, ground;
    Daemon gateway{ANOGATED, socket, {device.link("fc"), ground.link("ground")}};
    ASSERT_TRUE(gateway.until_answers()) << gateway.output();
    Process plot{ANOCTL, {"plot-udp", there(), "--control", socket, "--from", "0xDC"}};
    const auto all = plotted([&] {
        device.send(gateway.port("fc"), wind);
        device.send(gateway.port("fc"), text);
        device.send(gateway.port("fc"), euler);
    });
    for (const json& one : all) {
        EXPECT_EQ(one.size(), 2u) << one;
        EXPECT_GT(one["timestamp"], 1.6e9);
        EXPECT_EQ(one["fc"]["0xDC"].size(), 1u) << one;
        if (one["fc"]["0xDC"].contains("euler")) {
            EXPECT_DOUBLE_EQ(one["fc"]["0xDC"]["euler"]["rol"], 1.23);
        }
        EXPECT_FALSE(one["fc"].contains("0xDD")) << one;
    }
    plot.signal(SIGINT);
    EXPECT_EQ(plot.wait(), 0) << plot.output();
    EXPECT_NE(plot.output().find(" sent to " + there()), std::string::npos) << plot.output();
}

TEST_F(AnoctlPlotUdp, needs_no_gateway_when_it_opens_the_link) {
    PtyDevice device{dir / "tty"};
    Process plot{ANOCTL, {"plot-udp", there(), "serial:" + device.path(), "--id", "euler"}};
    ASSERT_TRUE(plot.until_says(" is up")) << plot.output();
    const auto all = plotted([&] {
        device.write(wind);
        device.write(euler);
    });
    EXPECT_DOUBLE_EQ(all[0][device.path()]["0xDC"]["euler"]["rol"], 1.23) << all[0];
}

/// It ends after the first error, however many frames `device` sends.
void says_once(Process& plot, PtyDevice& device, const std::string& words) {
    EXPECT_TRUE(wait_until([&] {
        device.write(euler);
        return plot.output().find(words) != std::string::npos;
    })) << plot.output();
    for (int i = 0; i < 3; ++i) device.write(euler);
    plot.signal(SIGINT);
    EXPECT_EQ(plot.wait(), 0) << plot.output();
    EXPECT_EQ(plot.output().find(words), plot.output().rfind(words)) << plot.output();
}

TEST_F(AnoctlPlotUdp, reports_once_that_nothing_listens_at_the_target) {
    PtyDevice device{dir / "tty"};
    const std::string nobody = UdpPeer{}.local().text();    // a closed port
    Process plot{ANOCTL, {"plot-udp", nobody, "serial:" + device.path()}};
    ASSERT_TRUE(plot.until_says(" is up")) << plot.output();
    const std::string words = "nothing listens at " + nobody + "; ";
    says_once(plot, device, words);
    EXPECT_NE(plot.output().find(" sent to " + nobody), std::string::npos) << plot.output();
    EXPECT_EQ(plot.output().find(" failed: "), std::string::npos) << plot.output();
}

TEST_F(AnoctlPlotUdp, reports_once_that_no_frame_can_be_sent) {
    PtyDevice device{dir / "tty"};
    const auto cut_off = [] { return ::unshare(CLONE_NEWNET) == 0 || ::unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0; };
    const pid_t child = ::fork();
    if (child == 0) ::_exit(cut_off() ? 0 : 1);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    if (status != 0) GTEST_SKIP() << "no network namespaces here";
    Process plot{ANOCTL, {"plot-udp", "192.0.2.1:9870", "serial:" + device.path()}, {}, [&] { (void)cut_off(); }};
    ASSERT_TRUE(plot.until_says(" is up")) << plot.output();
    const std::string words = "cannot send to 192.0.2.1:9870: ";
    says_once(plot, device, words);
    EXPECT_NE(plot.output().find(" failed: "), std::string::npos) << plot.output();
}

TEST_F(AnoctlPlotUdp, rejects_a_target_that_is_not_an_address) {
    for (const char* wrong : {"localhost:9870", "127.0.0.1", "127.0.0.1:0"}) {
        Process plot{ANOCTL, {"plot-udp", wrong}};
        EXPECT_EQ(plot.wait(), 2);
        EXPECT_NE(plot.output().find("is not an IP address and a port"), std::string::npos) << plot.output();
    }
}

}    // namespace
}    // namespace anoctl_plot_udp_tests
