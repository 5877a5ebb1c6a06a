// Messages of publishers of CycloneDDS at devices.
#include "bridged.hpp"

#include <ano/typed.hpp>

#include <csignal>

namespace inputs_tests {
namespace {

using namespace ros2_tests;
using support::Bytes;

constexpr std::uint8_t mode_id = 0x06;

class Ros2Inputs : public Bridged {
protected:
    /// The frames with this id that the device received since the last call.
    std::vector<Bytes> received(std::uint8_t id) {
        std::vector<Bytes> frames;
        for (Bytes& frame : device.frames())
            if (ano::FrameView{frame}.id() == id) frames.push_back(std::move(frame));
        return frames;
    }
    void report_mode(std::uint8_t mode) { send(mode_id, {mode, 2, 0, 0, 0}); }
};

TEST_F(Ros2Inputs, velocities_reach_the_device_in_its_mode_and_their_end_stops_it) {
    start_gateway();
    start_bridge(R"({"devices": [{"address": 5, "prefix": "drone", "accept": ["cmd_vel"], "hover_throttle": 40}]})");
    ASSERT_TRUE(until_connected()) << bridge->output();
    Talker talker{dir};
    std::vector<Bytes> frames;
    ASSERT_TRUE(support::wait_until(
        [&] {
            report_mode(2);
            talker.say("twist /drone/cmd_vel 1.5 -0.5 0.25 0.5");
            for (Bytes& frame : received(0x41)) frames.push_back(std::move(frame));
            return frames.size() >= 5;
        },
        support::patience, [] { std::this_thread::sleep_for(50ms); }))
        << bridge->output();
    const ano::FrameView first{frames.front()};
    EXPECT_EQ(first.source(), 0xD2);
    EXPECT_EQ(first.destination(), 5);
    const auto control = ano::as<"realtime_control">(first);
    EXPECT_EQ(control->get<"ctrl_thr">(), 40);
    EXPECT_EQ(control->get<"ctrl_spd_x">(), 150);
    EXPECT_EQ(control->get<"ctrl_spd_y">(), -50);
    EXPECT_EQ(control->get<"ctrl_spd_z">(), 25);
    EXPECT_EQ(control->get<"ctrl_yaw_dps">(), 29);
    // Silence: one frame that stops it, then none.
    frames.clear();
    ASSERT_TRUE(bridge->until_says("no messages for 0.5 s")) << bridge->output();
    ASSERT_TRUE(support::wait_until([&] {
        report_mode(2);
        for (Bytes& frame : received(0x41)) frames.push_back(std::move(frame));
        return !frames.empty() && ano::as<"realtime_control">(ano::FrameView{frames.back()})->get<"ctrl_spd_x">() == 0;
    }));
    const auto stop = ano::as<"realtime_control">(ano::FrameView{frames.back()});
    EXPECT_EQ(stop->get<"ctrl_thr">(), 40);
    EXPECT_EQ(stop->get<"ctrl_yaw_dps">(), 0);
    std::this_thread::sleep_for(300ms);
    EXPECT_TRUE(received(0x41).empty());
    EXPECT_NE(bridge->output().find("/drone/cmd_vel: controlled by publisher 01.10."), std::string::npos) << bridge->output();
}

TEST_F(Ros2Inputs, a_joy_reaches_the_device) {
    start_gateway();
    start_bridge(R"({"devices": [{"address": 5, "prefix": "drone", "accept": ["joy"]}]})");
    send(mode_id, {2, 2, 0, 0, 0});    // the gateway learns where the device is
    ASSERT_TRUE(until_connected()) << bridge->output();
    Talker talker{dir};
    std::vector<Bytes> frames;
    ASSERT_TRUE(support::wait_until(
        [&] {
            talker.say("joy /drone/joy 10 0.5");
            for (Bytes& frame : received(0x40)) frames.push_back(std::move(frame));
            return !frames.empty();
        },
        support::patience, [] { std::this_thread::sleep_for(50ms); }))
        << bridge->output();
    EXPECT_EQ(ano::as<"remote_control">(ano::FrameView{frames.front()})->get<"thr">(), 1750);
}

TEST_F(Ros2Inputs, a_device_that_talks_to_the_bridge_of_the_vendor_talks_to_it) {
    constexpr std::uint8_t bridge_id = 0xD2, question_id = 0xE0, device_info_id = 0xE3;
    start_gateway();
    start_bridge();
    ASSERT_TRUE(until_connected()) << bridge->output();
    Listener listener{{"/fc/imu/data=Imu"}};
    const std::uint16_t port = gateway->port("fc");
    bool has_answer = false;
    ASSERT_TRUE(support::wait_until(
        [&] {
            device.send(port, support::frame(5, bridge_id, 0x01, Bytes(13)));
            device.send(port, support::frame(5, bridge_id, question_id, {0, 0, 0}));
            for (const Bytes& frame : received(device_info_id)) {
                const ano::FrameView view{frame};
                has_answer = has_answer || (view.source() == bridge_id && view.destination() == 5);
            }
            return has_answer && listener.count("/fc/imu/data") > 0;
        },
        support::patience, [] { std::this_thread::sleep_for(50ms); }))
        << bridge->output();
}

TEST_F(Ros2Inputs, nothing_is_subscribed_by_default) {
    start_gateway();
    start_bridge();
    ASSERT_TRUE(until_connected()) << bridge->output();
    Talker talker{dir};
    Listener listener{{"/fc/imu/data=Imu"}};
    talker.say("twist /fc/cmd_vel 1 0 0 0");
    ASSERT_TRUE(send_until(0x01, Bytes(13), [&] { return listener.count("/fc/imu/data") >= 50; })) << bridge->output();
    EXPECT_TRUE(received(0x41).empty());
}

TEST_F(Ros2Inputs, a_command_flies_the_simulated_device_and_its_result_returns) {
    start_gateway({"sim:fc,name=fc"});
    start_bridge(R"({"devices": [{"address": "0xDC", "prefix": "drone", "accept": ["command"]}]})");
    ASSERT_TRUE(until_connected()) << bridge->output();
    Listener listener{{"/drone/command_result=String", "/drone/position=PointStamped"}};
    ASSERT_TRUE(listener.until_count("/drone/position", 1)) << bridge->output();
    Talker talker{dir};
    const std::vector<std::string> orders{R"({"command": "NO_SUCH", "id": "1"})",
                                          R"({"command": "TAKE_OFF", "values": [150], "id": "2"})"};
    for (const std::string& order : orders) {
        const std::size_t before = listener.count("/drone/command_result");
        talker.say("string /drone/command " + order);
        ASSERT_TRUE(listener.until_count("/drone/command_result", before + 1)) << bridge->output();
    }
    std::vector<nlohmann::json> results;
    for (const Heard& message : listener.heard())
        if (message.topic == "/drone/command_result")
            results.push_back(nlohmann::json::parse(message.values[0].get<std::string>()));
    EXPECT_EQ(results[0]["id"], "1");
    EXPECT_EQ(results[0]["ok"], false);
    EXPECT_NE(results[0]["error"].get<std::string>().find("NO_SUCH"), std::string::npos) << results[0];
    EXPECT_EQ(results[1]["id"], "2");
    EXPECT_EQ(results[1]["ok"], true) << results[1];
    ASSERT_TRUE(support::wait_until([&] {
        return !listener.heard().empty() &&
               std::any_of(listener.heard().begin(), listener.heard().end(), [](const Heard& message) {
                   return message.topic == "/drone/position" && message.values[5].get<double>() > 0.5;
               });
    })) << "it does not rise";
}

}    // namespace
}    // namespace inputs_tests
