#include <link/udp/datagram_sender.hpp>
#include <sys/asio.hpp>

#include <support/bytes.hpp>
#include <support/failing_calls.hpp>

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <functional>
#include <vector>

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::Fate;
using Sizes = std::vector<std::size_t>;

namespace datagram_sender_tests {
namespace {

// Frames of 40 bytes that wait, and a socket with its other end.
class Datagrams : public testing::Test {
protected:
    Datagrams() {
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, ends), 0);
        way.fd = ends[0];
        outbox.open();
    }
    ~Datagrams() override {
        support::fate_of_sendmmsg = {};
        for (const int end : ends) ::close(end);
    }
    void push(int frames) {
        for (int i = 0; i < frames; ++i) outbox.push(ano::FrameView{frame}, {}, now);
    }
    SendReport send() { return sender.send_all(way, outbox, pacing, now); }
    /// The results of the first calls; later calls go to the kernel.
    void calls_do(std::vector<Fate> fates) {
        support::fate_of_sendmmsg = [this, fates = std::move(fates)](int) {
            return calls < fates.size() ? fates[calls++] : Fate{};
        };
    }
    /// The sizes of the received datagrams.
    Sizes received() {
        Sizes sizes;
        char room[2000];
        for (ssize_t n = 0; (n = ::recv(ends[1], room, sizeof room, 0)) >= 0;) sizes.push_back(static_cast<std::size_t>(n));
        return sizes;
    }

    const Bytes frame = support::frame(0xDC, 0xFE, 0xF1, Bytes(32));
    int ends[2] = {-1, -1};
    std::size_t calls = 0;
    asio::io_context io{1};
    AlarmClock clock{io};
    Pacing pacing{clock, [] {}};
    Outbox outbox{{}};
    DatagramSender sender;
    DatagramSender::Path way;
    const ano::TimePoint now = ano::Clock::now();
};

TEST_F(Datagrams, do_not_exceed_the_bytes_allowed_at_once) {
    push(5);
    way.max_bytes = 100;
    EXPECT_EQ(send().result, SendResult::done);
    EXPECT_EQ(received(), (Sizes{40, 40}));
    EXPECT_EQ(outbox.waiting(), 3u);
}

TEST_F(Datagrams, wait_for_their_time_on_a_paced_path) {
    push(3);
    pacing.start(1000, 20ms);
    EXPECT_EQ(send().result, SendResult::paced);
    EXPECT_EQ(received(), Sizes{40});
}

TEST_F(Datagrams, are_retried_once_each) {
    push(3);
    calls_do({{.error = ECONNREFUSED}, {.most = 1}, {.error = ECONNREFUSED}});
    const SendReport report = send();
    EXPECT_EQ(report.refused, 2u);
    EXPECT_EQ(received(), (Sizes{40, 40, 40}));
    EXPECT_EQ(outbox.counters().send_failed, 0u);
    push(2);
    calls = 0;
    calls_do({{.error = ECONNREFUSED}, {.error = ECONNREFUSED}});
    send();
    EXPECT_EQ(received(), Sizes{40}) << "and no third";
    EXPECT_EQ(outbox.counters().send_failed, 1u);
}

TEST_F(Datagrams, wait_briefly_if_every_try_fails_due_to_earlier_datagrams) {
    push(1);
    const std::function<bool()> there_was_one = [] { return true; };
    way.read_reports = &there_was_one;
    calls_do(std::vector<Fate>(100, Fate{.error = ECONNREFUSED}));
    EXPECT_EQ(send().result, SendResult::no_memory);
    EXPECT_EQ(calls, 16u);
    EXPECT_TRUE(outbox.congested());
    EXPECT_EQ(outbox.waiting(), 1u);
}

TEST_F(Datagrams, that_cannot_be_sent_for_lack_of_room_leave_the_outbox_congested) {
    for (const auto& [error, result] :
         {std::pair{EAGAIN, SendResult::full}, {ENOMEM, SendResult::no_memory}, {ENOBUFS, SendResult::no_memory}}) {
        push(1);
        calls = 0;
        calls_do({{.error = error}});
        EXPECT_EQ(send().result, result) << error;
        EXPECT_TRUE(outbox.congested()) << error;
        EXPECT_EQ(send().result, SendResult::done);
        EXPECT_FALSE(outbox.congested()) << error;
    }
}

TEST_F(Datagrams, that_exceed_the_path_mtu_are_split_into_single_frames) {
    push(4);
    way.mtu = 1000;
    calls_do(std::vector<Fate>(100, Fate{.mtu = 100}));
    EXPECT_EQ(send().result, SendResult::done);
    EXPECT_EQ(received(), (Sizes{40, 40, 40, 40}));
    EXPECT_EQ(outbox.counters().too_big, 0u);
}

TEST_F(Datagrams, of_one_frame_too_long_for_the_path_are_tried_twice_and_counted) {
    push(2);
    calls_do({{.error = EMSGSIZE}});
    send();
    EXPECT_EQ(received(), (Sizes{40, 40})) << "the error was about an earlier one";
    push(2);
    calls = 0;
    calls_do({{.error = EMSGSIZE}, {.error = EMSGSIZE}});
    send();
    EXPECT_EQ(received(), Sizes{40});
    EXPECT_EQ(outbox.counters().too_big, 1u);
}

}    // namespace
}    // namespace datagram_sender_tests
