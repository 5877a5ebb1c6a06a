// The gateway as a device, and anoctl: through the gateway, and over a link of its own.
#include <support/anoctl.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace anoctl_own_device_tests {

namespace {

using namespace support;
using nlohmann::json;

TEST(AnoctlOwnDevice, is_configured_through_the_gateway_and_over_a_direct_link) {
    TempDir dir;
    const std::string socket = dir / "control";
    const json config = {{"gateway", {{"id", 21}, {"name", "vehicle"}}},
                         {"links", {"udp-listen:127.0.0.1:0,name=ground,manage", "udp-listen:127.0.0.1:0,name=guest"}}};
    dir.write("anogate.json", config.dump());
    Daemon daemon{ANOGATED, socket, {"--config", dir / "anogate.json"}, {"STATE_DIRECTORY=" + (dir / "state")}};
    ASSERT_TRUE(daemon.until_answers());
    const auto parameter = [&] {
        const json status = daemon.status();
        for (const json& one : status.at("gateway").at("device").at("parameters"))
            if (one.at("name") == "FORGET_AFTER") return one;
        return json{};
    };

    const auto through = support::anoctl({"param", "get", "FORGET_AFTER", "--device", "21", "--control", socket});
    EXPECT_EQ(through.exit, 0) << through.err;
    EXPECT_NE(through.out.find("30000"), std::string::npos) << through.out;
    const auto by_link = [&](const std::string& name, std::vector<std::string> words) {
        words.insert(words.end(), {"--device", "21", "--link", "udp:127.0.0.1:" + std::to_string(daemon.port(name))});
        return support::anoctl(words);
    };
    EXPECT_EQ(by_link("guest", {"param", "get", "FORGET_AFTER"}).exit, 0);
    EXPECT_EQ(by_link("guest", {"param", "set", "FORGET_AFTER", "5000"}).exit, 1);
    EXPECT_EQ(parameter().at("value"), 30'000);
    const auto set = by_link("ground", {"param", "set", "FORGET_AFTER", "5000"});
    EXPECT_EQ(set.exit, 0) << set.err;
    EXPECT_TRUE(wait_until([&] { return parameter().at("value") == 5000 && parameter().at("from") == "parameter"; }));
    EXPECT_EQ(by_link("ground", {"command", "call", "RELOAD", "--yes"}).exit, 0);
}

}    // namespace
}    // namespace anoctl_own_device_tests
