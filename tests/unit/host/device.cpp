// The requests on their way to one device, in time that is a number.
#include <host/device.hpp>
#include <host/parameter_info.hpp>
#include <host/parameter_write.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ano::host::device_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;

const TimePoint start = TimePoint{} + 1h;

struct Listener final : Asker {
    struct End {
        Outcome outcome;
        std::uint32_t tag;
        unsigned sent;
        bool device_answers;
    };
    std::vector<End> ends;
    void ended(const Ended& e, TimePoint) override { ends.push_back({e.outcome, e.tag, e.evidence.sent, e.device_answers}); }
};

struct Host {
    Device device{0xDC};
    Listener listener;

    Host() { take(0xE0, {1, 0, 1}, start); }    // it has 256 parameters
    Taken take(std::uint8_t id, const Bytes& data, TimePoint now, std::uint8_t from = 0xDC, std::uint8_t to = 0xFE) {
        const Bytes frame = support::frame(from, to, id, data);
        return device.take(FrameView{frame}, now);
    }
    Taken value(std::uint16_t id, TimePoint now) {
        return take(0xE1, {static_cast<std::uint8_t>(id), static_cast<std::uint8_t>(id >> 8), 1}, now);
    }
    Taken acknowledge(const Bytes& frame, TimePoint now) {
        const FrameView view{frame};
        return take(0x00, {view.id(), view.checks().sum, view.checks().add}, now);
    }
    void ask_value(std::uint16_t id) { ASSERT_TRUE(device.ask(question::parameter_value(id, id), listener)); }
    std::vector<Bytes> sent(TimePoint now) {
        std::vector<Bytes> all;
        while (const auto frame = device.next_frame(now)) all.emplace_back(frame->bytes().begin(), frame->bytes().end());
        return all;
    }
};

TEST(Device, an_unanswered_question_is_sent_five_times_each_wait_twice_the_last) {
    Host host;
    host.ask_value(5);
    std::vector<Duration> at;
    EXPECT_EQ(host.device.due(), TimePoint::min());
    for (TimePoint now = start; host.listener.ends.empty(); now = host.device.due().value_or(now + 1ms)) {
        if (!host.sent(now).empty()) at.push_back(now - start);
        ASSERT_LT(now - start, 1min);
    }
    EXPECT_EQ(at, (std::vector<Duration>{0ms, 300ms, 900ms, 2100ms, 4100ms}));
    EXPECT_EQ(host.listener.ends[0].outcome, Outcome::timeout);
    EXPECT_EQ(host.listener.ends[0].sent, 5u);
    EXPECT_FALSE(host.listener.ends[0].device_answers);
    EXPECT_FALSE(host.device.due());
}

TEST(Device, the_window_opens_with_the_answers) {
    Host host;
    for (std::uint16_t id = 0; id < 40; ++id) host.ask_value(id);
    EXPECT_EQ(host.sent(start).size(), 1u);
    host.value(0, start + 10ms);
    EXPECT_EQ(host.sent(start + 10ms).size(), 2u);
    for (std::uint16_t id = 1; id < 20; ++id) {
        host.value(id, start + 20ms);
        host.sent(start + 20ms);
        EXPECT_LE(host.device.on_their_way(), Window::max_size);
    }
    EXPECT_EQ(host.device.on_their_way(), Window::max_size);
}

TEST(Device, writes_go_one_at_a_time_and_questions_pass_them) {
    Host host;
    for (int i = 0; i < 20; ++i) {
        host.ask_value(9);
        host.sent(start);
        host.value(9, start + 1ms);
    }
    ASSERT_TRUE(host.device.ask(action(Action::save, 1), host.listener));
    ASSERT_TRUE(host.device.ask(action(Action::store_compass_calibration, 2), host.listener));
    host.ask_value(3);
    const auto sent = host.sent(start + 1ms);
    ASSERT_EQ(sent.size(), 2u);
    EXPECT_EQ(FrameView{sent[0]}.data()[0], 0x10);
    EXPECT_EQ(FrameView{sent[1]}.data()[0], 2);
    EXPECT_EQ(host.acknowledge(sent[0], start + 2ms), Taken::ended);
    EXPECT_EQ(host.sent(start + 2ms).size(), 1u);
}

TEST(Device, two_that_the_same_answer_would_end_go_one_after_the_other) {
    Host host;
    host.ask_value(9);
    host.sent(start);
    host.value(9, start);
    host.ask_value(7);
    host.ask_value(7);
    EXPECT_EQ(host.sent(start).size(), 1u);
    EXPECT_EQ(host.value(7, start + 1ms), Taken::ended);
    EXPECT_EQ(host.sent(start + 1ms).size(), 1u);
    EXPECT_EQ(host.value(7, start + 2ms), Taken::ended);
}

TEST(Device, tells_answers_apart) {
    Host host;
    host.ask_value(5);
    host.sent(start);
    EXPECT_EQ(host.take(0xE1, {5, 0, 1}, start, 0xDD), Taken::nothing) << "another device";
    EXPECT_EQ(host.take(0xE1, {6, 0, 1}, start), Taken::unasked);
    EXPECT_EQ(host.take(0xE1, {5, 0, 1}, start, 0xDC, 0xD2), Taken::foreign);
    EXPECT_EQ(host.take(0x03, Bytes(7), start), Taken::nothing) << "telemetry";
    EXPECT_EQ(host.value(5, start), Taken::ended);
    EXPECT_EQ(host.value(5, start), Taken::doubled);
    host.ask_value(6);
    host.sent(start);
    host.device.forget(host.listener);
    EXPECT_EQ(host.value(6, start), Taken::late);
    ASSERT_EQ(host.listener.ends.size(), 1u);
}

TEST(Device, an_id_at_or_beyond_the_count_is_never_sent) {
    Host host;
    EXPECT_FALSE(host.device.ask(question::parameter_value(256, 0), host.listener));
    EXPECT_FALSE(host.device.ask(question::parameter_info(256, 0), host.listener));
    EXPECT_FALSE(host.device.ask({id_of<"parameter_value">, {0, 1, 7}}, host.listener));
    EXPECT_TRUE(host.device.ask(question::parameter_value(255, 0), host.listener));
    Device fresh{0xDC};
    EXPECT_FALSE(fresh.ask(question::parameter_value(0, 0), host.listener)) << "the count is not known";
}

TEST(Device, what_waits_is_not_sent_when_the_count_has_become_smaller) {
    Host host;
    host.ask_value(5);
    host.ask_value(200);
    EXPECT_EQ(host.sent(start).size(), 1u);
    host.take(0xE0, {1, 100, 0}, start);
    host.value(5, start);
    EXPECT_TRUE(host.sent(start).empty());
    ASSERT_EQ(host.listener.ends.size(), 2u);
    EXPECT_EQ(host.listener.ends[1].outcome, Outcome::not_there);
}

TEST(Device, what_is_to_be_repeated_is_not_when_the_count_has_become_smaller) {
    Host host;
    host.ask_value(200);
    host.sent(start);
    host.take(0xE0, {1, 100, 0}, start);
    EXPECT_TRUE(host.sent(start + 1s).empty());
    ASSERT_EQ(host.listener.ends.size(), 1u);
    EXPECT_EQ(host.listener.ends[0].outcome, Outcome::not_there);
}

TEST(Device, one_that_was_silent_for_long_is_not_known_any_more) {
    Host host;
    host.take(0xE3, {0xDC, 1, 0, 2, 0, 3, 0, 4, 0, 'f', 'c'}, start);
    ASSERT_TRUE(host.device.info());
    EXPECT_EQ(host.device.info()->name, "fc");
    const auto presence = host.device.presence();
    host.take(0x03, Bytes(7), start + 29s);
    EXPECT_TRUE(host.device.info());
    host.take(0x03, Bytes(7), start + 59s);
    EXPECT_FALSE(host.device.info());
    EXPECT_FALSE(host.device.parameter_count());
    EXPECT_NE(host.device.presence(), presence);
}

TEST(Device, one_that_says_otherwise_is_another_one) {
    Host host;
    host.take(0xE3, {0xDC, 1, 0, 2, 0, 3, 0, 4, 0, 'f', 'c'}, start);
    host.take(0xE0, {1, 9, 0}, start);
    const auto presence = host.device.presence();
    host.take(0xE3, {0xDC, 1, 0, 2, 0, 3, 0, 4, 0, 'f', 'c'}, start);
    EXPECT_EQ(host.device.presence(), presence);
    host.take(0xE3, {0xDC, 1, 0, 3, 0, 3, 0, 4, 0, 'f', 'c'}, start);
    EXPECT_NE(host.device.presence(), presence);
    EXPECT_EQ(host.device.info()->sw_ver, 3);
    EXPECT_FALSE(host.device.parameter_count());
}

TEST(Device, an_action_waits_five_seconds_and_says_nothing_about_the_round_trip) {
    Host host;
    ASSERT_TRUE(host.device.ask(action(Action::save), host.listener));
    const auto sent = host.sent(start);
    EXPECT_EQ(host.device.due(), start + 5s);
    EXPECT_EQ(host.acknowledge(sent[0], start + 4s), Taken::ended);
    EXPECT_FALSE(host.device.round_trip().smoothed());
}

TEST(Device, an_asker_may_ask_again_when_it_is_told) {
    struct Chain final : Asker {
        Device* device = nullptr;
        int left = 3;
        void ended(const Ended&, TimePoint) override {
            if (--left == 0) return;
            EXPECT_TRUE(device->ask(question::parameter_count(0), *this));
        }
    } chain;
    Host host;
    chain.device = &host.device;
    ASSERT_TRUE(host.device.ask(question::parameter_count(0), chain));
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(host.sent(start).size(), 1u);
        host.take(0xE0, {1, 0, 1}, start);
    }
    EXPECT_EQ(chain.left, 0);
    EXPECT_TRUE(host.sent(start).empty());
}

}    // namespace
}    // namespace ano::host::device_tests
