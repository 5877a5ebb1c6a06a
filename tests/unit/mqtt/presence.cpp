#include <mqtt/presence.hpp>
#include <mqtt/seen_records.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace presence_tests {
namespace {

using namespace anogate;
using Json = nlohmann::json;

TEST(MqttPresence, a_birth_says_whether_the_connection_or_the_program_is_new) {
    const Presence presence{"g", "run1", "1.2.3"};
    const Json will = Json::parse(presence.will(1));
    EXPECT_EQ(will,
              (Json{{"gateway", "g"}, {"state", "offline"}, {"why", "connection lost"}, {"run", "run1"}, {"connection", 1}}));
    Json birth = Json::parse(presence.birth(1, {{"fc", 5}}, {{5, "Falcon"}}, {.published = 3, .dropped = 2}));
    EXPECT_EQ(birth["state"], "online");
    EXPECT_EQ(birth["why"], "restart");
    EXPECT_EQ(birth["run"], "run1");
    EXPECT_EQ(birth["connection"], 1);
    EXPECT_EQ(birth["version"], "1.2.3");
    EXPECT_EQ(birth["schema"], 1);
    EXPECT_EQ(birth["devices"][0], (Json{{"device", "fc-05"}, {"link", "fc"}, {"address", "0x05"}, {"name", "Falcon"}}));
    EXPECT_EQ(birth["counts"]["dropped"], 2);
    birth = Json::parse(presence.birth(2, {}, {}, {}));
    EXPECT_EQ(birth["why"], "connection");
    EXPECT_EQ(birth["connection"], 2);
    EXPECT_EQ(Json::parse(presence.farewell(2))["why"], "stopped");
}

TEST(MqttPresence, a_status_fits_a_message) {
    std::set<HeardDevice> devices;
    std::map<std::uint8_t, std::string> names;
    for (int i = 0; i < 1024; ++i) devices.insert({std::string(40, 'l') + std::to_string(i), static_cast<std::uint8_t>(i)});
    for (int i = 0; i < 256; ++i) names[static_cast<std::uint8_t>(i)] = std::string(20, 'n');
    Presence presence{"g", "run", "1"};
    EXPECT_LE(presence.birth(1, devices, names, {}).size(), max_payload);
}

TEST(MqttSeenRecords, each_record_is_new_once_in_any_order) {
    std::vector<std::uint64_t> all(2000);
    std::iota(all.begin(), all.end(), 1);
    std::vector<std::uint64_t> twice = all;
    twice.insert(twice.end(), all.begin(), all.end());
    std::shuffle(twice.begin(), twice.end(), std::mt19937{7});
    SeenRecords seen;
    std::size_t fresh = 0;
    for (const std::uint64_t seq : twice) fresh += seen.add("a", seq) ? 1u : 0u;
    EXPECT_EQ(fresh, all.size());
    EXPECT_EQ(seen.ranges(), 1u);
    EXPECT_TRUE(seen.add("b", 1));
    EXPECT_TRUE(seen.add("b", 3));
    EXPECT_FALSE(seen.add("b", 3));
    EXPECT_EQ(seen.ranges(), 3u);
    EXPECT_TRUE(seen.add("b", 2));
    EXPECT_EQ(seen.ranges(), 2u);
}

}    // namespace
}    // namespace presence_tests
