// A thread waits for the last bit and then switches the transceiver back; here the port is a pty, which has nothing to wait for.
#include <link/serial/half_duplex.hpp>
#include <support/loop.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <vector>

namespace half_duplex_tests {
namespace {

using namespace std::chrono_literals;
using anogate::HalfDuplex;
using support::Loop;

class Transceiver : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(port.is_open()); }
    void open() { ASSERT_TRUE(line.open(port.fd(), 87us).has_value()); }
    void write() {
        line.writing();
        port.write(support::frame(0xDC, 0xFE, 0x03));
        line.written();
        device.heard();
    }
    /// Whether each switch to sending was followed by one back.
    bool is_back() const { return turns.size() % 2 == 0; }
    void expect_turns_in_order() const {
        for (std::size_t i = 0; i < turns.size(); ++i) ASSERT_EQ(turns[i], i % 2 == 0) << i;
    }

    support::TempDir dir;
    support::PtyDevice device{dir / "port"};
    support::PortUser port{device.path()};
    std::vector<bool> turns;
    Loop loop;
    HalfDuplex line{loop.io, [this](bool sending) { turns.push_back(sending); }};
};

TEST_F(Transceiver, sends_from_before_the_write_until_all_bytes_are_sent) {
    open();
    EXPECT_TRUE(turns.empty());
    line.writing();
    EXPECT_EQ(turns, std::vector{true});
    EXPECT_TRUE(line.is_sending());
    line.written();
    EXPECT_TRUE(loop.until([&] { return !line.is_sending(); }));
    EXPECT_EQ(turns, (std::vector{true, false}));
}

TEST_F(Transceiver, keeps_sending_until_data_written_meanwhile_is_sent) {
    open();
    write();
    write();
    loop.io.run_one_for(support::patience);    // the first one was sent
    EXPECT_TRUE(line.is_sending());
    EXPECT_EQ(turns, std::vector{true});
    EXPECT_TRUE(loop.until([&] { return !line.is_sending(); }));
    EXPECT_EQ(turns, (std::vector{true, false}));
}

TEST_F(Transceiver, turns_with_every_burst_whatever_the_timing) {
    open();
    for (int burst = 0; burst < 500; ++burst) {
        for (int n = 0; n <= burst % 3; ++n) write();
        if (burst % 2 == 0) {
            ASSERT_TRUE(loop.until([&] { return !line.is_sending(); }));
        }
        loop.turn();
    }
    EXPECT_TRUE(loop.until([&] { return !line.is_sending(); }));
    EXPECT_GE(turns.size(), 500u);
    EXPECT_TRUE(is_back());
    expect_turns_in_order();
}

TEST_F(Transceiver, receives_after_it_is_closed_at_any_moment_and_can_be_opened_again) {
    for (int round = 0; round < 200; ++round) {
        open();
        if (round % 4 != 0) write();
        if (round % 4 == 2) write();
        if (round % 4 == 3) loop.turn();
        line.close();
        EXPECT_FALSE(line.is_sending());
        ASSERT_TRUE(is_back()) << round;
    }
    expect_turns_in_order();
    EXPECT_EQ(turns.size(), 300u) << "each of three rounds in four turned it once";
}

TEST_F(Transceiver, that_was_closed_while_bytes_were_being_sent_starts_in_a_clean_state) {
    for (int round = 0; round < 50; ++round) {
        open();
        line.writing();
        line.written();
        line.close();
        const std::size_t before = turns.size();
        open();
        loop.io.restart();
        loop.io.run_for(2ms);
        EXPECT_EQ(turns.size(), before) << "nothing was written since";
        write();
        ASSERT_TRUE(loop.until([&] { return !line.is_sending(); })) << "and this is waited for";
        line.close();
    }
    expect_turns_in_order();
}

}    // namespace
}    // namespace half_duplex_tests
