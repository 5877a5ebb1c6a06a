#include <link/reconnect.hpp>
#include <sys/asio.hpp>

#include <support/wait.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace reconnect_tests {

using namespace anogate;
using namespace std::chrono_literals;

namespace {

struct Reconnects : testing::Test {
    bool until_tries(std::size_t count) {
        return support::wait_until([&] { return tries >= count; }, support::patience,
                                   [this] {
                                       io.restart();
                                       io.run_for(1ms);
                                   });
    }
    void run_for(ano::Duration time) {
        io.restart();
        io.run_for(time);
    }

    asio::io_context io{1};
    AlarmClock clock{io};
    std::size_t tries = 0;
    std::string fault = "absent";    // empty: it can be opened
    bool at_once = true;             // false: it only begins to open
    std::vector<std::string> told;
    Reconnect reconnect{clock, ano::Clock::now,
                        [this]() -> Opened<void> {
                            ++tries;
                            if (!fault.empty()) return Unexpected{fault};
                            if (at_once) reconnect.came_up(ano::Clock::now());
                            return {};
                        },
                        [this](LinkError why) { told.push_back(std::move(why.text)); }};
};

TEST_F(Reconnects, each_failed_try_is_reported_and_followed_by_another) {
    const auto start = ano::Clock::now();
    reconnect.start();
    EXPECT_EQ(tries, 1u) << "at once";
    EXPECT_EQ(told, std::vector<std::string>{"absent"});
    ASSERT_TRUE(until_tries(3));
    EXPECT_GE(ano::Clock::now() - start, 100ms) << "the third waits";
    EXPECT_EQ(told.size(), 3u);
    fault.clear();
    ASSERT_TRUE(until_tries(4));
    run_for(600ms);
    EXPECT_EQ(tries, 4u) << "it is open";
    EXPECT_EQ(told.size(), 3u);
}

TEST_F(Reconnects, a_lost_device_is_reported_and_opened_again) {
    fault.clear();
    reconnect.start();
    reconnect.lost("unplugged");
    EXPECT_EQ(told, std::vector<std::string>{"unplugged"});
    EXPECT_EQ(tries, 1u) << "not from within the call";
    ASSERT_TRUE(until_tries(2));
    EXPECT_EQ(told.size(), 1u);
}

TEST_F(Reconnects, an_open_that_takes_long_and_fails_is_tried_again) {
    fault.clear();
    at_once = false;
    reconnect.start();
    run_for(400ms);
    EXPECT_EQ(tries, 1u) << "under way";
    reconnect.lost("refused");
    ASSERT_TRUE(until_tries(2));
    EXPECT_EQ(told, std::vector<std::string>{"refused"});
}

TEST_F(Reconnects, a_device_that_appears_is_opened_at_once_and_the_next_try_is_cancelled) {
    reconnect.start();
    ASSERT_TRUE(until_tries(5));    // the next is most of a second later
    fault.clear();
    reconnect.try_now();
    EXPECT_EQ(tries, 6u);
    run_for(1500ms);
    EXPECT_EQ(tries, 6u);
}

TEST_F(Reconnects, nothing_is_opened_once_it_has_been_stopped) {
    reconnect.start();
    reconnect.stop();
    reconnect.try_now();
    reconnect.try_soon();
    reconnect.lost("unplugged at the end");
    run_for(600ms);
    EXPECT_EQ(tries, 1u);
    EXPECT_EQ(told.back(), "unplugged at the end");
}

}    // namespace
}    // namespace reconnect_tests
