// The requests to one device, in simulated time.
#include <host/device.hpp>
#include <host/parameter_info.hpp>
#include <host/parameter_write.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
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

// Before the first measurement a loss shows nothing: five losses in a row are no reason to give up when every other frame is
// lost.
TEST(Device, sends_an_unanswered_request_every_200_ms_for_six_seconds) {
    Host host;
    host.ask_value(5);
    std::vector<Duration> at;
    EXPECT_EQ(host.device.due(), TimePoint::min());
    for (TimePoint now = start; host.listener.ends.empty(); now = host.device.due().value_or(now + 1ms)) {
        if (!host.sent(now).empty()) at.push_back(now - start);
        ASSERT_LT(now - start, 1min);
    }
    ASSERT_EQ(at.size(), 30u);
    for (std::size_t n = 0; n < at.size(); ++n) EXPECT_EQ(at[n], n * 200ms);
    EXPECT_EQ(host.listener.ends[0].outcome, Outcome::timeout);
    EXPECT_EQ(host.listener.ends[0].sent, 30u);
    EXPECT_FALSE(host.listener.ends[0].device_answers);
    EXPECT_FALSE(host.device.due());
}

TEST(Device, repeats_a_request_for_one_second_on_a_measured_line) {
    Host host;
    for (int i = 0; i < 20; ++i) {
        host.ask_value(9);
        host.sent(start);
        host.value(9, start + 1ms);
    }
    host.listener.ends.clear();
    host.ask_value(5);
    TimePoint now = start + 1ms;
    for (; host.listener.ends.empty(); now = host.device.due().value_or(now)) {
        host.sent(now);
        ASSERT_LT(now - start, 1min);
    }
    EXPECT_GE(now - start, 1s);
    EXPECT_LT(now - start, 1200ms);
    EXPECT_EQ(host.listener.ends[0].sent, 10u);
}

struct Flushes : Host {
    std::vector<std::uint8_t> before;    // their ids
    Flushes() {
        device.on_maybe_deaf([this](FrameView next) {
            before.push_back(next.id());
            return ano::Flush{.sent = true, .busy = 20ms};
        });
    }
};

TEST(Device, repeats_a_request_after_a_flush_and_waits_longer_by_the_time_of_the_flush) {
    Flushes host;
    host.ask_value(5);
    host.sent(start);
    EXPECT_TRUE(host.before.empty()) << "the first one";
    EXPECT_EQ(host.sent(start + 200ms).size(), 1u);
    EXPECT_EQ(host.before, (std::vector<std::uint8_t>{0xE0}));
    EXPECT_EQ(host.device.due(), start + 200ms + 20ms + 200ms);
}

// Any frame sent meanwhile would end the zero bytes: only a command is sent.
TEST(Device, sends_only_commands_after_a_flush_until_the_line_is_free) {
    Flushes host;
    host.device.on_maybe_deaf([](FrameView) { return ano::Flush{.sent = true, .busy = 500ms}; });
    for (int i = 0; i < 5; ++i) {
        host.ask_value(9);
        host.sent(start);
        host.value(9, start + 1ms);
    }
    host.ask_value(1);
    host.ask_value(2);
    EXPECT_EQ(host.sent(start + 1ms).size(), 2u);
    EXPECT_EQ(host.sent(start + 201ms).size(), 1u) << "the first one again, behind zero bytes";
    EXPECT_EQ(host.device.due(), start + 701ms);
    EXPECT_TRUE(host.sent(start + 699ms).empty());
    ASSERT_TRUE(host.device.ask(Request{0xC0, {1, 2, 3}, {.sends = 1, .wait = 2s}}, host.listener));
    EXPECT_LE(host.device.due(), start + 400ms);
    EXPECT_EQ(host.sent(start + 699ms).size(), 1u);
    EXPECT_FALSE(host.sent(start + 1700ms).empty());
}

TEST(Device, that_answered_a_later_request_needs_no_flush) {
    Flushes host;
    for (int i = 0; i < 3; ++i) {
        host.ask_value(9);
        host.sent(start);
        host.value(9, start + 1ms);
    }
    host.ask_value(1);
    host.ask_value(2);
    EXPECT_EQ(host.sent(start + 1ms).size(), 2u);
    host.value(2, start + 2ms);
    EXPECT_EQ(host.sent(start + 1s).size(), 1u);
    EXPECT_TRUE(host.before.empty());
    host.ask_value(3);
    host.ask_value(4);
    host.sent(start + 1s);
    host.value(1, start + 1s);
    host.value(3, start + 1s);
    EXPECT_EQ(host.sent(start + 2s).size(), 1u);
    EXPECT_EQ(host.before.size(), 1u) << "the last one may have made it deaf";
}

TEST(Device, flushes_before_a_request_that_is_sent_only_once) {
    Flushes host;
    const Request command{0xC0, {1, 2, 3}, {.sends = 1, .wait = 2s}};
    ASSERT_TRUE(host.device.ask(command, host.listener));
    const auto sent = host.sent(start);
    ASSERT_EQ(sent.size(), 1u);
    EXPECT_EQ(host.before, (std::vector<std::uint8_t>{0xC0}));
    EXPECT_EQ(host.device.due(), start + 20ms + 2s);
    host.acknowledge(sent[0], start + 30ms);
    ASSERT_TRUE(host.device.ask(command, host.listener));
    const auto again = host.sent(start + 1s);
    EXPECT_EQ(host.before.size(), 2u) << "it was heard just now, but what came since may have made it deaf";
    host.acknowledge(again[0], start + 1s);
    ASSERT_TRUE(host.device.ask(action(Action::save), host.listener));
    host.sent(start + 2s);
    EXPECT_EQ(host.before, (std::vector<std::uint8_t>{0xC0, 0xC0, 0xE0}));
}

struct LateFlushes : Host {
    TimePoint free_at;
    int flushes = 0;
    explicit LateFlushes(TimePoint at) : free_at{at} {}
    void listen(TimePoint& now) {
        device.on_maybe_deaf([this, &now](FrameView) -> ano::Flush {
            if (now < free_at) return {.later = free_at - now};
            ++flushes;
            free_at = now + 1s;
            return {.sent = true, .busy = 20ms};
        });
    }
    std::vector<Bytes> sent_at(TimePoint& now, TimePoint at) {
        now = at;
        return sent(at);
    }
};

void measure(Host& host) {
    for (int i = 0; i < 5; ++i) {
        host.ask_value(9);
        host.sent(start);
        host.value(9, start + 1ms);
    }
}

TEST(Device, needs_one_flush_for_all_requests_that_were_lost_before_it) {
    TimePoint now = start;
    LateFlushes host{start};
    host.listen(now);
    measure(host);
    for (std::uint16_t id = 1; id <= 3; ++id) host.ask_value(id);
    EXPECT_EQ(host.sent_at(now, start + 1ms).size(), 3u);
    EXPECT_EQ(host.sent_at(now, start + 300ms).size(), 1u) << "behind zero bytes";
    host.free_at = start + 330ms;
    EXPECT_EQ(host.sent_at(now, start + 320ms).size(), 2u) << "without waiting for the next flush";
    EXPECT_EQ(host.flushes, 1);
}

TEST(Device, repeats_what_was_sent_before_a_flush_at_the_first_answer_after_it) {
    TimePoint now = start;
    LateFlushes host{start};
    host.listen(now);
    measure(host);
    host.ask_value(1);
    host.ask_value(2);
    EXPECT_EQ(host.sent_at(now, start + 1ms).size(), 2u);
    EXPECT_EQ(host.sent_at(now, start + 40ms).size(), 1u) << "behind zero bytes";
    EXPECT_TRUE(host.sent_at(now, start + 60ms).empty()) << "the other one may still be answered";
    host.value(1, start + 65ms);
    EXPECT_EQ(host.sent_at(now, start + 65ms).size(), 1u);
    EXPECT_EQ(host.flushes, 1);
}

// The answer is to the first send: the zero bytes have not left yet.
TEST(Device, does_not_repeat_what_was_sent_before_a_flush_because_of_a_late_answer) {
    TimePoint now = start;
    LateFlushes host{start};
    host.listen(now);
    measure(host);
    host.ask_value(1);
    host.ask_value(2);
    host.sent_at(now, start + 1ms);
    EXPECT_EQ(host.sent_at(now, start + 40ms).size(), 1u);
    host.value(1, start + 45ms);
    EXPECT_TRUE(host.sent_at(now, start + 75ms).empty());
}

TEST(Device, whose_parser_was_not_ready_has_lost_nothing_because_of_too_many_requests) {
    TimePoint now = start;
    LateFlushes host{start + 900ms};
    for (int i = 0; i < 3; ++i) measure(host);
    for (std::uint16_t id = 1; id <= 4; ++id) host.ask_value(id);
    EXPECT_EQ(host.sent(start).size(), 4u);
    EXPECT_EQ(host.sent(start + 300ms).size(), 4u) << "lost once";
    for (std::uint16_t id = 1; id <= 4; ++id) host.value(id, start + 300ms);
    const std::size_t before = host.device.window();
    host.listen(now);
    for (std::uint16_t id = 0; id < 8; ++id) host.ask_value(id);
    for (int ms = 301; host.flushes == 0; ++ms) {
        ASSERT_LT(ms, 2000);
        host.sent_at(now, start + ms * 1ms);
    }
    EXPECT_EQ(host.device.window(), before);
}

TEST(Device, waits_longer_behind_others_until_that_was_measured) {
    Host host;
    measure(host);
    host.ask_value(1);
    host.ask_value(2);
    EXPECT_EQ(host.sent(start + 1ms).size(), 2u);
    EXPECT_EQ(host.sent(start + 200ms).size(), 1u) << "the first one";
    EXPECT_EQ(host.sent(start + 201ms).size(), 1u);
}

TEST(Device, waits_for_an_answer_from_the_answer_to_the_request_before) {
    Host host;
    measure(host);
    const auto ask_two = [&](TimePoint at) {
        host.ask_value(1);
        host.ask_value(2);
        EXPECT_EQ(host.sent(at).size(), 2u);
    };
    ask_two(start);
    host.value(1, start + 1ms);
    host.value(2, start + 1ms);
    ask_two(start + 1s);
    host.value(1, start + 1s + 20ms);
    EXPECT_TRUE(host.sent(start + 1s + 49ms).empty());
    EXPECT_EQ(host.sent(start + 1s + 100ms).size(), 1u);
}

// A command may be LAND, and it is rare that the parser of a device is not ready.
TEST(Device, a_request_that_is_sent_only_once_never_waits_for_a_flush) {
    TimePoint now = start;
    LateFlushes host{start + 700ms};
    host.listen(now);
    ASSERT_TRUE(host.device.ask({0xC0, {1, 2, 3}, {.sends = 1, .wait = 2s}}, host.listener));
    ASSERT_EQ(host.sent_at(now, start).size(), 1u);
    EXPECT_EQ(host.flushes, 0);
    EXPECT_TRUE(host.sent_at(now, start + 1999ms).empty()) << "it is not sent again";
    host.sent_at(now, start + 2s);
    EXPECT_EQ(host.listener.ends.size(), 1u);
}

// Waiting only for the answer to the first try would take five seconds.
TEST(Device, sends_a_save_at_once_and_again_when_a_flush_is_allowed) {
    TimePoint now = start;
    LateFlushes host{start + 700ms};
    host.listen(now);
    ASSERT_TRUE(host.device.ask(action(Action::save), host.listener));
    ASSERT_EQ(host.sent_at(now, start).size(), 1u);
    EXPECT_TRUE(host.sent_at(now, start + 699ms).empty());
    EXPECT_EQ(host.sent_at(now, start + 700ms).size(), 1u);
    EXPECT_EQ(host.flushes, 1);
    EXPECT_TRUE(host.sent_at(now, start + 5s).empty()) << "each save wears the flash";
}

// The command waits neither for a flush, nor for a place in the window, nor for an acknowledgement. A device that accepts one
// frame at a time would lose it, and a command is sent once.
TEST(Device, a_command_waits_only_briefly_for_outstanding_answers) {
    Host host;
    const Request command{0xC0, {1, 2, 3}, {.sends = 1, .wait = 2s}};
    host.ask_value(1);
    host.ask_value(2);
    ASSERT_FALSE(host.sent(start).empty());
    ASSERT_TRUE(host.device.ask(command, host.listener));
    EXPECT_TRUE(host.sent(start + 1ms).empty());
    host.value(1, start + 5ms);
    host.value(2, start + 6ms);
    const auto behind_answers = host.sent(start + 6ms);
    ASSERT_FALSE(behind_answers.empty());
    EXPECT_EQ(behind_answers[0][3], 0xC0);
    host.acknowledge(behind_answers[0], start + 10ms);

    host.ask_value(3);
    ASSERT_FALSE(host.sent(start + 3s).empty());
    ASSERT_TRUE(host.device.ask(command, host.listener));
    host.ask_value(4);
    ASSERT_TRUE(host.device.due());
    EXPECT_GT(*host.device.due(), start + 3s);
    EXPECT_LE(*host.device.due(), start + 3s + Device::max_wait_of_commands);
    const auto behind_silence = host.sent(start + 3s + Device::max_wait_of_commands);
    ASSERT_FALSE(behind_silence.empty());
    EXPECT_EQ(behind_silence[0][3], 0xC0);
}

TEST(Device, sends_a_command_at_once_after_another_request) {
    TimePoint now = start;
    LateFlushes host{start};
    host.listen(now);
    const auto command = [](Bytes data) { return Request{0xC0, std::move(data), {.sends = 1, .wait = 2s}}; };
    ASSERT_TRUE(host.device.ask(action(Action::save), host.listener));
    EXPECT_EQ(host.sent_at(now, start).size(), 1u);
    ASSERT_TRUE(host.device.ask(command({1, 2, 4}), host.listener));
    EXPECT_LE(host.device.due(), start + Device::max_wait_of_commands);
    EXPECT_EQ(host.sent_at(now, start + Device::max_wait_of_commands).size(), 1u) << "neither for the flush nor for its end";
    ASSERT_TRUE(host.device.ask(command({1, 2, 3}), host.listener));
    ASSERT_TRUE(host.device.has_command());
    EXPECT_EQ(host.sent_at(now, start + 110ms).size(), 1u) << "another one is not acknowledged yet";
    ASSERT_TRUE(host.device.ask(command({1, 2, 3}), host.listener));
    EXPECT_EQ(host.sent_at(now, start + 111ms).size(), 1u) << "nor the same one";
    EXPECT_EQ(host.device.on_their_way(), 4u);
    EXPECT_FALSE(host.device.has_command());
    EXPECT_EQ(host.flushes, 1);
}

// This is how the description of a command is checked.
TEST(Device, an_urgent_request_passes_all_except_commands_even_when_repeated) {
    Host host;
    for (std::uint16_t id = 0; id < 40; ++id) host.ask_value(id);
    ASSERT_FALSE(host.sent(start).empty());
    Request urgent{0xC1, {1, 3, 0}, {.sends = 2, .wait = 200ms}};
    urgent.urgent = true;
    ASSERT_TRUE(host.device.ask(urgent, host.listener));
    const auto first = host.sent(start + Device::max_wait_of_commands);
    ASSERT_FALSE(first.empty());
    EXPECT_EQ(first[0][3], 0xC1);
    const auto again = host.sent(start + 300ms);
    ASSERT_FALSE(again.empty());
    EXPECT_EQ(again[0][3], 0xC1);
    ASSERT_TRUE(host.device.ask({0xC0, {1, 2, 3}, {.sends = 1, .wait = 2s}}, host.listener));
    const auto command = host.sent(start + 400ms);
    ASSERT_FALSE(command.empty());
    EXPECT_EQ(command[0][3], 0xC0);
}

// For instance the question whether the command is still the same: the flush is left to the command.
TEST(Device, sends_a_command_at_once_after_a_request_with_a_short_time_out) {
    TimePoint now = start;
    LateFlushes host{start};
    host.listen(now);
    Request brief = question::parameter_value(5, 5);
    brief.patience = {.sends = 1, .wait = 200ms};
    ASSERT_TRUE(host.device.ask(brief, host.listener));
    EXPECT_EQ(host.sent_at(now, start).size(), 1u);
    EXPECT_EQ(host.flushes, 0);
    EXPECT_TRUE(host.sent_at(now, start + 200ms).empty());
    ASSERT_EQ(host.listener.ends.size(), 1u);
    ASSERT_TRUE(host.device.ask({0xC0, {1, 2, 3}, {.sends = 1, .wait = 2s}}, host.listener));
    EXPECT_EQ(host.sent_at(now, start + 200ms).size(), 1u);
    EXPECT_EQ(host.flushes, 1);
}

TEST(Device, sends_a_command_at_once_after_an_answered_command) {
    TimePoint now = start;
    LateFlushes host{start};
    host.listen(now);
    const Request command{0xC0, {1, 2, 3}, {.sends = 1, .wait = 2s}};
    ASSERT_TRUE(host.device.ask(command, host.listener));
    const auto first = host.sent_at(now, start);
    ASSERT_EQ(first.size(), 1u);
    host.acknowledge(first[0], start + 30ms);
    Listener another;
    ASSERT_TRUE(host.device.ask(command, another));
    EXPECT_EQ(host.sent_at(now, start + 31ms).size(), 1u);
    EXPECT_EQ(host.flushes, 1);
}

TEST(Device, repeats_a_command_that_was_sent_at_once_after_the_flush) {
    TimePoint now = start;
    LateFlushes host{start};
    host.listen(now);
    for (int i = 0; i < 3; ++i) {
        host.ask_value(9);
        host.sent_at(now, start);
        host.value(9, start);
    }
    ASSERT_TRUE(host.device.ask({0xC0, {1, 2, 3}, {.sends = 1, .wait = 2s}}, host.listener));
    EXPECT_EQ(host.sent_at(now, start).size(), 1u);
    ASSERT_TRUE(host.device.ask({0xC0, {1, 2, 4}, {.sends = 5, .wait = 2s}}, host.listener));
    EXPECT_EQ(host.sent_at(now, start + 100ms).size(), 1u) << "the first one is not acknowledged yet";
    EXPECT_EQ(host.device.due(), start + 1s);
    EXPECT_EQ(host.sent_at(now, start + 1s).size(), 1u);
    EXPECT_EQ(host.flushes, 2);
    EXPECT_TRUE(host.sent_at(now, start + 2900ms).empty());
}

// The other flush was after the request.
TEST(Device, a_second_try_waits_once_for_a_flush_even_if_another_request_uses_it) {
    TimePoint now = start;
    LateFlushes host{start + 310ms};
    host.listen(now);
    host.ask_value(5);
    EXPECT_EQ(host.sent_at(now, start).size(), 1u);
    EXPECT_TRUE(host.sent_at(now, start + 200ms).empty());
    host.free_at = start + 400ms;
    EXPECT_EQ(host.sent_at(now, start + 310ms).size(), 1u);
    EXPECT_EQ(host.flushes, 0);
}

TEST(Device, a_repetition_waits_for_a_flush_at_most_one_time_out_which_is_not_counted) {
    TimePoint now = start;
    LateFlushes host{start + 310ms};
    host.listen(now);
    host.ask_value(5);
    EXPECT_EQ(host.sent_at(now, start).size(), 1u) << "the first try of a question";
    EXPECT_TRUE(host.sent_at(now, start + 200ms).empty());
    EXPECT_EQ(host.device.due(), start + 310ms);
    EXPECT_EQ(host.sent_at(now, start + 310ms).size(), 1u);
    EXPECT_EQ(host.flushes, 1);
    const TimePoint second = *host.device.due();
    EXPECT_EQ(second, start + 310ms + 20ms + 200ms);
    EXPECT_EQ(host.sent_at(now, second).size(), 1u) << "780 ms are longer than an answer may take";
    for (; host.listener.ends.empty(); now = host.device.due().value_or(now)) {
        host.sent(now);
        ASSERT_LT(now - start, 1min);
    }
    EXPECT_GE(now - start, 6s + 110ms);
}

TEST(Device, starts_the_time_out_of_a_frame_when_the_frame_has_left) {
    Host host;
    host.ask_value(5);
    host.sent(start);
    host.device.wait_to_leave(start + 2s);
    EXPECT_EQ(host.device.due(), start + 2s + 200ms);
    host.value(5, start + 2s + 10ms);
    EXPECT_EQ(host.device.round_trip().smoothed(), 10ms);
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

/// The number of requests in flight at the end, for a device with this line that answers 300 questions one after the other.
std::size_t on_their_way_at_last(Duration each_way, Duration for_each, Duration jitter = {}) {
    Host host;
    host.listener.yield_to_others(true);
    for (std::uint16_t id = 0; id < 250; ++id) host.ask_value(id);
    support::Random random{1};
    std::vector<std::pair<TimePoint, std::uint16_t>> answers;
    TimePoint now = start, free_at = start;
    std::size_t most = 0, answered = 0;
    while (answered < 200) {
        for (const Bytes& one : host.sent(now)) {
            free_at = std::max(free_at, now + each_way) + for_each;
            const auto more = jitter.count() > 0 ? jitter / 1000 * static_cast<int>(random.below(1000u)) : Duration{};
            answers.emplace_back(free_at + each_way + more, static_cast<std::uint16_t>(FrameView{one}.data()[1]));
        }
        if (answered >= 100) most = std::max(most, host.device.on_their_way());
        const auto next = std::min_element(answers.begin(), answers.end());
        if (next == answers.end()) break;
        const auto [at, id] = *next;
        answers.erase(next);
        now = std::max(now, at);
        host.value(id, now);
        ++answered;
    }
    return most;
}

// A client that may only view, and reads all parameters of a slow device, would delay a command to it.
TEST(Device, a_yielding_request_waits_for_others_in_flight_at_most_40_ms) {
    EXPECT_EQ(on_their_way_at_last(1ms, 1ms), 8u);
    EXPECT_EQ(on_their_way_at_last(1ms, 5ms), 8u);
    EXPECT_EQ(on_their_way_at_last(1ms, 10ms), 5u);
    EXPECT_EQ(on_their_way_at_last(1ms, 20ms), 3u);
    EXPECT_EQ(on_their_way_at_last(1ms, 50ms), 2u);
    EXPECT_EQ(on_their_way_at_last(200ms, 1ms), 8u) << "a long line is no wait";
    EXPECT_EQ(on_their_way_at_last(200ms, 5ms), 8u);
    EXPECT_GE(on_their_way_at_last(200ms, 1ms, 60ms), 6u) << "nor is an uneven one";
}

TEST(Device, sends_writes_one_at_a_time_and_lets_read_requests_pass) {
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

TEST(Device, sends_two_requests_with_the_same_answer_one_after_the_other) {
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

TEST(Device, distinguishes_answers) {
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

TEST(Device, that_is_asked_by_number_gets_any_id_while_it_reports_no_parameters) {
    Host host;
    host.device.ask_by_number(true);
    EXPECT_FALSE(host.device.ask(question::parameter_value(256, 0), host.listener)) << "it reports some";
    host.take(0xE0, {1, 0, 0}, start);
    EXPECT_TRUE(host.device.ask(question::parameter_value(256, 0), host.listener));
    host.device.ask_by_number(false);
    EXPECT_FALSE(host.device.ask(question::parameter_value(256, 0), host.listener));
}

TEST(Device, does_not_send_a_waiting_request_beyond_a_reduced_count) {
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

TEST(Device, does_not_repeat_a_request_beyond_a_reduced_count) {
    Host host;
    host.ask_value(200);
    host.sent(start);
    host.take(0xE0, {1, 100, 0}, start);
    EXPECT_TRUE(host.sent(start + 1s).empty());
    ASSERT_EQ(host.listener.ends.size(), 1u);
    EXPECT_EQ(host.listener.ends[0].outcome, Outcome::not_there);
}

TEST(Device, that_was_silent_for_30_s_loses_its_stored_device_info) {
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

TEST(Device, with_changed_device_info_is_another_device) {
    Host host;
    host.device.expect_info(start);
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

TEST(Device, with_unrequested_device_info_may_be_another_device) {
    Host host;
    host.device.expect_info(start);
    host.take(0xE3, {0xDC, 1, 0, 2, 0, 3, 0, 4, 0, 'f', 'c'}, start);
    host.take(0xE0, {1, 9, 0}, start);
    const auto presence = host.device.presence();
    host.take(0xE3, {0xDC, 1, 0, 2, 0, 3, 0, 4, 0, 'f', 'c'}, start + 10s);
    EXPECT_NE(host.device.presence(), presence);
    EXPECT_TRUE(host.device.info());
    EXPECT_FALSE(host.device.parameter_count());
}

const Bytes info_of_fc{0xDC, 1, 0, 2, 0, 3, 0, 4, 0, 'f', 'c'};

TEST(Device, each_expected_device_info_matches_one_answer) {
    Host host;
    host.device.expect_info(start);
    host.device.expect_info(start + 200ms);    // repeated
    host.take(0xE3, info_of_fc, start + 1s);
    host.take(0xE3, info_of_fc, start + 1200ms);
    EXPECT_EQ(host.device.announcements(), 0u) << "both were answered";
    host.take(0xE3, info_of_fc, start + 1250ms);
    EXPECT_EQ(host.device.announcements(), 0u) << "the line doubled it";
    host.take(0xE3, info_of_fc, start + 1500ms);
    EXPECT_EQ(host.device.announcements(), 1u);
    host.device.expect_info(start + 2s);
    host.take(0xE3, info_of_fc, start + 8s);
    EXPECT_EQ(host.device.announcements(), 2u) << "too late for an answer";
}

TEST(Device, a_device_info_request_that_it_sends_matches_one_answer) {
    Host host;
    ASSERT_TRUE(host.device.ask(question::device_info(0), host.listener));
    EXPECT_EQ(host.sent(start).size(), 1u);
    host.take(0xE3, info_of_fc, start + 10ms);
    ASSERT_EQ(host.listener.ends.size(), 1u);
    host.take(0xE3, info_of_fc, start + 500ms);
    EXPECT_EQ(host.device.announcements(), 1u);
}

TEST(Device, an_action_waits_five_seconds_and_is_not_measured_as_a_round_trip) {
    Host host;
    ASSERT_TRUE(host.device.ask(action(Action::save), host.listener));
    const auto sent = host.sent(start);
    EXPECT_EQ(host.device.due(), start + 5s);
    EXPECT_EQ(host.acknowledge(sent[0], start + 4s), Taken::ended);
    EXPECT_FALSE(host.device.round_trip().smoothed());
}

TEST(Device, accepts_a_new_request_while_it_reports_the_end_of_the_previous_one) {
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
