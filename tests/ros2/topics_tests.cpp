// Messages at subscribers of CycloneDDS and Fast DDS.
#include "bridged.hpp"

#include <record/decoded_channels.hpp>
#include <ros/standard_messages.hpp>
#include <ros2/topic_table.hpp>
#include <support/files.hpp>
#include <support/recorded.hpp>
#include <support/ros_definition.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>

namespace topics_tests {
namespace {

using namespace anogate;
using namespace ros2_tests;
using support::Bytes;

using Json = nlohmann::json;

/// A frame for every standard message; the values differ by `round`.
std::vector<std::pair<std::uint8_t, Bytes>> telemetry(unsigned round) {
    const auto low = static_cast<std::uint8_t>(round), high = static_cast<std::uint8_t>(round >> 8);
    const auto numbered = [&](std::size_t size) {
        Bytes data(size);
        for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(7 * i + 1);
        data[0] = low, data[1] = high;
        return data;
    };
    Bytes fix = numbered(23);
    fix[0] = 3, fix[2] = low, fix[3] = high;
    Bytes quaternion{0x10, 0x27, 0, 0, low, 0, 0, 0, 1};    // w 10000
    Bytes scan{100, 10, 0, low, 2, 20, 0, 30, 1};
    Bytes image{low, high, 0, 3, 0, 2, 0};
    image.resize(17);
    for (int i = 0; i < 6; ++i) image.push_back(static_cast<std::uint8_t>(round + static_cast<unsigned>(i)));
    std::vector<std::pair<std::uint8_t, Bytes>> all{{0x01, numbered(13)}, {0x02, numbered(9)},  {0x04, quaternion},
                                                    {0x07, numbered(6)},  {0x08, numbered(12)}, {0x0D, numbered(4)},
                                                    {0x30, fix},          {0x32, numbered(12)}, {0x33, numbered(6)},
                                                    {0x34, scan},         {0xB0, image}};
    for (std::uint8_t type = 0; type < 6; ++type) all.push_back({0x34, {type, low, high, 0, 0}});
    return all;
}

/// All values in order, without the stamp.
void flatten(const ano::Json& json, std::vector<Json>& out) {
    for (const auto& part : json) {
        if (part.is_structured()) flatten(part, out);
        else out.push_back(Json::parse(part.dump()));
    }
}

bool is_same(const Json& a, const Json& b) {
    if (!a.is_number() || !b.is_number()) return a == b;
    const double x = a.get<double>(), y = b.get<double>();
    return std::abs(x - y) <= 1e-6 * std::max(std::abs(x), std::abs(y));
}

bool are_same(const std::vector<Json>& recorded, const Json& received) {
    if (recorded.size() != received.size()) return false;
    for (std::size_t i = 2; i < recorded.size(); ++i)    // after the stamp
        if (!is_same(recorded[i], received[i])) return false;
    return true;
}

/// The messages of each standard topic in a recording, with the names of topics and frames that ROS has.
std::map<std::string, std::vector<std::vector<Json>>> recorded_messages(const std::string& file) {
    std::map<std::string, std::vector<std::vector<Json>>> all;
    const support::ReadRecording read = support::read_recording(file);
    DecodedChannels channels{DecodedEncoding::cdr, nullptr};
    for (const support::KeptItem& item : read.items) {
        if (item.frame.empty()) continue;
        for (const DecodedMessage& message : channels.decode(support::frame_of(item))) {
            const DecodedChannel& channel = channels.channels()[message.channel];
            for (std::size_t topic = 0; topic < standard_topics; ++topic) {
                const std::string name = "/fc/device_5/" + std::string{standard_row(static_cast<StandardTopic>(topic)).name};
                if (channel.topic != name) continue;
                std::vector<Json> values;
                flatten(support::decoded_cdr(channels.schemas()[channel.schema].text, message.data), values);
                for (Json& value : values)
                    if (value.is_string() && value.get<std::string>().starts_with("fc/device_5"))
                        value = "fc" + value.get<std::string>().substr(std::string{"fc/device_5"}.size());
                all["/fc/" + std::string{topic_table()[topic].name}].push_back(std::move(values));
            }
        }
    }
    return all;
}

class Ros2Topics : public Bridged {
protected:
    /// Sends telemetry until a subscriber received each standard message three times, and compares all of them with the recording.
    std::unique_ptr<Listener> compare_with_recording(Listener::Of of);
};

std::string name_of(std::size_t topic) { return "/fc/" + std::string{topic_table()[topic].name}; }

std::unique_ptr<Listener> Ros2Topics::compare_with_recording(Listener::Of of) {
    std::filesystem::create_directory(dir / "recordings");
    const std::string config = dir.write("anogate.json", R"({"links": [")" + device.link("fc") + R"("], "record": {"folder": ")" +
                                                             (dir / "recordings") + R"(", "format": "mcap"}})");
    start_gateway({"--config", config});
    start_bridge();
    std::vector<std::string> topics;
    for (std::size_t topic = 0; topic < standard_topics; ++topic)
        topics.push_back(name_of(topic) + "=" + topic_table()[topic].type->name);
    auto listener = std::make_unique<Listener>(topics, "lo", of);
    EXPECT_TRUE(until_connected()) << bridge->output();
    unsigned round = 1;
    const auto heard_all = [&] {
        for (std::size_t topic = 0; topic < standard_topics; ++topic)
            if (listener->count(name_of(topic)) < 3) return false;
        return true;
    };
    const std::uint16_t port = gateway->port("fc");
    EXPECT_TRUE(support::wait_until(heard_all, support::patience, [&] {
        for (const auto& [id, data] : telemetry(round)) device.send(port, support::frame(5, 0xFE, id, data));
        ++round;
        std::this_thread::sleep_for(50ms);
    })) << bridge->output();
    const std::size_t received = listener->heard().size();
    gateway->signal(SIGTERM);
    gateway->wait();
    std::string file;
    for (const auto& entry : std::filesystem::directory_iterator{dir / "recordings"}) file = support::file_text(entry.path());
    const auto recorded = recorded_messages(file);
    for (std::size_t i = 0; i < received; ++i) {
        const Heard& message = listener->heard()[i];
        const auto all = recorded.find(message.topic);
        if (all == recorded.end()) {
            ADD_FAILURE() << message.topic << " was not recorded";
            continue;
        }
        EXPECT_TRUE(std::any_of(all->second.begin(), all->second.end(),
                                [&](const std::vector<Json>& one) { return are_same(one, message.values); }))
            << message.topic << " " << message.values.dump() << "\n"
            << Json(all->second.back()).dump();
    }
    return listener;
}

TEST_F(Ros2Topics, standard_messages_at_cyclonedds_equal_the_recording_of_the_same_run) {
    const auto listener = compare_with_recording(Listener::Of::cyclone);
    // Every endpoint states the hash of its type.
    ASSERT_EQ(listener->matched().size(), standard_topics);
    for (const std::string& line : listener->matched()) {
        if (line.starts_with("/fc/imu/data")) {
            EXPECT_EQ(line, "/fc/imu/data typehash=RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b;");
        }
        EXPECT_NE(line.find(" typehash=RIHS01_"), std::string::npos) << line;
    }
}

TEST_F(Ros2Topics, standard_messages_at_fast_dds_equal_the_recording_of_the_same_run) {
    if (std::string{FAST_LISTENER}.empty()) GTEST_SKIP() << "fastddsgen is not installed";
    compare_with_recording(Listener::Of::fast);
}

TEST_F(Ros2Topics, sticks_log_lines_transforms_and_diagnostics_arrive) {
    start_gateway();
    start_bridge(R"({"tf": true, "qos": {"joy": "best_effort"}})");
    Listener listener{{"/fc/joy=Joy,best_effort", "/fc/log=Log", "/tf=TFMessage", "/diagnostics=DiagnosticArray"}};
    ASSERT_TRUE(until_connected()) << bridge->output();
    const Bytes sticks{0xD0, 0x07, 0xE8, 0x03, 0xDC, 0x05, 0,    0,    0xDC, 0x05,
                       0xDC, 0x05, 0xDC, 0x05, 0xDC, 0x05, 0xDC, 0x05, 0xDC, 0x05};
    ASSERT_TRUE(send_until(0x40, sticks, [&] { return listener.count("/fc/joy") > 0; })) << bridge->output();
    ASSERT_TRUE(send_until(0xA0, {1, 'l', 'o', 'w'}, [&] { return listener.count("/fc/log") > 0; })) << bridge->output();
    ASSERT_TRUE(send_until(0x04, {0x10, 0x27, 0, 0, 0, 0, 0, 0, 1}, [&] {
        send(0x07, {1, 0, 2, 0, 3, 0});
        send(0x08, {100, 0, 0, 0, 200, 0, 0, 0, 44, 1, 0, 0});
        return listener.count("/tf") > 0;
    })) << bridge->output();
    ASSERT_TRUE(listener.until_count("/diagnostics", 1));
    for (const Heard& message : listener.heard()) {
        if (message.topic == "/fc/joy") {
            EXPECT_EQ(message.values[2], "fc");
            EXPECT_EQ(message.values[3], 1);
            EXPECT_EQ(message.values[4], -1);
            EXPECT_TRUE(message.values[6].is_null());
        } else if (message.topic == "/fc/log") {
            EXPECT_EQ((Json{message.values[2], message.values[3], message.values[4]}), (Json{40, "fc", "low"}));
        } else if (message.topic == "/tf") {
            EXPECT_EQ((Json{message.values[2], message.values[3], message.values[4]}), (Json{"fc/odom", "fc", 1}));
        } else {
            EXPECT_EQ(message.values[4], "anogate: gateway");
        }
    }
}

TEST_F(Ros2Topics, a_subscriber_and_the_bridge_find_each_other_in_any_order_and_again_after_a_kill) {
    start_gateway();
    start_bridge();
    ASSERT_TRUE(until_connected()) << bridge->output();
    Listener first{{"/fc/imu/data=Imu"}};
    ASSERT_TRUE(send_until(0x01, Bytes(13), [&] { return first.count("/fc/imu/data") > 0; })) << bridge->output();
    bridge->signal(SIGKILL);
    bridge->wait();
    const std::size_t before = first.count("/fc/imu/data");
    start_bridge();
    ASSERT_TRUE(send_until(0x01, Bytes(13), [&] { return first.count("/fc/imu/data") > before; })) << bridge->output();
    Listener second{{"/fc/imu/data=Imu"}};
    ASSERT_TRUE(send_until(0x01, Bytes(13), [&] { return second.count("/fc/imu/data") > 0; })) << bridge->output();
}

TEST_F(Ros2Topics, the_bridge_waits_for_the_gateway_and_survives_its_restart) {
    start_bridge();
    ASSERT_TRUE(bridge->until_says("connecting again")) << bridge->output();
    Listener listener{{"/fc/imu/data=Imu"}};
    for (int run = 0; run < 2; ++run) {
        const std::size_t before = listener.count("/fc/imu/data");
        start_gateway();
        ASSERT_TRUE(send_until(0x01, Bytes(13), [&] { return listener.count("/fc/imu/data") > before; })) << bridge->output();
        gateway->signal(SIGKILL);
        gateway->wait();
    }
    bridge->signal(SIGTERM);
    EXPECT_EQ(bridge->wait(), 0);
    const std::string log = bridge->output();
    EXPECT_LT(std::count(log.begin(), log.end(), '\n'), 15) << log;
}

TEST_F(Ros2Topics, the_list_shows_sources_rates_and_why_topics_are_silent) {
    start_gateway({"sim:fc,name=fc"});
    support::Process list{ANOGATE_ROS2, {"--control", socket, "--list"}, bridge_environment()};
    ASSERT_EQ(list.wait(), 0) << list.output();
    const std::string& text = list.output();
    EXPECT_NE(text.find("/fc/imu/data"), std::string::npos) << text;
    EXPECT_NE(text.find("0x01 inertial"), std::string::npos);
    EXPECT_NE(text.find("the device does not send 0x40"), std::string::npos) << text;
    support::Process nowhere{ANOGATE_ROS2, {"--control", dir / "none", "--list"}, bridge_environment()};
    EXPECT_EQ(nowhere.wait(), 1);
    EXPECT_NE(nowhere.output().find("no gateway is running"), std::string::npos) << nowhere.output();
}

TEST_F(Ros2Topics, tshark_understands_the_packets) {
    if (support::run("tshark --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "tshark is not installed";
    start_gateway();
    start_bridge();
    ASSERT_TRUE(until_connected()) << bridge->output();
    const std::string file = dir / "packets.pcapng";
    support::Shell capture{"exec tshark -q -i lo -f udp -w " + file};
    const auto has_packets = [&] {
        std::error_code ec;
        const auto size = std::filesystem::file_size(file, ec);
        return !ec && size > 1000;
    };
    ASSERT_TRUE(send_until(0x01, Bytes(13), has_packets)) << capture.output();    // the names of topics are sent only once
    Listener listener{{"/fc/imu/data=Imu"}};
    ASSERT_TRUE(send_until(0x01, Bytes(13), [&] { return listener.count("/fc/imu/data") >= 20; })) << bridge->output();
    // tshark writes packets up to a second after they were sent.
    const auto shows = [&](const std::string& wanted, int packets) {
        return support::run("test $(tshark -r " + file + " -Y '" + wanted + "' 2>/dev/null | wc -l) -ge " +
                            std::to_string(packets)) == 0;
    };
    ASSERT_TRUE(send_until(0x01, Bytes(13), [&] {
        return shows("rtps.sm.id == 0x15 && rtps.sm.wrEntityId.entityKind == 0x03", 10) &&
               shows("rtps.param.topicName == \"rt/fc/imu/data\"", 1);
    })) << bridge->output();
    EXPECT_FALSE(shows("_ws.malformed && rtps", 1));
}

}    // namespace
}    // namespace topics_tests
