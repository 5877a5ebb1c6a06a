// `anoctl top` in a terminal of 80 by 24, which tmux provides.
#include <support/bytes.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace anoctl_top_tests {
namespace {

using namespace support;

class TopInTmux : public testing::Test {
protected:
    void SetUp() override {
        if (std::system("tmux -V > /dev/null 2>&1") != 0) GTEST_SKIP() << "tmux is not installed";
        ASSERT_TRUE(gateway.until_answers()) << gateway.output();
        ASSERT_EQ(tmux("-f /dev/null new-session -d -x 80 -y 24 -s top 'sh'"), 0);
        ASSERT_EQ(tmux("send-keys -t top 'echo before; " ANOCTL " top --control " + socket + "; echo ended as $?' Enter"), 0);
    }
    void TearDown() override { tmux("kill-server"); }

    int tmux(const std::string& words) const {
        return std::system(("TERM=xterm tmux -S " + (dir / "tmux") + " " + words + " 2>/dev/null").c_str());
    }
    std::string screen() const {
        Process capture{"tmux", {"-S", dir / "tmux", "capture-pane", "-p", "-t", "top"}};
        capture.wait();
        return capture.output();
    }
    bool shows(const std::string& words) {
        return wait_until([&] {
            peer.send(gateway.port("peer"), frame(0xDC, 0xFF, 0x03, {1, 2, 3, 4, 5, 6, 7}));
            return screen().find(words) != std::string::npos;
        });
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    UdpPeer peer;
    Daemon gateway{ANOGATED, socket, {peer.link("peer"), "serial:" + (dir / "absent") + ",name=fc"}};
};

TEST_F(TopInTmux, shows_channels_and_addresses_and_restores_the_terminal) {
    EXPECT_TRUE(shows("0xDC flight controller")) << screen();
    EXPECT_TRUE(shows("IN/s")) << screen();
    EXPECT_TRUE(shows("link_down")) << screen();
    EXPECT_EQ(screen().find("before"), std::string::npos) << "it is a screen of its own";
    tmux("send-keys -t top s");
    EXPECT_TRUE(shows("s sort, by in")) << screen();
    tmux("send-keys -t top q");
    EXPECT_TRUE(shows("ended as 0")) << screen();
    EXPECT_TRUE(shows("before"));
    tmux("send-keys -t top 'echo shown' Enter");
    EXPECT_TRUE(shows("echo shown\nshown\n")) << "what is typed is shown again: " << screen();
}

TEST_F(TopInTmux, adapts_to_the_window_size_and_ends_with_the_gateway) {
    EXPECT_TRUE(shows("q quit")) << screen();
    tmux("resize-window -t top -x 40 -y 10");
    EXPECT_TRUE(wait_until([&] {
        const std::string text = screen();
        return text.find("q quit") != std::string::npos && std::count(text.begin(), text.end(), '\n') == 10;
    })) << screen();
    gateway.signal(SIGTERM);
    EXPECT_TRUE(wait_until([&] { return screen().find("ended as 1") != std::string::npos; })) << screen();
    EXPECT_NE(screen().find("anoctl: "), std::string::npos) << screen();
}

TEST_F(TopInTmux, an_interrupt_restores_the_terminal) {
    EXPECT_TRUE(shows("q quit")) << screen();
    tmux("send-keys -t top C-c");
    EXPECT_TRUE(wait_until([&] { return screen().find("ended as 0") != std::string::npos; })) << screen();
}

TEST(AnoctlTop, needs_a_terminal) {
    Process top{ANOCTL, {"top"}};
    EXPECT_EQ(top.wait(), 1);
    EXPECT_EQ(top.output(), "anoctl: top requires a terminal; for a single snapshot: anoctl status\n");
}

}    // namespace
}    // namespace anoctl_top_tests
