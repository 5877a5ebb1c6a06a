#include <anoctl/own_link.hpp>
#include <sys/asio.hpp>

#include <support/loop.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <sstream>
#include <string>

namespace own_link_tests {
namespace {

using namespace anoctl;
using namespace std::chrono_literals;
using support::Bytes;
using support::operator+;

struct Taker final : FrameReceiver {
    bool accept(ano::FrameView, const Passage&) override { return ++frames < most; }
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

    bool until_said(const std::string& words) {
        return loop.until([&] { return err.str().find(words) != std::string::npos; });
    }
};

/// The socket of the link at `peer`: `own` sends a frame from it.
anogate::Endpoint reached_from(OwnLink& own, support::UdpPeer& peer, support::Loop& loop, const Bytes& frame) {
    loop.until([&] { return own.is_up(); });
    EXPECT_TRUE(own.send(ano::FrameView{frame}));
    EXPECT_TRUE(loop.until([&] { return !peer.heard().empty(); }));
    return peer.last_sender();
}

TEST_F(OwnLinks, print_once_why_they_wait) {
    const support::TempDir folder;
    OwnLink own{loop.io, link_settings_of("serial:" + (folder / "absent")), taker, streams, "monitor"};
    own.start();
    loop.io.run_for(500ms);    // several attempts are made meanwhile
    own.stop();
    const std::string said = err.str();
    EXPECT_NE(said.find("waiting: "), said.npos);
    EXPECT_EQ(said.find("waiting: "), said.rfind("waiting: ")) << said;
}

TEST_F(OwnLinks, deliver_no_frames_after_the_receiver_has_enough) {
    support::UdpPeer peer;
    OwnLink own{loop.io, link_settings_of(peer.link("peer")), taker, streams, "monitor"};
    taker.most = 1;
    own.start();
    ASSERT_TRUE(peer.send(reached_from(own, peer, loop, frame), frame + frame));
    ASSERT_TRUE(loop.until([&] { return taker.frames > 0; }));
    EXPECT_EQ(taker.frames, 1);
    own.stop();
}

TEST_F(OwnLinks, print_a_hint_once_while_it_applies) {
    support::UdpPeer peer;
    OwnLink own{loop.io, link_settings_of(peer.link("peer")), taker, streams, "monitor", 5ms};
    own.start();
    ASSERT_TRUE(peer.send(reached_from(own, peer, loop, frame), Bytes(100, 0x55)));
    ASSERT_TRUE(until_said("peer: data"));
    loop.io.run_for(200ms);    // several checks are made meanwhile
    own.stop();
    const std::string said = err.str();
    EXPECT_EQ(said.find("peer: data"), said.rfind("peer: data")) << said;
}

TEST_F(OwnLinks, report_that_they_sent_the_zero_bytes_of_a_flush) {
    const support::TempDir folder;
    support::PtyDevice device{folder / "fc"};
    OwnLink own{loop.io, link_settings_of("serial:" + (folder / "fc") + ",baud=9600"), taker, streams, "monitor"};
    own.start();
    ASSERT_TRUE(loop.until([&] { return own.is_up(); }));
    const ano::Flush flush = own.flush_parser(ano::FrameView{frame});
    EXPECT_TRUE(flush.sent);
    EXPECT_GT(flush.busy, 200ms);
    const ano::Flush again = own.flush_parser(ano::FrameView{frame});
    EXPECT_FALSE(again.sent);
    own.stop();
}

TEST_F(OwnLinks, detect_a_device_that_uses_the_previous_version) {
    support::UdpPeer peer;
    OwnLink own{loop.io, link_settings_of(peer.link("peer")), taker, streams, "monitor", 5ms};
    own.start();
    Bytes old = support::hex("AA FF 20 00");
    const ano::Checks checks = ano::checks_of(old);
    old = old + Bytes{checks.sum, checks.add};
    ASSERT_TRUE(peer.send(reached_from(own, peer, loop, frame), old + old));
    EXPECT_TRUE(until_said("V7 frames")) << err.str();
    own.stop();
}

TEST_F(OwnLinks, count_skipped_bytes_of_a_peer_even_after_it_is_removed) {
    const std::string local = support::UdpPeer{}.local().text();
    support::UdpPeer noisy, next;
    OwnLink own{loop.io, link_settings_of("udp-listen:" + local + ",max_peers=1"), taker, streams, "monitor"};
    own.start();
    ASSERT_TRUE(loop.until([&] { return own.is_up(); }));
    const auto to = *anogate::Endpoint::parse(local);
    ASSERT_TRUE(noisy.send(to, Bytes(10, 0x55) + frame));
    ASSERT_TRUE(next.send(to, frame));
    ASSERT_TRUE(loop.until([&] { return taker.frames == 2; }));
    EXPECT_EQ(own.skipped(), 10u) << "its place is the other's";
    own.stop();
}

}    // namespace
}    // namespace own_link_tests
