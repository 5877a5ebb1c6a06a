// Sessions of a link that has many, over connections that are being established, like those of a TCP link.
#include <link/stream_session.hpp>

#include <support/link_host.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <memory>
#include <string>
#include <vector>

namespace stream_session_tests {
namespace {

using namespace anogate;
using namespace support;

class Connection final : public StreamSession {
public:
    using StreamSession::pacing;
    using StreamSession::StreamSession;
    std::string log;    // "o": opened, "e": its input ended, "f": it failed
    int error = 0;
    std::size_t most = SIZE_MAX;    // bytes that a write accepts
    std::size_t held = 0;           // waiting in the driver
    int interrupted = 0;            // the number of reads interrupted by signals
    bool ends_with_a_read = false;

private:
    ssize_t read_some(std::span<std::uint8_t> room) override {
        if (interrupted > 0) {
            --interrupted;
            errno = EINTR;
            return -1;
        }
        const ssize_t n = ::read(fd(), room.data(), room.size());
        if (n > 0 && ends_with_a_read) close();
        return n;
    }
    std::size_t held_by_driver() const override { return held; }
    Opening go_on_opening() override {
        pollfd there{fd(), POLLOUT, 0};
        if (::poll(&there, 1, 0) == 0) return Opening::wants_to_write;
        socklen_t size = sizeof error;
        ::getsockopt(fd(), SOL_SOCKET, SO_ERROR, &error, &size);
        errno = error;
        return error == 0 ? Opening::done : Opening::failed;
    }
    void opened() override {
        log += 'o';
        resume_reading();
    }
    ssize_t write_some(std::span<const iovec> pieces) override {
        return ::write(fd(), pieces[0].iov_base, std::min(pieces[0].iov_len, most));
    }
    void read_ended(int) override {
        log += 'e';
        end_of_input();
        close();
    }
    void failed(int why) override {
        log += 'f';
        error = why;
        close();
    }
};

class ManyConnections final : public Link {
public:
    ManyConnections(const LinkContext& context) : Link{LinkId{0}, {}}, context_{context} {}
    Connection& open(UniqueFd fd, const std::string& peer, StoredLink* before = nullptr) {
        Channel* const channel = context_.host.open_channel(*this, peer);
        sessions.push_back(std::make_unique<Connection>(context_));
        if (before) sessions.back()->go_on_from(std::move(*before));
        sessions.back()->open(std::move(fd), *channel);
        context_.host.link_up(*this);
        return *sessions.back();
    }
    void start() override {}
    void stop_reading() override {
        for (const auto& session : sessions) session->pause_reading();
    }
    void stop() override { sessions.clear(); }
    void flush(Channel&) override {
        for (const auto& session : sessions) session->write();
    }
    std::vector<std::unique_ptr<Connection>> sessions;

private:
    LinkContext context_;
};

UniqueFd tcp() { return UniqueFd{::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)}; }

struct Sessions : testing::Test {
    Sessions() {
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        EXPECT_EQ(::bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        ::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&address), &size);
    }
    UniqueFd connecting() {
        UniqueFd fd = tcp();
        const int result = ::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
        EXPECT_TRUE(result == 0 || errno == EINPROGRESS || errno == ECONNREFUSED);
        return fd;
    }
    UniqueFd accepted() {
        UniqueFd fd;
        EXPECT_TRUE(host.until([&] {
            fd = UniqueFd{::accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)};
            return static_cast<bool>(fd);
        }));
        return fd;
    }
    bool until_received(const UniqueFd& fd, const Bytes& what) {
        Bytes heard;
        return host.until([&] {
            Bytes more(4096);
            const ssize_t n = ::read(fd.get(), more.data(), more.size());
            if (n > 0) heard.insert(heard.end(), more.begin(), more.begin() + n);
            return heard == what;
        });
    }
    BareLinkHost host;
    ManyConnections link{host.context()};
    UniqueFd listener = tcp();
    sockaddr_in address{};
};

TEST_F(Sessions, open_when_the_connection_is_established_and_carry_frames_both_ways) {
    ASSERT_EQ(::listen(listener.get(), 5), 0);
    Connection& one = link.open(connecting(), "one");
    Connection& two = link.open(connecting(), "two");
    const UniqueFd first = accepted(), second = accepted();
    ASSERT_TRUE(host.until([&] { return one.log == "o" && two.log == "o"; }));
    ASSERT_GT(::write(first.get(), vendor::i_am_an_mcu.data(), vendor::i_am_an_mcu.size()), 0);
    ASSERT_GT(::write(second.get(), vendor::who_are_you.data(), vendor::who_are_you.size()), 0);
    EXPECT_TRUE(host.until([&] { return host.heard("one") == vendor::i_am_an_mcu && host.heard("two") == vendor::who_are_you; }));
    one.most = 3;    // a write may accept less than a frame
    host.channels()[0]->outbox.push(ano::FrameView{vendor::who_are_you});
    one.write();
    EXPECT_TRUE(until_received(first, vendor::who_are_you));
}

TEST_F(Sessions, one_that_ends_does_not_affect_the_others) {
    ASSERT_EQ(::listen(listener.get(), 5), 0);
    Connection& one = link.open(connecting(), "one");
    UniqueFd first = accepted();
    Connection& two = link.open(connecting(), "two");
    const UniqueFd second = accepted();
    const Bytes half(vendor::i_am_an_mcu.begin(), vendor::i_am_an_mcu.begin() + 7);
    ASSERT_GT(::write(first.get(), vendor::i_am_an_mcu.data(), vendor::i_am_an_mcu.size()), 0);
    ASSERT_GT(::write(first.get(), half.data(), half.size()), 0);
    first = UniqueFd{};
    ASSERT_TRUE(host.until([&] { return one.log == "oe"; }));
    EXPECT_FALSE(one.is_open());
    EXPECT_EQ(host.heard("one"), vendor::i_am_an_mcu);
    ASSERT_GT(::write(second.get(), vendor::who_are_you.data(), vendor::who_are_you.size()), 0);
    EXPECT_TRUE(host.until([&] { return host.heard("two") == vendor::who_are_you; }));
    EXPECT_EQ(two.log, "o");
}

TEST_F(Sessions, a_refused_connection_reports_the_error_and_is_never_open) {
    Connection& refused = link.open(connecting(), "refused");    // bound, but not listening
    EXPECT_TRUE(host.until([&] { return !refused.log.empty(); }));
    EXPECT_EQ(refused.log, "f");
    EXPECT_EQ(refused.error, ECONNREFUSED);
    EXPECT_FALSE(refused.is_open());
}

TEST_F(Sessions, nothing_is_read_after_the_link_stops_reading) {
    ASSERT_EQ(::listen(listener.get(), 5), 0);
    Connection& one = link.open(connecting(), "one");
    const UniqueFd first = accepted();
    ASSERT_TRUE(host.until([&] { return one.log == "o"; }));
    link.stop_reading();
    ASSERT_GT(::write(first.get(), vendor::i_am_an_mcu.data(), vendor::i_am_an_mcu.size()), 0);
    host.io.restart();
    host.io.run_for(std::chrono::milliseconds{50});
    EXPECT_TRUE(host.heard("one").empty());
}

// An open one, on a pair of sockets.
struct Session : Sessions {
    Session() {
        int ends[2] = {-1, -1};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0);
        ours = UniqueFd{ends[0]};
        other = UniqueFd{ends[1]};
    }
    Connection& open(StoredLink* before = nullptr) { return link.open(std::move(ours), "one", before); }
    Channel& channel() { return *host.channels()[0]; }
    void send(const Bytes& bytes) {
        ASSERT_EQ(::write(other.get(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    }
    bool until_read(const Bytes& bytes) {
        return host.until([&] { return channel().parser.counters().bytes_in == bytes.size(); });
    }
    /// Waits 150 ms, in which nothing is expected to happen.
    void wait() {
        host.io.restart();
        host.io.run_for(std::chrono::milliseconds{150});
    }
    UniqueFd ours, other;
    const Bytes frame = vendor::i_am_an_mcu;
    // The frame is recognised after the line was quiet for 50 ms.
    const Bytes behind_a_false_header = Bytes{ano::head, 1, 2, 3, 0xE8, 3} + frame;
};

TEST_F(Session, has_a_congested_outbox_while_the_wire_accepts_nothing) {
    Connection& one = open();
    one.most = 0;
    channel().outbox.push(ano::FrameView{frame});
    one.write();
    EXPECT_TRUE(channel().outbox.congested());
    one.most = SIZE_MAX;
    EXPECT_TRUE(until_received(other, frame));
}

TEST_F(Session, that_is_paced_sends_no_more_than_the_line_carries) {
    Connection& one = open();
    one.pacing().start(1000, std::chrono::milliseconds{1});
    for (int i = 0; i < 2; ++i) channel().outbox.push(ano::FrameView{frame});
    one.write();
    EXPECT_EQ(channel().outbox.waiting(), 1u);
}

TEST_F(Session, that_is_paced_waits_for_bytes_held_by_the_driver) {
    Connection& one = open();
    one.pacing().start(100'000, std::chrono::milliseconds{20});
    one.held = 10'000;
    for (int i = 0; i < 2; ++i) channel().outbox.push(ano::FrameView{frame});
    one.write();
    EXPECT_EQ(channel().outbox.waiting(), 1u);
}

TEST_F(Session, that_is_closed_does_nothing_more) {
    Connection& one = open();
    one.pacing().start(1000, std::chrono::milliseconds{20});
    send(behind_a_false_header);
    ASSERT_TRUE(until_read(behind_a_false_header));
    one.close();
    EXPECT_FALSE(one.pacing().is_on());
    wait();
    EXPECT_EQ(host.heard("one"), Bytes{});
}

TEST_F(Session, that_is_closed_during_a_read_does_nothing_more) {
    Connection& one = open();
    one.ends_with_a_read = true;
    send(behind_a_false_header);
    ASSERT_TRUE(until_read(behind_a_false_header));
    wait();
    EXPECT_EQ(host.heard("one"), Bytes{});
    EXPECT_EQ(one.log, "o");
}

TEST_F(Session, delivers_the_frames_after_a_false_header_at_its_end) {
    Connection& one = open();
    send(behind_a_false_header);
    other = UniqueFd{};
    ASSERT_TRUE(host.until([&] { return one.log == "oe"; }));
    EXPECT_EQ(host.heard("one"), frame);
}

TEST_F(Session, continues_after_a_signal_interrupted_a_read) {
    Connection& one = open();
    one.interrupted = 1;
    send(frame);
    EXPECT_TRUE(host.until([&] { return host.heard("one") == frame; }));
    EXPECT_EQ(one.log, "o");
}

TEST_F(Session, continues_where_another_program_stopped) {
    StoredLink before;
    before.unread_since = host.turn().clocks();
    for (auto* clock : {&before.unread_since.boot, &before.unread_since.real}) *clock -= std::chrono::seconds{3};
    before.unread_since.now -= std::chrono::seconds{3};
    const TimePoint then = before.unread_since.now;
    before.rest.assign(frame.begin(), frame.begin() + 7);
    const Bytes end{frame.begin() + 7, frame.end()};
    send(end);
    open(&before);
    EXPECT_EQ(channel().arrived_at, then);
    ASSERT_TRUE(host.until([&] { return host.heard("one") == frame; }));
    EXPECT_LT(channel().arrived_at, then + std::chrono::seconds{1}) << "it may have waited on the wire";
    const TimePoint again = host.now();
    send(frame);
    ASSERT_TRUE(host.until([&] { return host.heard("one") == frame + frame; }));
    EXPECT_GE(channel().arrived_at, again) << "the wire was empty in between";
}

}    // namespace
}    // namespace stream_session_tests
