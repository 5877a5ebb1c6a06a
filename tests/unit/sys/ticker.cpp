#include <sys/ticker.hpp>

#include <gtest/gtest.h>

#include <thread>

namespace ticker_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

TEST(Ticker, calls_repeatedly_until_it_is_stopped) {
    asio::io_context io;
    int calls = 0;
    Ticker ticker{io, [&] {
                      if (++calls == 3) ticker.stop();
                  }};
    ticker.start(1ms);
    io.run();
    EXPECT_EQ(calls, 3);
}

TEST(Ticker, stopped_in_its_handler_waits_for_no_further_call) {
    asio::io_context io;
    Ticker ticker{io, [&] { ticker.stop(); }};
    ticker.start(100ms);
    io.run_one();
    io.poll();
    EXPECT_TRUE(io.stopped());
}

// The loop handles the due call and the stop in one round, the stop first.
TEST(Ticker, stopped_while_a_call_is_due_makes_no_further_call) {
    asio::io_context io;
    int calls = 0;
    Ticker ticker{io, [&] { ++calls; }};
    ticker.start(50ms);
    asio::post(io, [&] {
        std::this_thread::sleep_for(60ms);
        asio::post(io, [&] { ticker.stop(); });
    });
    io.run_for(1s);
    EXPECT_TRUE(io.stopped()) << "nothing is left to wait for";
    EXPECT_EQ(calls, 0);
}

TEST(Ticker, can_be_started_again) {
    asio::io_context io;
    int calls = 0;
    Ticker ticker{io, [&] {
                      ++calls;
                      ticker.stop();
                  }};
    ticker.start(1ms);
    io.run();
    io.restart();
    ticker.start(1ms);
    io.run();
    EXPECT_EQ(calls, 2);
}

}    // namespace
}    // namespace ticker_tests
