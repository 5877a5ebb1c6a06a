// A real serial device whose parser is blocked by one flipped bit of LEN, like that of the vendor's libraries.
#include <support/asked.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/vendor_device.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>

namespace deaf_device_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

class DeafDevice : public testing::Test {
protected:
    DeafDevice() {
        device.fake.make_parameters(20);
        device.fake.commands.push_back({{1, 2, 3}, {}, "go", ""});
        device.start();
    }
    // The parser is flushed at most once a second, so each operation has its own second.
    void disturb() {
        std::this_thread::sleep_for(1100ms);
        device.disturb();
    }

    TempDir dir;
    VendorDevice device{dir / "fc"};
    const std::string link = "serial:" + (dir / "fc") + ",baud=115200,name=fc";
};

TEST_F(DeafDevice, every_operation_of_a_gateway_succeeds_after_a_damaged_header) {
    const std::string socket = dir / "control.sock";
    const std::string config = dir.write("anogate.json", R"({"links": [")" + link + R"("]})");
    Daemon daemon{ANOGATED, socket, {"--config", config}, {"STATE_DIRECTORY=" + (dir / "state")}};
    ASSERT_TRUE(daemon.until_answers());
    ASSERT_TRUE(daemon.until([](const nlohmann::json& status) { return !status.at("routes").empty(); }));
    struct Operation {
        std::string method, target, body;
    };
    const std::string fc = "/devices/0xDC";
    for (const Operation& operation :
         {Operation{"GET", fc + "/parameters", ""}, Operation{"POST", fc + "/commands/go", ""},
          Operation{"POST", fc + "/actions", R"({"action": "save"})"},
          Operation{"PUT", fc + "/parameters/PAR_1", R"({"value": 5})"},
          Operation{"PUT", fc + "/waypoints", R"({"waypoints": [{"lng": 116.4, "lat": 39.9, "alt": 10}]})"},
          Operation{"GET", fc + "/waypoints", ""}, Operation{"POST", fc + "/firmware", std::string(1000, '\x01')}}) {
        disturb();
        const auto begin = std::chrono::steady_clock::now();
        const auto answer = asked(socket, operation.method, operation.target, operation.body);
        RecordProperty(operation.target, std::to_string((std::chrono::steady_clock::now() - begin) / 1ms));
        EXPECT_TRUE(answer.status == 200 || answer.status == 202) << operation.target << ' ' << answer.body;
        EXPECT_EQ(answer.body.find("failed"), std::string::npos) << operation.target << ' ' << answer.body;
    }
    EXPECT_EQ(device.calls(), 1u) << "a command is sent once";
    EXPECT_GE(daemon.count("fc", "flush_bytes"), 206u);
    EXPECT_LE(daemon.count("fc", "flush_bytes"), 7 * 206u);
}

TEST_F(DeafDevice, a_hello_reaches_one_that_sends_nothing_before_it_is_asked) {
    const std::string socket = dir / "control.sock";
    const std::string config = dir.write("anogate.json",
                                         R"({"links": ["serial:)" + (dir / "quiet") + R"(,name=quiet,hello=1s"]})");
    PtyDevice quiet{dir / "quiet"};
    Daemon daemon{ANOGATED, socket, {"--config", config}, {"STATE_DIRECTORY=" + (dir / "state")}};
    EXPECT_TRUE(wait_until([&] {
        const Bytes& heard = quiet.heard();
        return std::count(heard.begin(), heard.end(), 0xAB) >= 3;
    }));
    const Bytes& heard = quiet.heard();
    const auto zeros = std::search_n(heard.begin(), heard.end(), 206, 0);
    ASSERT_NE(zeros, heard.end());
    EXPECT_EQ(std::count(heard.begin(), zeros, 0xAB), 2) << "before the third";
}

TEST_F(DeafDevice, is_read_without_a_gateway_as_well) {
    device.disturb();
    Process list{ANOCTL, {"param", "list", "--device", "0xDC", "--link", link}};
    EXPECT_EQ(list.wait(), 0) << list.output();
    EXPECT_NE(list.output().find("PAR_19"), std::string::npos) << list.output();
    EXPECT_GE(device.zeros(), 206u);
}

// Eight questions need 0.3 s to be sent.
TEST_F(DeafDevice, requests_that_wait_for_their_turn_on_a_slow_link_are_not_repeated) {
    const std::string socket = dir / "control.sock";
    const std::string config = dir.write("anogate.json", R"({"links": [")" + link + R"(,rate=300"]})");
    Daemon daemon{ANOGATED, socket, {"--config", config}, {"STATE_DIRECTORY=" + (dir / "state")}};
    ASSERT_TRUE(daemon.until_answers());
    ASSERT_TRUE(daemon.until([](const nlohmann::json& status) { return !status.at("routes").empty(); }));
    const auto answer = asked(socket, "GET", "/devices/0xDC/parameters");
    EXPECT_EQ(answer.status, 200u) << answer.body;
    RecordProperty("frames", std::to_string(device.frames()));
    EXPECT_LE(device.frames(), 3 + 2 * 20 + 10u) << "hardly any twice, however busy this machine is";
}

TEST(VendorParser, of_a_simulated_device_does_not_block_reading_its_parameters) {
    const TempDir dir;
    const std::string socket = dir / "control.sock";
    const std::string config = dir.write("anogate.json", R"({"links": ["sim:fc,parser=vendor,corrupt=10,seed=3"]})");
    Daemon daemon{ANOGATED, socket, {"--config", config}, {"STATE_DIRECTORY=" + (dir / "state")}};
    ASSERT_TRUE(daemon.until_answers());
    ASSERT_TRUE(daemon.until([](const nlohmann::json& status) { return !status.at("routes").empty(); }));
    EXPECT_TRUE(wait_until([&] {    // until one of the damaged bytes was a LEN
        const auto answer = asked(socket, "GET", "/devices/0xDC/parameters");
        EXPECT_EQ(answer.status, 200u) << answer.body;
        return daemon.count("fc", "flush_bytes") > 0;
    }));
}

}    // namespace
}    // namespace deaf_device_tests
