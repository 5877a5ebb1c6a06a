#include <anoctl/own_link.hpp>
#include <link/asio.hpp>

#include <support/loop.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <sstream>
#include <string>

namespace {

using namespace anoctl;
using namespace std::chrono_literals;
using support::Bytes;
using support::operator+;

struct Taker final : FrameTaker {
    bool take(ano::FrameView, const Passage&) override { return ++frames < most; }
    bool flush() override { return true; }
    void miss(std::uint64_t, const std::string&, std::string_view) override {}
    int frames = 0, most = 1'000;
};

struct OwnLinks : testing::Test {
    support::Loop loop;
    Taker taker;
    std::ostringstream out, err;
    Streams streams{-1, out, err};
    const Bytes frame = support::frame(0xDC, 0xFE, 0xF1, Bytes(4));
};

TEST_F(OwnLinks, say_once_why_they_wait) {
    const support::TempDir folder;
    OwnLink own{loop.io, link_settings_of("serial:" + (folder / "absent")), taker, streams, "monitor"};
    own.start();
    loop.io.run_for(500ms);    // and it is tried again some times
    own.stop();
    const std::string said = err.str();
    EXPECT_NE(said.find("waiting: "), said.npos);
    EXPECT_EQ(said.find("waiting: "), said.rfind("waiting: ")) << said;
}

TEST_F(OwnLinks, give_no_frame_to_whom_wants_no_more) {
    support::UdpPeer peer;
    OwnLink own{loop.io, link_settings_of(peer.link("peer")), taker, streams, "monitor"};
    taker.most = 1;
    own.start();
    ASSERT_TRUE(loop.until([&] { return own.is_up(); }));
    ASSERT_TRUE(own.send(ano::FrameView{frame}));
    pollfd there{peer.fd(), POLLIN, 0};
    ASSERT_EQ(::poll(&there, 1, 10'000), 1);
    sockaddr_storage from{};
    socklen_t size = sizeof from;
    char room[100];
    ASSERT_EQ(::recvfrom(peer.fd(), room, sizeof room, 0, reinterpret_cast<sockaddr*>(&from), &size),
              static_cast<ssize_t>(frame.size()));
    ASSERT_TRUE(peer.send(anogate::endpoint_of(from), frame + frame));
    ASSERT_TRUE(loop.until([&] { return taker.frames > 0; }));
    EXPECT_EQ(taker.frames, 1);
    own.stop();
}

}    // namespace
