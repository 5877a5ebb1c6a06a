// A listening UDP link without a gateway: its peers, and the state that it leaves to the next program.
#include <gateway/peers/listening_notice.hpp>
#include <link/udp/udp_listen_link.hpp>

#include <support/link_host.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <dlfcn.h>
#include <fcntl.h>
#include <ifaddrs.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace {

int networks_read = 0;
bool no_interfaces = false;

}    // namespace

// Replaces libc's function: counts the reads of our networks, and returns none if a test wants that.
extern "C" int getifaddrs(ifaddrs** list) noexcept {
    static const auto real = reinterpret_cast<int (*)(ifaddrs**)>(::dlsym(RTLD_NEXT, "getifaddrs"));
    ++networks_read;
    return no_interfaces ? -1 : real(list);
}

namespace udp_listen_link_tests {
namespace {

using namespace std::chrono_literals;
using namespace anogate;
using namespace support;
using Kind = ListeningNotice::Kind;

const Bytes telemetry = frame(0xDC, 0xFE, 0x03, {1, 2, 3, 4, 5, 6, 0});

Bytes notice(Kind kind, std::uint64_t number) {
    const NoticeFrame bytes = frame_of({kind, number});
    return {bytes.begin(), bytes.end()};
}

/// No frame registers its sender as a peer.
class Unwelcoming final : public UdpListenLink {
public:
    using UdpListenLink::UdpListenLink;

private:
    bool welcomes(const Endpoint&, ano::FrameView) override { return false; }
};

struct ListeningLink : testing::Test {
    ~ListeningLink() override {
        no_interfaces = false;
        if (link) link->stop();
    }
    template <class L = UdpListenLink>
    void start() {
        if (link) link->stop();
        link = std::make_unique<L>(LinkId{0}, settings, host.context());
        link->start();
        ASSERT_TRUE(host.why.empty()) << host.why;
    }
    void send(UdpPeer& peer, const Bytes& bytes) { ASSERT_TRUE(peer.send(link->local_port(), bytes)); }
    /// The peer of this endpoint; waits until it is registered.
    Channel* channel(const UdpPeer& peer) {
        Channel* found = nullptr;
        host.until([&] {
            for (const auto& one : host.channels())
                if (one->peer == peer.local().text()) found = one.get();
            return found != nullptr;
        });
        return found;
    }
    bool until_denied(std::uint64_t count) {
        return host.until([&] { return link->unassigned_traffic().received.denied_in >= count; });
    }
    std::vector<std::string> peers() const {
        std::vector<std::string> all;
        for (const StoredPeer& peer : link->peers()) all.push_back(peer.endpoint.text());
        std::sort(all.begin(), all.end());
        return all;
    }
    /// The socket and its peers as the next program finds them.
    StoredLink stored(std::vector<StoredPeer> with) const {
        StoredLink left;
        left.wire = UniqueFd{::fcntl(link->storable_wire(), F_DUPFD_CLOEXEC, 0)};
        left.peers = std::move(with);
        return left;
    }

    BareLinkHost host;
    LinkSettings settings = udp_listen("ground");
    UdpListenSettings& udp = settings.as<UdpListenSettings>();
    std::unique_ptr<UdpListenLink> link;
    UdpPeer first, second, third;
};

TEST_F(ListeningLink, reuses_the_quota_of_a_forgotten_peer) {
    udp.max_peers = 1;
    start();
    send(first, vendor::who_are_you);
    const Channel* const channel_of_first = channel(first);
    ASSERT_TRUE(channel_of_first);
    link->forget_peer(channel_of_first->id);
    send(second, vendor::who_are_you);
    EXPECT_TRUE(channel(second));
    EXPECT_EQ(peers(), std::vector{second.local().text()});
}

TEST_F(ListeningLink, counts_a_peer_as_seen_although_its_first_frame_waits_after_a_false_header) {
    start();
    send(first, hex("AB 01 02 03 FF 00") + telemetry);
    const Channel* const of_first = channel(first);
    ASSERT_TRUE(of_first);
    EXPECT_TRUE(host.heard(of_first->peer).empty());
    EXPECT_NE(of_first->heard_at, TimePoint{});
}

TEST_F(ListeningLink, counts_frames_from_senders_that_are_not_allowed) {
    start<Unwelcoming>();
    send(first, telemetry + telemetry);
    EXPECT_TRUE(host.until([&] { return link->unassigned_traffic().received.bytes_in == 2 * telemetry.size(); }));
    EXPECT_EQ(link->unassigned_traffic().received.denied_in, 2u);
    EXPECT_TRUE(peers().empty());
}

TEST_F(ListeningLink, drops_and_counts_frames_from_a_peer_that_sends_a_listening_request) {
    start();
    send(first, telemetry);
    const Channel* const of_first = channel(first);
    ASSERT_TRUE(of_first);
    send(first, notice(Kind::question, 7) + telemetry);
    EXPECT_TRUE(host.until([&] { return of_first->routed.suspended == 1; }));
    EXPECT_EQ(host.heard(of_first->peer), telemetry);
}

TEST_F(ListeningLink, drops_frames_from_a_peer_that_is_a_gateway_and_forgets_it) {
    start();
    send(first, telemetry);
    ASSERT_TRUE(channel(first));
    send(first, notice(Kind::question, 7));
    std::optional<ListeningNotice> asked;
    ASSERT_TRUE(host.until([&] {
        for (const Bytes& one : first.frames())
            if (const auto said = listening_notice(ano::FrameView{one}); said && said->kind == Kind::question) asked = said;
        return asked.has_value();
    }));
    send(first, notice(Kind::answer, asked->number) + telemetry);
    EXPECT_TRUE(host.until([&] { return peers().empty(); }));
    EXPECT_EQ(host.heard(first.local().text()), telemetry) << "that of before";
    EXPECT_EQ(link->trouble().id, "other_gateway");
}

// The port may belong to another program now. The suspension stays; otherwise forgetting the peer would be a way to suspend it
// again.
TEST_F(ListeningLink, accepts_a_new_program_on_the_port_of_a_forgotten_peer) {
    start();
    send(first, telemetry);
    const Channel* const before = channel(first);
    ASSERT_TRUE(before);
    send(first, notice(Kind::question, 7) + telemetry);
    ASSERT_TRUE(host.until([&] { return before->routed.suspended == 1; }));
    link->forget_peer(before->id);
    send(first, vendor::who_are_you);
    ASSERT_TRUE(host.until([&] { return link->unassigned_traffic().received.suspended == 1; }));
    ASSERT_TRUE(host.until([&] {
        send(first, vendor::who_are_you);
        return !peers().empty();
    }));
    EXPECT_EQ(peers(), std::vector{first.local().text()});
}

TEST_F(ListeningLink, reads_the_local_networks_once_a_second_however_many_unknown_senders_there_are) {
    no_interfaces = true;
    start();
    const TimePoint begin = Clock::now();
    const int before = networks_read;
    constexpr int strangers = 50;
    for (int i = 0; i < strangers; ++i) send(first, telemetry);
    ASSERT_TRUE(until_denied(strangers));
    EXPECT_GE(networks_read, before + 1);
    EXPECT_LE(networks_read, before + 1 + (Clock::now() - begin) / 1s);
}

// The kernel's stamps are useless across a step of the clock, and valid again after the first read after it.
TEST_F(ListeningLink, measures_the_age_of_datagrams_again_after_the_clock_was_set) {
    Duration ahead = 1h;
    host.clocks = [&] {
        ClockReading reading = read_clocks();
        reading.real += ahead;
        return reading;
    };
    start();
    ahead = {};
    send(first, telemetry);
    Channel* const of_first = channel(first);
    ASSERT_TRUE(of_first);
    for (int i = 0; i < 2; ++i) {    // the first read still compares with the turn before the step
        send(first, telemetry);
        const Bytes& heard = host.heard(of_first->peer);
        const std::size_t all = heard.size() + telemetry.size();
        ASSERT_TRUE(host.until([&] { return heard.size() >= all; }));
    }
    send(first, telemetry);
    const TimePoint there = Clock::now();
    std::this_thread::sleep_for(20ms);
    const TimePoint arrived_before = of_first->arrived_at;
    ASSERT_TRUE(host.until([&] { return of_first->arrived_at != arrived_before; }));
    EXPECT_LT(of_first->arrived_at, there + 10ms) << "not when it was read";
}

TEST_F(ListeningLink, restores_the_stored_state_of_its_peers) {
    start();
    const TimePoint now = Clock::now();
    const PeerBook::Memory memory{now - 10s, true, true};
    host.stored = stored({{first.local(), memory, true}});
    const std::uint16_t port = link->local_port();
    start();
    EXPECT_EQ(link->local_port(), port);
    const std::vector<StoredPeer> known = link->peers();
    ASSERT_EQ(known.size(), 1u);
    EXPECT_EQ(known[0].endpoint, first.local());
    EXPECT_EQ(known[0].memory.heard_at, memory.heard_at);
    EXPECT_TRUE(known[0].memory.is_host);
    EXPECT_TRUE(known[0].memory.has_returned);
}

TEST_F(ListeningLink, restores_up_to_max_peers_and_prefers_those_last_heard) {
    start();
    const TimePoint now = Clock::now();
    host.stored = stored({{first.local(), {now - 2s, true, false}, true},
                          {second.local(), {now - 3s, true, false}, true},
                          {third.local(), {now - 1s, true, false}, true}});
    udp.max_peers = 2;
    start();
    std::vector<std::string> expected{first.local().text(), third.local().text()};
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(peers(), expected);
}

}    // namespace
}    // namespace udp_listen_link_tests
