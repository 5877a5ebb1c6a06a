#include <runtime/peer_log.hpp>
#include <sys/asio.hpp>

#include <support/log_lines.hpp>

#include <gtest/gtest.h>

namespace peer_log_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

class Peers : public testing::Test {
protected:
    std::vector<std::string> after(int times, ano::TimePoint now) {
        for (int i = 0; i < times; ++i)
            i % 2 ? peers.went("ground", "p", "it closed the connection", now) : peers.came("ground", "p", now);
        return lines.pop_all();
    }
    void until_the_alarm() {
        io.restart();
        io.run();
    }

    asio::io_context io{1};
    AlarmClock alarms{io};
    support::LogLines lines;
    PeerLog peers{alarms};
};
using Lines = std::vector<std::string>;

TEST_F(Peers, are_logged_in_at_most_32_lines_in_five_seconds_and_one_for_the_rest) {
    auto now = ano::Clock::now() - 9900ms;
    for (const int more : {8, 3}) {
        const auto said = after(32 + more, now);
        ASSERT_EQ(said.size(), 32u);
        EXPECT_EQ(said[0], "ground: peer p");
        EXPECT_EQ(said[1], "ground: peer p is gone: it closed the connection");
        until_the_alarm();
        EXPECT_EQ(lines.pop_all(), Lines{std::to_string(more) + " more peers came or went"})
            << "and the next five seconds have lines of their own";
        now += 5s;
    }
}

TEST_F(Peers, that_connected_just_before_the_end_are_logged_at_the_end) {
    after(33, ano::Clock::now());
    peers.finish();
    EXPECT_EQ(lines.pop_all(), Lines{"1 more peers came or went"});
    until_the_alarm();
    EXPECT_EQ(lines.pop_all(), Lines{});
}

}    // namespace
}    // namespace peer_log_tests
