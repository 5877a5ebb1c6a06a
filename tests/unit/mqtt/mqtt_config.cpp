#include <mqtt/mqtt_config.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace mqtt_config_tests {
namespace {

using namespace anogate;

std::string faults(const std::string& json) {
    MqttSettings settings;
    ConfigErrors errors;
    read_mqtt_config(json, "f", settings, errors);
    std::string text;
    for (const ConfigError& error : errors) text += error.where + ": " + error.what + "\n";
    return text;
}

std::string faults_of(const MqttSettings& settings) {
    ConfigErrors errors;
    check_mqtt_settings(settings, errors);
    return errors.empty() ? "" : errors.front().what;
}

constexpr char everything[] = R"({
    // comments are allowed
    "$schema": "x", "control": "/run/x.sock", "broker": "[::1]:8883", "name": "drone-1", "username": "u", "password_file": "/p",
    "tls": {"ca": "/ca", "certificate": "/c", "key": "/k"}, "spool": "/s", "spool_size": "1MiB", "spool_age": "1h",
    "backlog_rate": "10KiB", "will_delay": "2s", "raw": true, "allow": ["POST /devices/*/commands"],
    "messages": [{"message": "*", "rate": 0.5, "keep": "low"}, {"message": "euler", "rate": 10, "change": 0.25},
                 {"message": "0x01", "publish": false}],
    "log": {"level": "debug"}
})";

TEST(MqttConfig, a_printed_configuration_is_the_same_again) {
    MqttSettings settings, again;
    ConfigErrors errors;
    read_mqtt_config(everything, "", settings, errors);
    ASSERT_EQ(faults(everything), "");
    EXPECT_EQ(settings.broker, "[::1]:8883");
    EXPECT_EQ(settings.tls_key, "/k");
    EXPECT_EQ(settings.spool_size, 1u << 20);
    EXPECT_EQ(settings.will_delay, std::chrono::seconds{2});
    ASSERT_EQ(settings.messages.size(), 3u);
    EXPECT_EQ(settings.messages[1].change, 250u);
    EXPECT_EQ(settings.messages[0].keep, Keep::low);
    const std::string printed = print_mqtt_config(settings);
    read_mqtt_config(printed, "", again, errors);
    ASSERT_TRUE(errors.empty()) << errors.front().where << errors.front().what << printed;
    EXPECT_EQ(again, settings);
    EXPECT_EQ(print_mqtt_config(again), printed);
}

TEST(MqttConfig, the_examples_in_the_repository_are_valid) {
    std::vector<std::filesystem::path> files{ANOGATE_SOURCE_DIR "/config/mqtt.json"};
    for (const auto& entry : std::filesystem::directory_iterator{ANOGATE_SOURCE_DIR "/config/mqtt"})
        if (entry.path().extension() == ".json") files.push_back(entry.path());
    EXPECT_GE(files.size(), 3u);
    for (const auto& file : files) {
        std::ifstream stream{file};
        const std::string text{std::istreambuf_iterator<char>{stream}, {}};
        EXPECT_EQ(faults(text), "") << file;
        MqttSettings settings;
        ConfigErrors errors;
        read_mqtt_config(text, "", settings, errors);
        EXPECT_EQ(faults_of(settings), "") << file;
    }
}

TEST(MqttConfig, errors_name_the_place_and_the_nearest_key) {
    EXPECT_EQ(faults(R"({"brocker": "a:1"})"), "f: /brocker: unknown key 'brocker' (did you mean 'broker'?)\n");
    EXPECT_NE(faults(R"({"tls": {"cert": "x"}})").find("/tls/cert"), std::string::npos);
    for (const char* bad :
         {R"({"broker": "host"})", R"({"broker": "host:0"})", R"({"broker": "::1:1883"})", R"({"name": "a/b"})",
          R"({"will_delay": "6s"})", R"({"allow": ["POST"]})", R"({"messages": {}})", R"({"messages": [{}]})",
          R"({"messages": [{"message": "eular"}]})", R"({"messages": [{"message": "euler", "keep": "x"}]})", "[]"})
        EXPECT_NE(faults(bad), "") << bad;
}

TEST(MqttConfig, keys_that_need_each_other_are_set_together) {
    MqttSettings settings;
    EXPECT_NE(faults_of(settings), "");
    settings.broker = "a:1883";
    EXPECT_EQ(faults_of(settings), "");
    settings.tls_ca = "ca";
    EXPECT_EQ(faults_of(settings), "");
    settings.tls_key = "k";
    EXPECT_NE(faults_of(settings), "");
    settings.tls_certificate = "c";
    EXPECT_EQ(faults_of(settings), "");
    settings.tls_ca = "";
    EXPECT_NE(faults_of(settings), "");
}

TEST(MqttConfig, a_broker_is_a_host_and_a_port) {
    EXPECT_EQ(broker_address("broker.example:8883").host, "broker.example");
    EXPECT_EQ(broker_address("[fe80::1]:1883").host, "fe80::1");
    EXPECT_EQ(broker_address("10.0.0.1:65535").port, 65535);
    for (const char* bad : {"", "a", ":1", "a:", "a:x", "a:65536", "a:-1", "[]:1", "a:1.5"})
        EXPECT_EQ(broker_address(bad).port, 0) << bad;
}

}    // namespace
}    // namespace mqtt_config_tests
