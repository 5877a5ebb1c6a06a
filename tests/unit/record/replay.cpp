#include <gtest/gtest.h>
#include <record/replay.hpp>

#include <chrono>
#include <initializer_list>

#include <support/bytes.hpp>

namespace replay_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

const Bytes euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});

ano::Duration due(ReplayClock& clock, std::chrono::nanoseconds time, std::chrono::nanoseconds boottime) {
    return clock.due({.time_ns = static_cast<std::uint64_t>(time.count()),
                      .boottime_ns = static_cast<std::uint64_t>(boottime.count()),
                      .frame = ano::FrameView{euler}});
}

bool may(const Bytes& frame) { return may_command(ano::FrameView{frame}); }

TEST(Replay, does_not_replay_frames_that_may_move_a_vehicle) {
    EXPECT_FALSE(may(euler));
    EXPECT_FALSE(may(support::frame(0xDC, 0xFF, 0xA0, {1, 'a'})));
    EXPECT_TRUE(may(support::frame(0xFE, 0xDC, 0x03, {0x7B, 0, 0, 0, 0, 0, 1})));    // of a host
    EXPECT_TRUE(may(support::frame(0xD2, 0xDC, 0x03, {0x7B, 0, 0, 0, 0, 0, 1})));
    for (const std::uint8_t id : std::initializer_list<std::uint8_t>{0x40, 0x41, 0x61, 0xC0, 0xE1, 0xF0})
        EXPECT_TRUE(may(support::frame(0x30, 0xDC, id, {0, 0, 0}))) << +id;
    EXPECT_TRUE(may(support::frame(0x30, 0xDC, 0xE0, {0x10, 0xAB, 0})));
    EXPECT_FALSE(may(support::frame(0x30, 0xDC, 0xE0, {0, 0, 0})));    // a question
    const Bytes command = support::frame(0x30, 0xDC, 0x40, {0, 0, 0});
    Bytes content{192, 168, 0, 1, 0x0A, 0x1A, 192, 168, 0, 2, 0x0A, 0x1A};
    EXPECT_TRUE(may(support::frame(0x30, 0xDC, 0xB1, {1, 2, 3})));    // can't be read
    content.insert(content.end(), command.begin(), command.end());
    EXPECT_TRUE(may(support::frame(0x30, 0xDC, 0xB1, content)));
}

TEST(Replay, keeps_the_time_between_frames) {
    ReplayClock clock{1}, twice{2};
    EXPECT_EQ(due(clock, 1000s, 10s), 0ns);
    EXPECT_EQ(due(clock, 1001s, 11s), 1s);
    EXPECT_EQ(due(clock, 1001500ms, 11500ms), 1500ms);
    EXPECT_EQ(due(twice, 1000s, 10s), 0ns);
    EXPECT_EQ(due(twice, 1001s, 11s), 500ms);
}

TEST(Replay, a_clock_that_was_set_changes_nothing) {
    ReplayClock clock{1};
    due(clock, 1000s, 10s);
    EXPECT_EQ(due(clock, 1000s - 1h, 11s), 1s);
    EXPECT_EQ(due(clock, 1002s, 12s), 2s);
    EXPECT_EQ(due(clock, 1003s, 5s), 2s);    // another boot of the computer: joined files
    EXPECT_EQ(due(clock, 1004s, 6s), 3s);
    ReplayClock other{1};
    due(other, 1000s, 0s);
    EXPECT_EQ(due(other, 1001s, 0s), 1s);
    EXPECT_EQ(due(other, 900s, 0s), 1s);
    EXPECT_EQ(due(other, 901s, 0s), 2s);
}

TEST(Replay, hostile_times_stay_within_limits) {
    ReplayClock clock{0.001};
    due(clock, 0s, 0s);
    const auto last = clock.due({.time_ns = ~std::uint64_t{0}, .frame = ano::FrameView{euler}});
    EXPECT_LE(last, 24h * 365);
    EXPECT_GT(last, 0s);
}

TEST(Replay, detects_the_risk_of_the_frame_in_a_tunnel_frame) {
    const auto tunnelled = [](const Bytes& inner) {
        Bytes content{192, 168, 0, 1, 0x0A, 0x1A, 192, 168, 0, 2};
        content.insert(content.end(), inner.begin(), inner.end());
        return support::frame(0x30, 0xDC, 0xB1, content);
    };
    const auto risk = [](const Bytes& bytes) { return risk_of(ano::FrameView{bytes}); };
    EXPECT_EQ(risk(euler), Risk::none);
    EXPECT_EQ(risk(tunnelled(euler)), Risk::none);
    EXPECT_EQ(risk(support::frame(0xFE, 0xDC, 0xC0, {1})), Risk::of_host);
    EXPECT_EQ(risk(support::frame(0x30, 0xDC, 0xC0, {1})), Risk::command);
    EXPECT_EQ(risk(tunnelled(support::frame(0x30, 0xDC, 0xC0, {1}))), Risk::tunnel);
    EXPECT_EQ(risk(tunnelled(support::frame(0xFE, 0xDC, 0x03, {0}))), Risk::tunnel);    // of a host
    EXPECT_EQ(risk(tunnelled(tunnelled(euler))), Risk::tunnel);                         // its deeper content is unknown
    EXPECT_EQ(risk(tunnelled({1, 2, 3})), Risk::tunnel);
}

RecordedFrame recorded(const Bytes& bytes, std::chrono::nanoseconds at, std::string_view link = "fc",
                       Direction direction = Direction::in) {
    return {.time_ns = 1'000'000'000 + static_cast<std::uint64_t>(at.count()),
            .link = link,
            .direction = direction,
            .frame = ano::FrameView{bytes}};
}

TEST(Replay, at_rate_0_all_frames_are_due_at_once) {
    ReplayClock clock{0};
    EXPECT_EQ(clock.due(recorded(euler, 0s)), 0ns);
    EXPECT_EQ(clock.due(recorded(euler, 100s)), 0ns);
}

TEST(ReplayPlan, replays_only_received_frames) {
    ReplayPlan plan{{}};
    EXPECT_EQ(plan.due(recorded(euler, 0s)), 0s);
    EXPECT_EQ(plan.due(recorded(euler, 1s, "fc", Direction::out)), std::nullopt);
    EXPECT_EQ(plan.due(recorded(euler, 2s, "fc", Direction::dropped)), std::nullopt);
    EXPECT_EQ(plan.due(recorded(euler, 3s)), 3s);
    EXPECT_EQ(plan.kept_back().of_hosts + plan.kept_back().commands + plan.kept_back().tunnels, 0u);
}

TEST(ReplayPlan, counts_omitted_frames_by_their_risk) {
    const Bytes of_host = support::frame(0xFE, 0xDC, 0x03, {0}), command = support::frame(0x30, 0xDC, 0x61, {0}),
                tunnel = support::frame(0x30, 0xDC, 0xB1, {1, 2, 3});
    ReplayPlan plan{{}}, all{{.rate = 2, .commands = true}};
    for (const Bytes& bytes : {of_host, command, command, tunnel}) {
        EXPECT_EQ(plan.due(recorded(bytes, 1s)), std::nullopt);
        EXPECT_EQ(all.due(recorded(bytes, 1s)), 0s);
    }
    EXPECT_EQ(plan.kept_back().of_hosts, 1u);
    EXPECT_EQ(plan.kept_back().commands, 2u);
    EXPECT_EQ(plan.kept_back().tunnels, 1u);
    EXPECT_EQ(all.kept_back().commands, 0u);
}

TEST(ReplayPlan, that_replays_nothing_reports_why) {
    const Bytes command = support::frame(0x30, 0xDC, 0x61, {0});
    const auto why = [](ReplayPlan::Options options, const std::vector<RecordedFrame>& frames) {
        ReplayPlan plan{std::move(options)};
        for (const RecordedFrame& frame : frames) plan.due(frame);
        return plan.why_nothing();
    };
    const std::vector<RecordedFrame> flight{recorded(euler, 0s), recorded(euler, 10s, "imu", Direction::out),
                                            recorded(euler, 20s)};
    EXPECT_EQ(why({}, flight), "");
    EXPECT_EQ(why({.from = 20s}, flight), "");
    EXPECT_EQ(why({}, {}), "it contains no frames");
    EXPECT_EQ(why({.links = {"radio"}}, flight), "there is no link radio in it; it has fc and imu");
    EXPECT_EQ(why({.from = 30s, .links = {"radio", "gps"}}, flight), "there is no link radio or gps in it; it has fc and imu");
    EXPECT_EQ(why({.links = {"radio", "fc"}}, flight), "");
    EXPECT_EQ(why({.links = {"imu"}}, flight), "none of the requested frames was received");
    EXPECT_EQ(why({.from = 30s}, flight), "it is 20 s long, so there is nothing to replay from 30 s on");
    EXPECT_EQ(why({.from = 20001ms}, {recorded(euler, 0s), recorded(euler, 1440ms)}),
              "it is 1.4 s long, so there is nothing to replay from 20 s on");
    EXPECT_EQ(why({.from = 1s, .to = 5s}, flight), "none of the requested frames was received");
    EXPECT_NE(why({}, {recorded(command, 0s)}).find("so none is replayed; set commands=true"), std::string::npos);
    EXPECT_EQ(why({}, {recorded(command, 0s), recorded(euler, 1s)}), "");
}

TEST(ReplayPlan, begins_and_ends_at_the_configured_times_of_the_whole_recording) {
    ReplayPlan plan{{.rate = 2, .from = 10s, .to = 20s, .links = {"radio"}}};
    EXPECT_EQ(plan.due(recorded(euler, 0s)), std::nullopt);
    EXPECT_EQ(plan.due(recorded(euler, 9s, "radio")), std::nullopt);
    EXPECT_EQ(plan.due(recorded(euler, 10s, "radio")), 0s);
    EXPECT_EQ(plan.due(recorded(euler, 12s, "fc")), std::nullopt);
    EXPECT_EQ(plan.due(recorded(euler, 14s, "radio")), 2s);
    EXPECT_FALSE(plan.is_over());
    EXPECT_EQ(plan.due(recorded(euler, 20s, "radio")), std::nullopt);
    EXPECT_TRUE(plan.is_over());
}

}    // namespace
}    // namespace replay_tests
