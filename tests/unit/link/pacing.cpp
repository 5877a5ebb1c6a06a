#include <link/pacing.hpp>
#include <sys/asio.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

using namespace anogate;
using namespace std::chrono_literals;

namespace pacing_tests {
namespace {

// A line of 1000 bytes/s, 20 ms of them ahead, and a frame of 40 bytes that waits.
class Paced : public testing::Test {
protected:
    Paced() {
        outbox.open();
        outbox.push(ano::FrameView{support::frame(0xDC, 0xFE, 0xF1, support::Bytes(32))}, {}, now);
        pacing.start(1000, 20ms);
    }

    asio::io_context io{1};
    AlarmClock clock{io};
    std::optional<ano::TimePoint> went_on;
    Pacing pacing{clock, [this] { went_on = ano::Clock::now(); }};
    Outbox outbox{{}};
    const ano::TimePoint now = ano::Clock::now();
};

TEST_F(Paced, an_outbox_that_waits_for_the_line_is_congested_and_continues_when_the_line_is_free) {
    EXPECT_EQ(pacing.budget(outbox, now), 40u);
    EXPECT_FALSE(outbox.congested());
    pacing.sent(200, now);
    EXPECT_EQ(pacing.budget(outbox, now), 0u);
    EXPECT_TRUE(outbox.congested());
    io.run();
    ASSERT_TRUE(went_on);
    EXPECT_GE(*went_on, now + 200ms);
}

TEST_F(Paced, an_empty_outbox_does_not_wait) {
    pacing.sent(200, now);
    Outbox empty{{}};
    EXPECT_EQ(pacing.budget(empty, now), SIZE_MAX);
    io.run();
    EXPECT_FALSE(went_on);
}

TEST_F(Paced, a_line_that_is_no_longer_paced_delays_nothing) {
    pacing.sent(200, now);
    EXPECT_EQ(pacing.budget(outbox, now), 0u);
    pacing.stop();
    EXPECT_FALSE(pacing.is_on());
    EXPECT_EQ(pacing.rate(), 0u);
    EXPECT_EQ(pacing.budget(outbox, now), SIZE_MAX);
    io.run_for(300ms);
    EXPECT_FALSE(went_on);
}

}    // namespace
}    // namespace pacing_tests
