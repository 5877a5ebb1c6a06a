#include <ros2/bridge.hpp>
#include <ros2/ros2_config.hpp>

#include <ano/typed.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <unit/ros2/fake_bus.hpp>

namespace bridge_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
using ros2_tests::FakeBus;
using ros2_tests::KeptOutput;
using support::Bytes;

constexpr std::uint8_t mode_id = 0x06, inertial_id = 0x01;

Ros2Settings configured(const std::string& json) {
    Ros2Settings settings;
    ConfigErrors errors;
    read_ros2_config(json, "", settings, errors);
    EXPECT_TRUE(errors.empty()) << (errors.empty() ? "" : errors.front().where + ": " + errors.front().what);
    return settings;
}

struct Bridged {
    explicit Bridged(const std::string& json = "{}") : settings{configured(json)} {}

    Ros2Settings settings;
    FakeBus bus;
    KeptOutput output;
    Bridge bridge{settings, bus, output};
    ano::TimePoint now{1000s};
    std::uint64_t time_ns = 1'700'000'000'000'000'007;
    bool is_elsewhere = false;

    void receive(std::uint8_t source, std::uint8_t id, const Bytes& data, const std::string& link = "fc") {
        const Bytes bytes = support::frame(source, 0xFE, id, data);
        FrameRecord record{.time_ns = time_ns, .boottime_ns = time_ns / 2, .frame = ano::FrameView{bytes}};
        record.is_elsewhere = is_elsewhere;
        bridge.receive(link, record, now);
    }
    void report_mode(std::uint8_t mode) { receive(5, mode_id, {mode, 2, 0, 0, 0}); }

    /// A message on the subscription of `topic`.
    void publish(const std::string& topic, const std::string& cdr, std::uint8_t publisher = 1) {
        Sample sample;
        sample.topic = bus.subscriptions.size();
        for (std::size_t i = 0; i < bus.subscriptions.size(); ++i)
            if (bus.subscriptions[i].name == topic) sample.topic = i;
        ASSERT_LT(sample.topic, bus.subscriptions.size()) << topic;
        sample.publisher[0] = publisher;
        sample.cdr = cdr;
        sample.received_at = now;
        bridge.on_sample(sample, now);
    }
};

void append(std::string& cdr, const auto value) { cdr.append(reinterpret_cast<const char*>(&value), sizeof value); }

std::string twist(double x, double y, double z, double yaw) {
    std::string cdr{"\0\1\0\0", 4};
    for (const double value : {x, y, z, 0.0, 0.0, yaw}) append(cdr, value);
    return cdr;
}

std::string text(const std::string& value) {
    std::string cdr{"\0\1\0\0", 4};
    append(cdr, static_cast<std::uint32_t>(value.size() + 1));
    return cdr + value + '\0';
}

std::string joy(std::size_t axes, float value) {
    std::string cdr{"\0\1\0\0", 4};
    append(cdr, std::uint64_t{0});
    append(cdr, std::uint32_t{1});
    append(cdr, std::uint32_t{0});    // the NUL of frame_id, and a gap
    append(cdr, static_cast<std::uint32_t>(axes));
    for (std::size_t i = 0; i < axes; ++i) append(cdr, value);
    append(cdr, std::uint32_t{0});
    return cdr;
}

constexpr char velocities[] = R"({"devices": [{"address": 5, "prefix": "drone", "accept": ["cmd_vel"], "hover_throttle": 40}]})";

TEST(Bridge, publishes_a_standard_message_and_our_own_under_the_name_of_the_link) {
    Bridged b;
    b.receive(5, inertial_id, Bytes(13));
    ASSERT_EQ(b.bus.on("/fc/imu/data").size(), 1u);
    const ano::Json imu = b.bus.on("/fc/imu/data").front();
    EXPECT_EQ(imu["header"]["frame_id"], "fc");
    EXPECT_EQ(imu["header"]["stamp"]["sec"], 1'700'000'000);
    EXPECT_EQ(imu["orientation_covariance"][0], -1);
    EXPECT_EQ(b.bus.on("/fc/raw/inertial").size(), 1u);
}

TEST(Bridge, nothing_is_encoded_for_nobody_but_counted_for_the_list) {
    Bridged b;
    b.bus.someone_subscribes = false;
    b.receive(5, inertial_id, Bytes(13));
    EXPECT_TRUE(b.bus.has("/fc/imu/data"));
    EXPECT_TRUE(b.bus.on("/fc/imu/data").empty());
    EXPECT_NE(b.bridge.list(2s).find("/fc/imu/data"), std::string::npos);
    EXPECT_NE(b.bridge.list(2s).find("0.5 Hz"), std::string::npos);
}

TEST(Bridge, frames_of_hosts_and_of_other_links_than_the_one_of_the_device_are_not_published) {
    Bridged b;
    b.receive(0xFE, inertial_id, Bytes(13));
    b.receive(0xD2, inertial_id, Bytes(13));
    b.receive(0xFF, inertial_id, Bytes(13));
    b.is_elsewhere = true;
    b.receive(5, inertial_id, Bytes(13));
    EXPECT_FALSE(b.bus.has("/fc/imu/data"));
}

TEST(Bridge, a_second_device_with_the_same_prefix_is_refused_with_what_to_do) {
    Bridged b;
    b.receive(5, inertial_id, Bytes(13));
    for (int i = 0; i < 3; ++i) b.receive(6, inertial_id, Bytes(13));
    EXPECT_EQ(b.bus.on("/fc/imu/data").size(), 1u);
    ASSERT_EQ(b.output.warnings.size(), 1u);    // once
    EXPECT_NE(b.output.warnings.front().find("prefix 'fc' belongs to device 0x05; add {\"address\": \"0x06\""),
              std::string::npos);
    EXPECT_NE(b.bridge.list(3s).find("no topics for device 0x06 on link fc"), std::string::npos);
}

TEST(Bridge, prefixes_are_configured_or_the_names_of_devices) {
    Bridged configured{R"({"devices": [{"address": 6, "prefix": "fleet/drone2"}]})"};
    configured.receive(6, inertial_id, Bytes(13));
    EXPECT_TRUE(configured.bus.has("/fleet/drone2/imu/data"));

    Bridged named{R"({"prefix": "device"})"};
    named.receive(5, inertial_id, Bytes(13));
    EXPECT_TRUE(named.bridge.needs_names());
    named.bridge.use(std::vector<DeviceNote>{{5, "8 ANO-LX 拓空者"}});
    named.receive(5, inertial_id, Bytes(13));
    EXPECT_TRUE(named.bus.has("/device_8_ANO_LX/imu/data"));
}

TEST(Bridge, a_topic_has_the_reliability_of_the_configuration) {
    Bridged b{R"({"qos": {"imu/data": "best_effort", "raw": "best_effort"}})"};
    b.receive(5, inertial_id, Bytes(13));
    b.receive(5, 0x0D, Bytes(4));
    for (const auto& topic : b.bus.topics) {
        const bool best_effort = topic.spec.name == "/fc/imu/data" || topic.spec.name.starts_with("/fc/raw/");
        EXPECT_EQ(topic.spec.reliability == Reliability::best_effort, best_effort) << topic.spec.name;
    }
}

TEST(Bridge, variances_of_the_configuration_are_in_the_covariances_and_are_never_nan) {
    Bridged b{R"({"variances": {"angular_velocity": 0.5, "linear_acceleration": 2}})"};
    b.receive(5, inertial_id, Bytes(13));
    const ano::Json imu = b.bus.on("/fc/imu/data").front();
    EXPECT_EQ(imu["angular_velocity_covariance"], (ano::Json{0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5}));
    EXPECT_EQ(imu["linear_acceleration_covariance"][8], 2.0);
    EXPECT_EQ(imu["orientation_covariance"], (ano::Json{-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}));
}

TEST(Bridge, sticks_are_a_joy_and_log_lines_a_log) {
    Bridged b;
    Bytes sticks(20);
    sticks[0] = 0xD0, sticks[1] = 0x07;    // 2000
    sticks[2] = 0xE8, sticks[3] = 0x03;    // 1000
    b.receive(5, 0x40, sticks);
    const ano::Json axes = b.bus.on("/fc/joy").front()["axes"];
    EXPECT_EQ(axes[0], 1.0);
    EXPECT_EQ(axes[1], -1.0);
    EXPECT_TRUE(axes[2].is_null());    // 0: no link
    EXPECT_EQ(axes.size(), 10u);
    b.receive(5, 0xA0, {1, 'l', 'o', 'w'});
    const ano::Json line = b.bus.on("/fc/log").front();
    EXPECT_EQ(line["level"], 40);
    EXPECT_EQ(line["name"], "fc");
    EXPECT_EQ(line["msg"], "low");
    b.receive(5, 0xA1, {0, 0, 0x20, 0x41, 'v'});
    EXPECT_EQ(b.bus.on("/fc/log").back()["msg"], "v 10");
}

TEST(Bridge, the_transform_is_published_only_when_asked_for) {
    for (const bool asked : {false, true}) {
        Bridged b{asked ? R"({"tf": true})" : "{}"};
        b.receive(5, 0x03, Bytes(7));
        b.receive(5, 0x07, Bytes(6));
        Bytes position(12);
        position[0] = 100;
        b.receive(5, 0x08, position);
        EXPECT_EQ(b.bus.on("/fc/odom").size(), 1u);
        ASSERT_EQ(b.bus.on("/tf").size(), asked ? 1u : 0u);
        if (!asked) continue;
        const ano::Json transform = b.bus.on("/tf").front()["transforms"][0];
        EXPECT_EQ(transform["header"]["frame_id"], "fc/odom");
        EXPECT_EQ(transform["child_frame_id"], "fc");
        EXPECT_EQ(transform["transform"]["translation"]["x"], 1.0);
        EXPECT_EQ(transform["transform"]["rotation"]["w"], 1.0);
    }
}

TEST(Bridge, velocities_become_frames_for_the_device_only_in_its_modes) {
    Bridged b{velocities};
    b.publish("/drone/cmd_vel", twist(1, 0, 0, 0));    // the subscription is there before the device
    EXPECT_TRUE(b.output.frames.empty());
    b.report_mode(2);
    b.publish("/drone/cmd_vel", twist(1, -0.5, 0.25, 0));
    ASSERT_EQ(b.output.frames.size(), 1u);
    const ano::FrameView frame{b.output.frames.front()};
    EXPECT_EQ(frame.source(), 0xD2);
    EXPECT_EQ(frame.destination(), 5);
    const auto control = ano::as<"realtime_control">(frame);
    ASSERT_TRUE(control);
    EXPECT_EQ(control->get<"ctrl_thr">(), 40);
    EXPECT_EQ(control->get<"ctrl_rol">(), 0);
    EXPECT_EQ(control->get<"ctrl_pit">(), 0);
    EXPECT_EQ(control->get<"ctrl_spd_x">(), 100);
    EXPECT_EQ(control->get<"ctrl_spd_y">(), -50);
    EXPECT_EQ(control->get<"ctrl_spd_z">(), 25);
    b.report_mode(0);
    b.publish("/drone/cmd_vel", twist(1, 0, 0, 0));
    EXPECT_EQ(b.output.frames.size(), 1u);
}

TEST(Bridge, a_silent_publisher_stops_the_device_with_one_frame) {
    Bridged b{velocities};
    b.report_mode(2);
    b.publish("/drone/cmd_vel", twist(1, 0, 0, 0));
    for (int tick = 0; tick < 40; ++tick) b.bridge.on_time(b.now += 50ms);
    ASSERT_EQ(b.output.frames.size(), 2u);
    const auto stop = ano::as<"realtime_control">(ano::FrameView{b.output.frames.back()});
    EXPECT_EQ(stop->get<"ctrl_spd_x">(), 0);
    EXPECT_EQ(stop->get<"ctrl_thr">(), 40);
    EXPECT_EQ(b.output.lines.size(), 2u);    // who controls it, and that nobody does any more
    EXPECT_NE(b.output.lines.front().find("controlled by publisher 01.00."), std::string::npos);
}

TEST(Bridge, a_second_publisher_controls_nothing_meanwhile) {
    Bridged b{velocities};
    b.report_mode(2);
    b.publish("/drone/cmd_vel", twist(1, 0, 0, 0), 1);
    b.publish("/drone/cmd_vel", twist(-1, 0, 0, 0), 2);
    EXPECT_EQ(b.output.frames.size(), 1u);
    b.bridge.publish_diagnostics("", b.time_ns, b.now);
    EXPECT_NE(b.bus.on("/diagnostics").front().dump().find("cmd_vel ignored: from a second publisher"), std::string::npos);
}

TEST(Bridge, publishers_that_take_turns_cause_at_most_20_lines_per_minute) {
    Bridged b{velocities};
    for (int turn = 0; turn < 200; ++turn) {
        b.report_mode(2);
        b.publish("/drone/cmd_vel", twist(1, 0, 0, 0), static_cast<std::uint8_t>(turn));
        b.now += 600ms;
        b.bridge.on_time(b.now);
    }
    EXPECT_LE(b.output.lines.size(), 60u);    // within 2 minutes
    EXPECT_GT(b.output.lines.size(), 20u);
    EXPECT_NE(b.output.lines[19].find("not shown"), std::string::npos);
}

TEST(Bridge, without_a_configuration_there_are_no_inputs) {
    Bridged b;
    b.receive(5, inertial_id, Bytes(13));
    EXPECT_TRUE(b.bus.subscriptions.empty());
}

TEST(Bridge, a_joy_with_ten_axes_becomes_channels_and_is_not_published_then) {
    Bridged b{R"({"devices": [{"address": 5, "prefix": "drone", "accept": ["joy"]}]})"};
    b.receive(5, 0x40, Bytes(20));
    EXPECT_FALSE(b.bus.has("/drone/joy"));
    b.publish("/drone/joy", joy(8, 0.5F));
    EXPECT_TRUE(b.output.frames.empty());
    b.publish("/drone/joy", joy(10, 0.5F));
    ASSERT_EQ(b.output.frames.size(), 1u);
    EXPECT_EQ(ano::as<"remote_control">(ano::FrameView{b.output.frames.front()})->get<"aux6">(), 1750);
    b.publish("/drone/joy", joy(10, std::nanf("")));
    EXPECT_EQ(b.output.frames.size(), 1u);
    EXPECT_NE(b.bridge.list(1s).find("it is an input"), std::string::npos);
}

TEST(Bridge, a_command_is_called_and_its_result_published) {
    Bridged b{R"({"devices": [{"address": 5, "prefix": "drone", "accept": ["command"]}]})"};
    b.publish("/drone/command", text(R"({"command": "TAKE_OFF", "values": [150], "id": "7"})"));
    ASSERT_EQ(b.output.calls.size(), 1u);
    EXPECT_EQ(b.output.calls.front().address, 5);
    EXPECT_EQ(b.output.calls.front().command.command, "TAKE_OFF");
    EXPECT_EQ(b.output.calls.front().command.body, R"({"values":[150]})");
    http::Outcome outcome;
    outcome.answer.status = 200;
    outcome.answer.body = R"({"state": "done"})";
    b.output.calls.front().done(outcome);
    EXPECT_EQ(b.bus.on("/drone/command_result").front()["data"],
              R"({"id":"7","command":"TAKE_OFF","ok":true,"result":{"state":"done"}})");
    outcome.answer.status = 504;
    outcome.answer.body = R"({"error": "no answer"})";
    b.output.calls.front().done(outcome);
    EXPECT_EQ(b.bus.on("/drone/command_result").back()["data"],
              R"({"id":"7","command":"TAKE_OFF","ok":false,"error":"no answer"})");
}

TEST(Bridge, a_text_that_is_no_command_is_answered_with_the_reason) {
    Bridged b{R"({"devices": [{"address": 5, "prefix": "drone", "accept": ["command"]}]})"};
    for (const char* wrong : {"LAND", "{}", R"({"command": "LAND", "vales": []})", R"({"command": 5})",
                              R"({"command": "LAND", "values": 5})", R"({"command": "LAND", "id": 5})"})
        b.publish("/drone/command", text(wrong));
    EXPECT_TRUE(b.output.calls.empty());
    const auto results = b.bus.on("/drone/command_result");
    ASSERT_EQ(results.size(), 6u);
    EXPECT_NE(results[2]["data"].get<std::string>().find("did you mean 'values'"), std::string::npos);
    b.publish("/drone/command", text(std::string(5000, ' ')));
    EXPECT_NE(b.bus.on("/drone/command_result").back()["data"].get<std::string>().find("longer than 4096"), std::string::npos);
    b.publish("/drone/command", "xx");
    EXPECT_NE(b.bus.on("/drone/command_result").back()["data"].get<std::string>().find("not a std_msgs/String"),
              std::string::npos);
}

TEST(Bridge, flexible_messages_follow_the_layouts_of_the_gateway) {
    Bridged b;
    const auto decoding = [](const char* name) {
        ano::FlexibleSpec spec;
        spec.id = 0xF1;
        spec.fields = {{name, ano::Type::u8, 1, "", 1}};
        return std::make_shared<const Decoding>(std::vector{spec});
    };
    b.receive(5, 0xF1, {7});
    EXPECT_FALSE(b.bus.has("/fc/raw/flexible_1"));
    b.bridge.use(decoding("height"));
    b.receive(5, 0xF1, {7});
    const auto topic_of = [&] {
        for (const auto& topic : b.bus.topics)
            if (topic.spec.name.starts_with("/fc/raw/flex") && !topic.is_withdrawn) return topic.messages.back();
        return ano::Json{};
    };
    EXPECT_EQ(topic_of(), (ano::Json{{"height", 7}}));
    b.bridge.use(decoding("depth"));
    b.receive(5, 0xF1, {8});
    EXPECT_EQ(topic_of(), (ano::Json{{"depth", 8}}));
}

TEST(Bridge, diagnostics_name_the_gateway_the_devices_and_those_without_topics) {
    Bridged b;
    b.receive(5, inertial_id, Bytes(13));
    b.receive(6, inertial_id, Bytes(13));
    b.bridge.publish_diagnostics("no gateway is running", b.time_ns, b.now + 6s);
    const ano::Json array = b.bus.on("/diagnostics").front();
    EXPECT_EQ(array["status"][0]["level"], 2);
    EXPECT_EQ(array["status"][0]["message"], "no gateway is running");
    EXPECT_NE(array["status"][0].dump().find("no topics for 0x06 on fc"), std::string::npos);
    EXPECT_EQ(array["status"][1]["name"], "anogate: fc");
    EXPECT_EQ(array["status"][1]["level"], 3);    // no frames for 5 s
    EXPECT_EQ(array["status"][1]["hardware_id"], "0x05");
}

TEST(Bridge, the_list_says_why_a_topic_is_silent) {
    Bridged b;
    b.receive(5, 0x08, Bytes(8));    // without a height
    const std::string list = b.bridge.list(1s);
    EXPECT_NE(list.find("the device does not send 0x01 inertial"), std::string::npos);
    EXPECT_NE(list.find("needs a height"), std::string::npos);
    EXPECT_NE(Bridged{}.bridge.list(3s).find("no device was heard in 3 s"), std::string::npos);
}

TEST(Bridge, the_number_of_topics_is_limited) {
    Bridged b;
    for (unsigned address = 1; address <= 0xFC; ++address)
        for (const int id : {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x09, 0x0A, 0x0B, 0x0C, 0x0D, 0x0F, 0x40})
            b.receive(static_cast<std::uint8_t>(address), static_cast<std::uint8_t>(id), Bytes(20),
                      "link" + std::to_string(address));
    EXPECT_LE(b.bus.topics.size(), 1100u);
}

}    // namespace
}    // namespace bridge_tests
