#include <ros2/command_line.hpp>
#include <ros2/ros2_config.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace ros2_config_tests {
namespace {

using namespace anogate;

std::string faults(const std::string& json) {
    Ros2Settings settings;
    ConfigErrors errors;
    read_ros2_config(json, "f", settings, errors);
    std::string text;
    for (const ConfigError& error : errors) text += error.where + ": " + error.what + "\n";
    return text;
}

Ros2Settings settings_of(const std::string& json) {
    Ros2Settings settings;
    ConfigErrors errors;
    read_ros2_config(json, "", settings, errors);
    EXPECT_TRUE(errors.empty()) << (errors.empty() ? "" : errors.front().where + errors.front().what);
    return settings;
}

std::string text_of(const std::string& path) {
    std::ifstream file{path};
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

TEST(Ros2Config, reads_every_key_and_prints_the_same) {
    const std::string text = R"({
        // comments are allowed
        "control": "/run/x.sock", "domain": 42, "interfaces": ["lo", "eth0"], "prefix": "device", "raw": false, "tf": true,
        "qos": {"scan": "best_effort", "raw": "reliable"},
        "variances": {"orientation": 1e-4, "fix": 2, "fix_altitude": 9},
        "devices": [{"address": "0x05", "link": "fc", "prefix": "fleet/drone1", "accept": ["cmd_vel", "command"],
                     "hover_throttle": 42.5, "velocity_modes": [2, 3]}],
        "log": {"level": "warn"}
    })";
    const Ros2Settings settings = settings_of(text);
    EXPECT_EQ(settings.control, "/run/x.sock");
    EXPECT_EQ(settings.domain, 42u);
    EXPECT_EQ(settings.interfaces, (std::vector<std::string>{"lo", "eth0"}));
    EXPECT_EQ(settings.prefix, PrefixFrom::device);
    EXPECT_FALSE(settings.raw);
    EXPECT_TRUE(settings.tf);
    EXPECT_EQ(settings.qos.at("scan"), Reliability::best_effort);
    EXPECT_EQ(settings.variances.orientation, 1e-4);
    ASSERT_EQ(settings.devices.size(), 1u);
    const Ros2Device& device = settings.devices.front();
    EXPECT_EQ(device, (Ros2Device{5, "fc", "fleet/drone1", {"cmd_vel", "command"}, 42'500, {2, 3}}));
    EXPECT_TRUE(device.accepts(Input::cmd_vel));
    EXPECT_FALSE(device.accepts(Input::joy));
    EXPECT_EQ(settings.log.level, "warn");
    const std::string printed = print_ros2_config(settings);
    EXPECT_EQ(print_ros2_config(settings_of(printed)), printed);
}

TEST(Ros2Config, nothing_may_control_a_device_by_default) {
    EXPECT_TRUE(settings_of("{}").devices.empty());
    EXPECT_TRUE(settings_of(R"({"devices": [{"address": 5}]})").devices.front().accept.empty());
}

TEST(Ros2Config, reports_faults_with_their_place) {
    EXPECT_EQ(faults(R"({"domian": 1})"), "f: /domian: unknown key 'domian' (did you mean 'domain'?)\n");
    EXPECT_EQ(faults(R"({"domain": 233})"), "f: /domain: 'domain' must be a whole number from 0 to 232, not '233'\n");
    EXPECT_NE(faults(R"({"qos": {"scann": "reliable"}})").find("did you mean 'scan'"), std::string::npos);
    EXPECT_NE(faults(R"({"qos": {"scan": "exact"}})").find("must be \"reliable\" or \"best_effort\""), std::string::npos);
    EXPECT_NE(faults(R"({"variances": {"fix": 0, "fix_altitude": 1}})").find("must be a number above 0"), std::string::npos);
    EXPECT_NE(faults(R"({"variances": {"fix": 1}})").find("set both"), std::string::npos);
    EXPECT_NE(faults(R"({"devices": [{}]})").find("'address' is missing"), std::string::npos);
    EXPECT_NE(faults(R"({"devices": [{"address": 5, "accept": ["cmd_vels"]}]})").find("did you mean 'cmd_vel'"),
              std::string::npos);
    EXPECT_NE(faults(R"({"devices": [{"address": 5, "prefix": "9x"}]})").find("beginning with a letter"), std::string::npos);
    EXPECT_NE(faults(R"({"devices": [{"address": 5, "velocity_modes": [256]}]})").find("numbers up to 255"), std::string::npos);
    EXPECT_NE(faults("{").find("f"), std::string::npos);
}

TEST(Ros2Config, velocities_need_the_throttle_of_hovering_which_is_never_0) {
    EXPECT_NE(faults(R"({"devices": [{"address": 5, "accept": ["cmd_vel"]}]})").find("'hover_throttle' is missing"),
              std::string::npos);
    EXPECT_NE(faults(R"({"devices": [{"address": 5, "accept": ["cmd_vel"], "hover_throttle": 0}]})").find("from 1 to 100"),
              std::string::npos);
    EXPECT_EQ(faults(R"({"devices": [{"address": 5, "accept": ["cmd_vel"], "hover_throttle": 38.5}]})"), "");
    EXPECT_NE(faults(R"({"devices": [{"address": 5, "accept": ["cmd_vel", "joy"], "hover_throttle": 38}]})").find("only one"),
              std::string::npos);
}

TEST(Ros2Config, refuses_prefixes_and_devices_that_are_stated_twice) {
    EXPECT_NE(faults(R"({"devices": [{"address": 5, "prefix": "a"}, {"address": 6, "prefix": "a"}]})").find("also the prefix"),
              std::string::npos);
    EXPECT_NE(faults(R"({"devices": [{"address": 5}, {"address": 5, "link": "fc"}]})").find("same device"), std::string::npos);
    EXPECT_EQ(faults(R"({"devices": [{"address": 5, "link": "a"}, {"address": 5, "link": "b"}]})"), "");
}

TEST(Ros2Config, the_example_is_valid) { EXPECT_EQ(faults(text_of(ANOGATE_SOURCE_DIR "/config/ros2.json")), ""); }

struct Line {
    explicit Line(std::vector<const char*> words, const std::string& default_file = "/nonexistent") {
        words.insert(words.begin(), "anogate-ros2");
        result = parse_ros2_command_line(static_cast<int>(words.size()), words.data(), default_file);
    }
    const Ros2Settings& settings() const { return std::get<Ros2CommandLine>(result).settings; }
    const Ros2Exit& exit() const { return std::get<Ros2Exit>(result); }
    std::variant<Ros2CommandLine, Ros2Exit> result;
};

TEST(Ros2CommandLine, options_override_the_file) {
    const support::TempDir dir;
    const std::string file = dir.write("ros2.json", R"({"domain": 3, "interfaces": ["eth0"], "tf": true})");
    const Line by_default{{"--domain", "4", "--interface", "lo", "--interface", "wlan0", "--control", "/x"}, file};
    EXPECT_EQ(by_default.settings().domain, 4u);
    EXPECT_EQ(by_default.settings().interfaces, (std::vector<std::string>{"lo", "wlan0"}));
    EXPECT_EQ(by_default.settings().control, "/x");
    EXPECT_TRUE(by_default.settings().tf);
    const Line given{{"--config", file.c_str(), "--list"}};
    EXPECT_EQ(given.settings().domain, 3u);
    EXPECT_TRUE(std::get<Ros2CommandLine>(given.result).list);
    EXPECT_EQ(Line{{}}.settings().domain, 0u);
}

TEST(Ros2CommandLine, faults_end_the_program_with_78) {
    EXPECT_EQ(Line({"--domain", "x"}).exit().code, 78);
    EXPECT_EQ(Line({"--domian", "1"}).exit().code, 78);
    EXPECT_EQ(Line({"--config", "/nonexistent/ros2.json"}).exit().code, 78);
    EXPECT_EQ(Line{{"--version"}}.exit().code, 0);
    EXPECT_NE(Line{{"--help"}}.exit().text.find("--interface"), std::string::npos);
}

}    // namespace
}    // namespace ros2_config_tests
