// Whatever the kernel returns for writes: only whole frames leave, in order, none twice, and every offered frame is counted.
#include <link/serial/serial_settings.hpp>
#include <support/failing_calls.hpp>
#include <support/pty_device.hpp>
#include <support/random.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <memory>

namespace faults_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::LinkSettings;

// Frames of many lengths, all of one class without replacement, so that they leave in order.
Bytes numbered(std::uint32_t n) {
    Bytes data(4 + n % 40, 0xAB);
    for (std::size_t i = 0; i < 4; ++i) data[i] = static_cast<std::uint8_t>(n >> 8 * i);
    return frame(0xDC, 0xFF, 0xA0, data);
}
std::uint32_t number(const Bytes& frame) {
    return static_cast<std::uint32_t>(frame[6] | frame[7] << 8 | frame[8] << 16 | frame[9] << 24);
}

// Whole frames, unchanged, in order, none twice.
void expect_in_order(const Bytes& stream) {
    const Split got = split(stream);
    EXPECT_TRUE(got.rest.empty()) << got.rest.size() << " bytes that are no whole frame";
    std::int64_t last = -1;
    for (const Bytes& one : got.frames) {
        ASSERT_GT(number(one), last);
        last = number(one);
        ASSERT_EQ(one, numbered(number(one)));
    }
}

class Faults : public testing::Test {
protected:
    ~Faults() override { fate_of_writev = fate_of_sendmmsg = nullptr; }
    void start(LinkSettings to) {
        to.name = "to";
        to.age.telemetry = 1min;    // so that frames are dropped only because of the kernel's results
        daemon = std::make_unique<RunningGateway>(settings_of({std::move(to), udp_listen("air")}));
        ASSERT_TRUE(daemon->until_up("to") && daemon->until_up("air"));
        in(1);    // registers the peer
        ASSERT_TRUE(daemon->until([&] { return daemon->count("to", "frames_out") == 1; }));
    }
    void in(int frames) {
        Bytes datagram;
        for (int i = 0; i < frames; ++i) datagram = datagram + numbered(sent++);
        air.send(daemon->port("air"), datagram);
        ASSERT_TRUE(daemon->until([&] { return daemon->count("air", "frames_in") == sent; }));
    }
    std::uint64_t count(const std::string& counter) { return daemon->count("to", counter); }
    bool until_nothing_waits() {
        return daemon->until([&] { return count("waiting") == 0; });
    }
    void expect_accounted() {
        EXPECT_TRUE(daemon->counters_add_up());
        std::uint64_t sum = 0;
        for (const char* cause : {"frames_out", "superseded", "queue_full", "stale", "limited", "denied_out", "link_down",
                                  "too_big", "send_failed", "held_back", "waiting"})
            sum += count(cause);
        EXPECT_EQ(sum, sent);
    }

    const TempDir dir;
    UdpPeer air;
    std::uint32_t sent = 0;
    std::unique_ptr<RunningGateway> daemon;
};

class SerialFaults : public Faults {
protected:
    void start() {
        LinkSettings to = serial("to", device.path());
        to.as<anogate::SerialSettings>().pace = anogate::Pace::off;
        Faults::start(to);
    }
    PtyDevice device{dir / "port"};
};

TEST_F(SerialFaults, writes_of_every_length_lose_no_frame) {
    start();
    std::size_t length = 0;
    fate_of_writev = [&](int) { return Fate{0, ++length}; };    // 1 byte, then 2, then 3 …
    for (int round = 0; round < 30; ++round) in(20);
    EXPECT_GT(length, 100u);
    EXPECT_TRUE(daemon->until([&] { return split(device.heard()).frames.size() == sent; }));
    expect_in_order(device.heard());
    expect_accounted();
}

TEST_F(SerialFaults, writes_of_random_lengths_between_interruptions_lose_no_frame) {
    start();
    Random random{7};
    fate_of_writev = [&](int) -> Fate {
        if (random.one_in(4)) return {EINTR, 0};
        return {0, 1 + random.below(std::size_t{30})};
    };
    for (int round = 0; round < 50; ++round) {
        in(20);
        device.heard();
    }
    EXPECT_TRUE(daemon->until([&] { return split(device.heard()).frames.size() == sent; }));
    expect_in_order(device.heard());
    expect_accounted();
}

TEST_F(SerialFaults, a_port_that_fails_in_the_middle_of_a_frame_continues_with_a_whole_one) {
    start();
    for (int failure = 0; failure < 4; ++failure) {
        std::size_t calls = 0;
        fate_of_writev = [&](int) -> Fate {
            switch (++calls) {
            case 1: return {0, 7};    // a part of a frame
            case 2: return {EIO, 0};
            default: return Fate{};
            }
        };
        in(5);
        ASSERT_TRUE(daemon->until([&] { return calls >= 2 && daemon->link("to").at("state") == "up"; }));
        fate_of_writev = nullptr;
        in(3);
        ASSERT_TRUE(until_nothing_waits());
    }
    EXPECT_GE(count("link_down"), 4u * 5);
    EXPECT_TRUE(daemon->counters_add_up());
    // The terminal stays open: the device has received torn frames, each followed by whole ones.
    std::size_t whole = 0;
    ano::FrameParser parser{{}};
    const Bytes all = device.heard();
    for (std::size_t at = 0; at < all.size();) {
        const auto room = parser.prepare();
        const std::size_t n = std::min(room.size(), all.size() - at);
        std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(at), n, room.begin());
        at += n;
        parser.commit(n, anogate::Clock::now());
        while (parser.next()) ++whole;
    }
    EXPECT_GE(whole, 1u + 4 * 3);
}

class UdpFaults : public Faults {
protected:
    void start(bool pack) {
        LinkSettings to = udp("to", peer.local().text());
        to.pack = pack;
        Faults::start(to);
    }
    std::size_t arrived() { return split(peer.heard()).frames.size(); }
    UdpPeer peer;
};

TEST_F(UdpFaults, no_frame_is_lost_while_the_kernel_has_no_buffer_space) {
    for (const bool pack : {false, true}) {
        for (const int error : {EAGAIN, ENOBUFS, ENOMEM, EINTR}) {
            SCOPED_TRACE(testing::Message() << "errno " << error << (pack ? ", packed" : ""));
            sent = 0;
            peer.forget();
            start(pack);
            int calls = 0;
            fate_of_sendmmsg = [&](int) -> Fate {
                ++calls;
                if (calls % 3 != 0) return {error, 0};
                return {0, 2};    // two of the offered datagrams
            };
            for (int round = 0; round < 10; ++round) in(20);
            EXPECT_TRUE(until_nothing_waits());
            EXPECT_TRUE(daemon->until([&] { return arrived() == sent; }));
            expect_in_order(peer.heard());
            expect_accounted();
            EXPECT_EQ(count("frames_out"), sent) << daemon->link("to").dump();
            EXPECT_EQ(daemon->link("to").at("state"), "up");
            fate_of_sendmmsg = nullptr;
        }
    }
}

TEST_F(UdpFaults, a_refused_send_is_counted_and_the_next_frames_are_sent) {
    for (const bool pack : {false, true}) {
        for (const int error : {ECONNREFUSED, EHOSTUNREACH, EPERM, EACCES}) {
            SCOPED_TRACE(testing::Message() << "errno " << error << (pack ? ", packed" : ""));
            sent = 0;
            peer.forget();
            start(pack);
            int calls = 0;
            fate_of_sendmmsg = [&](int) { return ++calls % 5 == 0 ? Fate{error, 0} : Fate{0, 3}; };
            for (int round = 0; round < 10; ++round) in(20);
            EXPECT_TRUE(until_nothing_waits());
            const std::uint64_t failed = count("send_failed");
            EXPECT_TRUE(daemon->until([&] { return arrived() == sent - failed; }));
            if (error == ECONNREFUSED) EXPECT_EQ(failed, 0u) << "it was about an earlier one";
            else EXPECT_GE(failed, 1u);
            expect_in_order(peer.heard());
            expect_accounted();
            EXPECT_EQ(daemon->link("to").at("state"), "up");
            fate_of_sendmmsg = nullptr;
        }
    }
}

TEST_F(UdpFaults, datagrams_rejected_as_too_long_are_sent_as_single_frames_or_counted) {
    start(true);
    bool every = false;
    int calls = 0;
    fate_of_sendmmsg = [&](int) { return every || ++calls % 2 == 1 ? Fate{EMSGSIZE, 0} : Fate{}; };
    in(20);
    EXPECT_TRUE(until_nothing_waits());
    EXPECT_TRUE(daemon->until([&] { return arrived() == sent; })) << "packed it was too long, one by one it is not";
    every = true;
    in(5);
    EXPECT_TRUE(until_nothing_waits());
    EXPECT_EQ(count("too_big"), 5u);
    every = false;
    calls = 0;
    in(1);
    EXPECT_TRUE(until_nothing_waits());
    EXPECT_EQ(count("too_big"), 5u) << "the report may be about an earlier one";
    expect_in_order(peer.heard());
    expect_accounted();
}

// Packed up to `mtu`, which the user may have set to more than the path supports.
TEST_F(UdpFaults, packed_datagrams_too_long_for_the_path_are_sent_as_single_frames) {
    start(true);
    fate_of_sendmmsg = [&](int) { return Fate{0, SIZE_MAX, 60}; };    // any single frame, but never three
    for (int round = 0; round < 5; ++round) in(20);
    EXPECT_TRUE(until_nothing_waits());
    EXPECT_EQ(count("frames_out"), sent) << daemon->link("to");
    EXPECT_EQ(count("too_big"), 0u);
    EXPECT_TRUE(daemon->until([&] { return arrived() == sent; }));
    expect_in_order(peer.heard());
    expect_accounted();
}

TEST_F(UdpFaults, a_link_reopens_after_a_network_error) {
    for (const int error : {ENETDOWN, ENODEV, EADDRNOTAVAIL, EINVAL, ENETUNREACH}) {
        SCOPED_TRACE(testing::Message() << "errno " << error);
        sent = 0;
        peer.forget();
        start(true);
        int calls = 0;
        fate_of_sendmmsg = [&](int) { return ++calls == 1 ? Fate{error, 0} : Fate{}; };
        in(5);
        ASSERT_TRUE(daemon->until_up("to"));
        in(5);
        EXPECT_TRUE(until_nothing_waits());
        EXPECT_EQ(count("link_down"), 5u);
        EXPECT_EQ(count("frames_out"), 6u);
        expect_accounted();
        fate_of_sendmmsg = nullptr;
    }
}

TEST_F(UdpFaults, frames_to_a_closed_peer_are_counted_and_the_link_stays_up) {
    auto gone = std::make_unique<UdpPeer>();
    LinkSettings to = udp("to", gone->local().text());
    Faults::start(to);
    gone.reset();
    for (int round = 0; round < 30; ++round) in(10);
    EXPECT_TRUE(until_nothing_waits());
    EXPECT_EQ(daemon->link("to").at("state"), "up");
    expect_accounted();
}

}    // namespace
}    // namespace faults_tests
