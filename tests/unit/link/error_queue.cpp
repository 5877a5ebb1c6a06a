#include <link/udp/error_queue.hpp>

#include <support/udp_peer.hpp>
#include <support/wait.hpp>

#include <gtest/gtest.h>

#include <linux/net_tstamp.h>

#include <vector>

namespace error_queue_tests {
namespace {

using support::Bytes;

TEST(ErrorReports, are_all_read_at_once_with_their_destinations) {
    support::UdpPeer sender;
    anogate::keep_error_reports(sender.fd(), false);
    std::vector<anogate::Endpoint> closed, refused;
    for (int i = 0; i < 3; ++i) closed.push_back(support::UdpPeer{}.local());
    for (const anogate::Endpoint& there : closed)
        while (!sender.send(there, Bytes{1})) {}    // a call may fail because of the previous datagram
    std::size_t reports = 0;
    const auto take = [&] {
        reports = anogate::read_error_reports(
            sender.fd(), [&](const anogate::Endpoint& who, const anogate::IpAddress&) { refused.push_back(who); });
    };
    pollfd there{sender.fd(), 0, 0};
    ASSERT_EQ(::poll(&there, 1, 10'000), 1);
    take();
    EXPECT_EQ(reports, 3u);
    EXPECT_EQ(refused, closed);
    take();
    EXPECT_EQ(reports, 0u);
}

// Reports of the local system, such as that a datagram was sent, are no reason to send anything again.
TEST(ErrorReports, of_the_local_system_are_read_but_not_counted) {
    support::UdpPeer sender, receiver;
    anogate::keep_error_reports(sender.fd(), false);
    const int stamps = SOF_TIMESTAMPING_TX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE;
    ASSERT_EQ(::setsockopt(sender.fd(), SOL_SOCKET, SO_TIMESTAMPING, &stamps, sizeof stamps), 0);
    ASSERT_TRUE(sender.send(receiver.local(), Bytes{1}));
    pollfd there{sender.fd(), 0, 0};
    ASSERT_EQ(::poll(&there, 1, 10'000), 1);
    EXPECT_EQ(anogate::read_error_reports(
                  sender.fd(), [](const anogate::Endpoint& who, const anogate::IpAddress&) { ADD_FAILURE() << who.text(); }),
              0u);
    EXPECT_EQ(::poll(&there, 1, 0), 0) << "or it would be looked at again and again";
}

TEST(ErrorReports, that_are_not_kept_let_no_call_fail) {
    support::UdpPeer sender;
    const anogate::Endpoint closed = support::UdpPeer{}.local();
    const auto ignore = [](const anogate::Endpoint&, const anogate::IpAddress&) {};
    anogate::keep_error_reports(sender.fd(), false);
    ASSERT_TRUE(sender.send(closed, Bytes{1}));
    pollfd there{sender.fd(), 0, 0};
    ASSERT_EQ(::poll(&there, 1, 10'000), 1);
    anogate::keep_error_reports(sender.fd(), false, false);
    EXPECT_EQ(anogate::read_error_reports(sender.fd(), ignore), 0u);
    sender.send(closed, Bytes{1});    // may still fail because of the first one
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(sender.send(closed, Bytes{1}));
    anogate::keep_error_reports(sender.fd(), false);
    EXPECT_TRUE(support::wait_until([&] {
        sender.send(closed, Bytes{1});
        return anogate::read_error_reports(sender.fd(), ignore) > 0;
    }));
}

TEST(ErrorReports, are_limited_per_second) {
    using namespace std::chrono_literals;
    anogate::ReportLimit limit;
    ano::TimePoint now{1h};
    for (int second = 0; second < 3; ++second, now += 1s) {
        EXPECT_FALSE(limit.is_exceeded(anogate::ReportLimit::max_reports, now));
        EXPECT_FALSE(limit.is_exceeded(0, now + 500ms));
        EXPECT_TRUE(limit.is_exceeded(1, now + 999ms));
    }
}

}    // namespace
}    // namespace error_queue_tests
