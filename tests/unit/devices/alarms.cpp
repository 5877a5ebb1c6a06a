// Alarms: the values that are beyond their limits, in simulated time, and the reports to clients that follow them.
#include <ano/flexible.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ano_json/text.hpp>
#include <devices/alarm_watch.hpp>
#include <devices/loss_watch.hpp>
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

#include <limits>

namespace alarms_tests {
namespace {

using namespace support;
using anogate::ActiveAlarm;
using anogate::AlarmLevel;
using anogate::AlarmLimit;
using anogate::AlarmWatch;
using anogate::LimitClock;
using Json = nlohmann::ordered_json;
using enum AlarmLevel;

const AlarmLimit cell{"power.voltage", true, 3.6, 3.4, 4u, 2};    // volts per cell of four, for 2 s

Bytes power(double voltage, std::uint8_t from = 0xDC) {
    ano::Draft<"power"> draft;
    EXPECT_TRUE(draft.set<"voltage">(voltage));
    Bytes bytes(256);
    bytes.resize(draft.encode(bytes, from, ano::address::broadcast));
    return bytes;
}

TEST(Alarms, are_raised_when_a_value_is_beyond_its_limit_for_long_enough) {
    const auto levels = [](std::initializer_list<double> values, const AlarmLimit& limit) {
        std::vector<AlarmLevel> all;
        for (const double value : values) all.push_back(anogate::level_of(value, limit));
        return all;
    };
    EXPECT_EQ(levels({3.7, 3.6, 3.5, 3.4, 3.3}, cell), (std::vector{none, none, amber, amber, red}));
    EXPECT_EQ(levels({499, 500, 500.5}, {"return_home.r_d", false, std::nullopt, 500, std::nullopt, 0}),
              (std::vector{none, none, red}));
    LimitClock clock;
    const TimePoint begin{1h};
    const auto at = [&](double s, double volts_a_cell) {
        const TimePoint now = begin + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
        clock.update(4 * volts_a_cell, cell, now);
        return clock.level(cell, now);
    };
    std::vector<AlarmLevel> told;
    for (const auto& [s, volts] :
         {std::pair{0.0, 3.5}, {1.0, 3.5}, {2.0, 3.5}, {2.5, 3.3}, {4.4, 3.3}, {4.5, 3.3}, {5.0, 3.5}, {6.0, 3.9}, {7.0, 3.5}})
        told.push_back(at(s, volts));
    EXPECT_EQ(told, (std::vector{none, none, amber, amber, amber, red, amber, none, none}));
    EXPECT_EQ(clock.level(cell, begin + 8900ms), none);
    EXPECT_EQ(clock.level(cell, begin + 9s), amber) << "a value that does not arrive any more stays as it was";
    EXPECT_EQ(clock.level(cell, begin + 24h), amber);
}

struct Watch : testing::Test {
    AlarmWatch watch;
    ano::FlexibleLayouts layouts;
    TimePoint time{1h};

    bool receive(const Bytes& bytes) {
        const ano::FrameView frame{bytes};
        return watch.receive(frame.source(), ano::read(frame, &layouts), time);
    }
    std::string told() const {
        std::string all;
        for (const ActiveAlarm& alarm : watch.active(time))
            all += (all.empty() ? "" : ", ") + ano::hex_byte(alarm.device) + " " + alarm.limit.field + " " +
                   std::string{text(alarm.level)} + " " + ano::number_text(alarm.value);
        return all;
    }
};

TEST_F(Watch, selects_only_frames_with_a_limit) {
    for (unsigned id = 0; id < 256; ++id) EXPECT_FALSE(watch.wants(0xDC, static_cast<std::uint8_t>(id)));
    watch.set(0xDC, {cell, {"no_message.x", true, 1.0, std::nullopt, std::nullopt, 0}}, time);
    for (unsigned id = 0; id < 256; ++id)
        EXPECT_EQ(watch.wants(0xDC, static_cast<std::uint8_t>(id)), id == ano::id_of<"power">) << id;
    EXPECT_FALSE(watch.wants(0xDD, ano::id_of<"power">));
    watch.set(0xFE, {cell}, time);
    EXPECT_FALSE(watch.wants(0xFE, ano::id_of<"power">)) << "a host has no alarms";
    watch.set(0xDC, {}, time);
    EXPECT_FALSE(watch.wants(0xDC, ano::id_of<"power">));
}

TEST_F(Watch, lists_red_alarms_first_and_ignores_frames_without_a_value) {
    const AlarmLimit at_once{"power.voltage", true, 14.4, 13.6, std::nullopt, 0};
    watch.set(0x34, {at_once}, time);
    watch.set(0xDC, {at_once, {"power.no_field", true, 1.0, std::nullopt, std::nullopt, 0}}, time);
    EXPECT_FALSE(receive(power(15))) << "it is well, and was before";
    EXPECT_TRUE(receive(power(14, 0x34)));
    EXPECT_TRUE(receive(power(13.2)));
    EXPECT_EQ(told(), "0xDC power.voltage red 13.2, 0x34 power.voltage amber 14");
    Bytes cut = frame(0xDC, 0xFF, ano::id_of<"power">, {1});
    EXPECT_FALSE(receive(cut));
    EXPECT_TRUE(receive(power(15))) << "it comes back";
    EXPECT_EQ(told(), "0x34 power.voltage amber 14");
    EXPECT_FALSE(receive(power(15)));
}

TEST_F(Watch, checks_the_last_value_against_new_limits) {
    watch.set(0xDC, {cell}, time);
    receive(power(14));    // 3.5 V per cell
    time += 2s;
    EXPECT_EQ(told(), "0xDC power.voltage amber 3.5");
    watch.set(0xDC, {{"power.voltage", true, 3.6, 3.55, 4u, 2}}, time);
    EXPECT_EQ(told(), "0xDC power.voltage amber 3.5") << "red counts from now on";
    time += 2s;
    EXPECT_EQ(told(), "0xDC power.voltage red 3.5");
    watch.set(0xDC, {{"power.voltage", true, 3.45, 3.3, 4u, 2}}, time);
    EXPECT_EQ(told(), "");
    watch.set(0xDC, {cell}, time);
    time += 2s;
    EXPECT_EQ(told(), "0xDC power.voltage amber 3.5");
    watch.forget(0xDC);
    EXPECT_EQ(told(), "") << "it was switched off";
    watch.set(0xDC, {}, time);
    watch.set(0xDC, {cell}, time);
    EXPECT_EQ(told(), "");
}

TEST_F(Watch, checks_flexible_messages_by_their_layouts_and_skips_values_that_are_not_finite) {
    ano::FlexibleSpec spec;
    spec.id = 0xF1;
    spec.fields = {{"percent", ano::Type::f32, 1, "%", 1}, {"many", ano::Type::u8, 1, "", 4}};
    layouts.add(spec);
    watch.set(0xDC,
              {{"flexible1.percent", true, 25.0, 15.0, std::nullopt, 0}, {"flexible1.many", true, 25.0, 15.0, std::nullopt, 0}},
              time);
    const auto percent = [](float value) {
        Bytes data(8);
        std::memcpy(data.data(), &value, sizeof value);
        return frame(0xDC, 0xFF, 0xF1, data);
    };
    receive(percent(12));
    EXPECT_EQ(told(), "0xDC flexible1.percent red 12");
    receive(percent(std::numeric_limits<float>::quiet_NaN()));
    EXPECT_EQ(told(), "0xDC flexible1.percent red 12");
    receive(percent(20));
    EXPECT_EQ(told(), "0xDC flexible1.percent amber 20");
    layouts = ano::FlexibleLayouts{};
    EXPECT_FALSE(receive(percent(90))) << "nobody knows what it says";
}

struct AlarmAnswers : testing::Test {
    SimulatedNet net;

    void receive(double voltage, std::uint8_t from = 0xDC) {
        const Bytes bytes = power(voltage, from);
        if (net.service.alarms().watch().wants(from, ano::id_of<"power">))
            net.service.record_value(from, ano::read(ano::FrameView{bytes}), net.time);
    }
    void set(double for_s = 0) {
        const std::string row = R"({"field":"power.voltage","side":"below","amber":3.6,"red":3.4,"cells":4,"for_s":)";
        EXPECT_EQ(net.ask("PUT", "/devices/0xDC/limits", R"({"limits":[)" + row + std::to_string(for_s) + "}]}").status, 200u);
    }
    /// "red 3.3" for the only alarm; "" if there is none.
    static std::string in(const Json& answer) {
        const Json& all = answer.at("alarms");
        if (all.empty()) return {};
        return all.at(0).at("level").get<std::string>() + " " + ano::number_text(all.at(0).at("value").get<double>());
    }
    std::string now() { return in(net.ask("GET", "/alarms").json); }
};

/// A client that follows; reads all available lines.
struct Follower {
    std::unique_ptr<anogate::http::Producer> producer;
    std::size_t woken = 0;
    explicit Follower(SimulatedNet& net, const std::string& path = "/alarms") : producer{net.lines("GET", path)} {
        if (producer) producer->start([this] { ++woken; });
    }
    std::vector<Json> lines() {
        std::string all;
        while (true) {
            std::string part;
            const auto next = producer->next(part);
            all += part;
            if (next != anogate::http::Producer::Next::part) break;
        }
        std::vector<Json> found;
        for (std::size_t at = 0, end = 0; (end = all.find('\n', at)) != all.npos; at = end + 1)
            found.push_back(Json::parse(all.substr(at, end - at)));
        return found;
    }
};

TEST_F(AlarmAnswers, list_the_current_alarms) {
    EXPECT_EQ(net.ask("GET", "/alarms").json, (Json{{"alarms", Json::array()}}));
    set(2);
    receive(13.2);
    EXPECT_EQ(now(), "");
    net.pass(2s);
    const Json alarm = net.ask("GET", "/alarms").json.at("alarms").at(0);
    EXPECT_EQ(alarm, (Json{{"device", "0xDC"},
                           {"field", "power.voltage"},
                           {"side", "below"},
                           {"level", "red"},
                           {"value", 3.3},
                           {"limit", 3.4},
                           {"unit", "V"},
                           {"cells", 4},
                           {"beyond_s", 2.0},
                           {"age_s", 2.0}}));
    receive(14.2);
    EXPECT_EQ(now(), "amber 3.55") << "it was beyond amber as long";
    net.ask("PUT", "/devices/0xDC/limits", R"({"limits":[]})");
    EXPECT_EQ(now(), "");
}

TEST_F(AlarmAnswers, use_limits_stored_by_an_earlier_run) {
    set();
    SimulatedNet after;
    EXPECT_EQ(after.service.remember_limits(0xDC, net.kept.at("limits-0xDC.json")), "");
    const Bytes bytes = power(13.2);
    after.service.record_value(0xDC, ano::read(ano::FrameView{bytes}), after.time);
    EXPECT_EQ(in(after.ask("GET", "/alarms").json), "red 3.3");
}

TEST_F(AlarmAnswers, send_all_alarms_at_each_change_and_nothing_while_there_are_none) {
    set(1);
    Follower follower{net};
    ASSERT_TRUE(follower.producer);
    auto lines = follower.lines();
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(in(lines[0]), "");
    for (int i = 0; i < 500; ++i) {
        receive(15.2);
        net.pass(20ms);
    }
    EXPECT_EQ(follower.woken, 0u) << "all is well";
    receive(13.2);
    net.pass(900ms);
    EXPECT_EQ(follower.woken, 0u) << "not for long enough";
    net.pass(300ms);    // no other frame is received
    lines = follower.lines();
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(in(lines[0]), "red 3.3");
    net.pass(5s);
    EXPECT_EQ(follower.woken, 6u) << "once a second, for its age";
    lines = follower.lines();
    ASSERT_EQ(lines.size(), 1u) << "what was not taken is replaced";
    EXPECT_GT(lines[0].at("alarms").at(0).at("age_s"), 5.0);
    receive(15.2);
    net.pass(100ms);
    lines = follower.lines();
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(in(lines[0]), "");
    const std::size_t before = follower.woken;
    net.pass(1min);
    EXPECT_EQ(follower.woken, before);
}

TEST_F(AlarmAnswers, report_a_constantly_changing_value_at_most_ten_times_a_second) {
    set();
    Follower follower{net};
    follower.lines();
    std::size_t told = 0;
    for (int i = 0; i < 1000; ++i) {
        receive(13.0 + 0.01 * (i % 7));
        net.pass(1ms);
        told += follower.lines().size();
    }
    EXPECT_GE(told, 5u);
    EXPECT_LE(told, 10u);
    net.service.forget_values(0xDC);
    net.pass(100ms);
    const auto lines = follower.lines();
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(in(lines[0]), "");
}

struct LostVehicles : testing::Test {
    SimulatedNet net;

    void send_mode(std::uint8_t flag, std::uint8_t from = 0xDC) {
        const Bytes bytes = frame(from, 0xFF, 0x06, {3, flag, 0, 0, 0});
        net.service.record_mode(ano::FrameView{bytes}, net.time);
    }
    Json lost() {
        const Json answer = net.ask("GET", "/devices").json;
        return answer.contains("lost") ? answer.at("lost") : Json::array();
    }
};

// For a page that is opened after the loss.
TEST_F(LostVehicles, are_listed_with_their_last_state_until_they_are_received_again) {
    send_mode(2);
    net.pass(1900ms);
    EXPECT_EQ(lost(), Json::array());
    net.pass(1s);
    EXPECT_EQ(lost(), (Json::array({{{"address", "0xDC"}, {"age", 2.9}, {"sflag", 2}}})));
    net.pass(3600s);
    EXPECT_EQ(lost().at(0).at("age"), 3602.9);
    send_mode(2);
    EXPECT_EQ(lost(), Json::array());
    net.pass(3s);
    EXPECT_EQ(lost().size(), 1u);
    net.service.forget_values(0xDC);
    EXPECT_EQ(lost(), Json::array()) << "it was switched off";
}

TEST_F(LostVehicles, that_were_locked_are_listed_for_a_minute) {
    send_mode(0);
    send_mode(1, 0xDD);
    net.pass(59s);
    EXPECT_EQ(lost().size(), 2u);
    net.pass(2s);
    EXPECT_EQ(lost().size(), 1u);
    EXPECT_EQ(lost().at(0).at("address"), "0xDD");
}

// An optical flow sensor, or a vehicle whose program sends no `mode`.
TEST_F(LostVehicles, that_never_sent_a_mode_are_listed_without_a_state) {
    for (int i = 0; i < 3; ++i) {
        net.service.record_telemetry(0x51, 0x51, net.time);
        net.pass(2s);
    }
    net.pass(2s);
    EXPECT_EQ(lost(), Json::array()) << "its next frame may come yet";
    net.pass(2s);
    EXPECT_EQ(lost(), (Json::array({{{"address", "0x51"}, {"age", 6.0}}})));
    net.pass(3600s);
    EXPECT_EQ(lost().size(), 1u);
    net.service.record_telemetry(0x51, 0x51, net.time);
    EXPECT_EQ(lost(), Json::array());
    net.pass(7s);
    EXPECT_EQ(lost(), Json::array()) << "a single frame is no telemetry that could end";
    for (int i = 0; i < 3; ++i) net.service.record_telemetry(0x51, 0x51, net.time);
    net.pass(7s);
    EXPECT_EQ(lost().size(), 1u);
    net.service.forget_values(0x51);
    EXPECT_EQ(lost(), Json::array()) << "it was switched off";
}

TEST_F(LostVehicles, exclude_devices_that_only_answer_or_log) {
    for (const std::uint8_t id :
         {std::uint8_t{0xE3}, std::uint8_t{0xE1}, std::uint8_t{0xA0}, std::uint8_t{0xB0}, std::uint8_t{0xFB}})
        for (int i = 0; i < 9; ++i) net.service.record_telemetry(0x51, id, net.time), net.pass(1s);
    net.pass(60s);
    EXPECT_EQ(lost(), Json::array());
}

TEST_F(LostVehicles, are_lost_after_a_silence_that_depends_on_their_period) {
    using anogate::LossWatch;
    for (const Duration period : std::initializer_list<Duration>{20ms, 100ms, 1s, 4s}) {
        LossWatch watch;
        TimePoint now{1h};
        for (std::size_t i = 0; i <= LossWatch::periods; ++i) watch.record_mode(0xDC, 2, now += period);
        const TimePoint last = now;
        EXPECT_FALSE(watch.device(0xDC, last + period + 899ms)->is_lost);
        EXPECT_TRUE(watch.device(0xDC, last + period + 900ms)->is_lost);
        EXPECT_EQ(watch.device(0xDC, last)->lost_at, last + period + 900ms);
        watch.receive(0xDC, 0xE1, last + 500ms);
        EXPECT_FALSE(watch.device(0xDC, last + period + 1s)->is_lost) << "another frame of it came";
        watch.receive(0xDC, 0xE1, last + period + 1s);
        EXPECT_EQ(watch.device(0xDC, last)->lost_at, last + period + 1s + LossWatch::lost_after) << "alone";
        watch.record_mode(0xDC, 2, now += 1min);    // the period is not known
        EXPECT_EQ(watch.device(0xDC, now)->lost_at, now + period + 900ms);
        watch.forget(0xDC);
        EXPECT_FALSE(watch.device(0xDC, now));
    }
    LossWatch brief;
    brief.record_mode(0xDC, 2, TimePoint{1h});
    EXPECT_EQ(brief.device(0xDC, TimePoint{1h})->lost_at, TimePoint{1h} + LossWatch::lost_after);
    brief.receive(0xDD, 0xE1, TimePoint{1h});
    EXPECT_FALSE(brief.device(0xDD, TimePoint{1h}));
}

// Any program in a network can send frames with the address of a lost vehicle.
TEST_F(LostVehicles, stay_lost_while_they_are_only_received_on_another_link) {
    EXPECT_FALSE(net.service.stays_lost(0xDC)) << "it was never heard";
    send_mode(0);
    EXPECT_FALSE(net.service.stays_lost(0xDC)) << "it was locked, and may be connected elsewhere";
    send_mode(2);
    EXPECT_TRUE(net.service.stays_lost(0xDC));
    net.pass(3s);
    net.service.record_elsewhere(0xDC, "radio", net.time);
    EXPECT_TRUE(net.service.was_received_elsewhere(0xDC));
    EXPECT_EQ(lost(), (Json::array({{{"address", "0xDC"}, {"age", 3.0}, {"sflag", 2}, {"elsewhere", "radio"}}})));
    send_mode(2);
    EXPECT_EQ(lost(), Json::array());
    EXPECT_FALSE(net.service.was_received_elsewhere(0xDC)) << "it was heard";
    EXPECT_TRUE(net.service.forget_values(0xDC));
    EXPECT_FALSE(net.service.forget_values(0xDC));
    EXPECT_FALSE(net.service.stays_lost(0xDC));
    for (int i = 0; i < 3; ++i) net.service.record_telemetry(0x51, 0x51, net.time);
    EXPECT_TRUE(net.service.stays_lost(0x51)) << "it has no state that says it is on the ground";
}

// "lost DC 2 1.5, heard DD": the devices in the last line.
std::string devices_in(const std::vector<Json>& lines) {
    std::string all;
    if (lines.empty()) return "no line";
    if (!lines.back().contains("devices")) return "none";
    for (const Json& one : lines.back().at("devices")) {
        all += (all.empty() ? "" : ", ") + std::string{one.at("lost").get<bool>() ? "lost " : "heard "} +
               one.at("address").get<std::string>();
        if (one.contains("sflag")) all += " " + one.at("sflag").dump();
        if (one.contains("age")) all += " " + one.at("age").dump();
    }
    return all;
}

// A hidden page receives no other reports.
TEST_F(LostVehicles, are_reported_to_followers_of_the_alarms_when_lost_and_when_back) {
    Follower follower{net};
    EXPECT_EQ(devices_in(follower.lines()), "none");
    const auto fly = [&](Duration duration, std::uint8_t flag = 2) {
        for (const TimePoint end = net.time + duration; net.time < end; net.pass(100ms)) send_mode(flag);
    };
    send_mode(2, 0xFE);
    net.pass(1s);
    EXPECT_EQ(follower.woken, 0u) << "a host is no vehicle";
    fly(10s);
    EXPECT_EQ(follower.woken, 1u) << "while all is well, once";
    EXPECT_EQ(devices_in(follower.lines()), "heard 0xDC");
    net.pass(800ms);    // after 100 ms of its period
    EXPECT_EQ(follower.woken, 1u);
    net.pass(100ms);
    EXPECT_EQ(devices_in(follower.lines()), "lost 0xDC 2 1.0") << "nothing else comes";
    net.pass(5s);
    EXPECT_EQ(follower.woken, 7u) << "once a second, for who makes a sound";
    Follower late{net};
    EXPECT_EQ(devices_in(late.lines()), "lost 0xDC 2 6.0");
    follower.lines();
    fly(200ms);
    EXPECT_EQ(devices_in(follower.lines()), "heard 0xDC");
    net.pass(2s);
    EXPECT_EQ(devices_in(follower.lines()), "lost 0xDC 2 2.1");
    net.service.forget_values(0xDC);
    net.pass(100ms);
    EXPECT_EQ(devices_in(follower.lines()), "none");
}

TEST_F(LostVehicles, that_never_sent_a_mode_are_reported_to_followers_too) {
    Follower follower{net};
    follower.lines();
    const auto send = [&] {
        for (int i = 0; i < 3; ++i, net.pass(200ms)) net.service.record_telemetry(0x51, 0x51, net.time);
    };
    send();
    EXPECT_EQ(devices_in(follower.lines()), "heard 0x51");
    net.pass(5s);
    EXPECT_EQ(devices_in(follower.lines()), "lost 0x51 5.2");
    send();
    EXPECT_EQ(devices_in(follower.lines()), "heard 0x51");
}

TEST_F(LostVehicles, that_were_locked_are_reported_to_followers_for_a_minute_and_stay_lost) {
    Follower follower{net};
    follower.lines();
    send_mode(0);
    net.pass(62s);
    EXPECT_EQ(devices_in(follower.lines()), "lost 0xDC 0 62.0");
    const std::size_t woken = follower.woken;
    net.pass(1h);
    EXPECT_EQ(follower.woken, woken);
    EXPECT_EQ(devices_in(Follower{net}.lines()), "lost 0xDC 0 3662.0");
}

TEST_F(LostVehicles, are_not_reported_by_a_gateway_that_was_stalled) {
    Follower follower{net};
    follower.lines();
    send_mode(2);
    net.pass(200ms);
    EXPECT_EQ(devices_in(follower.lines()), "heard 0xDC");
    net.time += 10s;
    net.service.run(net.time);    // before the frames received meanwhile are read
    send_mode(2);
    net.pass(1s);
    EXPECT_EQ(devices_in(follower.lines()), "no line");
    net.pass(2s);
    EXPECT_EQ(devices_in(follower.lines()).substr(0, 11), "lost 0xDC 2");
}

struct LogStream : testing::Test {
    SimulatedNet net;
    std::uint64_t time_ns = 1'000'000'000'000;

    void log(const std::string& text, std::uint8_t from = 0xDC) {
        Bytes data{1};
        data.insert(data.end(), text.begin(), text.end());
        const Bytes bytes = frame(from, 0xFF, 0xA0, data);
        net.service.record_log(ano::FrameView{bytes}, "fc", time_ns += 1'000'000'000);
    }
    static std::string texts(const std::vector<Json>& lines) {
        std::string all;
        for (const Json& line : lines)
            all += (all.empty() ? "" : ", ") +
                   (line.contains("lost") ? "lost " + line.at("lost").dump() : line.at("text").get<std::string>());
        return all;
    }
};

TEST_F(LogStream, begins_with_the_stored_lines_and_continues_with_new_ones) {
    for (const char* text : {"a", "b", "c"}) log(text);
    log("x", 0xDD);
    Follower all{net, "/devices/0xDC/log"}, late{net, "/devices/0xDC/log?since=1003"}, everybody{net, "/devices/0xFF/log"};
    EXPECT_EQ(texts(all.lines()), "a, b, c");
    EXPECT_EQ(texts(late.lines()), "c");
    EXPECT_EQ(texts(everybody.lines()), "a, b, c, x");
    log("d");
    log("y", 0xDD);
    log("e");
    net.pass(20ms);
    EXPECT_EQ(all.woken, 1u) << "lines that come together are told together";
    EXPECT_EQ(texts(all.lines()), "d, e");
    EXPECT_EQ(texts(late.lines()), "d, e");
    EXPECT_EQ(texts(everybody.lines()), "d, y, e");
    EXPECT_EQ(texts(all.lines()), "");
    time_ns = 1;    // the clock was set back
    log("f");
    EXPECT_EQ(texts(late.lines()), "f");
}

TEST_F(LogStream, counts_lines_that_a_slow_client_lost) {
    log("first");
    Follower slow{net, "/devices/0xDC/log"}, everybody{net, "/devices/0xFF/log"};
    for (int i = 0; i < 600; ++i) log("line " + std::to_string(i));
    auto lines = slow.lines();
    ASSERT_EQ(lines.size(), 501u);
    EXPECT_EQ(lines.front(), (Json{{"lost", 100}}));
    EXPECT_EQ(lines[1].at("text"), "line 100");
    lines = everybody.lines();
    ASSERT_EQ(lines.size(), 501u);
    EXPECT_EQ(lines.front(), (Json{{"lost", 100}}));
    Follower next{net, "/devices/0xDC/log"};
    lines = next.lines();
    ASSERT_EQ(lines.size(), 500u) << "what was forgotten before it came is not lost";
    EXPECT_EQ(lines.front().at("text"), "line 100");
}

}    // namespace
}    // namespace alarms_tests
